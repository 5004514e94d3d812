// Reads the index, whose rows repeat nothing of the rows before (formats/container.md 4 to 6).

import { readAttributes } from "./attributes.ts";
import { FileFields } from "./bytes.ts";
import {
  checkChunkCount,
  checkPlace,
  checkProbe,
  checkStream,
  checkUnique,
  coverUnits,
  HEAD_BYTES,
  type IndexTables,
  numberUnits,
  readDataset,
  readOrientation,
  readPosition,
  type StreamRow,
  STORAGES,
} from "./index_tables.ts";
import type { Chunk, Probe } from "./types.ts";

const MIN_PROBE_BYTES = 27;
/** One of them in the chunk table. */
const MIN_STREAM_BYTES = 2;
const MIN_CHUNK_BYTES = 1;
const MAX_PROBES = 2 ** 16;

const PROBE_ORIENTATION = 1;
const PROBE_FRAMES = 2;
const PROBE_INTRINSICS = 4;
const STREAM_KIND = 1;
const STREAM_PROBE = 2;
const STREAM_FACE = 4;
const STREAM_SIZE = 8;
const STREAM_FRAMES = 16;
const STREAM_UNIT = 32;
const STREAM_HEADER = 64;
const STREAM_CHUNK_FRAMES = 128;
/** In place of a storage: the stored bytes are those of an earlier row. */
const SHARED = 3;
const STEP = 4;

/** A row of the stream table, and the frames of its chunks: 0 where each row of the chunk table says. */
interface ChunkedStream extends StreamRow {
  chunkFrames: number;
}

/** What the first rows take their values from. */
const BEFORE_PROBES: Probe = {
  name: "",
  position: [0, 0, 0],
  orientation: [0, 0, 0, 1],
  frames: [0, 0],
  intrinsics: [0, 0, 0, 0],
};
const BEFORE_STREAMS: ChunkedStream = {
  kind: 0,
  face: -1,
  probe: 0,
  codec: "\0\0\0\0",
  width: 0,
  height: 0,
  firstFrame: 0,
  frameCount: 0,
  unitWidth: 0,
  unitHeight: 0,
  headerBytes: new Uint8Array(0),
  chunkFrames: 0,
};

/** Reads an index that starts at `offset` of its file, which is also where the chunks end. */
export function readIndex(bytes: Uint8Array, offset: number): IndexTables {
  const fields = new FileFields(bytes, "container.md 4", offset);
  const [probeCount, streamCount, chunkCount] = [fields.varint32(), fields.varint32(), fields.varint32()];
  const order = fields.u8();
  if (order > 1) {
    throw fields.error(`Order ${order} of the chunk table is unknown`);
  }
  const dataset = readDataset(fields);
  fields.fits(probeCount, "probes", MIN_PROBE_BYTES);
  const probes: Probe[] = [];
  for (let row = 0; row < probeCount; row += 1) {
    probes.push(readProbe(fields, probes.at(-1) ?? BEFORE_PROBES));
  }
  fields.section = "container.md 5";
  fields.fits(streamCount, "streams", MIN_STREAM_BYTES);
  const streams: ChunkedStream[] = [];
  for (let row = 0; row < streamCount; row += 1) {
    streams.push(readStream(fields, streams, probeCount));
  }
  fields.section = "container.md 6";
  checkChunkCount(fields, chunkCount, MIN_CHUNK_BYTES);
  const chunks = new ChunkTable(fields, streams, chunkCount).read(order === 1, offset);
  const attributes = readAttributes(fields);
  checkUnique(probes, streams);
  return { ...dataset, probes, streams, chunks, units: coverUnits(streams, chunks), attributes };
}

function readProbe(fields: FileFields, before: Probe): Probe {
  const start = fields.at;
  const flags = fields.u8();
  if (flags > 7) {
    throw fields.error(`A probe has flags ${flags}, of which some are unknown`, start);
  }
  const name = fields.string("A probe's name");
  const probe: Probe = { ...before, name, position: readPosition(fields, "A probe's position") };
  if (flags & PROBE_ORIENTATION) {
    probe.orientation = readOrientation(fields, "A probe's orientation");
  }
  if (flags & PROBE_FRAMES) {
    probe.frames = [fields.varint32(), fields.varint32()];
  }
  if (flags & PROBE_INTRINSICS) {
    probe.intrinsics = fields.finites(4, "A probe's intrinsics") as Probe["intrinsics"];
  }
  checkProbe(fields, start, probe);
  return probe;
}

/** Reads the row after `rows`. */
function readStream(fields: FileFields, rows: readonly ChunkedStream[], probes: number): ChunkedStream {
  const start = fields.at;
  const flags = fields.u8();
  const row = { ...(rows.at(-1) ?? BEFORE_STREAMS) };
  row.face += 1;
  if (flags & STREAM_KIND) {
    row.kind = fields.u8();
    row.codec = String.fromCharCode(...fields.take(4));
  }
  if (flags & STREAM_PROBE) {
    row.probe = fields.varint32();
  }
  if (flags & STREAM_FACE) {
    row.face = fields.u8();
  }
  if (flags & STREAM_SIZE) {
    [row.width, row.height] = [fields.varint32(), fields.varint32()];
  }
  if (flags & STREAM_FRAMES) {
    [row.firstFrame, row.frameCount] = [fields.varint32(), fields.varint32()];
  }
  if (flags & STREAM_UNIT) {
    [row.unitWidth, row.unitHeight] = [fields.varint32(), fields.varint32()];
  }
  if (flags & STREAM_HEADER) {
    const back = fields.varint32();
    if (back > rows.length) {
      throw fields.error(`A codec header is that of ${back} rows before, where there are ${rows.length}`, start);
    }
    row.headerBytes = back > 0 ? rows[rows.length - back].headerBytes : fields.take(fields.varint32());
  }
  if (flags & STREAM_CHUNK_FRAMES) {
    row.chunkFrames = fields.varint32();
  }
  checkStream(fields, start, row, Math.min(probes, MAX_PROBES));
  return row;
}

class ChunkTable {
  private readonly firstUnits: Uint32Array;
  /** Stream of each unit of all streams. */
  private readonly streamOf: Uint32Array;
  /** First frame of each unit that no row has had yet. */
  private readonly nextFrame: Uint32Array;
  private readonly rows: Chunk[] = [];

  constructor(
    private readonly fields: FileFields,
    private readonly streams: readonly ChunkedStream[],
    private readonly count: number,
  ) {
    this.firstUnits = numberUnits(streams, count);
    const units = this.firstUnits[streams.length];
    [this.streamOf, this.nextFrame] = [new Uint32Array(units), new Uint32Array(units)];
    streams.forEach(({ firstFrame }, at) => {
      const [from, to] = [this.firstUnits[at], this.firstUnits[at + 1]];
      this.streamOf.fill(at, from, to);
      this.nextFrame.fill(firstFrame, from, to);
    });
  }

  /** Reads the rows; answers them in the order of streams, units and frames. The stored bytes end at `end`. */
  read(isByUnit: boolean, end: number): Chunk[] {
    const { fields, rows } = this;
    const units = this.nextFrame.length;
    let predicted = 0;
    let offset = HEAD_BYTES;
    for (let row = 0; row < this.count; row += 1) {
      const start = fields.at;
      const head = fields.varint();
      // The remainder of 8 is exact beyond 32 bits, too.
      const flags = head % 8;
      let step = 0;
      if (flags & STEP) {
        step = fields.varint32();
        if (step < 1 || step >= units) {
          throw fields.error(`A step of ${step} units, where there are ${units}`, start);
        }
      }
      const unit = (predicted + step) % units;
      const chunk = this.frames(unit, start);
      const isShared = (flags & 3) === SHARED;
      this.place(chunk, [flags & 3, Math.floor(head / 8)], [start, offset]);
      checkPlace(fields, start, chunk, end);
      offset += isShared ? 0 : chunk.storedBytes;
      rows.push(chunk);
      const { firstFrame, frameCount } = this.streams[chunk.stream];
      const isComplete = this.nextFrame[unit] === firstFrame + frameCount;
      predicted = isByUnit && !isComplete ? unit : (unit + 1) % units;
    }
    if (offset !== end) {
      throw fields.error(`The chunks end at byte ${offset}, and the index starts at ${end}`);
    }
    return this.sorted();
  }

  /** The unit and frames of the next row, which starts at `start`; what is stored is still to be read. */
  private frames(unit: number, start: number): Chunk {
    const stream = this.streamOf[unit];
    const row = this.streams[stream];
    const firstFrame = this.nextFrame[unit];
    const left = row.firstFrame + row.frameCount - firstFrame;
    const frameCount = row.chunkFrames === 0 ? this.fields.varint32() : Math.min(row.chunkFrames, left);
    if (frameCount < 1 || frameCount > left) {
      throw this.fields.error(`A chunk has ${frameCount} frames of a unit of which ${left} are left`, start);
    }
    this.nextFrame[unit] += frameCount;
    const key = { stream, unit: unit - this.firstUnits[stream], firstFrame, frameCount };
    return { ...key, offset: 0, storedBytes: 0, rawBytes: 0, crc32: 0, storage: "raw" };
  }

  /** The rest of a row: what is stored at `offset`, or in an earlier row. */
  private place(chunk: Chunk, [method, value]: [number, number], [start, offset]: [number, number]): void {
    const { fields, rows } = this;
    if (method === SHARED) {
      const earlier = rows.at(-1 - value);
      if (!earlier) {
        throw fields.error(`A chunk has the bytes of ${value + 1} rows before, where there are ${rows.length}`, start);
      }
      const { offset, storedBytes, rawBytes, crc32, storage } = earlier;
      Object.assign(chunk, { offset, storedBytes, rawBytes, crc32, storage });
      return;
    }
    chunk.offset = offset;
    chunk.storage = STORAGES[method];
    chunk.storedBytes = value;
    chunk.rawBytes = method === 0 ? value : fields.varint32();
    chunk.crc32 = fields.u32();
  }

  /** The rows by unit; those of one unit stand in the order of their frames. */
  private sorted(): Chunk[] {
    const next = new Uint32Array(this.nextFrame.length + 1);
    const unitOf = (chunk: Chunk) => this.firstUnits[chunk.stream] + chunk.unit;
    this.rows.forEach((chunk) => (next[unitOf(chunk) + 1] += 1));
    for (let unit = 1; unit < next.length; unit += 1) {
      next[unit] += next[unit - 1];
    }
    const sorted = Array<Chunk>(this.rows.length);
    for (const chunk of this.rows) {
      const unit = unitOf(chunk);
      sorted[next[unit]] = chunk;
      next[unit] += 1;
    }
    return sorted;
  }
}
