// A chunk of the transform codec: reads it, and shows frames of it (formats/color.md 6).

import { FormatError } from "../../../format/types.ts";
import { type EntropyTables, tableSet } from "../../entropy.ts";
import { bitsOf, type Samples } from "../samples.ts";
import { BASIS_BITS, lengthIndex, TIME_BASES } from "./basis.ts";
import { CHANNELS, type Domain, domainOf, pixelFraction, predictChroma } from "./domain.ts";
import { inverseTransform } from "./inverse.ts";
import * as leaf from "./leaves.ts";
import { passesOf } from "./passes.ts";
import { type Layout, parseLayout, regionRect } from "./payload.ts";
import { RegionReader } from "./region.ts";

const MAX_PIXELS = 32 * 32;
/** Room for the coefficients of a channel of a block, and for the values of the three channels. */
const coefficients = new Int32Array(MAX_PIXELS);
const planes = Array.from({ length: CHANNELS }, () => new Int32Array(MAX_PIXELS));

/** The part of a block that lies in the cell, in pixels, and where a leaf's row starts. */
interface Window {
  row: number;
  left: number;
  top: number;
  columns: number;
  rows: number;
}

/** What shows a frame of a block, read from a leaf's row. */
interface BlockFrame {
  size: number;
  /** Counted in the block. */
  frame: number;
  frames: number;
}

/** A chunk as it was read: any of its frames can be shown. */
export class TransformChunk {
  readonly layout: Layout;
  readonly format: { size: [number, number]; isHalf: boolean };
  readonly #domain: Domain;
  readonly #leaves: leaf.Leaves;

  /** Reads and checks a payload of `frames` frames, at most 96 (formats/color.md 6.4). */
  constructor(payload: Uint8Array, format: TransformChunk["format"], frames: number, tables: EntropyTables) {
    const { size } = format;
    this.format = format;
    this.#domain = domainOf(format.isHalf);
    this.layout = parseLayout(payload, size, tables, this.#domain);
    const set = tableSet(tables, this.layout.set);
    if (set === undefined) {
      throw new FormatError(`The stream has no table set ${this.layout.set} (color.md 6.4).`);
    }
    const reader = new RegionReader(this.layout, this.#domain, set);
    const { substreams } = this.layout;
    for (let region = 0; region + 1 < substreams.length; region++) {
      const [, , width, height] = regionRect(size, region);
      reader.read(payload.subarray(substreams[region], substreams[region + 1]), [width, height], frames);
    }
    this.#leaves = reader.leaves;
  }

  /** Writes a frame into `out`, three samples a pixel; blocks that look the same in frame `shown`, which is in `out`, are left alone. */
  show(frame: number, shown: number | undefined, out: Samples): void {
    const { rows, count } = this.#leaves;
    for (let row = 0; row < count * leaf.LEAF_ROW; row += leaf.LEAF_ROW) {
      if (!this.#contains(row, frame) || (shown !== undefined && this.#isSame(row, frame, shown))) {
        continue;
      }
      const window = this.#window(row);
      if (window === undefined) {
        continue;
      }
      const place = rows[row + leaf.LEAF_PLACE];
      const span = rows[row + leaf.LEAF_FRAMES];
      const block = { size: (place >> 16) & 3, frame: frame - (span & 0xff), frames: span >> 8 };
      if ((place & leaf.IS_PALETTE) !== 0) {
        this.#writePalette(window, block, out);
      } else {
        this.#writeTransform(window, block, out);
      }
    }
  }

  /** Passes in which a device reads its regions, at most. */
  get passes(): number {
    return passesOf(this.#leaves);
  }

  /** Pixels of blocks that look the same in a set of frames, by that set: bit f is frame f. */
  pixelsOfFrames(): Map<bigint, number> {
    const { rows, count } = this.#leaves;
    const sets = new Map<bigint, number>();
    // Most sets are runs of frames: first | count << 8.
    const runs = new Map<number, number>();
    for (let row = 0; row < count * leaf.LEAF_ROW; row += leaf.LEAF_ROW) {
      const window = this.#window(row);
      if (window === undefined) {
        continue;
      }
      const pixels = window.columns * window.rows;
      const [place, span] = [rows[row + leaf.LEAF_PLACE], rows[row + leaf.LEAF_FRAMES]];
      if ((place & leaf.IS_STILL) !== 0) {
        runs.set(span, (runs.get(span) ?? 0) + pixels);
      } else if ((place & leaf.IS_PALETTE) !== 0) {
        for (const frames of this.#framesOf(row, span & 0xff, span >> 8)) {
          sets.set(frames, (sets.get(frames) ?? 0) + pixels);
        }
      } else {
        for (let frame = span & 0xff; frame < (span & 0xff) + (span >> 8); frame++) {
          const alone = frame | (1 << 8);
          runs.set(alone, (runs.get(alone) ?? 0) + pixels);
        }
      }
    }
    for (const [run, pixels] of runs) {
      const frames = ((1n << BigInt(run >> 8)) - 1n) << BigInt(run & 0xff);
      sets.set(frames, (sets.get(frames) ?? 0) + pixels);
    }
    return sets;
  }

  /** Sets of frames in which a palette looks the same. */
  #framesOf(row: number, first: number, count: number): bigint[] {
    const sets: bigint[] = [];
    const seen = new Uint8Array(count);
    for (let frame = 0; frame < count; frame++) {
      if (seen[frame] === 1) {
        continue;
      }
      let set = 1n << BigInt(first + frame);
      for (let other = frame + 1; other < count; other++) {
        if (seen[other] === 0 && this.#isSame(row, first + frame, first + other)) {
          seen[other] = 1;
          set |= 1n << BigInt(first + other);
        }
      }
      sets.push(set);
    }
    return sets;
  }

  /** The part of a block that lies in the cell, if there is one. */
  #window(row: number): Window | undefined {
    const { rows } = this.#leaves;
    const [left, top, width, height] = regionRect(this.format.size, rows[row + leaf.LEAF_REGION]);
    const place = rows[row + leaf.LEAF_PLACE];
    const [x, y, side] = [place & 0xff, (place >> 8) & 0xff, 4 << ((place >> 16) & 3)];
    const [columns, lines] = [Math.min(side, width - x), Math.min(side, height - y)];
    return columns > 0 && lines > 0 ? { row, left: left + x, top: top + y, columns, rows: lines } : undefined;
  }

  #contains(row: number, frame: number): boolean {
    const span = this.#leaves.rows[row + leaf.LEAF_FRAMES];
    return frame >= (span & 0xff) && frame < (span & 0xff) + (span >> 8);
  }

  /** Whether a frame of a block looks the same in another one. */
  #isSame(row: number, frame: number, other: number): boolean {
    const { rows, indices } = this.#leaves;
    const place = rows[row + leaf.LEAF_PLACE];
    if (!this.#contains(row, other)) {
      return false;
    }
    if (frame === other || (place & leaf.IS_STILL) !== 0) {
      return true;
    }
    if ((place & leaf.IS_PALETTE) === 0) {
      return false;
    }
    const pixels = 16 << (2 * ((place >> 16) & 3));
    const first = rows[row + leaf.LEAF_INDICES] - (rows[row + leaf.LEAF_FRAMES] & 0xff) * pixels;
    const [one, two] = [first + frame * pixels, first + other * pixels];
    for (let at = 0; at < pixels; at++) {
      if (indices[one + at] !== indices[two + at]) {
        return false;
      }
    }
    return true;
  }

  #writePalette({ row, left, top, columns, rows }: Window, { size, frame }: BlockFrame, out: Samples): void {
    const { rows: leaves, keys, indices } = this.#leaves;
    const side = 4 << size;
    const firstKey = leaves[row + leaf.LEAF_COLORS];
    const isOne = leaves[row + leaf.LEAF_COLOR_COUNT] === 1;
    const firstIndex = leaves[row + leaf.LEAF_INDICES] + frame * side * side;
    const { isHalf } = this.#domain;
    for (let y = 0; y < rows; y++) {
      let to = 3 * ((top + y) * this.format.size[0] + left);
      for (let x = 0; x < columns; x++) {
        const key = firstKey + (isOne ? 0 : 3 * indices[firstIndex + y * side + x]);
        for (let channel = 0; channel < 3; channel++) {
          out[to + channel] = isHalf ? bitsOf(keys[key + channel]) : keys[key + channel];
        }
        to += 3;
      }
    }
  }

  #writeTransform(window: Window, block: BlockFrame, out: Samples): void {
    const length = lengthIndex(block.frames);
    const fraction = pixelFraction(this.#domain, this.layout.offsetSet);
    for (let channel = 0; channel < CHANNELS; channel++) {
      const extents = this.#leaves.rows[window.row + leaf.LEAF_EXTENTS] >> (10 * channel);
      const extent: [number, number] = [1 + (extents & 31), 1 + ((extents >> 5) & 31)];
      this.#readCoefficients(window.row, channel, block, length, extent);
      inverseTransform(coefficients, block.size, extent, this.#domain.fractionBits - fraction, planes[channel]);
    }
    writeChannels(
      planes,
      { ...this.layout.slopes, fraction },
      this.#domain,
      { ...window, side: 4 << block.size, width: this.format.size[0] },
      out,
    );
  }

  /** The inverse transform in time: coefficients in space of one frame. */
  #readCoefficients(
    row: number,
    channel: number,
    { size, frame, frames }: BlockFrame,
    length: number,
    [columns, height]: [number, number],
  ): void {
    const { rows, levels, places } = this.#leaves;
    const out = coefficients;
    const weights = TIME_BASES[length];
    const shift = 2 + size;
    for (let y = 0; y < height; y++) {
      out.fill(0, y << shift, (y << shift) + columns);
    }
    const end = rows[row + leaf.LEAF_LEVELS + channel + 1];
    for (let at = rows[row + leaf.LEAF_LEVELS + channel]; at < end; at++) {
      const place = places[at];
      // The mean, which was coded as a difference, is the leaf's.
      if (place !== 0) {
        const to = (((place >> 5) & 31) << shift) | (place & 31);
        const weight = weights[frame * frames + (place >> 10)];
        out[to] = (out[to] + Math.imul(levels[at], weight)) | 0;
      }
    }
    out[0] = (out[0] + (rows[row + leaf.LEAF_MEAN + channel] << BASIS_BITS)) | 0;
    for (let y = 0; y < height; y++) {
      for (let at = y << shift; at < (y << shift) + columns; at++) {
        out[at] = (out[at] + (1 << (BASIS_BITS - 1))) >> BASIS_BITS;
      }
    }
  }
}

/** Writes the samples of a block's channels (formats/color.md 6.2). */
function writeChannels(
  [luma, green, orange]: readonly Int32Array[],
  { green: greenSlope, orange: orangeSlope, fraction }: Layout["slopes"] & { fraction: number },
  { isHalf, middle: base, least, most }: Domain,
  window: { left: number; top: number; columns: number; rows: number; side: number; width: number },
  out: Samples,
): void {
  const { left, top, columns, rows, side, width } = window;
  const half = (1 << fraction) >> 1;
  const keyOf = (fine: number): number => Math.min(Math.max(((fine + half) | 0) >> fraction, least), most);
  for (let y = 0; y < rows; y++) {
    let to = 3 * ((top + y) * width + left);
    for (let at = y * side; at < y * side + columns; at++) {
      const light = luma[at];
      const chroma = (green[at] + predictChroma(greenSlope, light)) | 0;
      const warm = (orange[at] + predictChroma(orangeSlope, light)) | 0;
      const middle = (light + (base << fraction) - (chroma >> 1)) | 0;
      const blue = (middle - (warm >> 1)) | 0;
      const red = keyOf(blue + warm);
      const mid = keyOf(chroma + middle);
      const low = keyOf(blue);
      out[to] = isHalf ? bitsOf(red) : red;
      out[to + 1] = isHalf ? bitsOf(mid) : mid;
      out[to + 2] = isHalf ? bitsOf(low) : low;
      to += 3;
    }
  }
}
