// Blocks of few colors: a palette, and an index for each pixel (formats/color.md 6.8).

import { FormatError } from "../../../format/types.ts";
import { colorModel } from "../../entropy.ts";
import type { RansDecoder } from "../../rans.ts";
import type { Leaves } from "./leaves.ts";

/** Colors of the cache; the symbol of a new color. */
const CACHED = 15;

/** Reads palettes of a region into `Leaves`, with the cache of colors that its earlier ones had. */
export class PaletteReader {
  /** Keys of the colors, the latest first; zeros where there are none yet. */
  readonly #cache = new Uint16Array(3 * CACHED);
  #held = 0;
  readonly #contexts = colorModel().firstContext;
  readonly #known = new Uint8Array(3);

  /** Starts a region, with the keys of the payload's colors. */
  start(colors: Uint16Array): void {
    this.#cache.fill(0);
    this.#cache.set(colors);
    this.#held = colors.length / 3;
  }

  /** Reads the colors of a block of a size, 0 to 3, and answers their number, 1 to 16. */
  readColors(stream: RansDecoder, size: number, keyBits: number, leaves: Leaves): number {
    const count = stream.symbol(this.#contexts.paletteSize + size) + 1;
    leaves.reserveKeys(3 * count);
    const { keys } = leaves;
    const first = leaves.keyCount;
    for (let at = first; at < first + 3 * count; at += 3) {
      const place = stream.symbol(this.#contexts.paletteColor);
      for (let channel = 0; channel < 3; channel++) {
        keys[at + channel] = place < CACHED ? this.#cache[3 * place + channel] : stream.bits(keyBits);
      }
    }
    leaves.keyCount += 3 * count;
    for (let color = count - 1; color >= 0; color--) {
      this.#touch(keys, first + 3 * color);
    }
    return count;
  }

  /** Moves the color at `keys[at]` to the front of the cache; the last one is dropped where it is new and the cache is full. */
  #touch(keys: Uint16Array, at: number): void {
    const cache = this.#cache;
    let place = 0;
    while (
      place < this.#held &&
      !(cache[3 * place] === keys[at] && cache[3 * place + 1] === keys[at + 1] && cache[3 * place + 2] === keys[at + 2])
    ) {
      place += 1;
    }
    if (place === this.#held) {
      place = Math.min(place, CACHED - 1);
      this.#held = place + 1;
    }
    cache.copyWithin(3, 0, 3 * place);
    cache.set(keys.subarray(at, at + 3));
  }

  /** Reads the indices of a block of a side in pixels and some frames, for a palette of 2 to 16 colors. */
  readIndices(stream: RansDecoder, side: number, frames: number, leaves: Leaves, colors: number): void {
    const pixels = side * side;
    leaves.reserveIndices(pixels * frames);
    const { indices, indexCount: first } = leaves;
    leaves.indexCount += pixels * frames;
    this.#readFirstFrame(stream, side, indices.subarray(first, first + pixels), colors);
    let repeats = 0;
    for (let frame = 1; frame < frames; frame++) {
      const at = first + frame * pixels;
      repeats = stream.symbol(this.#contexts.laterFrame + repeats);
      if (repeats === 1) {
        indices.copyWithin(at, at - pixels, at);
      } else {
        this.#readLaterFrame(stream, side, indices.subarray(at - pixels, at + pixels), colors);
      }
    }
  }

  #readFirstFrame(stream: RansDecoder, side: number, frame: Uint8Array, colors: number): void {
    const { row: rowAt, pixel: pixelAt } = this.#contexts;
    let repeats = 0;
    for (let y = 0; y < side; y++) {
      const row = y * side;
      repeats = y > 0 ? stream.symbol(rowAt + repeats) : 0;
      if (repeats === 1) {
        frame.copyWithin(row, row - side, row);
        continue;
      }
      for (let at = row; at < row + side; at++) {
        const isFirst = at === row;
        let above = y > 0 ? frame[at - side] : -1;
        const left = isFirst ? Math.max(above, 0) : frame[at - 1];
        above = y > 0 ? above : left;
        const aboveLeft = y > 0 && !isFirst ? frame[at - side - 1] : above;
        const aboveRight = y > 0 && at + 1 < row + side ? frame[at - side + 1] : above;
        const context =
          (left === above ? 1 : 0) |
          (aboveLeft === left ? 2 : 0) |
          (aboveLeft === above ? 4 : 0) |
          (aboveRight === above ? 8 : 0);
        this.#known[0] = left;
        this.#known[1] = above;
        frame[at] = this.#choose(stream, pixelAt + context, left === above ? 1 : 2, colors);
      }
    }
  }

  /** Reads the second of two frames, the first being known. */
  #readLaterFrame(stream: RansDecoder, side: number, both: Uint8Array, colors: number): void {
    const { laterRow: rowAt, laterPixel: pixelAt } = this.#contexts;
    const pixels = side * side;
    let repeats = 0;
    for (let y = 0; y < side; y++) {
      const row = pixels + y * side;
      repeats = stream.symbol(rowAt + repeats);
      if (repeats === 1) {
        both.copyWithin(row, row - pixels, row - pixels + side);
        continue;
      }
      for (let at = row; at < row + side; at++) {
        const held = both[at - pixels];
        const [hasLeft, hasAbove] = [at > row, y > 0];
        const left = hasLeft ? both[at - 1] : hasAbove ? both[at - side] : held;
        const above = hasAbove ? both[at - side] : left;
        const context =
          (hasLeft && left !== both[at - 1 - pixels] ? 1 : 0) |
          (hasAbove && above !== both[at - side - pixels] ? 2 : 0) |
          (left === held ? 4 : 0) |
          (above === held ? 8 : 0);
        both[at] = this.#choose(stream, pixelAt + context, this.#distinct(held, left, above), colors);
      }
    }
  }

  /** Notes three candidates without repetition, and answers how many there are. */
  #distinct(held: number, left: number, above: number): number {
    const known = this.#known;
    known[0] = held;
    let count = 1;
    if (left !== held) {
      known[count++] = left;
    }
    if (above !== held && above !== left) {
      known[count++] = above;
    }
    return count;
  }

  /** Reads which of the candidates an index is, or the index itself. */
  #choose(stream: RansDecoder, context: number, candidates: number, colors: number): number {
    const symbol = stream.symbol(context);
    if (symbol < candidates) {
      return this.#known[symbol];
    }
    const index = stream.bits(32 - Math.clz32(colors - 1));
    if (index >= colors) {
      throw new FormatError("A pixel names a color that its palette does not have (color.md 6.8).");
    }
    return index;
  }
}
