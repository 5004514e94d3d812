// How each pixel of a unit is coded in a frame: the node, box or block that it belongs to, and of which kind that is. The same as
// `lightfold inspect --plot` draws (src/inspect/unit_map.rs), but that pixels which a frame does not write show what wrote them before.

import type { Rect } from "../../format/types.ts";
import type { BoxChunk, BoxRecord } from "./boxes.ts";
import type { NodeChunk, NodeFrame } from "./node_chunk.ts";
import { functionOf, levelOf, NODE_WORDS, type Place, placeOf } from "./nodes.ts";
import type { PredictiveChunk } from "./predictive.ts";

/** Kinds of coding; their places in this list are their numbers in a map. */
export const CODINGS = [
  "none",
  // Functions of nodes.
  "raw",
  "biquadratic",
  "platelet",
  "bc4w",
  // Boxes.
  "values",
  "one value",
  "blocks",
  // Blocks of predictive coding.
  "background",
  "plane",
  "changed plane",
  "quarters",
  "pixels",
] as const;
export type Coding = (typeof CODINGS)[number];

/** Bits of a byte of a map that are the number of a kind. */
export const CODING_BITS = 0x3f;
/** Bit of pixels that an earlier frame of the chunk wrote. */
export const KEPT = 0x40;
/** Bit of pixels beside which, on the left or above, another node, box or block begins or the unit ends. */
export const BORDER = 0x80;

const NUMBERS = Object.fromEntries(CODINGS.map((coding, number) => [coding, number])) as Record<Coding, number>;

/** The map of a unit, which frame by frame is painted over. */
export class CodingMap {
  /** A byte for each pixel, row by row, as of the last call of {@link CodingMap.at}. */
  readonly bytes: Uint8Array;
  readonly #width: number;
  readonly #numbers: Uint8Array;
  /** What each pixel belongs to, counted from 1 over all frames. */
  readonly #parts: Uint32Array;
  #next = 1;
  /** The frame that was begun last, and its first part. */
  #frame = 0;
  #first = 1;

  constructor(width: number, height: number) {
    this.#width = width;
    this.bytes = new Uint8Array(width * height);
    this.#numbers = new Uint8Array(width * height);
    this.#parts = new Uint32Array(width * height);
  }

  /** What is painted from now on is written by a frame; `isWhole` where it writes all pixels. */
  begin(frame: number, isWhole: boolean): void {
    this.#next = isWhole ? 1 : this.#next;
    this.#frame = frame;
    this.#first = this.#next;
  }

  /** Paints a rectangle of a node, box or block, which has this number among those of the frame. */
  paint([left, top, width, height]: Rect, coding: Coding, number: number): void {
    const part = this.#first + number;
    this.#next = Math.max(this.#next, part + 1);
    for (let y = top; y < top + height; y += 1) {
      const start = y * this.#width + left;
      this.#numbers.fill(NUMBERS[coding], start, start + width);
      this.#parts.fill(part, start, start + width);
    }
  }

  /** The map at a frame, up to which all was painted: the same array each time. */
  at(frame: number): Uint8Array {
    const { bytes } = this;
    const width = this.#width;
    const [parts, numbers] = [this.#parts, this.#numbers];
    const first = this.#frame === frame ? this.#first : Infinity;
    for (let at = 0, x = 0; at < bytes.length; at += 1) {
      const part = parts[at];
      const isBorder = x === 0 || at < width || parts[at - 1] !== part || parts[at - width] !== part;
      bytes[at] = numbers[at] | (part < first ? KEPT : 0) | (isBorder ? BORDER : 0);
      x = x + 1 === width ? 0 : x + 1;
    }
    return bytes;
  }
}

/** Paints what a record of boxes writes. */
export function paintBoxes(map: CodingMap, chunk: BoxChunk, record: BoxRecord): void {
  map.begin(record.frame, record.frame === 0);
  for (const { rect, coding, box } of chunk.written(record)) {
    map.paint(rect, coding, box);
  }
}

/** Paints the nodes of a frame. Of the intermediate form, whose leaves are raw codes, the coarsest function that there is for each leaf. */
export function paintNodes(map: CodingMap, chunk: NodeChunk, frame: NodeFrame, isWhole: boolean): void {
  map.begin(frame.frame, isWhole || frame.frame === 0);
  const coarse = new Map<Place, Coding>();
  frame.coarse?.places.forEach((place, at) => {
    coarse.set(place, functionOf(levelOf(place), frame.coarse!.words, NODE_WORDS * at));
  });
  const numbers = new Map<Place, number>();
  chunk.forEachNode(frame, (place, coefficients, rect) => {
    const above = coarse.size > 0 ? coarsest(place, coarse) : undefined;
    const part = above ?? place;
    const number = numbers.get(part) ?? numbers.size;
    numbers.set(part, number);
    const coding = above === undefined ? functionOf(levelOf(place), chunk.words, coefficients) : coarse.get(above)!;
    map.paint(rect, coding, number);
  });
}

/** The greatest of these places in which a leaf lies. */
function coarsest(leaf: Place, places: ReadonlyMap<Place, unknown>): Place | undefined {
  for (let level = 8; level > 0; level -= 1) {
    const place = placeOf(level, (leaf & 0xff) >> level, ((leaf >> 8) & 0xff) >> level);
    if (places.has(place)) {
      return place;
    }
  }
  return undefined;
}

/** Paints the blocks that the frame decoded last has written. */
export function paintPredictive(map: CodingMap, chunk: PredictiveChunk): void {
  const frame = chunk.next - 1;
  map.begin(frame, frame === 0);
  let number = 0;
  for (const { rect, coding } of chunk.writtenBlocks()) {
    map.paint(rect, coding, number);
    number += 1;
  }
}
