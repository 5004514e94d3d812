// Shows pictures on a canvas without a graphics device.

import { decoder } from "../decoder/module.ts";
import type { Presentation } from "../decoder/types.ts";
import type { StereoLayout } from "../views/presentation.ts";

/** How pictures are shown. */
export interface PresentOptions extends Omit<Presentation, "isAnaglyph"> {
  /** Of the canvas. */
  size: readonly [number, number];
  stereo: StereoLayout;
}

/** Draws the picture of the left or only eye, that of the right one, and an overlay: linear light and alpha of `width` x `height` pixels. */
export function present(
  canvas: HTMLCanvasElement,
  [width, height]: readonly [number, number],
  { eyes, overlay }: { eyes: readonly Float32Array[]; overlay: Float32Array | undefined },
  options: PresentOptions,
): void {
  const context = canvas.getContext("2d");
  if (context === null) {
    throw new Error("The canvas cannot be drawn to.");
  }
  const overlayShare = overlay === undefined ? 0 : options.overlayShare;
  const how = { ...options, overlayShare, isAnaglyph: options.stereo === "anaglyph" };
  const codes = decoder().presentPictures(overlay === undefined ? eyes : [...eyes, overlay], how);
  [canvas.width, canvas.height] = options.size;
  const bytes = 4 * width * height;
  for (let at = 0; at * bytes < codes.length; at += 1) {
    const one = new ImageData(codes.slice(at * bytes, (at + 1) * bytes), width, height);
    // Both eyes share a column of an odd width.
    context.putImageData(one, at * (canvas.width - width), 0);
  }
}
