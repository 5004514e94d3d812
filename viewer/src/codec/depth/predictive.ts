// A chunk of predictive depth or alpha: a table set's number and one substream, from which frames are decoded in order (formats/depth.md
// 15.1 and 15.2).

import { FormatError, type PredictiveCoding, type Rect } from "../../format/types.ts";
import { depthModel, tableSet } from "../entropy.ts";
import { type Distributions, RansDecoder } from "../rans.ts";
import type { ChunkArea, UnitArea } from "../types.ts";
import { PredictiveTile } from "./predictive_tile.ts";

export type { Projection } from "./projection.ts";

/** Codes that occur in a stream, ascending, whose numbers are coded in their place (depth.md 15.2); none where any code may occur. */
export type Levels = Uint16Array;

/** Most frames of a chunk, and pixels of a side of a unit. */
const MAX_FRAMES = 4096;
const MAX_SIDE = 1024;
const BLOCK = 8;
const MODE_SAME = 1;
/** How blocks are coded, by their modes (depth.md 15.2). A block that is as before a first frame is background. */
const CODING_OF_MODE = [
  "pixels",
  "background",
  "background",
  "quarters",
  "plane",
  "plane",
  "plane",
  "changed plane",
  "changed plane",
  "changed plane",
] as const;

/** A block that a frame wrote: its place in the unit, and how it is coded. */
export interface WrittenBlock {
  rect: Rect;
  coding: (typeof CODING_OF_MODE)[number];
}

/** A chunk and the frame that it decoded last. */
export class PredictiveChunk {
  /** Frames of the chunk. */
  readonly frames: number;
  /** The frame that will be decoded next, from 0. */
  next = 0;

  readonly #substream: Uint8Array;
  readonly #tables: Distributions;
  readonly #coding: PredictiveCoding;
  readonly #area: UnitArea;
  #stream: RansDecoder;
  /** Made when the first frame is decoded. */
  #tile: PredictiveTile | undefined;
  #isCoded = false;

  /** Checks what can be told without decoding. */
  constructor(payload: Uint8Array, coding: PredictiveCoding, { area, frames }: ChunkArea) {
    const set = payload.length > 0 ? payload[0] : undefined;
    const tables = set === undefined ? undefined : tableSet(coding.tables, set);
    if (tables === undefined) {
      throw new FormatError(
        set === undefined
          ? "A payload of predictive depth is empty (depth.md 15.1)."
          : `A payload of predictive depth names table set ${set}, which its stream does not have (depth.md 15.1).`,
      );
    }
    if (frames > MAX_FRAMES) {
      throw new FormatError(`A chunk has ${frames} frames where at most ${MAX_FRAMES} are legal (depth.md 15.1).`);
    }
    const [, , width, height] = area.rect;
    if (width < 1 || height < 1 || width > MAX_SIDE || height > MAX_SIDE) {
      throw new FormatError(`A tile has ${width}x${height} pixels where sides are 1 to ${MAX_SIDE} (depth.md 3).`);
    }
    this.frames = frames;
    this.#substream = payload.subarray(1);
    this.#tables = tables;
    this.#coding = coding;
    this.#area = area;
    this.#stream = this.#start();
  }

  #start(): RansDecoder {
    return new RansDecoder(this.#substream, this.#tables, depthModel().distributionOf);
  }

  /** Codes of the frame that was decoded last, row by row; changed in place by the next one. Of alpha they may be above 255. */
  get picture(): Uint16Array {
    if (this.#tile === undefined) {
      throw new RangeError("no frame was decoded");
    }
    return this.#tile.picture;
  }

  /** Starts again at the first frame. */
  restart(): void {
    this.#stream = this.#start();
    this.#tile?.restart(this.#stream);
    this.next = 0;
  }

  /** Decodes the next frame. After an error the chunk must be started again. */
  decodeNext(): void {
    if (this.next >= this.frames) {
      throw new RangeError(`a chunk has ${this.frames} frames`);
    }
    this.#tile ??= new PredictiveTile(this.#coding, this.#area, this.#stream);
    this.#isCoded = this.#tile.decodeFrame();
    this.next += 1;
    const { isShort, isFinished } = this.#stream;
    if (isShort || (this.next === this.frames && !isFinished)) {
      const problem = isShort ? "ends too early" : "does not end with its last frame";
      throw new FormatError(`A substream of predictive depth ${problem} (depth.md 15.1).`);
    }
  }

  /** Rectangles of the unit that the frame decoded last has written: neighbouring blocks joined, the whole unit in a first frame. */
  written(): Rect[] {
    const [, , width, height] = this.#area.rect;
    if (this.next === 1) {
      return [[0, 0, width, height]];
    }
    const written: Rect[] = [];
    for (const { rect } of this.writtenBlocks()) {
      const last = written.at(-1);
      if (last !== undefined && last[1] === rect[1] && last[0] + last[2] === rect[0]) {
        last[2] += rect[2];
      } else {
        written.push(rect);
      }
    }
    return written;
  }

  /** Blocks of the unit that the frame decoded last has written: all in a first frame, or the unit as one where its blocks are not coded. */
  *writtenBlocks(): Generator<WrittenBlock> {
    const [, , width, height] = this.#area.rect;
    const isFirst = this.next === 1;
    if (this.#tile === undefined || !this.#isCoded) {
      if (isFirst) {
        yield { rect: [0, 0, width, height], coding: "background" };
      }
      return;
    }
    const { modes, columns } = this.#tile;
    for (let block = 0; block < modes.length; block += 1) {
      if (modes[block] !== MODE_SAME || isFirst) {
        const x = (block % columns) * BLOCK;
        const y = Math.floor(block / columns) * BLOCK;
        const rect: Rect = [x, y, Math.min(BLOCK, width - x), Math.min(BLOCK, height - y)];
        yield { rect, coding: CODING_OF_MODE[modes[block]] };
      }
    }
  }
}
