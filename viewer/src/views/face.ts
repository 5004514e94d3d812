// Images of probes: faces of cubes, and pinhole images. Mirrors src/codec/image/cube.rs, projection.rs and texel_map.rs, and
// src/render/views/face_frustum.rs (formats/container.md 4 and 5).

import type { Probe, Vec3 } from "../format/types.ts";
import type { Axes } from "../math.ts";
import { rotate, rotation } from "../math.ts";
import type { Frustum } from "./frustum.ts";
import { frustum } from "./frustum.ts";

/** Number of the image of a perspective probe; 0 to 5 are px nx py ny pz nz. */
export const VIEW_FACE = 6;

const [X, Y, Z]: Axes = [
  [1, 0, 0],
  [0, 1, 0],
  [0, 0, 1],
];
const [NEGATIVE_X, NEGATIVE_Y, NEGATIVE_Z]: Axes = [
  [-1, 0, 0],
  [0, -1, 0],
  [0, 0, -1],
];

/** Forward, right and down of faces 0 to 6, in the axes of the probe. */
export const FACE_AXES: readonly Axes[] = [
  [X, NEGATIVE_Z, NEGATIVE_Y],
  [NEGATIVE_X, Z, NEGATIVE_Y],
  [Y, X, Z],
  [NEGATIVE_Y, X, NEGATIVE_Z],
  [Z, X, NEGATIVE_Y],
  [NEGATIVE_Z, NEGATIVE_X, NEGATIVE_Y],
  [NEGATIVE_Z, X, NEGATIVE_Y],
];

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

/** An image in the world. */
export interface FaceImage {
  center: Vec3;
  /** Forward, right, down. */
  axes: Axes;
  /** (u, v) of a position in pixels. */
  plane: (x: number, y: number) => [number, number];
}

/** The image of a face; `undefined` without known directions: a view without intrinsics, or an orientation whose length is not 1. */
export function faceImage(probe: Probe, face: number, [width, height]: [number, number]): FaceImage | undefined {
  const turn = rotation(probe.orientation);
  const axes = FACE_AXES[face];
  if (turn === undefined || axes === undefined) {
    return undefined;
  }
  const [fx, fy, cx, cy] = probe.intrinsics;
  const plane: FaceImage["plane"] =
    face === VIEW_FACE
      ? (x, y) => [(x - cx) / fx, (y - cy) / fy]
      : (x, y) => [(2 * x) / width - 1, (2 * y) / height - 1];
  const isUsable = [...plane(0, 0), ...plane(1, 1)].every((value) => Number.isFinite(value));
  const turned = axes.map((axis) => rotate(turn, axis)) as unknown as Axes;
  return isUsable ? { center: probe.position, axes: turned, plane } : undefined;
}

/** The frustum of pixels from `from` up to, but without, `to` (column, row), `margin` pixels larger on each side: of all points that are
 *  at least `nearM` metres from the probe. */
export function unitFrustum(
  { center, axes, plane }: FaceImage,
  from: readonly [number, number],
  to: readonly [number, number],
  { margin, nearM }: { margin: number; nearM: number },
): Frustum {
  const first = plane(from[0] - margin, from[1] - margin);
  const last = plane(to[0] + margin, to[1] + margin);
  const edges = (axis: 0 | 1): [number, number] => [
    Math.min(first[axis], last[axis]),
    Math.max(first[axis], last[axis]),
  ];
  const [u, v] = [edges(0), edges(1)];
  const farthest = ([low, high]: [number, number]): number => Math.max(Math.abs(low), Math.abs(high));
  const longest = Math.sqrt(1 + farthest(u) ** 2 + farthest(v) ** 2);
  return frustum(center, axes, { u, v }, nearM / longest);
}
