// Cameras, and the flat images of probes. Mirrors src/math/camera.rs, src/image/projection.rs and src/image/cube.rs.

import type { Probe, Vec3 } from "../format/types.ts";
import type { Pose } from "../player/types.ts";
import { Frustum, type Window } from "./frustum.ts";
import { add, rotation, scaled, turned } from "./vectors.ts";

/** Number of the face that is the only image of a perspective probe. */
export const VIEW_FACE = 6;

/** A pinhole camera. */
export interface Camera {
  eye: Vec3;
  /** Forward, right and down, of length 1. */
  axes: [Vec3, Vec3, Vec3];
  /** Half the width and half the height of its picture at distance 1. */
  half: [number, number];
}

/** The camera of a pose. `fovDeg` is the vertical field of view, `aspect` width over height. */
export function cameraOf({ eye, yaw, pitch }: Pose, fovDeg: number, aspect: number): Camera {
  const [sinYaw, cosYaw, sinPitch, cosPitch] = [Math.sin(yaw), Math.cos(yaw), Math.sin(pitch), Math.cos(pitch)];
  const half = Math.tan((fovDeg * Math.PI) / 360);
  const forward: Vec3 = [-sinYaw * cosPitch, sinPitch, -cosYaw * cosPitch];
  const right: Vec3 = [cosYaw, 0, -sinYaw];
  const down: Vec3 = [-sinYaw * sinPitch, -cosPitch, -cosYaw * sinPitch];
  return { eye: [...eye], axes: [forward, right, down], half: [half * aspect, half] };
}

/** The camera moved to its right, in metres. */
export function besideOf(camera: Camera, byM: number): Camera {
  return { ...camera, eye: add(camera.eye, scaled(camera.axes[1], byM)) };
}

/** All that a camera sees. */
export function sightLines({ eye, axes, half: [right, down] }: Camera): Frustum {
  return new Frustum(eye, axes, { u: [-right, right], v: [-down, down] }, [0, Infinity]);
}

/** Forward, right and down of the faces of a cube, and of the view of a perspective probe. */
const FACE_AXES: readonly [Vec3, Vec3, Vec3][] = [
  [
    [1, 0, 0],
    [0, 0, -1],
    [0, -1, 0],
  ],
  [
    [-1, 0, 0],
    [0, 0, 1],
    [0, -1, 0],
  ],
  [
    [0, 1, 0],
    [1, 0, 0],
    [0, 0, 1],
  ],
  [
    [0, -1, 0],
    [1, 0, 0],
    [0, 0, -1],
  ],
  [
    [0, 0, 1],
    [1, 0, 0],
    [0, -1, 0],
  ],
  [
    [0, 0, -1],
    [-1, 0, 0],
    [0, -1, 0],
  ],
  [
    [0, 0, -1],
    [1, 0, 0],
    [0, -1, 0],
  ],
];

/** Pixels per unit of u and v, and the position of u = v = 0, as single floats. */
export interface TexelMap {
  scale: [number, number];
  centre: [number, number];
}

/** The map of an image of a face, in pixels (`TexelMap` of src/image/texel_map.rs). */
export function texelMap(face: number, size: [number, number], intrinsics: Probe["intrinsics"]): TexelMap {
  if (face === VIEW_FACE) {
    const [fx, fy, cx, cy] = intrinsics.map(Math.fround);
    return { scale: [fx, fy], centre: [cx, cy] };
  }
  return { scale: [size[0] / 2, size[1] / 2], centre: [size[0] / 2, size[1] / 2] };
}

/** Distance over planar depth at the centre of a pixel, as a single float. */
export function rayLengthFactor({ scale, centre }: TexelMap, column: number, row: number): number {
  const { fround } = Math;
  const u = fround(fround(fround(column + 0.5) - centre[0]) / scale[0]);
  const v = fround(fround(fround(row + 0.5) - centre[1]) / scale[1]);
  return fround(Math.sqrt(fround(fround(1 + fround(u * u)) + fround(v * v))));
}

/** An image of a probe, of which rectangles are asked for. */
export interface FaceImage {
  centre: Vec3;
  axes: [Vec3, Vec3, Vec3];
  /** u and v of a position in pixels. */
  plane: (x: number, y: number) => [number, number];
  /** No surface is nearer, in metres of distance. */
  nearM: number;
}

/** The image of a face of a probe; `undefined` without known directions. */
export function faceImage(
  probe: Probe,
  face: number,
  [width, height]: [number, number],
  nearM: number,
): FaceImage | undefined {
  const turn = rotation(probe.orientation);
  const [fx, fy, cx, cy] = probe.intrinsics;
  const plane = (x: number, y: number): [number, number] =>
    face === VIEW_FACE ? [(x - cx) / fx, (y - cy) / fy] : [(2 * x) / width - 1, (2 * y) / height - 1];
  if (turn === undefined || ![...plane(0, 0), ...plane(1, 1)].every(Number.isFinite)) {
    return undefined;
  }
  const axes = FACE_AXES[face].map((axis) => turned(turn, axis)) as [Vec3, Vec3, Vec3];
  return { centre: probe.position, axes, plane, nearM };
}

/** The frustum of the surfaces of pixels from `from` up to, but without, `to`, and of `margin` pixels around. */
export function frustumOf(image: FaceImage, from: [number, number], to: [number, number], margin: number): Frustum {
  const first = image.plane(from[0] - margin, from[1] - margin);
  const last = image.plane(to[0] + margin, to[1] + margin);
  const edges = (axis: 0 | 1): [number, number] => [
    Math.min(first[axis], last[axis]),
    Math.max(first[axis], last[axis]),
  ];
  const window: Window = { u: edges(0), v: edges(1) };
  // The least planar depth of a surface at a distance is that in the farthest corner.
  const greatest = Math.hypot(1, ...[window.u, window.v].map(([low, high]) => Math.max(Math.abs(low), Math.abs(high))));
  return new Frustum(image.centre, image.axes, window, [image.nearM / greatest, Infinity]);
}
