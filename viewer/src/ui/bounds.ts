// Where the eye may be: the head box and a small margin, in which it is slowed.

import type { Vec3 } from "../format/types.ts";

/** A box in metres. */
export interface Box {
  least: Vec3;
  greatest: Vec3;
}

/** Part of the longest side of the box that the margin takes, and its least value in metres. */
const MARGIN_SHARE = 0.1;
const MIN_MARGIN_M = 0.1;

/** Metres around a head box that the eye can use. */
export function marginOf({ least, greatest }: Box): number {
  const sides = least.map((value, axis) => greatest[axis] - value);
  return Math.max(MARGIN_SHARE * Math.max(...sides), MIN_MARGIN_M);
}

/** Moves a coordinate that may be in `least - margin` to `greatest + margin`. In the box the step is whole; beyond a wall each
 *  part of it counts by the share of the margin that is left, so that the end is never reached. On the way back it is whole. Two halves of a step are as good as one. */
export function moveWithin(from: number, step: number, [least, greatest]: [number, number], margin: number): number {
  if (step < 0) {
    return -moveWithin(-from, -step, [-greatest, -least], margin);
  }
  const free = Math.min(step, Math.max(greatest - from, 0));
  const limit = greatest + margin;
  const rest = step - free;
  if (rest === 0) {
    return from + free;
  }
  const at = Math.max(from, greatest);
  return limit - Math.max(limit - at, 0) * Math.exp(-rest / margin);
}

/** The eye after a step in metres. */
export function moveEye(eye: Vec3, step: Vec3, box: Box): Vec3 {
  const margin = marginOf(box);
  const axis = (at: 0 | 1 | 2): number => moveWithin(eye[at], step[at], [box.least[at], box.greatest[at]], margin);
  return [axis(0), axis(1), axis(2)];
}

/** The nearest point of the box with its margin. */
export function clampEye(eye: Vec3, box: Box): Vec3 {
  const margin = marginOf(box);
  const axis = (at: 0 | 1 | 2): number =>
    Math.min(Math.max(eye[at], box.least[at] - margin), box.greatest[at] + margin);
  return [axis(0), axis(1), axis(2)];
}
