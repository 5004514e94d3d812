// Form 0 of the index: rows of fixed size (formats/container.md 4 to 6).

import { FileFields } from "./bytes.ts";
import {
  checkChunkCount,
  checkPlace,
  checkProbe,
  checkStream,
  checkUnique,
  coverUnits,
  type IndexTables,
  readDataset,
  readOrientation,
  readPosition,
  type StreamRow,
  STORAGES,
} from "./index_tables.ts";
import type { Chunk, Probe } from "./types.ts";

const MIN_PROBE_BYTES = 98;
const MIN_STREAM_BYTES = 36;
const CHUNK_BYTES = 40;

/** Reads an index that starts at `offset` of its file, which is also where the chunks end. */
export function readRows(bytes: Uint8Array, offset: number): IndexTables {
  const fields = new FileFields(bytes, "container.md 4", offset);
  const [probeCount, streamCount, chunkCount] = [fields.u32(), fields.u32(), fields.u32()];
  const dataset = readDataset(fields);
  fields.fits(probeCount, "probes", MIN_PROBE_BYTES);
  const probes = Array.from({ length: probeCount }, () => readProbe(fields));
  fields.section = "container.md 5";
  fields.fits(streamCount, "streams", MIN_STREAM_BYTES);
  const streams = Array.from({ length: streamCount }, () => readStream(fields, probeCount));
  fields.section = "container.md 6";
  checkChunkCount(fields, chunkCount, CHUNK_BYTES);
  const chunks = Array.from({ length: chunkCount }, () => readChunk(fields, offset));
  fields.finish();
  checkUnique(probes, streams);
  const units = coverUnits(streams, chunks);
  return { ...dataset, probes, streams, chunks, units, attributes: new Map() };
}

function readProbe(fields: FileFields): Probe {
  const start = fields.at;
  const name = fields.string("A probe's name");
  const position = readPosition(fields, "A probe's position");
  const orientation = readOrientation(fields, "A probe's orientation");
  const frames: [number, number] = [fields.u32(), fields.u32()];
  const intrinsics = fields.finites(4, "A probe's intrinsics") as Probe["intrinsics"];
  const probe = { name, position, orientation, frames, intrinsics };
  checkProbe(fields, start, probe);
  return probe;
}

function readStream(fields: FileFields, probes: number): StreamRow {
  const start = fields.at;
  const [kind, face, probe] = [fields.u8(), fields.u8(), fields.u16()];
  const codec = String.fromCharCode(...fields.take(4));
  const [width, height, firstFrame, frameCount] = [fields.u32(), fields.u32(), fields.u32(), fields.u32()];
  const [unitWidth, unitHeight] = [fields.u32(), fields.u32()];
  const headerBytes = fields.take(fields.u32());
  const stream = {
    kind,
    face,
    probe,
    codec,
    width,
    height,
    firstFrame,
    frameCount,
    unitWidth,
    unitHeight,
    headerBytes,
  };
  checkStream(fields, start, stream, probes);
  return stream;
}

function readChunk(fields: FileFields, end: number): Chunk {
  const start = fields.at;
  const [stream, unit, firstFrame, frameCount] = [fields.u32(), fields.u32(), fields.u32(), fields.u32()];
  const offset = fields.u64("A chunk's offset");
  const [storedBytes, rawBytes, crc32, method] = [fields.u32(), fields.u32(), fields.u32(), fields.u8()];
  fields.zeros(3);
  // Storage 2 is that of form 1 alone.
  if (method > 1) {
    throw fields.error(`A chunk is stored by method ${method}, which is unknown`, start);
  }
  const storage = STORAGES[method];
  const chunk = { stream, unit, firstFrame, frameCount, offset, storedBytes, rawBytes, crc32, storage };
  checkPlace(fields, start, chunk, end);
  return chunk;
}
