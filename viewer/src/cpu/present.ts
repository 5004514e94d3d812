// Shows pictures on a canvas without a graphics device.

import { decoder } from "../decoder/module.ts";
import type { Presentation } from "../decoder/types.ts";
import type { StereoLayout } from "../views/presentation.ts";

/** A picture of linear light: red, green, blue and alpha, row by row. */
export interface LightPicture {
  size: readonly [number, number];
  rgba: Float32Array;
}

/** How pictures are shown. */
export interface PresentOptions extends Omit<Presentation, "isAnaglyph"> {
  /** Of the canvas. */
  size: readonly [number, number];
  stereo: StereoLayout;
}

/** Draws the picture of the left or only eye, that of the right one, and an overlay, which have one size. */
export function present(
  canvas: HTMLCanvasElement,
  { eyes, overlay }: { eyes: readonly LightPicture[]; overlay: LightPicture | undefined },
  options: PresentOptions,
): void {
  const context = canvas.getContext("2d");
  if (context === null) {
    throw new Error("The canvas cannot be drawn to.");
  }
  const pictures = [...eyes, ...(overlay === undefined ? [] : [overlay])].map(({ rgba }) => rgba);
  const how = {
    overlayShare: overlay === undefined ? 0 : options.overlayShare,
    isAnaglyph: options.stereo === "anaglyph",
  };
  const codes = decoder().presentPictures(pictures, { ...options, ...how });
  const [width, height] = eyes[0].size;
  [canvas.width, canvas.height] = options.size;
  for (let at = 0; at * 4 * width * height < codes.length; at += 1) {
    const one = codes.slice(at * 4 * width * height, (at + 1) * 4 * width * height);
    // Of an odd width the eyes share a column.
    context.putImageData(new ImageData(one, width, height), at * (canvas.width - width), 0);
  }
}
