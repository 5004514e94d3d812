// Vectors and rotations in double precision.

import type { Quaternion, Vec3 } from "./format/types.ts";

/** Three vectors: forward, right and down of a picture, or the rows of a matrix. */
export type Axes = readonly [Vec3, Vec3, Vec3];

/** The length of a quaternion that is a rotation differs from 1 by this at most. */
const UNIT_TOLERANCE = 1e-3;

export function add(a: Vec3, b: Vec3): Vec3 {
  return [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
}

export function subtract(a: Vec3, b: Vec3): Vec3 {
  return [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
}

export function scale(a: Vec3, by: number): Vec3 {
  return [a[0] * by, a[1] * by, a[2] * by];
}

export function dot(a: Vec3, b: Vec3): number {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

export function cross(a: Vec3, b: Vec3): Vec3 {
  return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
}

export function length(a: Vec3): number {
  return Math.sqrt(dot(a, a));
}

export function distance(a: Vec3, b: Vec3): number {
  return length(subtract(a, b));
}

/** The quaternion with length 1, `undefined` where its length is too far from that. */
export function rotation([x, y, z, w]: Quaternion): Quaternion | undefined {
  const size = Math.sqrt(x * x + y * y + z * z + w * w);
  const by = 1 / size;
  return Math.abs(size - 1) <= UNIT_TOLERANCE ? [x * by, y * by, z * by, w * by] : undefined;
}

/** A vector turned by a quaternion of length 1. */
export function rotate([x, y, z, w]: Quaternion, a: Vec3): Vec3 {
  const axis: Vec3 = [x, y, z];
  const along = scale(axis, 2 * dot(a, axis));
  const across = scale(cross(axis, a), 2 * w);
  return add(add(scale(a, w * w - dot(axis, axis)), along), across);
}

/** The quaternion of length 1 that turns back. */
export function inverse([x, y, z, w]: Quaternion): Quaternion {
  return [-x, -y, -z, w];
}
