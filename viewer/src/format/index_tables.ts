// The tables of an index, and the rules that bind them (formats/container.md 4 to 6).

import { type FileFields, hasControls, quoted } from "./bytes.ts";
import {
  type Chunk,
  FormatError,
  type Probe,
  type Quaternion,
  type Rect,
  type Storage,
  UnsupportedError,
  type Vec3,
} from "./types.ts";

/** Bytes of the head of a file, before which no chunk lies. */
export const HEAD_BYTES = 16;
const MAX_SIZE = 16_384;
export const MAX_FRAME = 2 ** 31;
const MAX_CHUNK_BYTES = 2 ** 30;
/** Rows of the chunk table that this player reads; each takes some hundred bytes of memory. */
const MAX_CHUNKS = 2 ** 22;
/** Payload bytes of a stored byte, by storage. */
const MAX_EXPANSION: Readonly<Record<Storage, number>> = { raw: 1, lzma2: 16_384, zstd: 32_768 };
/** How chunks are stored, by number. */
export const STORAGES: readonly Storage[] = ["raw", "lzma2", "zstd"];
export const PROBE_NAME = /^[A-Za-z0-9_-][A-Za-z0-9._-]*$/u;

/** A row of the stream table (container.md 5), whose codec header is not read. */
export interface StreamRow {
  /** 0: color; 1: depth; 2: material; 3: alpha. */
  kind: number;
  face: number;
  probe: number;
  /** Four characters. */
  codec: string;
  width: number;
  height: number;
  firstFrame: number;
  frameCount: number;
  unitWidth: number;
  unitHeight: number;
  /** The same array where the file stores the header once for several streams. */
  headerBytes: Uint8Array;
}

/** What stands between the counts and the probe table. */
export interface Dataset {
  /** 0: cube maps; 1: perspective. */
  projection: number;
  fps: number;
  name: string;
}

/** A checked index. */
export interface IndexTables extends Dataset {
  probes: Probe[];
  streams: StreamRow[];
  /** In the order of stream, unit and first frame. */
  chunks: Chunk[];
  units: UnitTable;
  attributes: ReadonlyMap<string, Uint8Array>;
}

/** The units of all streams, numbered together in the order of the streams, and their chunks. */
export interface UnitTable {
  /** Number of the first unit of each stream, and behind them that of all units. */
  firstUnits: Uint32Array;
  /** First chunk of each unit, and behind them that of all chunks. */
  firstChunks: Uint32Array;
}

/** Columns of units of a stream's images. */
function columnsOf(stream: { width: number; unitWidth: number }): number {
  return Math.ceil(stream.width / stream.unitWidth);
}

/** Units of a stream's images. */
export function unitCountOf(stream: Pick<StreamRow, "width" | "height" | "unitWidth" | "unitHeight">): number {
  return columnsOf(stream) * Math.ceil(stream.height / stream.unitHeight);
}

/** Left, top, width and height of a unit in pixels of its image. */
export function unitRectOf(
  stream: Pick<StreamRow, "width" | "height" | "unitWidth" | "unitHeight">,
  unit: number,
): Rect {
  const columns = columnsOf(stream);
  const left = (unit % columns) * stream.unitWidth;
  const top = Math.floor(unit / columns) * stream.unitHeight;
  return [left, top, Math.min(stream.unitWidth, stream.width - left), Math.min(stream.unitHeight, stream.height - top)];
}

/** Projection, frame rate and name of the dataset (container.md 4). */
export function readDataset(fields: FileFields): Dataset {
  const projection = fields.u8();
  fields.zeros(3);
  if (projection > 1) {
    throw fields.error(`Projection ${projection} is unknown`);
  }
  const [fps] = fields.finites(1, "The frame rate");
  if (fps <= 0) {
    throw fields.error(`A frame rate of ${fps} is not positive`);
  }
  const start = fields.at;
  const name = fields.string("The dataset's name");
  if (hasControls(name)) {
    throw fields.error("The dataset's name holds control characters", start);
  }
  return { projection, fps, name };
}

/** The next three numbers, in metres, all finite; errors call them `what`. */
export function readPosition(fields: FileFields, what: string): Vec3 {
  return fields.finites(3, what) as Vec3;
}

/** The next four numbers, all finite: a quaternion x, y, z, w. */
export function readOrientation(fields: FileFields, what: string): Quaternion {
  return fields.finites(4, what) as Quaternion;
}

/** Refuses illegal values in a row of the probe table that starts at `start`. */
export function checkProbe(fields: FileFields, start: number, { name, frames: [first, last] }: Probe): void {
  if (!PROBE_NAME.test(name)) {
    throw fields.error(`The probe name ${quoted(name)} has other than letters, digits, ".", "_" and "-"`, start);
  }
  if (first > last || last >= MAX_FRAME) {
    throw fields.error(`A probe is active from frame ${first} to ${last}`, start);
  }
}

/** Refuses illegal values in a row of the stream table that starts at `start`, in a file of so many probes. */
export function checkStream(fields: FileFields, start: number, stream: StreamRow, probes: number): void {
  const { kind, face, probe, width, height, unitWidth, unitHeight, firstFrame, frameCount } = stream;
  if (kind > 3 || face > 6) {
    throw fields.error(`A stream has kind ${kind} and face ${face}, which is unknown`, start);
  }
  if (probe >= probes) {
    throw fields.error(`A stream is of probe ${probe}, where the file has ${probes}`, start);
  }
  if ([width, height, unitWidth, unitHeight].some((size) => size < 1 || size > MAX_SIZE)) {
    const sizes = `${width}x${height} pixels in units of ${unitWidth}x${unitHeight}`;
    throw fields.error(`A stream has ${sizes}, where each size is 1 to ${MAX_SIZE}`, start);
  }
  if (frameCount < 1 || firstFrame + frameCount > MAX_FRAME) {
    throw fields.error(`A stream has ${frameCount} frames from frame ${firstFrame} on, which is impossible`, start);
  }
}

/** Refuses a row of the chunk table that starts at `start` whose stored bytes do not lie between the head and `end`, or whose sizes cannot
 *  be. */
export function checkPlace(
  fields: FileFields,
  start: number,
  chunk: Pick<Chunk, "offset" | "storedBytes" | "rawBytes" | "storage">,
  end: number,
): void {
  const { offset, storedBytes, rawBytes, storage } = chunk;
  if (offset < HEAD_BYTES || offset + storedBytes > end) {
    throw fields.error(`A chunk of ${storedBytes} bytes at byte ${offset} lies outside the file's chunks`, start);
  }
  const most = Math.min(MAX_CHUNK_BYTES, storedBytes * MAX_EXPANSION[storage]);
  if (rawBytes > most || (storage === "raw" && rawBytes !== storedBytes)) {
    throw fields.error(`A chunk of ${storedBytes} stored bytes cannot mean ${rawBytes} bytes`, start);
  }
}

/** Refuses a chunk table that does not fit what is left of the index, with rows of at least `least` bytes, or is too large for this player. */
export function checkChunkCount(fields: FileFields, count: number, least: number): void {
  fields.fits(count, "chunks", least);
  if (count > MAX_CHUNKS) {
    throw new UnsupportedError(`The container has ${count} chunks; this player reads at most ${MAX_CHUNKS}.`);
  }
}

/** Refuses two probes of one name, and two streams of one kind, probe and face. */
export function checkUnique(probes: readonly Probe[], streams: readonly StreamRow[]): void {
  const names = new Set<string>();
  for (const { name } of probes) {
    if (names.has(name)) {
      throw new FormatError(`Two probes are named ${quoted(name)} (container.md 4).`);
    }
    names.add(name);
  }
  const places = new Set<number>();
  streams.forEach(({ kind, probe, face }, at) => {
    const place = (probe * 4 + kind) * 7 + face;
    if (places.has(place)) {
      throw new FormatError(`Stream ${at} has the kind, probe and face of an earlier one (container.md 5).`);
    }
    places.add(place);
  });
}

/** Number of the first unit of each stream, and behind them that of all units, which are at most `chunkCount`: each unit has a chunk. */
export function numberUnits(streams: readonly StreamRow[], chunkCount: number): Uint32Array {
  const firstUnits = new Uint32Array(streams.length + 1);
  let units = 0;
  streams.forEach((stream, at) => {
    units += unitCountOf(stream);
    if (units > chunkCount) {
      throw new FormatError(
        `The chunk table breaks off: the streams have more units than its ${chunkCount} rows (container.md 6).`,
      );
    }
    firstUnits[at + 1] = units;
  });
  if (units === 0 && chunkCount > 0) {
    throw new FormatError(`The index has ${chunkCount} chunks and no stream (container.md 6).`);
  }
  return firstUnits;
}

/** Finds the chunks of each unit. They must cover the unit's frames, each once, in order; nothing else may be there. */
export function coverUnits(streams: readonly StreamRow[], chunks: readonly Chunk[]): UnitTable {
  const firstUnits = numberUnits(streams, chunks.length);
  const firstChunks = new Uint32Array(firstUnits[streams.length] + 1);
  let at = 0;
  const broken = (stream: number, unit: number, frame: number) =>
    new FormatError(
      `The chunk table breaks off at stream ${stream}, unit ${unit}, frame ${frame}: chunks must cover the frames of each unit in ` +
        "order (container.md 6).",
    );
  streams.forEach(({ firstFrame, frameCount }, stream) => {
    const end = firstFrame + frameCount;
    for (let unit = 0; unit < firstUnits[stream + 1] - firstUnits[stream]; unit += 1) {
      for (let frame = firstFrame; frame < end; at += 1) {
        const chunk = chunks.at(at);
        const fits = chunk?.stream === stream && chunk.unit === unit && chunk.firstFrame === frame;
        if (!chunk || !fits || chunk.frameCount < 1 || frame + chunk.frameCount > end) {
          throw broken(stream, unit, frame);
        }
        frame += chunk.frameCount;
      }
      firstChunks[firstUnits[stream] + unit + 1] = at;
    }
  });
  if (at < chunks.length) {
    const { stream, unit, firstFrame } = chunks[at];
    throw broken(stream, unit, firstFrame);
  }
  return { firstUnits, firstChunks };
}
