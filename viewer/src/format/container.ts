// An open container (formats/container.md): its index, and where the chunks of a frame lie.

import { decoder, loadDecoder } from "../decoder/module.ts";
import type { ChunkArea, ChunkPlace, HeaderStream } from "../decoder/types.ts";
import { type Footage, readFootage, STREAM_KINDS } from "./attributes.ts";
import { findFoot, type Foot, FOOT_BYTES, readFoot, readHead, VERSION } from "./foot.ts";
import { readIndex } from "./index_reader.ts";
import {
  HEAD_BYTES,
  type IndexTables,
  type StreamRow,
  unitCountOf,
  unitRectOf,
  type UnitTable,
} from "./index_tables.ts";
import { checkLimits, MAX_HEADER_BYTES, MAX_INDEX_BYTES } from "./limits.ts";
import {
  type ByteSource,
  type Chunk,
  type CodecHeader,
  FormatError,
  type Probe,
  type Rect,
  type Stream,
  UnsupportedError,
} from "./types.ts";

/** A foot that bytes follow is looked for in so many at the end of a file. */
const FOOT_SEARCH_BYTES = 1 << 16;

/** A container whose head, foot and index were read and checked. */
export class Container {
  /** Of the dataset; any text without control characters. */
  readonly name: string;
  /** Frames per second, above 0. */
  readonly fps: number;
  readonly projection: "cube" | "perspective";
  /** As they stand where they do not move. */
  readonly probes: readonly Probe[];
  readonly streams: readonly Stream[];
  /** In the order of stream, unit and first frame. */
  readonly chunks: readonly Chunk[];
  /** Values by name (container.md 6.3). */
  readonly attributes: ReadonlyMap<string, Uint8Array>;
  readonly footage: Footage;
  private readonly units: UnitTable;

  private constructor(
    readonly source: ByteSource,
    /** Of the format; one above 2 is later than this player. */
    readonly minorVersion: number,
    /** Bytes of the index; head and foot are 56 more. */
    readonly indexBytes: number,
    index: IndexTables,
  ) {
    this.name = index.name;
    this.fps = index.fps;
    this.projection = index.projection === 0 ? "cube" : "perspective";
    this.probes = index.probes;
    this.chunks = index.chunks;
    this.units = index.units;
    this.attributes = index.attributes;
    const headers = readHeaders(index.streams);
    checkLimits(index, headers, source.byteCount);
    this.streams = index.streams.map((row, at) => streamOf(row, at, headers[at]));
    this.footage = readFootage(index.attributes);
  }

  /** Reads head, foot and index, in three requests: a FormatError where they break a rule, an UnsupportedError where the file needs more
   *  than this player does; errors of the source as they are. */
  static async open(source: ByteSource, signal?: AbortSignal): Promise<Container> {
    const head = source.read(0, Math.min(HEAD_BYTES, source.byteCount), signal);
    await Promise.all([head, loadDecoder()]);
    const minor = readHead(await head);
    if (source.byteCount < HEAD_BYTES + FOOT_BYTES) {
      throw new FormatError(`The container ends after its head, at byte ${source.byteCount} (container.md 7).`);
    }
    const foot = await footOf(source, signal);
    if (foot.indexBytes > MAX_INDEX_BYTES) {
      throw new UnsupportedError(
        `The container has an index of ${foot.indexBytes} bytes; this player reads at most ${MAX_INDEX_BYTES}.`,
      );
    }
    const bytes = await source.read(foot.indexOffset, foot.indexBytes, signal);
    if (decoder().crc32(bytes) !== foot.indexCrc32) {
      throw new FormatError(
        `The index's CRC-32 does not match: the file is damaged at byte ${foot.indexOffset} (container.md 4).`,
      );
    }
    try {
      return new Container(source, minor, foot.indexBytes, readIndex(bytes, foot.indexOffset));
    } catch (error) {
      throw minor > VERSION[1] ? ofLaterVersion(error, minor) : error;
    }
  }

  /** A probe as it stands in a frame (container.md 6.5). */
  probeAt(probe: number, frame: number): Probe {
    const still = this.probes[probe];
    const poses = this.footage.poses.get(still.name) ?? [];
    const pose = poses[firstFrom(0, poses.length, (at) => poses[at].frame >= frame)];
    return pose?.frame === frame ? { ...still, position: pose.position, orientation: pose.orientation } : still;
  }

  /** Units of a stream's images, which are numbered row by row. */
  unitCount(stream: number): number {
    return unitCountOf(this.streams[stream]);
  }

  /** Left, top, width and height of a unit in pixels of its image. */
  unitRect(stream: number, unit: number): Rect {
    return unitRectOf(this.streams[stream], unit);
  }

  /** First chunk of a unit in `chunks`, and the one behind its last. */
  chunksOf(stream: number, unit: number): [number, number] {
    const at = this.units.firstUnits[stream] + unit;
    return [this.units.firstChunks[at], this.units.firstChunks[at + 1]];
  }

  /** The chunk of a unit that holds a frame, as its place in `chunks`; -1 where the stream does not have the frame. */
  chunkIndex(stream: number, unit: number, frame: number): number {
    const [start, end] = this.chunksOf(stream, unit);
    const at = firstFrom(start, end, (row) => this.chunks[row].firstFrame > frame) - 1;
    const isHeld = at >= start && frame < this.chunks[at].firstFrame + this.chunks[at].frameCount;
    return isHeld ? at : -1;
  }

  /** The places of a unit's chunks that hold any of some frames, first and last: the first, and the one behind the last. */
  chunksAmong(stream: number, unit: number, [first, last]: readonly [number, number]): [number, number] {
    const [start, end] = this.chunksOf(stream, unit);
    const at = firstFrom(start, end, (row) => this.chunks[row].firstFrame + this.chunks[row].frameCount > first);
    return [at, firstFrom(at, end, (row) => this.chunks[row].firstFrame > last)];
  }

  /** Whether a chunk is the last of its unit. */
  placeOf(chunkIndex: number): ChunkPlace {
    const { stream, unit } = this.chunks[chunkIndex];
    return chunkIndex + 1 === this.chunksOf(stream, unit)[1] ? "last" : "inner";
  }

  /** What a decoder needs to know of a chunk. */
  areaOf(chunkIndex: number): ChunkArea {
    const { stream, unit } = this.chunks[chunkIndex];
    return { rect: this.unitRect(stream, unit), place: this.placeOf(chunkIndex) };
  }
}

/** The first number from `start` on for which a condition holds that holds for all after it, or `end`. */
function firstFrom(start: number, end: number, holds: (at: number) => boolean): number {
  let [low, high] = [start, end];
  while (low < high) {
    const middle = Math.floor((low + high) / 2);
    if (holds(middle)) {
      high = middle;
    } else {
      low = middle + 1;
    }
  }
  return low;
}

/** The foot, which is the last bytes of the file. Where it ends before, the error says how many bytes follow it. */
async function footOf(source: ByteSource, signal?: AbortSignal): Promise<Foot> {
  const { byteCount } = source;
  const bytes = await source.read(byteCount - FOOT_BYTES, FOOT_BYTES, signal);
  try {
    return readFoot(bytes, byteCount);
  } catch (error) {
    const count = Math.min(byteCount, FOOT_SEARCH_BYTES);
    const end = findFoot(await source.read(byteCount - count, count, signal), byteCount);
    if (end === undefined) {
      throw error;
    }
    throw new FormatError(
      `The container ends at byte ${end}, and ${byteCount - end} bytes follow it (container.md 7).`,
    );
  }
}

/** The error of a file of a later minor version, which it names. */
function ofLaterVersion(error: unknown, minor: number): unknown {
  const version = `The format version ${VERSION[0]}.${minor} is later than this player knows`;
  if (error instanceof UnsupportedError || error instanceof FormatError) {
    return new UnsupportedError(`${version}: ${error.message}`);
  }
  return error;
}

/** Headers of streams; those of the same bytes and sizes are read once. */
function readHeaders(rows: readonly StreamRow[]): CodecHeader[] {
  const known = new Map<Uint8Array, Map<string, CodecHeader>>();
  let bytes = 0;
  return rows.map((row, at) => {
    const { kind, codec, face, width, height, unitWidth, unitHeight, headerBytes } = row;
    const stream = { kind: STREAM_KINDS[kind], codec, face, width, height, unitWidth, unitHeight };
    const key = Object.values(stream).join();
    const ofBytes = known.get(headerBytes) ?? new Map<string, CodecHeader>();
    known.set(headerBytes, ofBytes);
    const header = ofBytes.get(key);
    if (header) {
      return header;
    }
    bytes += headerBytes.length;
    if (bytes > MAX_HEADER_BYTES) {
      throw new UnsupportedError(`The streams have more than ${MAX_HEADER_BYTES} bytes of different codec headers.`);
    }
    const read = readHeader(stream, at, headerBytes);
    ofBytes.set(key, read);
    return read;
  });
}

/** The header of a stream; errors name it. */
function readHeader(stream: HeaderStream, at: number, bytes: Uint8Array): CodecHeader {
  try {
    const opened = decoder().openStream(stream, bytes);
    decoder().closeStream(opened);
    return opened.header;
  } catch (error) {
    if (error instanceof FormatError || error instanceof UnsupportedError) {
      error.message = `Stream ${at}: ${error.message}`;
    }
    throw error;
  }
}

function streamOf(row: StreamRow, index: number, header: CodecHeader): Stream {
  const { face, probe, codec, width, height, firstFrame, frameCount, unitWidth, unitHeight, headerBytes } = row;
  const place = { index, kind: header.kind, face, probe, codec, width, height, firstFrame, frameCount };
  return { ...place, unitWidth, unitHeight, header, headerBytes };
}
