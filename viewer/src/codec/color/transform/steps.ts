// Quantiser steps (formats/color.md 6.3): 16 an octave, by channel and length.

import type { Domain } from "./domain.ts";

/** round(4096·2^(i/16)). */
export const OCTAVE = [4096, 4277, 4467, 4664, 4871, 5087, 5312, 5547, 5793, 6049, 6317, 6597, 6889, 7194, 7512, 7845];
/** round(4096/√length) of each length. */
export const ROOTS = [4096, 2896, 2365, 2048, 1672, 1448, 1182, 1024, 836];

/** Changes of the step index by frequency, luma then chroma, 64 each: the sets that a payload chooses from. */
export const OFFSET_SETS: readonly Uint8Array[] = [
  new Uint8Array(128),
  // prettier-ignore
  Uint8Array.of(
    1, 3, 5, 7, 8, 9, 10, 10, 11, 12, 12, 13, 13, 14, 14, 15, 15, 15, 16, 16, 16, 17, 17, 17, 18, 18, 18, 18, 19, 19, 19, 19, 19, 20, 20, 20, 20, 20, 21, 21, 21, 21, 21, 21, 22, 22, 22, 22, 22, 22, 22, 23, 23, 23, 23, 23, 23, 23, 23, 24, 24, 24, 24, 24,
    2, 5, 8, 10, 12, 14, 15, 16, 18, 19, 20, 20, 21, 22, 23, 23, 24, 25, 25, 26, 26, 27, 27, 28, 28, 29, 29, 29, 30, 30, 30, 31, 31, 31, 32, 32, 32, 33, 33, 33, 34, 34, 34, 34, 35, 35, 35, 35, 36, 36, 36, 36, 36, 37, 37, 37, 37, 37, 38, 38, 38, 38, 38, 38,
  ),
];

/** Unit of a region's delta, in indices, and the least delta. */
const DELTA_UNIT = 4;
const MIN_DELTA = -8;
/** A delta of 0, as a payload holds it. */
export const NO_DELTA = -MIN_DELTA;

/** Step indices of the three channels of a region, before offsets; `nibble` is the delta as a payload holds it. */
export function regionIndices(luma: number, chroma: number, nibble: number): [number, number, number] {
  const moved = DELTA_UNIT * (nibble + MIN_DELTA);
  return [luma + moved, chroma + 3 + moved, chroma + 8 + moved];
}

/** Index of a length of blocks, and a channel and a size of them, 0 to 3. */
export interface ChannelOfBlock {
  length: number;
  channel: number;
  size: number;
}

/** The steps of a channel of blocks, by the sum of spatial frequencies (formats/color.md 6.3); `index` is of `regionIndices`. */
export function stepsOf(
  { length, channel, size }: ChannelOfBlock,
  index: number,
  offsetSet: number,
  domain: Domain,
): (frequency: number) => number {
  const offsets = OFFSET_SETS[offsetSet].subarray(channel > 0 ? 64 : 0);
  const shift = 11 - domain.fractionBits;
  return (frequency) => {
    const at = Math.min(Math.max(index + offsets[((2 * frequency + 1) << (3 - size)) >> 1], 0), 255);
    const mantissa = (OCTAVE[at & 15] * ROOTS[length] + 2048) >> 12;
    return Math.max(((mantissa << (at >> 4)) + (1 << (shift - 1))) >> shift, 1);
  };
}

/** The coefficient of a level (formats/color.md 6.3); wraps in 32 bits. */
export function coefficientOf(level: number, step: number): number {
  return (Math.imul(level, step) + 4) >> 3;
}
