// Vectors of the world: right-handed, +Y up, metres, doubles.

import type { Quaternion, Vec3 } from "../format/types.ts";

export function add(a: Vec3, b: Vec3): Vec3 {
  return [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
}

export function subtract(a: Vec3, b: Vec3): Vec3 {
  return [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
}

export function scaled(a: Vec3, by: number): Vec3 {
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

/** `undefined` where a length of 1 cannot be had. */
export function normalized(a: Vec3): Vec3 | undefined {
  const by = 1 / length(a);
  return Number.isFinite(by) && by > 0 ? scaled(a, by) : undefined;
}

/** Rows of the matrix of a rotation by a quaternion. */
export type Rotation = [Vec3, Vec3, Vec3];

/** How far a quaternion's length may be from 1. */
const UNIT_TOLERANCE = 1e-3;

/** The rotation of an orientation; `undefined` where its length is not 1. */
export function rotation(orientation: Quaternion): Rotation | undefined {
  const size = Math.hypot(...orientation);
  if (!(Math.abs(size - 1) <= UNIT_TOLERANCE)) {
    return undefined;
  }
  const [x, y, z, w] = orientation.map((part) => part / size) as Quaternion;
  return [
    [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
    [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
    [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
  ];
}

export function turned(by: Rotation, a: Vec3): Vec3 {
  return [dot(by[0], a), dot(by[1], a), dot(by[2], a)];
}
