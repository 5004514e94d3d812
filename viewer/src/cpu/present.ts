// Shows pictures on a canvas without a graphics device. Mirrors src/gpu/present.wgsl.

import type { StereoLayout, ToneMapName } from "../views/presentation.ts";

/** A picture of linear light: red, green, blue and alpha, row by row. */
export interface LightPicture {
  size: readonly [number, number];
  rgba: Float32Array;
}

/** How pictures are shown. */
export interface PresentOptions {
  /** Of the canvas. */
  size: readonly [number, number];
  exposureEv: number;
  toneMap: ToneMapName;
  stereo: StereoLayout;
  /** What no probe saw is marked: pixels with an alpha below 1. */
  marksHoles: boolean;
  /** Part of the overlay that is shown, 0 to 1. */
  overlayShare: number;
}

/** Entries of the table of the curve of sRGB. */
const CURVE = 4096;

/** 8-bit codes of light from 0 to 1. */
const CODES = Uint8Array.from({ length: CURVE + 1 }, (_, at) => {
  const light = at / CURVE;
  return Math.round(255 * (light <= 0.0031308 ? 12.92 * light : 1.055 * light ** (1 / 2.4) - 0.055));
});

function codeOf(light: number): number {
  return CODES[Math.round(CURVE * Math.min(Math.max(light, 0), 1))];
}

function toned(light: number, toneMap: ToneMapName): number {
  const x = Math.max(light, 0);
  switch (toneMap) {
    case "none":
      return x;
    case "reinhard":
      return x / (1 + x);
    case "filmic":
      return (x * (2.51 * x + 0.03)) / (x * (2.43 * x + 0.59) + 0.14);
  }
}

/** 8-bit pixels of a picture, over black or the mark of holes, which is magenta. */
function codesOf(
  { rgba }: LightPicture,
  { exposureEv, toneMap, marksHoles }: PresentOptions,
): Uint8ClampedArray<ArrayBuffer> {
  const codes = new Uint8ClampedArray(rgba.length);
  const gain = 2 ** exposureEv;
  for (let at = 0; at < rgba.length; at += 1) {
    if (at % 4 === 3) {
      codes[at] = 255;
      continue;
    }
    const alpha = Math.min(Math.max(rgba[at - (at % 4) + 3], 0), 1);
    const behind = marksHoles && at % 4 !== 1 ? 1 : 0;
    codes[at] = codeOf(toned(behind + alpha * (gain * rgba[at] - behind), toneMap));
  }
  return codes;
}

/** Mixes an overlay into codes of a picture, of which it has the size. */
function mix(codes: Uint8ClampedArray, { rgba }: LightPicture, share: number): void {
  for (let at = 0; at < codes.length; at += 1) {
    if (at % 4 < 3) {
      codes[at] = codes[at] + share * (codeOf(rgba[at]) - codes[at]);
    }
  }
}

/** Draws the picture of the left or only eye, that of the right one, and an overlay, which have one size. */
export function present(
  canvas: HTMLCanvasElement,
  { eyes: [left, right], overlay }: { eyes: readonly LightPicture[]; overlay: LightPicture | undefined },
  options: PresentOptions,
): void {
  const context = canvas.getContext("2d");
  if (context === null) {
    throw new Error("The canvas cannot be drawn to.");
  }
  const [width, height] = left.size;
  const codes = codesOf(left, options);
  const isSplit = options.stereo === "side-by-side";
  [canvas.width, canvas.height] = options.size;
  const others = right && codesOf(right, options);
  if (others !== undefined && !isSplit) {
    for (let at = 0; at < codes.length; at += 4) {
      codes[at + 1] = others[at + 1];
      codes[at + 2] = others[at + 2];
    }
  }
  [codes, isSplit ? others : undefined].forEach((one, at) => {
    if (one !== undefined) {
      if (overlay !== undefined) {
        mix(one, overlay, options.overlayShare);
      }
      // Of an odd width the eyes share a column.
      context.putImageData(new ImageData(one, width, height), at * (canvas.width - width), 0);
    }
  });
}
