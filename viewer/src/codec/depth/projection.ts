// What the projection of a stream does to predictive depth: corrections of pixels, and the curvature of planes (formats/depth.md 15.3).

import type { UnitArea } from "../types.ts";
import { integerLog2 } from "./domain.ts";

/** How pixels lie to the viewing axis, by its number in the header (depth.md 3): 0, no term; 1, planar depth of a pinhole camera or a
 *  cube face; 2, distances in a cube face. */
export type Shape = 0 | 1 | 2;

/** `octave`: codes for each factor of two of depth, 512 to 131071; 0 with shape 0. */
export interface Projection {
  shape: Shape;
  octave: number;
}

/** Terms of second order of planes: codes for each factor of e of depth, and 2²² over them; both 0 without a term. */
export interface Curvature {
  codes: number;
  factor: number;
}

/** K and R of depth.md 15.3. */
export function curvatureOf({ octave }: Projection): Curvature {
  const codes = (octave * 2955) >>> 11;
  return { codes, factor: codes === 0 ? 0 : Math.floor(0x400000 / codes) };
}

/** Corrections of a unit's pixels, row by row, in 256ths of a code; `undefined` where all are 0. */
export function correctionsOf({ shape, octave }: Projection, area: UnitArea): Int32Array | undefined {
  if (shape !== 2) {
    return undefined;
  }
  const side = area.imageSize[0];
  const [left, top, width, height] = area.rect;
  const out = new Int32Array(width * height);
  const logs = faceLogs(side);
  let at = 0;
  for (let y = top; y < top + height; y += 1) {
    for (let x = left; x < left + width; x += 1) {
      const log = logs === undefined ? logAt(side, x, y) : logs[y * side + x];
      out[at] = Math.imul(log, octave) >>> 7;
      at += 1;
    }
  }
  return out;
}

/** Logarithm, in 16384ths of a factor of two, of the square of distance over depth at a pixel of a face. */
function logAt(side: number, x: number, y: number): number {
  const a = 2 * x + 1 - side;
  const b = 2 * y + 1 - side;
  return (integerLog2(side * side + a * a + b * b) - integerLog2(side * side)) >>> 10;
}

/** Faces up to this side are kept, 8 MiB each. */
const MAX_KEPT_SIDE = 2048;
/** Faces of so many sides are kept, those used last. */
const MAX_KEPT = 2;
const kept = new Map<number, Uint16Array>();

/** `logAt` of all pixels of a face, which units of all streams share. */
function faceLogs(side: number): Uint16Array | undefined {
  if (side > MAX_KEPT_SIDE) {
    return undefined;
  }
  let logs = kept.get(side);
  if (logs === undefined) {
    logs = new Uint16Array(side * side);
    for (let y = 0; y < side; y += 1) {
      for (let x = 0; x < side; x += 1) {
        logs[y * side + x] = logAt(side, x, y);
      }
    }
  }
  kept.delete(side);
  kept.set(side, logs);
  for (const first of kept.keys()) {
    if (kept.size > MAX_KEPT) {
      kept.delete(first);
    }
  }
  return logs;
}
