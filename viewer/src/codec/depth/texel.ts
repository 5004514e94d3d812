// Pixels of chunks of boxes: codes of depth, and the three bytes of material (formats/depth.md 4, 5 and 14).

import { decodeBc1Block } from "../block/bc1.ts";
import { decodeBc5Block } from "../block/bc4.ts";
import type { Pixels } from "../types.ts";

/** A kind of pixel, and how it is stored. */
export interface Texel {
  /** Bytes of a value. */
  readonly bytes: number;
  /** Elements of a pixel in a picture. */
  readonly samples: number;
  /** Bytes of a block of 4x4 pixels. */
  readonly blockBytes: number;
  /** A picture of so many pixels, zeros. */
  picture(pixels: number): Pixels;
  /** Decodes `count` values at byte `at` to element `to` of a picture. */
  decodeValues(bytes: Uint8Array, at: number, out: Pixels, to: number, count: number): void;
  /** Decodes the block at byte `at` to the elements of 16 pixels, row by row. */
  decodeBlock(bytes: Uint8Array, at: number, out: Pixels): void;
}

const pairs = new Uint8Array(32);
const triples = new Uint8Array(48);

/** Codes of 16 bits; blocks are BC5, whose red is the high byte. */
export const CODES: Texel = {
  bytes: 2,
  samples: 1,
  blockBytes: 16,
  picture: (pixels) => new Uint16Array(pixels),
  decodeValues(bytes, at, out, to, count) {
    for (let pixel = 0; pixel < count; pixel += 1) {
      out[to + pixel] = bytes[at + 2 * pixel] | (bytes[at + 2 * pixel + 1] << 8);
    }
  },
  decodeBlock(bytes, at, out) {
    decodeBc5Block(bytes, at, pairs);
    for (let pixel = 0; pixel < 16; pixel += 1) {
      out[pixel] = (pairs[2 * pixel] << 8) | pairs[2 * pixel + 1];
    }
  },
};

/** Reflection weight, refraction weight and index of refraction, a byte each; blocks are BC1. */
export const MATERIALS: Texel = {
  bytes: 3,
  samples: 3,
  blockBytes: 8,
  picture: (pixels) => new Uint8Array(3 * pixels),
  decodeValues(bytes, at, out, to, count) {
    out.set(bytes.subarray(at, at + 3 * count), to);
  },
  decodeBlock(bytes, at, out) {
    decodeBc1Block(bytes, at, triples);
    out.set(triples);
  },
};
