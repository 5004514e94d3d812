// The player of scenes on a canvas, for ui.test.ts.

import { openScene } from "../src/glb/main.ts";
import type { ScenePlayer } from "../src/glb/main.ts";
import type { ByteSource } from "../src/format/types.ts";
import type { View } from "../src/player/types.ts";

let scene: ScenePlayer | undefined;

/** Opens `/scene.glb` once and draws a view. Answers the film, the counters, the light, and the canvas as a data URL. */
async function draw({ view, isOverdraw }: { view: Omit<View, "overlays">; isOverdraw: boolean }): Promise<object> {
  const canvas = document.body.querySelector("canvas") ?? document.body.appendChild(document.createElement("canvas"));
  if (scene === undefined) {
    const bytes = new Uint8Array(await (await fetch("/scene.glb")).arrayBuffer());
    const source: ByteSource = {
      byteCount: bytes.length,
      read: (offset, count) => Promise.resolve(bytes.slice(offset, offset + count)),
    };
    scene = await openScene(source, canvas, "scene.glb");
  }
  scene.showOverdraw(isOverdraw);
  const { counters } = await scene.draw({ ...view, overlays: new Set() });
  const { size, rgba } = await scene.pixels();
  return { film: scene.film, counters, size, rgba: [...rgba], url: canvas.toDataURL() };
}

Object.assign(globalThis, { functions: { draw } });
