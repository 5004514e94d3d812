// Chunks on the device: their bytes, and tables of offsets into them. Mirrors src/gpu/resident.rs.
//
// Dropped chunks leave gaps, which later ones fill; resident chunks never move.

import type { Prepared, Timeline } from "../decoder/types.ts";
import type { Gpu } from "./device.ts";
import { memberOffset, putRow, rowWords } from "./layout.ts";

const FIRST_WORDS = 1 << 14;

/** Words of a buffer: from `at` on. */
interface Place {
  at: number;
  words: number;
}

/** A buffer that grows, and its free places. */
export class Growing {
  readonly label: string;
  buffer: GPUBuffer;
  bytesSent = 0;
  readonly #gpu: Gpu;
  /** Words up to the last that is taken. */
  #length = 0;
  /** Places that are free, ascending, none beside another. */
  #gaps: Place[] = [];
  #gapWords = 0;

  constructor(gpu: Gpu, label: string) {
    this.#gpu = gpu;
    this.label = label;
    this.buffer = gpu.buffer(label, FIRST_WORDS);
  }

  /** Words in it, gaps apart. */
  get taken(): number {
    return this.#length - this.#gapWords;
  }

  /** Whether so many words fit, with at most `most` in all. */
  hasRoom(words: number, most: number): boolean {
    return this.#gaps.some((gap) => gap.words >= words) || this.#length + words <= most;
  }

  /** Writes words into the smallest gap that has room, or at the end; answers where they begin. */
  put(words: Uint32Array): number {
    const at = this.#place(words.length);
    this.#gpu.write(this.buffer, 4 * at, words);
    this.bytesSent += words.byteLength;
    return at;
  }

  #place(words: number): number {
    let best: Place | undefined;
    for (const gap of this.#gaps) {
      if (gap.words >= words && (best === undefined || gap.words < best.words)) {
        best = gap;
      }
    }
    if (best !== undefined && words > 0) {
      const { at } = best;
      best.at += words;
      best.words -= words;
      this.#gapWords -= words;
      this.#gaps = this.#gaps.filter((gap) => gap.words > 0);
      return at;
    }
    const at = this.#length;
    this.#grow(at + words);
    this.#length = at + words;
    return at;
  }

  #grow(needed: number): void {
    const before = this.buffer;
    if (4 * needed <= before.size) {
      return;
    }
    const most = Math.floor(this.#gpu.maxBindingBytes / 4);
    const words = Math.max(Math.min(2 ** Math.ceil(Math.log2(needed)), most), needed);
    this.buffer = this.#gpu.buffer(this.label, words);
    this.#gpu.submit((encoder) => encoder.copyBufferToBuffer(before, 0, this.buffer, 0, before.size));
    this.#gpu.release(before);
  }

  free({ at, words }: Place): void {
    if (words === 0) {
      return;
    }
    const next = this.#gaps.findIndex((gap) => gap.at > at);
    const position = next < 0 ? this.#gaps.length : next;
    const [before, after] = [this.#gaps[position - 1], this.#gaps[position]];
    const joined = { at, words };
    let [first, count] = [position, 0];
    if (before !== undefined && before.at + before.words === at) {
      joined.at = before.at;
      joined.words += before.words;
      first -= 1;
      count += 1;
    }
    if (after !== undefined && after.at === at + words) {
      joined.words += after.words;
      count += 1;
    }
    this.#gaps.splice(first, count, joined);
    this.#gapWords += words;
    if (joined.at + joined.words === this.#length) {
      this.#gaps.pop();
      this.#gapWords -= joined.words;
      this.#length = joined.at;
    }
  }

  destroy(): void {
    this.#gpu.release(this.buffer);
  }
}

/** What the host knows of a chunk on the device. */
export interface ResidentChunk {
  /** In the table of chunks. */
  row: number;
  /** Invocations that the largest of its records takes. */
  mostWork: number;
  kernel: Prepared["kernel"];
  passes: number;
  timeline: Timeline;
  /** Number of the call that used it last. */
  lastUsed: number;
  places: Place[];
}

const RECORD = {
  words: rowWords("Record"),
  at: memberOffset("Record", "at"),
  first: memberOffset("Record", "first"),
  work: memberOffset("Record", "work"),
};
const BOX = { words: rowWords("BoxRow"), at: memberOffset("BoxRow", "at") };
const CHUNK_WORDS = rowWords("Chunk");

/** Frames of nodes start on multiples of 16 bytes. */
const STREAM_ALIGNMENT = 4;

function alignedWords(stream: Uint32Array): number {
  return Math.ceil(stream.length / STREAM_ALIGNMENT) * STREAM_ALIGNMENT;
}

/** The words with zeros up to a multiple of the alignment. */
function aligned(stream: Uint32Array): Uint32Array {
  if (stream.length % STREAM_ALIGNMENT === 0) {
    return stream;
  }
  const words = new Uint32Array(alignedWords(stream));
  words.set(stream);
  return words;
}

/** A copy of rows, in which numbers are added to members by their offset. */
function moved(
  rows: Uint32Array,
  pitch: number,
  added: readonly (readonly [offset: number, by: number])[],
): Uint32Array {
  const words = rows.slice();
  for (const [offset, by] of added) {
    for (let at = offset; at < words.length; at += pitch) {
      words[at] += by;
    }
  }
  return words;
}

/** Chunks of one decoder. */
export class Resident {
  readonly #stream: Growing;
  readonly #records: Growing;
  readonly #boxes: Growing;
  readonly #chunks: Growing;
  readonly #resident = new Map<number, ResidentChunk>();
  readonly #mostWords: number;

  /** Nothing yet; buffers grow up to `mostWords` words. */
  constructor(gpu: Gpu, mostWords: number) {
    this.#stream = new Growing(gpu, "stream");
    this.#records = new Growing(gpu, "records");
    this.#boxes = new Growing(gpu, "boxes");
    this.#chunks = new Growing(gpu, "chunks");
    this.#mostWords = mostWords;
  }

  get #tables(): [Growing, Growing, Growing, Growing] {
    return [this.#stream, this.#records, this.#boxes, this.#chunks];
  }

  /** The buffer of a table by the name of its binding. */
  buffer(name: string): GPUBuffer | undefined {
    return this.#tables.find((table) => table.label === name)?.buffer;
  }

  chunk(key: number): ResidentChunk | undefined {
    return this.#resident.get(key);
  }

  /** Words of the bytes of chunks, tables apart. */
  get streamWords(): number {
    return this.#stream.taken;
  }

  get bytes(): number {
    return this.#tables.reduce((sum, table) => sum + table.buffer.size, 0);
  }

  get bytesSent(): number {
    return this.#tables.reduce((sum, table) => sum + table.bytesSent, 0);
  }

  hasRoom({ stream, records, boxes }: Prepared): boolean {
    const taken = [alignedWords(stream), records.length, boxes.length, CHUNK_WORDS];
    return this.#tables.every((table, number) => table.hasRoom(taken[number] ?? 0, this.#mostWords));
  }

  /** Sends a chunk for which there is room. */
  place(key: number, chunk: Prepared, call: number): void {
    const stream = aligned(chunk.stream);
    const word = this.#stream.put(stream);
    const boxes = moved(chunk.boxes, BOX.words, [[BOX.at, 4 * word]]);
    const box = this.#boxes.put(boxes);
    const records = moved(chunk.records, RECORD.words, [
      [RECORD.at, chunk.isNodes ? word : 4 * word],
      [RECORD.first, box / BOX.words],
    ]);
    const record = this.#records.put(records);
    const [weightsAt, weightCount] = chunk.weights;
    const row = new Uint32Array(CHUNK_WORDS);
    putRow(row, 0, "Chunk", {
      first_record: record / RECORD.words,
      record_count: records.length / RECORD.words,
      weights_at: weightsAt + 4 * word,
      weight_count: weightCount,
    });
    const at = this.#chunks.put(row);
    let mostWork = 0;
    for (let work = RECORD.work; work < records.length; work += RECORD.words) {
      mostWork = Math.max(mostWork, records[work] ?? 0);
    }
    this.#resident.set(key, {
      row: at / CHUNK_WORDS,
      mostWork,
      kernel: chunk.kernel,
      passes: chunk.passes,
      timeline: chunk.timeline,
      lastUsed: call,
      places: [
        { at: word, words: stream.length },
        { at: record, words: records.length },
        { at: box, words: boxes.length },
        { at, words: CHUNK_WORDS },
      ],
    });
  }

  /** Drops chunks that are not kept, the one used longest ago first, until at most `words` words of chunks are left. */
  drop(keep: ReadonlySet<number>, words: number): void {
    const others = [...this.#resident].filter(([key]) => !keep.has(key));
    others.sort(([one, { lastUsed: first }], [other, { lastUsed: second }]) => first - second || one - other);
    for (const [key, { places }] of others) {
      if (this.streamWords <= words) {
        return;
      }
      this.#resident.delete(key);
      this.#tables.forEach((table, number) => table.free(places[number] ?? { at: 0, words: 0 }));
    }
  }

  destroy(): void {
    this.#tables.forEach((table) => table.destroy());
    this.#resident.clear();
  }
}
