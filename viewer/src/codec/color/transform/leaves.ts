// The blocks of a parsed chunk in few arrays: leaves of the trees of all regions, their levels, palettes and indices.

import { UnsupportedError } from "../../../format/types.ts";
import { MAX_BYTES } from "../samples.ts";

/** Numbers of a leaf in `Leaves.rows`. */
export const LEAF_ROW = 11;
/** Column, row and size of the block in its region: x | y << 8 | size << 16, and flags from bit 24. */
export const LEAF_PLACE = 0;
/** First frame, counted in the chunk, and number of frames: first | count << 8. */
export const LEAF_FRAMES = 1;
/** Of a transform: where the levels of the three channels start, and where they end. */
export const LEAF_LEVELS = 2;
/** Of a transform: the coefficients of the means of three channels. */
export const LEAF_MEAN = 6;
/** Of a transform, by channel in 10 bits each: columns of spatial frequencies less 1 | rows less 1 << 5. */
export const LEAF_EXTENTS = 9;
/** Number of the region. */
export const LEAF_REGION = 10;
/** Of a palette: the first key of its colors, the number of colors, and the first index. */
export const LEAF_COLORS = 2;
export const LEAF_COLOR_COUNT = 3;
export const LEAF_INDICES = 4;

/** Flag of a leaf: it is a palette. */
export const IS_PALETTE = 1 << 24;
/** Flag of a leaf: all its frames are one picture. */
export const IS_STILL = 1 << 25;

/** Arrays that grow as leaves are read. */
export class Leaves {
  rows = new Int32Array(64 * LEAF_ROW);
  count = 0;
  /** Levels other than 0, and their places: 32 · vertical + horizontal frequency | plane << 10. */
  levels = new Int32Array(1024);
  places = new Uint16Array(1024);
  levelCount = 0;
  /** Keys of red, green and blue of palettes. */
  keys = new Uint16Array(256);
  keyCount = 0;
  /** Indices of palettes of more than one color, by frame, row by row. */
  indices = new Uint8Array(1024);
  indexCount = 0;

  /** Answers where the next leaf's row starts, and counts it. */
  add(): number {
    const at = this.count * LEAF_ROW;
    this.rows = withRoom(this.rows, at, LEAF_ROW);
    this.count += 1;
    return at;
  }

  /** Makes room for more levels. */
  reserveLevels(more: number): void {
    if (this.levelCount + more > this.levels.length) {
      this.levels = withRoom(this.levels, this.levelCount, more);
      this.places = withRoom(this.places, this.levelCount, more);
    }
  }

  /** Makes room for more keys of colors. */
  reserveKeys(more: number): void {
    this.keys = withRoom(this.keys, this.keyCount, more);
  }

  /** Makes room for more indices. */
  reserveIndices(more: number): void {
    this.indices = withRoom(this.indices, this.indexCount, more);
  }
}

/** The array, or a larger one of the same start, with room for `more` numbers behind the first `count`. */
function withRoom<T extends Int32Array<ArrayBuffer> | Uint16Array<ArrayBuffer> | Uint8Array<ArrayBuffer>>(
  array: T,
  count: number,
  more: number,
): T {
  if (count + more <= array.length) {
    return array;
  }
  const length = Math.max(2 * array.length, count + more);
  if (length * array.BYTES_PER_ELEMENT > MAX_BYTES) {
    throw new UnsupportedError("A chunk of color has more blocks than this player can hold (color.md 6.4).");
  }
  const larger = new (array.constructor as new (length: number) => T)(length);
  larger.set(array);
  return larger;
}
