// Reads the substream of a region: a tree of blocks in space and time (formats/color.md 6.4 to 6.8).

import { FormatError } from "../../../format/types.ts";
import { colorModel } from "../../entropy.ts";
import { type Distributions, RansDecoder } from "../../rans.ts";
import { LENGTHS, lengthIndex, MAX_LENGTH, TIME_BASES } from "./basis.ts";
import { CHANNELS, channelsOf, type Domain } from "./domain.ts";
import * as leaf from "./leaves.ts";
import { LevelReader } from "./levels.ts";
import { Means } from "./means.ts";
import { PaletteReader } from "./palette.ts";
import type { Layout } from "./payload.ts";
import { coefficientOf, stepsOf } from "./steps.ts";

const SECTION = "color.md 6.4";
const TRANSFORM = 0;
const QUARTERS = 1;
const PARTS = 2;
/** Leaves and colors that a region may have, and those for each byte of its substream on top. */
const FREE_ITEMS = 64;
const ITEMS_A_BYTE = 8;

/** A node: column and row in the region in squares of 4x4 pixels, size 0 to 3, first frame and number of frames. */
interface Block {
  x: number;
  y: number;
  size: number;
  frame: number;
  frames: number;
}

/** Reads the regions of a chunk, one after the other, into `leaves`. */
export class RegionReader {
  readonly leaves = new leaf.Leaves();
  readonly #layout: Layout;
  readonly #domain: Domain;
  readonly #set: Distributions;
  readonly #model = colorModel();
  readonly #levels = new LevelReader();
  readonly #palettes = new PaletteReader();
  readonly #means = new Means();
  /** Coefficients of frequency 0 in space of the planes of a channel. */
  readonly #constants = new Int32Array(MAX_LENGTH);
  readonly #sums = new Int32Array(CHANNELS);
  readonly #channels = new Int32Array(CHANNELS);
  #stream: RansDecoder;
  #itemsLeft = 0;
  #region = 0;

  constructor(layout: Layout, domain: Domain, set: Distributions) {
    this.#layout = layout;
    this.#domain = domain;
    this.#set = set;
    this.#stream = new RansDecoder(new Uint8Array(), set, this.#model.distributionOf);
  }

  /** Reads the substream of the next region, of a width and height in pixels, in a number of frames. */
  read(substream: Uint8Array, size: [number, number], frames: number): void {
    this.#stream = new RansDecoder(substream, this.#set, this.#model.distributionOf);
    this.#itemsLeft = FREE_ITEMS + ITEMS_A_BYTE * substream.length;
    this.#means.clear();
    this.#palettes.start(this.#layout.colors);
    const root = 32 - Math.clz32(Math.ceil(Math.max(...size) / 4) - 1);
    this.#node({ x: 0, y: 0, size: root, frame: 0, frames });
    if (!this.#stream.isFinished) {
      throw this.#error("The substream of a region does not end where its symbols do");
    }
    this.#region += 1;
  }

  #error(problem: string): FormatError {
    return new FormatError(`${problem}, in region ${this.#region} (${SECTION}).`);
  }

  #node(block: Block): void {
    if (this.#stream.isShort) {
      throw this.#error("The substream of a region is shorter than its symbols say");
    }
    const { x, y, size, frame, frames } = block;
    const length = lengthIndex(frames);
    const kind = this.#stream.symbol(this.#model.firstContext.node + size * (LENGTHS.length + 1) + length);
    if (kind === TRANSFORM && length < LENGTHS.length) {
      this.#transform(block, length);
    } else if (kind === QUARTERS && size > 0) {
      const half = 1 << (size - 1);
      for (let quarter = 0; quarter < 4; quarter++) {
        const [right, down] = [half * (quarter & 1), half * (quarter >> 1)];
        this.#node({ x: x + right, y: y + down, size: size - 1, frame, frames });
      }
    } else if (kind === PARTS && frames > 1) {
      const first = frames === 3 ? 1 : (frames + 1) >> 1;
      for (let at = 0; at < frames; at += first) {
        this.#node({ x, y, size, frame: frame + at, frames: Math.min(first, frames - at) });
      }
    } else if (kind > PARTS) {
      this.#palette(block);
    } else {
      throw this.#error("A block is split or transformed as its size does not allow");
    }
  }

  #takeItems(count: number): void {
    this.#itemsLeft -= count;
    if (this.#itemsLeft < 0) {
      throw this.#error("A region has more blocks and colors than its substream justifies");
    }
  }

  /** Adds a leaf, and answers where its row starts. */
  #add({ x, y, size, frame, frames }: Block, flags: number): number {
    const at = this.leaves.add();
    const { rows } = this.leaves;
    rows[at + leaf.LEAF_PLACE] = (4 * x) | ((4 * y) << 8) | (size << 16) | flags;
    rows[at + leaf.LEAF_FRAMES] = frame | (frames << 8);
    rows[at + leaf.LEAF_REGION] = this.#region;
    return at;
  }

  #transform(block: Block, length: number): void {
    this.#takeItems(1);
    const levels = this.#levels;
    levels.read(this.#stream, block.size, block.frames, this.leaves);
    const at = this.#add(block, levels.isStill ? leaf.IS_STILL : 0);
    const { rows } = this.leaves;
    rows.set(levels.starts, at + leaf.LEAF_LEVELS);
    rows[at + leaf.LEAF_EXTENTS] = levels.extents;
    const { frames } = block;
    const weights = TIME_BASES[length].subarray(frames * (frames - 1));
    for (let channel = 0; channel < CHANNELS; channel++) {
      const index = this.#layout.indices[CHANNELS * this.#region + channel];
      const stepOf = stepsOf({ length, channel, size: block.size }, index, this.#layout.offsetSet, this.#domain);
      const constants = this.#constants.fill(0);
      let mean = this.#means.predict(channel, block, block.frame === 0, stepOf(0));
      const { levels: values, places } = this.leaves;
      for (let level = levels.starts[channel]; level < levels.starts[channel + 1]; level++) {
        const [x, y, plane] = [places[level] & 31, (places[level] >> 5) & 31, places[level] >> 10];
        if (places[level] === 0) {
          mean = (mean + values[level]) | 0;
        }
        values[level] = coefficientOf(values[level], stepOf(x + y));
        if (x + y === 0) {
          constants[plane] = values[level];
        }
      }
      constants[0] = coefficientOf(mean, stepOf(0));
      rows[at + leaf.LEAF_MEAN + channel] = constants[0];
      this.#means.setBlock(channel, block, constants, weights);
    }
  }

  #palette(block: Block): void {
    const { leaves } = this;
    const side = 4 << block.size;
    const [firstKey, firstIndex] = [leaves.keyCount, leaves.indexCount];
    const count = this.#palettes.readColors(this.#stream, block.size, this.#domain.keyBits, leaves);
    this.#takeItems(1 + count);
    if (count > 1) {
      this.#palettes.readIndices(this.#stream, side, block.frames, leaves, count);
    }
    const at = this.#add(block, leaf.IS_PALETTE | (count === 1 ? leaf.IS_STILL : 0));
    leaves.rows[at + leaf.LEAF_COLORS] = firstKey;
    leaves.rows[at + leaf.LEAF_COLOR_COUNT] = count;
    leaves.rows[at + leaf.LEAF_INDICES] = firstIndex;
    const last = count > 1 ? firstIndex + (block.frames - 1) * side * side : -1;
    this.#notePalette(block, firstKey, last);
  }

  /** Notes the means of a palette's last frame, whose indices start at `last`; below 0, all are 0. */
  #notePalette({ x, y, size }: Block, firstKey: number, last: number): void {
    const { keys, indices } = this.leaves;
    const side = 4 << size;
    const sums = this.#sums;
    for (let square = 0; square < 1 << (2 * size); square++) {
      const [column, row] = [square & ((1 << size) - 1), square >> size];
      sums.fill(8);
      for (let texel = 0; texel < 16; texel++) {
        const index = last < 0 ? 0 : indices[last + (4 * row + (texel >> 2)) * side + 4 * column + (texel & 3)];
        const key = firstKey + 3 * index;
        sums[0] += keys[key];
        sums[1] += keys[key + 1];
        sums[2] += keys[key + 2];
      }
      for (let channel = 0; channel < CHANNELS; channel++) {
        sums[channel] >>= 4;
      }
      channelsOf(sums, this.#layout.slopes, this.#domain, this.#channels);
      for (let channel = 0; channel < CHANNELS; channel++) {
        this.#channels[channel] <<= this.#domain.fractionBits;
      }
      this.#means.setSquare(x + column, y + row, this.#channels);
    }
  }
}
