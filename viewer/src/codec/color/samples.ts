// Samples of color: bytes, or bit patterns of half floats, whose keys ascend with their values (formats/arithmetic.md 3 and 4).

import { UnsupportedError } from "../../format/types.ts";

/** Red, green and blue of pixels, row by row: bytes, or bit patterns of half floats. */
export type Samples = Uint8Array | Uint16Array;

/** Most bytes of a picture of a cell, and of what one chunk is parsed into. */
export const MAX_BYTES = 2 ** 30;

/** Room for the samples of a picture. */
export function roomFor(pixels: number, isHalf: boolean): Samples {
  if (3 * pixels * (isHalf ? 2 : 1) > MAX_BYTES) {
    throw new UnsupportedError(
      `A cell of ${pixels} pixels of color is larger than this player can decode (color.md 1).`,
    );
  }
  return isHalf ? new Uint16Array(3 * pixels) : new Uint8Array(3 * pixels);
}

/** The key of the bit pattern of a half float (formats/arithmetic.md 4); both have 16 bits. */
export function keyOf(bits: number): number {
  return bits ^ (bits >= 0x8000 ? 0xffff : 0x8000);
}

/** The bit pattern of a key (formats/arithmetic.md 4). */
export function bitsOf(key: number): number {
  return key ^ (key >= 0x8000 ? 0x8000 : 0xffff);
}

/** Writes `weight` 255ths of the way from `a` to `b`, of half floats by their keys, to nearest (formats/color.md 3). */
export function blendInto(out: Samples, a: Samples, b: Samples, weight: number): void {
  const rest = 255 - weight;
  if (out instanceof Uint8Array) {
    for (let at = 0; at < out.length; at++) {
      const value = a[at] * rest + b[at] * weight + 128;
      out[at] = (value + (value >> 8)) >> 8;
    }
  } else {
    for (let at = 0; at < out.length; at++) {
      out[at] = bitsOf(((keyOf(a[at]) * rest + keyOf(b[at]) * weight + 127) / 255) | 0);
    }
  }
}
