// Checked chunks in the form of the device: words of the stream, and rows of offsets into them (src/gpu/prepare.rs).

import { UnsupportedError } from "../../format/types.ts";
import type { Prepared, Timeline, Words } from "../types.ts";
import type { BoxChunk, WrittenRect } from "./boxes.ts";
import type { NodeChunk } from "./node_chunk.ts";
import type { PredictiveChunk } from "./predictive.ts";

/** `coding` of a `BoxRow`: `BOX_VALUES`, `BOX_CONSTANT` and `BOX_BLOCKS` of shaders/kernels.json. */
const BOX_CODINGS = { values: 0, "one value": 1, blocks: 2 } as const;
/** Most bytes of the codes of a chunk of predictive coding, whose payload may be far smaller. */
const MAX_UNPACKED = 128 * 2 ** 20;

/** What a record writes, of which kind, and where it stands. */
type Written = Omit<WrittenRect, "box">;

/** Rows `Record` and `BoxRow` of a chunk of boxes. */
class BoxRows {
  readonly #records: number[] = [];
  readonly #boxes: number[] = [];
  readonly #frames: number[] = [];
  readonly #pixels: number[] = [];
  readonly #areCodes: boolean;

  /** Two codes make a word of a picture, else a pixel does. */
  constructor(areCodes: boolean) {
    this.#areCodes = areCodes;
  }

  /** A record of a frame that writes so many pixels of the unit. */
  push(frame: number, pixels: number, written: Iterable<Written>): void {
    const first = this.#boxes.length / 7;
    let work = 0;
    for (const { rect, coding, at } of written) {
      const [x, y, width, height] = rect;
      // As many as the kernel writes words of each row.
      const columns = this.#areCodes ? ((x + width + 1) >> 1) - (x >> 1) : width;
      work += columns * height;
      this.#boxes.push(x, y, width, height, at, BOX_CODINGS[coding], work);
    }
    // frame, at, first, count, work, coding
    this.#records.push(frame, 0, first, this.#boxes.length / 7 - first, work, 0);
    this.#frames.push(frame);
    this.#pixels.push(pixels);
  }

  prepared(stream: Words): Prepared {
    const records = Uint32Array.from(this.#records);
    const boxes = Uint32Array.from(this.#boxes);
    const timeline = timelineOf(this.#frames, this.#pixels);
    return { kernel: "codec", isNodes: false, stream, records, boxes, weights: [0, 0], passes: 0, timeline };
  }
}

function timelineOf(frames: number[], pixels: number[]): Timeline {
  return {
    recordFrames: Uint32Array.from(frames),
    recordPixels: Uint32Array.from(pixels),
    keyframes: new Uint32Array(),
    weights: new Uint8Array(),
    frameSets: new Uint32Array(),
    framePixels: new Uint32Array(),
  };
}

/** Bytes as words, the lowest byte first, the last word filled up with zeros. */
function wordsOf(bytes: Uint8Array): Words {
  const words = new Uint32Array(Math.ceil(bytes.length / 4));
  for (let at = 0; at < bytes.length; at += 1) {
    words[at >> 2] |= bytes[at] << (8 * (at & 3));
  }
  return words;
}

/** Chunks of nodes: the runtime form (depth.md 10). */
export function preparedNodes(chunk: NodeChunk): Prepared {
  // frame, at, first, count, work, coding
  const records = chunk.frames.flatMap(({ frame, at, leaves }) => [frame, at, 0, 0, leaves, 0]);
  const frames = chunk.frames.map(({ frame }) => frame);
  const pixels = chunk.frames.map((frame) => frame.pixels);
  return {
    kernel: "codec",
    isNodes: true,
    stream: chunk.words.slice(),
    records: Uint32Array.from(records),
    boxes: new Uint32Array(),
    weights: [0, 0],
    passes: 0,
    timeline: timelineOf(frames, pixels),
  };
}

/** Chunks of boxes: the payload, and a row for each part of a box. */
export function preparedBoxes(chunk: BoxChunk): Prepared {
  const rows = new BoxRows(chunk.layout.texel.samples === 1);
  for (const record of chunk.records) {
    rows.push(record.frame, chunk.updatedPixels(record), chunk.written(record));
  }
  return rows.prepared(wordsOf(chunk.payload));
}

/** Chunks of predictive coding of a unit of `width` columns: their codes in boxes that each frame changes. Symbols depend on those before,
 *  and a unit is one substream, so that they are decoded here. */
export function preparedPredictive(chunk: PredictiveChunk, width: number): Prepared {
  const rows = new BoxRows(true);
  let codes = new Uint16Array(1024);
  let count = 0;
  const reserve = (more: number): void => {
    if (2 * (count + more) > MAX_UNPACKED) {
      const most = MAX_UNPACKED / 2 ** 20;
      throw new UnsupportedError(`The codes of a chunk of predictive depth take more than ${most} MiB.`);
    }
    if (count + more > codes.length) {
      const larger = new Uint16Array(Math.max(count + more, 2 * codes.length));
      larger.set(codes.subarray(0, count));
      codes = larger;
    }
  };
  while (chunk.next < chunk.frames) {
    chunk.decodeNext();
    const { picture } = chunk;
    const written: Written[] = [];
    let pixels = 0;
    for (const rect of chunk.written()) {
      const [x, y, columns, lines] = rect;
      reserve(columns * lines);
      written.push({ rect, coding: "values", at: 2 * count });
      for (let line = y; line < y + lines; line += 1) {
        codes.set(picture.subarray(line * width + x, line * width + x + columns), count);
        count += columns;
      }
      pixels += columns * lines;
    }
    if (written.length > 0) {
      rows.push(chunk.next - 1, pixels, written);
    }
  }
  const stream = new Uint32Array(Math.ceil(count / 2));
  for (let at = 0; at < count; at += 1) {
    stream[at >> 1] |= codes[at] << (16 * (at & 1));
  }
  return rows.prepared(stream);
}
