// Rectangles of pixels in blocks (formats/blocks.md 2).

import { decodeBc1Block } from "./bc1.ts";
import { decodeBc6hBlock } from "./bc6h.ts";
import { decodeBc7Block } from "./bc7.ts";

/** A format whose pixels are red, green and blue. */
export type ColorBlocks = "bc1" | "bc7" | "bc6h";

/** Bytes of the blocks of a rectangle; formats/blocks.md 2. */
export function blockImageBytes(format: ColorBlocks, width: number, height: number): number {
  return Math.ceil(width / 4) * Math.ceil(height / 4) * (format === "bc1" ? 8 : 16);
}

/** Decodes the blocks of a rectangle into red, green, blue of its pixels, row by row: bytes, or bit patterns of half floats of BC6H. All
 *  blocks must be in `bytes`. */
export function decodeBlockImage(
  format: ColorBlocks,
  bytes: Uint8Array,
  size: [number, number],
  out: Uint8Array | Uint16Array,
): void {
  const [width, height] = size;
  const block = format === "bc6h" ? new Uint16Array(48) : new Uint8Array(48);
  let at = 0;
  for (let top = 0; top < height; top += 4) {
    for (let left = 0; left < width; left += 4) {
      if (block instanceof Uint16Array) {
        decodeBc6hBlock(bytes, at, block);
      } else if (format === "bc1") {
        decodeBc1Block(bytes, at, block);
      } else {
        decodeBc7Block(bytes, at, block);
      }
      at += format === "bc1" ? 8 : 16;
      const samples = 3 * Math.min(4, width - left);
      for (let row = 0; row < Math.min(4, height - top); row++) {
        const to = 3 * ((top + row) * width + left);
        for (let sample = 0; sample < samples; sample++) {
          out[to + sample] = block[12 * row + sample];
        }
      }
    }
  }
}
