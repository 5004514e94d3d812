// Planes of predictive depth: a value and two slopes at a block's centre, with the curvature that planes have in logarithms of depth
// (formats/depth.md 15.6). Numbers have 32 bits and wrap where a file was made so that they overflow.

import type { RansDecoder } from "../rans.ts";
import type { Curvature } from "./projection.ts";

/** The value at the centre of a block in 256ths of a code; slopes to the right and down, in 256ths of a code for each pixel. */
export type Plane = readonly [number, number, number];

const MAX_SLOPE = 1 << 20;
const CHANGE_BITS = [0, 0, 1, 1, 2, 6, 14];
const CHANGE_MIN = [1, 2, 3, 5, 7, 11, 75];

/** A slope within ±2²⁰. */
export function clampSlope(slope: number): number {
  return Math.max(-MAX_SLOPE, Math.min(MAX_SLOPE, slope));
}

/** The same plane, with slopes within ±2²⁰, seen from a centre that lies half pixels further to the right and down. */
export function moved([value, gx, gy]: Plane, [right, down]: readonly [number, number], curvature: Curvature): Plane {
  const distance = (gx * right + gy * down) >> 1;
  const { codes } = curvature;
  if (codes === 0) {
    return [(value + distance) | 0, gx, gy];
  }
  if (Math.abs(distance) > codes << 7) {
    return [value, gx, gy];
  }
  // 4096ths: the change of the logarithm, its square.
  const ratio = Math.trunc((16 * distance) / codes);
  const square = (ratio * ratio) >> 12;
  const bend = (((distance >> 6) * ratio) >> 7) + Math.trunc(((distance >> 6) * square) / 192);
  const steeper = (slope: number): number => clampSlope(slope + (((slope >> 2) * (ratio + square)) >> 10));
  return [(value + distance + bend) | 0, steeper(gx), steeper(gy)];
}

/** The mean of two planes. */
export function meanOf(one: Plane, other: Plane): Plane {
  const mean = (at: 0 | 1 | 2): number => ((one[at] + other[at]) | 0) >> 1;
  return [mean(0), mean(1), mean(2)];
}

/** Units of the changes of planes at an error bound. */
export class PlaneSteps {
  readonly #value: number;
  readonly #slope: number;
  readonly #context: number;

  /** `bound` is 0 to 65534. */
  constructor(bound: number, isQuarter: boolean) {
    this.#value = Math.max(128 * bound, 256);
    this.#slope = Math.max((isQuarter ? 64 : 32) * bound, 16);
    this.#context = isQuarter ? 6 : 0;
  }

  /** Reads the change of a plane, from context `first` of its family on, and applies it. */
  changed([value, gx, gy]: Plane, stream: RansDecoder, first: number): Plane {
    const read = (number: number, before: number): number =>
      readChange(stream, first + this.#context + 2 * number + (before === 0 ? 0 : 1));
    const ofValue = read(0, 0);
    const ofGx = read(1, ofValue);
    const ofGy = read(2, ofGx);
    const slope = (of: number, by: number): number => clampSlope((of + Math.imul(by, this.#slope)) | 0);
    return [(value + Math.imul(ofValue, this.#value)) | 0, slope(gx, ofGx), slope(gy, ofGy)];
  }
}

/** 0, or a magnitude of at least 1 and a sign. */
function readChange(stream: RansDecoder, context: number): number {
  const symbol = stream.symbol(context);
  if (symbol === 0) {
    return 0;
  }
  const kind = (symbol - 1) >> 1;
  const magnitude = CHANGE_MIN[kind] + stream.bits(CHANGE_BITS[kind]);
  return symbol % 2 === 1 ? -magnitude : magnitude;
}
