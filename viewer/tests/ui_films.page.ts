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

Object.assign(globalThis, { functions: { scene, quilt, refusal } });
