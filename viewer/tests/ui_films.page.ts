// The players of scenes and quilts on a canvas, for ui.test.ts.

import type { ByteSource } from "../src/format/types.ts";
import { openScene } from "../src/glb/main.ts";
import type { Player, View } from "../src/player/types.ts";
import { openQuilt } from "../src/quilt.ts";
import type { QuiltLayout } from "../src/ui/film_file.ts";

/** What a test asks for: the file, the view without overlays, and how it is shown. */
interface Wish {
  path: string;
  view: Omit<View, "overlays">;
  isOverdraw?: boolean;
  layout?: QuiltLayout;
}

async function sourceOf(path: string): Promise<ByteSource> {
  const bytes = new Uint8Array(await (await fetch(path)).arrayBuffer());
  return { byteCount: bytes.length, read: (offset, count) => Promise.resolve(bytes.slice(offset, offset + count)) };
}

async function drawn(player: Player, canvas: HTMLCanvasElement, view: Wish["view"]): Promise<object> {
  const { counters } = await player.draw({ ...view, overlays: new Set() });
  const { size, rgba } = await player.pixels();
  player.close();
  return { film: player.film, counters, size, rgba: [...rgba], canvas: [canvas.width, canvas.height] };
}

/** Draws a view of a scene. Answers the film, the counters, and the light of the picture. */
async function scene({ path, view, isOverdraw }: Wish): Promise<object> {
  const canvas = document.createElement("canvas");
  const player = await openScene(await sourceOf(path), canvas, "scene.glb");
  player.showOverdraw(isOverdraw === true);
  return drawn(player, canvas, view);
}

/** Draws a view of a quilt. Answers as `scene`. */
async function quilt({ path, view, layout }: Wish): Promise<object> {
  const canvas = document.createElement("canvas");
  const player = await openQuilt(await sourceOf(path), canvas, { name: "quilt.png", layout: layout! });
  return drawn(player, canvas, view);
}

/** The sentence of an error, or none. */
async function refusal(wish: Wish): Promise<string | undefined> {
  return scene(wish).then(
    () => undefined,
    (error: unknown) => String(error),
  );
}

/** What is left of a scene that was closed while a headset was to show it: sessions that did not end, and whether the canvas is still
 *  drawn to. `isEarly`: before the browser gave the session. */
async function headset({ path, isEarly }: { path: string; isEarly: boolean }): Promise<object> {
  const open = new Set<EventTarget>();
  let allow: () => void = () => undefined;
  const requestSession = async (): Promise<EventTarget> => {
    await new Promise<void>((resolve) => (allow = resolve));
    const session = new EventTarget();
    const end = (): Promise<void> => {
      open.delete(session);
      session.dispatchEvent(new Event("end"));
      return Promise.resolve();
    };
    open.add(session);
    return Object.assign(session, { end });
  };
  Object.defineProperty(navigator, "xr", { value: { requestSession }, configurable: true });
  // No device answers: the session stays as it begins.
  WebGL2RenderingContext.prototype.makeXRCompatible = () => new Promise(() => undefined);
  const canvas = document.createElement("canvas");
  const player = await openScene(await sourceOf(path), canvas, "scene.glb");
  let problems = 0;
  player.onProblem = () => (problems += 1);
  void player.enterHeadset(player.film.start).catch(() => undefined);
  const steps = isEarly ? [() => player.close(), allow] : [allow, () => player.close()];
  const sessions: number[] = [];
  for (const step of steps) {
    step();
    await new Promise((resolve) => setTimeout(resolve, 50));
    sessions.push(open.size);
  }
  return { sessions, isLost: canvas.getContext("webgl2")?.isContextLost(), problems };
}

Object.assign(globalThis, { functions: { scene, quilt, refusal, headset } });
