// Quantiser steps (formats/color.md 6.3): 16 an octave, by channel and length.

import { LENGTHS } from "./basis.ts";
import type { Domain } from "./domain.ts";

/** round(4096·2^(i/16)). */
const OCTAVE = [4096, 4277, 4467, 4664, 4871, 5087, 5312, 5547, 5793, 6049, 6317, 6597, 6889, 7194, 7512, 7845];
/** round(4096/√length) of each length. */
const ROOTS = [4096, 2896, 2365, 2048, 1672, 1448, 1182, 1024, 836];

/** Steps of the three channels by the index of the length: step 9 · channel + index (formats/color.md 6.3). Indices are 0 to 255. */
export function stepsOf(lumaIndex: number, chromaIndex: number, domain: Domain): Int32Array {
  const indices = [lumaIndex, Math.min(chromaIndex + 3, 255), Math.min(chromaIndex + 8, 255)];
  const shift = 11 - domain.fractionBits;
  const step = (index: number, root: number) => {
    const mantissa = (OCTAVE[index & 15] * root + 2048) >> 12;
    return Math.max(((mantissa << (index >> 4)) + (1 << (shift - 1))) >> shift, 1);
  };
  return Int32Array.from({ length: indices.length * LENGTHS.length }, (_, at) =>
    step(indices[Math.floor(at / LENGTHS.length)], ROOTS[at % LENGTHS.length]),
  );
}

/** The coefficient of a level (formats/color.md 6.3); wraps in 32 bits. */
export function coefficientOf(level: number, step: number): number {
  return (Math.imul(level, step) + 4) >> 3;
}
