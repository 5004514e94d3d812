// Decodes streams of one family on the graphics device: all their tiles and cells together. Mirrors src/gpu/decode.rs.
//
// The device keeps chunks, pictures, and which frame each picture shows; a call sends only the list of units. A planning kernel finds
// the next record of each unit and sums up the work; the decoding kernel, whose size the plan sets, finds its part by bisection. Units
// more than a window behind take several rounds.

import { decoder } from "../decoder/module.ts";
import type { Prepared, Timeline } from "../decoder/types.ts";
import type { Stream } from "../format/types.ts";
import { unitCountOf, unitRectOf } from "../format/index_tables.ts";
import { DeviceError } from "./device.ts";
import type { Gpu, Pipeline } from "./device.ts";
import { familyOf, pictureWords, rowStride, unitMembers } from "./family.ts";
import type { Family } from "./family.ts";
import { kernel as kernelRow } from "./kernels.ts";
import type { KernelName } from "./kernels.ts";
import { CONSTANTS, LIST_HEAD_WORDS, listOf, memberOffset, putRow, rowWords, rowsOf } from "./layout.ts";
import { Resident } from "./resident.ts";
import type { ResidentChunk } from "./resident.ts";
import { stepsOver } from "./steps.ts";
import { blendOf, changedPixels } from "./timeline.ts";

/** Rounds of a call. A unit that needs more shows a frame in between, and goes on in the next call. */
const ROUNDS_OF_CALL = 64;

/** Most rounds that a unit may be away from its frame. Only entering a stream far behind its keyframe with a narrow window takes many;
 *  a file of a few bytes could ask for millions. */
const MAX_ROUNDS = 1 << 14;

/** Most invocations of a dispatch: kernels number them in 32 bits. Nodes that overhang narrow tiles can take more than there are
 *  pixels. */
const MAX_WORK = 2 ** 31;

/** Most bytes of the scratch memory between a kernel and its reader, unless one unit takes more. */
const MAX_SCRATCH_BYTES = 2 ** 27;

/** A unit, a frame, and the chunk that holds it. */
export interface Wanted {
  /** Position of its stream among those that the decoder was made for. */
  stream: number;
  unit: number;
  /** Numbered as in the source. */
  frame: number;
  /** Place of the chunk in the container's table, counted from 1. */
  key: number;
  /** First frame of the chunk. */
  firstFrame: number;
  /** Key of the unit's next chunk, if there is one. */
  nextKey?: number;
}

/** What a call did. Units that showed their frame already are in none of the lists. */
export interface Decoded {
  /** Units whose pictures show their frame now, or a frame before it if they are in `behind` too; and the pixels written. */
  written: { wanted: Wanted; pixels: number }[];
  /** Pixels of all of them. */
  pixels: number;
  /** Units whose chunk, or next chunk, is not on the device. They show what they did. */
  missing: Wanted[];
  /** Units that another call with the same list brings nearer to their frame. */
  behind: Wanted[];
  /** Units whose frame is too many steps away. */
  refused: Wanted[];
}

/** A picture among `FamilyDecoder.pictures`. */
export interface UnitPicture {
  /** Word at which it starts. */
  picture: number;
  /** Words of a row. */
  stride: number;
  width: number;
  height: number;
}

/** What a picture shows: a frame, counted from the first of a chunk. */
interface Shown {
  key: number;
  frame: number;
  timeline: Timeline;
}

/** What leads to a frame: pixels written by the rounds of a call, and the frame that they reach. */
interface Way {
  rounds: number;
  pixels: number;
  reached: number;
}

/** Items of one kernel. */
interface Batch {
  kernel: ResidentChunk["kernel"];
  items: { unit: number; chunk: number; next: number; frame: number; key: number }[];
  rounds: number;
  /** Passes of the kernel's reader. */
  passes: number;
  work: number;
}

/** A kernel, and the one that reads before it if there is one. */
interface Kernels {
  reader: Pipeline | undefined;
  kernel: Pipeline;
}

const UNIT = {
  words: rowWords("Unit"),
  picture: memberOffset("Unit", "picture"),
  width: memberOffset("Unit", "width"),
  height: memberOffset("Unit", "height"),
  stride: memberOffset("Unit", "stride"),
  window: memberOffset("Unit", "window"),
};

/** Streams of a family, and their units one stream behind the other. */
interface Units {
  firstUnits: number[];
  /** Rows `Unit`. */
  rows: Uint32Array;
}

function unitsOf(streams: readonly Stream[], family: Family, firstSets: ArrayLike<number>, multiple: number): Units {
  const firstUnits: number[] = [];
  const rows = new Uint32Array(streams.reduce((sum, stream) => sum + unitCountOf(stream), 0) * UNIT.words);
  let [number, picture] = [0, 0];
  streams.forEach((stream, position) => {
    firstUnits.push(number);
    const members = unitMembers(stream.header);
    const base = firstSets[position] ?? members.base;
    for (let unit = 0; unit < unitCountOf(stream); unit += 1) {
      const [, , width, height] = unitRectOf(stream, unit);
      const stride = rowStride(family, width, multiple);
      putRow(rows, number * UNIT.words, "Unit", { ...members, base, picture, width, height, stride });
      picture += stride * height;
      number += 1;
    }
  });
  return { firstUnits, rows };
}

/** Words of the buffer of pictures of streams of one family; a device may allow fewer. */
function familyWords(streams: readonly Stream[], rowMultiple: number): number {
  return streams.reduce((sum, stream) => sum + pictureWords(stream, rowMultiple), 0);
}

/** Words of the scratch memory that the largest unit takes: 0 where the kernel has no reader. */
function scratchWords(streams: readonly Stream[], { reader }: Kernels): number {
  const regions = streams.map(({ width, height, unitWidth, unitHeight }) => {
    return Math.ceil(Math.min(unitWidth, width) / 32) * Math.ceil(Math.min(unitHeight, height) / 32);
  });
  return reader === undefined ? 0 : Math.max(0, ...regions) * CONSTANTS.SCRATCH_WORDS;
}

/** The tables of the transform codec of streams of one family (src/kernels/transform_tables.rs); without any other, there are no words. */
function transformTables(streams: readonly Stream[]): { words: Uint32Array; firstSets: number[] } {
  const transformed = streams.filter(({ header }) => header.kind === "color" && header.coding.name === "transform");
  if (transformed.length === 0) {
    return { words: new Uint32Array(), firstSets: [] };
  }
  const opened = transformed.map((stream) => decoder().openStream(stream, stream.headerBytes));
  const tables = decoder().transformTables(opened);
  opened.forEach((stream) => decoder().closeStream(stream));
  return tables;
}

/** Streams of one family on the device. */
export class FamilyDecoder {
  readonly streams: readonly Stream[];
  readonly family: Family;
  /** Pictures of all units: words of `PixelWords`, row by row. */
  readonly pictures: GPUBuffer;
  /** Pixels that all calls wrote. */
  pixelsWritten = 0;
  /** Pixels of the units of all calls. */
  pixelsWanted = 0;
  readonly #gpu: Gpu;
  readonly #plan: Pipeline;
  readonly #kernels: Record<ResidentChunk["kernel"], Kernels>;
  readonly #units: Units;
  readonly #shown = new Map<number, Shown>();
  readonly #resident: Resident;
  /** By the names of bindings. */
  readonly #buffers: Record<"units" | "states" | "log2_table" | "tables" | "dispatch", GPUBuffer>;
  #items: GPUBuffer;
  #jobs: GPUBuffer;
  #listBytes = 0;
  #calls = 0;

  private constructor(
    gpu: Gpu,
    streams: readonly Stream[],
    plan: Pipeline,
    kernels: Record<ResidentChunk["kernel"], Kernels>,
    rowMultiple: number,
  ) {
    const family = familyOf(streams[0]!.header);
    const tables = transformTables(streams);
    const words = familyWords(streams, rowMultiple);
    const count = streams.reduce((sum, stream) => sum + unitCountOf(stream), 0);
    gpu.check("pictures", words);
    gpu.check("scratch", scratchWords(streams, kernels.codec));
    gpu.check("units", count * UNIT.words);
    this.#gpu = gpu;
    this.streams = streams;
    this.family = family;
    this.#plan = plan;
    this.#kernels = kernels;
    this.#units = unitsOf(streams, family, tables.firstSets, rowMultiple);
    this.pictures = gpu.buffer("pictures", words);
    this.#buffers = {
      units: gpu.filled("units", this.#units.rows),
      states: gpu.buffer("states", count * rowWords("State")),
      log2_table: gpu.filled("log2_table", decoder().log2Table()),
      tables: gpu.filled("tables", tables.words),
      dispatch: gpu.buffer("dispatch", rowWords("Dispatch"), GPUBufferUsage.INDIRECT),
    };
    this.#items = gpu.buffer("items", 0);
    this.#jobs = gpu.buffer("jobs", 0);
    this.#resident = new Resident(gpu, Math.floor(gpu.maxBindingBytes / 4));
  }

  /** A decoder of streams of one family, at least one. Rows of 8-bit colors take a multiple of `rowMultiple` words: 64 where pictures
   *  are copied into textures. */
  static async create(gpu: Gpu, streams: readonly Stream[], rowMultiple = 1): Promise<FamilyDecoder> {
    const [first, ...others] = streams.map((stream) => familyOf(stream.header));
    if (first === undefined || others.some(({ kernel }) => kernel !== first.kernel)) {
      throw new DeviceError("Streams of different families cannot be decoded together.");
    }
    const pipelines = async (name: KernelName): Promise<Kernels> => {
      const { reader: readerName } = kernelRow(name);
      const [kernel, reader] = await Promise.all([
        gpu.pipeline(name),
        readerName === undefined ? undefined : gpu.pipeline(readerName),
      ]);
      return { kernel, reader };
    };
    const [plan, codec, keyframes] = await Promise.all([
      gpu.pipeline(first.plan),
      pipelines(first.kernel),
      pipelines(first.keyframes ?? first.kernel),
    ]);
    return new FamilyDecoder(gpu, streams, plan, { codec, keyframes }, rowMultiple);
  }

  /** Whether a chunk is on the device. */
  has(key: number): boolean {
    return this.#resident.chunk(key) !== undefined;
  }

  /** Sends a chunk; `false` where there is no room, until others are dropped. */
  add(key: number, prepared: Prepared): boolean {
    if (this.has(key)) {
      return true;
    }
    if (!this.#resident.hasRoom(prepared)) {
      return false;
    }
    this.#resident.place(key, prepared, this.#calls);
    return true;
  }

  /** Drops chunks that are not kept, the one used longest ago first, until at most `words` words of chunks are left. Pictures stay. */
  drop(keep: ReadonlySet<number>, words: number): void {
    this.#resident.drop(keep, words);
  }

  /** Words of the chunks on the device. */
  get chunkWords(): number {
    return this.#resident.streamWords;
  }

  /** Bytes of its buffers. */
  get bytes(): number {
    const buffers = [this.pictures, this.#items, this.#jobs, ...Object.values(this.#buffers)];
    return this.#resident.bytes + buffers.reduce((sum, buffer) => sum + buffer.size, 0);
  }

  /** Bytes sent so far: chunks and lists. */
  get bytesSent(): number {
    return this.#resident.bytesSent + this.#listBytes;
  }

  /** Whether a frame is blended into the keyframe of the unit's next chunk; its own chunk must be on the device. */
  needsNext({ key, frame, firstFrame }: Wanted): boolean {
    const chunk = this.#resident.chunk(key);
    return this.family.isColor && chunk !== undefined && blendOf(chunk.timeline, frame - firstFrame).needsNext;
  }

  /** Whether what a unit's picture shows is right for a frame. */
  shows(wanted: Wanted): boolean {
    const shown = this.#shown.get(this.#number(wanted.stream, wanted.unit));
    if (shown?.key !== wanted.key) {
      return false;
    }
    const frame = wanted.frame - wanted.firstFrame;
    return shown.frame === frame || (this.family.isColor && changedPixels(shown.timeline, frame, shown.frame, 1) === 0);
  }

  /** Whether a unit's picture shows any frame. */
  showsAny(stream: number, unit: number): boolean {
    return this.#shown.has(this.#number(stream, unit));
  }

  /** Where a unit's picture is. */
  unit(stream: number, unit: number): UnitPicture {
    const at = this.#number(stream, unit) * UNIT.words;
    const word = (offset: number): number => this.#units.rows[at + offset] ?? 0;
    return {
      picture: word(UNIT.picture),
      stride: word(UNIT.stride),
      width: word(UNIT.width),
      height: word(UNIT.height),
    };
  }

  /** Decodes all units whose chunks are on the device, each unit at most once in the list. `timing` is written around the last
   *  dispatches. */
  decode(wanted: readonly Wanted[], timing?: GPUComputePassTimestampWrites): Decoded {
    this.#calls += 1;
    const done: Decoded = { written: [], pixels: 0, missing: [], behind: [], refused: [] };
    const batches: Batch[] = [];
    for (const one of wanted) {
      const { width, height } = this.unit(one.stream, one.unit);
      this.pixelsWanted += width * height;
      this.#list(one, batches, done);
    }
    this.pixelsWritten += done.pixels;
    batches.forEach((batch) => this.#submit(batch, timing));
    return done;
  }

  /** Frees its buffers. */
  destroy(): void {
    this.#resident.destroy();
    [this.pictures, this.#items, this.#jobs, ...Object.values(this.#buffers)].forEach((buffer) =>
      this.#gpu.release(buffer),
    );
  }

  /** Position of a unit among those of all streams. */
  #number(stream: number, unit: number): number {
    return (this.#units.firstUnits[stream] ?? 0) + unit;
  }

  #list(one: Wanted, batches: Batch[], done: Decoded): void {
    const unit = this.#number(one.stream, one.unit);
    const frame = one.frame - one.firstFrame;
    const shown = this.#shown.get(unit);
    if (shown?.key === one.key && shown.frame === frame) {
      return;
    }
    const chunk = this.#resident.chunk(one.key);
    const next = this.needsNext(one) ? this.#resident.chunk(one.nextKey ?? 0) : chunk;
    if (chunk === undefined || next === undefined) {
      done.missing.push(one);
      return;
    }
    chunk.lastUsed = this.#calls;
    next.lastUsed = this.#calls;
    const way = this.#way(one, chunk.timeline);
    if (way === undefined) {
      done.refused.push(one);
      return;
    }
    let batch = batches.findLast(({ kernel }) => kernel === chunk.kernel);
    if (batch === undefined || batch.work + chunk.mostWork > this.#mostWork(chunk.kernel)) {
      batch = { kernel: chunk.kernel, items: [], rounds: 0, passes: 0, work: 0 };
      batches.push(batch);
    }
    batch.items.push({ unit, chunk: chunk.row, next: next === chunk ? CONSTANTS.NONE : next.row, frame, key: one.key });
    batch.work += chunk.mostWork;
    batch.rounds = Math.max(batch.rounds, way.rounds);
    batch.passes = Math.max(batch.passes, chunk.passes);
    this.#shown.set(unit, { key: one.key, frame: way.reached, timeline: chunk.timeline });
    done.pixels += way.pixels;
    done.written.push({ wanted: one, pixels: way.pixels });
    if (way.reached !== frame) {
      done.behind.push(one);
    }
  }

  /** Most invocations of a list of units of a kernel. */
  #mostWork(kernel: ResidentChunk["kernel"]): number {
    if (this.#kernels[kernel].reader === undefined) {
      return MAX_WORK;
    }
    return Math.floor(Math.min(MAX_SCRATCH_BYTES, this.#gpu.maxBindingBytes) / (4 * CONSTANTS.SCRATCH_WORDS));
  }

  /** What a call does for a unit; `undefined` if its frame is too many rounds away. */
  #way(one: Wanted, timeline: Timeline): Way | undefined {
    const number = this.#number(one.stream, one.unit);
    const shown = this.#shown.get(number);
    const at = shown?.key === one.key ? shown.frame : undefined;
    const frame = one.frame - one.firstFrame;
    const { width, height } = this.unit(one.stream, one.unit);
    const pixels = width * height;
    if (this.family.isColor) {
      return { rounds: 1, pixels: changedPixels(timeline, frame, at, pixels), reached: frame };
    }
    const window = this.#units.rows[number * UNIT.words + UNIT.window] ?? 0;
    if (window === 0) {
      return { rounds: 1, pixels, reached: frame };
    }
    const steps = stepsOver(timeline.recordFrames, at, frame, window);
    if (steps.length > MAX_ROUNDS) {
      return undefined;
    }
    const now = steps.slice(0, ROUNDS_OF_CALL);
    const last = now.at(-1);
    const isBehind = now.length < steps.length && last !== undefined;
    return {
      rounds: Math.max(now.length, 1),
      pixels: now.reduce((sum, step) => sum + (timeline.recordPixels[step] ?? 0), 0),
      reached: isBehind ? (timeline.recordFrames[last] ?? frame) : frame,
    };
  }

  #submit(
    { kernel: name, items, rounds, passes, work }: Batch,
    timing: GPUComputePassTimestampWrites | undefined,
  ): void {
    const list = listOf([items.length, 0], rowsOf("Item", items));
    this.#items = this.#atLeast(this.#items, list.length);
    this.#jobs = this.#atLeast(this.#jobs, LIST_HEAD_WORDS + items.length * rowWords("Job"));
    this.#gpu.write(this.#items, 0, list);
    this.#listBytes += list.byteLength;
    const { reader, kernel } = this.#kernels[name];
    if (reader !== undefined) {
      this.#gpu.scratch(work * CONSTANTS.SCRATCH_WORDS);
    }
    // Bytes of the rows of `Dispatch`: invocations for the parts of the work, or workgroups.
    const [invocations, workgroups] = [0, 4 * memberOffset("Dispatch", "part_x")];
    const decoding = [
      ...(reader === undefined ? [] : [{ ...reader, times: passes, size: invocations }]),
      { ...kernel, times: 1, size: reader === undefined ? invocations : workgroups },
    ].map((step) => ({ ...step, group: this.#bind(step) }));
    const planGroup = this.#bind(this.#plan);
    this.#gpu.submit((encoder) => {
      const pass = encoder.beginComputePass(timing === undefined ? {} : { timestampWrites: timing });
      for (let round = 0; round < rounds; round += 1) {
        pass.setPipeline(this.#plan.pipeline);
        pass.setBindGroup(0, planGroup);
        pass.dispatchWorkgroups(1);
        for (const { pipeline, group, times, size } of decoding) {
          pass.setPipeline(pipeline);
          pass.setBindGroup(0, group);
          for (let at = 0; at < times; at += 1) {
            pass.dispatchWorkgroupsIndirect(this.#buffers.dispatch, size);
          }
        }
      }
      pass.end();
    });
  }

  /** A buffer with room for so many words: the same, or a new one in its place. */
  #atLeast(buffer: GPUBuffer, words: number): GPUBuffer {
    if (4 * words <= buffer.size) {
      return buffer;
    }
    const larger = this.#gpu.buffer(buffer.label, words);
    this.#gpu.release(buffer);
    return larger;
  }

  #bind(pipeline: Pipeline): GPUBindGroup {
    const named: Readonly<Record<string, GPUBuffer>> = {
      ...this.#buffers,
      items: this.#items,
      jobs: this.#jobs,
      scratch: this.#gpu.scratch(0),
      pictures: this.pictures,
    };
    return this.#gpu.bind(pipeline, (name) => {
      const buffer = named[name] ?? this.#resident.buffer(name);
      if (buffer === undefined) {
        throw new DeviceError(`No buffer of a decoder is named ${name}.`);
      }
      return { buffer };
    });
  }
}
