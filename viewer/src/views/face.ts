// Images of probes: faces of cubes, and pinhole images. Mirrors src/codec/image/texel_map.rs (formats/container.md 4 and 5).

import type { Probe } from "../format/types.ts";

/** Number of the image of a perspective probe; 0 to 5 are px nx py ny pz nz. */
export const VIEW_FACE = 6;

/** Position of (u, v), on the plane at distance 1, in an image: `[u, v] * scale + center`, in pixels. */
export interface TexelMap {
  scale: [number, number];
  center: [number, number];
}

/** The map of an image of `width` x `height` pixels; `intrinsics` are those of a perspective probe. */
export function texelMap(face: number, [width, height]: [number, number], intrinsics: Probe["intrinsics"]): TexelMap {
  const [fx, fy, cx, cy] = intrinsics;
  return face === VIEW_FACE
    ? { scale: [fx, fy], center: [cx, cy] }
    : { scale: [width / 2, height / 2], center: [width / 2, height / 2] };
}

/** Distance over planar depth in the middle of a pixel, in steps of single floats. */
export function rayLength({ scale, center }: TexelMap, column: number, row: number): number {
  const { fround } = Math;
  const along = (at: number, axis: 0 | 1): number =>
    fround(fround(at + 0.5 - fround(center[axis])) / fround(scale[axis]));
  const [u, v] = [along(column, 0), along(row, 1)];
  return fround(Math.sqrt(fround(fround(1 + fround(u * u)) + fround(v * v))));
}
