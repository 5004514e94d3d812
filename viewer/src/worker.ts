// The worker: checks, decompresses, parses and decodes chunks.

import { chunkCodings, chunkDecoder, prepare } from "./codec/decode.ts";
import { parseCodecHeader } from "./codec/headers.ts";
import type { ChunkDecoder } from "./codec/types.ts";
import { unpack } from "./format/payload.ts";
import type { CodecHeader } from "./format/types.ts";
import { DecoderCache } from "./decoder_cache.ts";
import type { Answer, Job, StreamOutline, WorkerSettings } from "./player/jobs.ts";

/** What a decoder holds of a pixel at most: pictures, keyframes, and what prediction knows; twice that of half floats. */
const PIXEL_BYTES = 16;
/** What it holds for each byte of a payload: nodes; of the transform codec up to 8 levels of 6 bytes, in arrays that double. */
const PAYLOAD_FACTOR = 8;
const TRANSFORM_FACTOR = 96;

/** Thrown where a frame blends into a chunk that the job did not have. */
class NextIsMissing extends Error {}

const headers = new Map<number, CodecHeader>();
let decoders = new DecoderCache(0);

function headerOf(stream: number, outline: StreamOutline | undefined): CodecHeader {
  const known = headers.get(stream) ?? (outline && parseCodecHeader(outline.stream, outline.headerBytes));
  if (known === undefined) {
    throw new Error(`Stream ${stream} is not known to a worker.`);
  }
  headers.set(stream, known);
  return known;
}

function decoderOf({ chunk, stored, area, asksCodings }: Job, header: CodecHeader): ChunkDecoder {
  const key = `${chunk.stream} ${chunk.unit} ${chunk.firstFrame} ${asksCodings ?? false}`;
  const make = asksCodings ? chunkCodings : chunkDecoder;
  const [, , width, height] = area.area.rect;
  const isHalf = header.kind === "color" && header.isHalf;
  const factor = header.kind === "color" && header.coding.name === "transform" ? TRANSFORM_FACTOR : PAYLOAD_FACTOR;
  const bytes = factor * chunk.rawBytes + PIXEL_BYTES * (isHalf ? 2 : 1) * width * height;
  return decoders.of(key, bytes, () => make(header, unpack(chunk, stored), area));
}

function answerTo(job: Job): [Answer, ArrayBufferLike[]] {
  const header = headerOf(job.chunk.stream, job.outline);
  if (job.frame === undefined) {
    const prepared = prepare(header, unpack(job.chunk, job.stored), job.area);
    const { stream, records, boxes, timeline } = prepared;
    const arrays = [stream, records, boxes, ...Object.values<ArrayBufferView>({ ...timeline })];
    return [{ id: job.id, prepared }, [...new Set(arrays.map((array) => array.buffer))]];
  }
  const next = (): Uint8Array => {
    if (job.next === undefined) {
      throw new NextIsMissing();
    }
    return unpack(job.next.chunk, job.next.stored);
  };
  // The decoder writes its next frame into the same array.
  const pixels = decoderOf(job, header).frame(job.frame, next).slice();
  return [{ id: job.id, pixels }, [pixels.buffer]];
}

self.onmessage = ({ data }: MessageEvent<Job | WorkerSettings>) => {
  if ("keptBytes" in data) {
    decoders = new DecoderCache(data.keptBytes);
    return;
  }
  try {
    const [answer, buffers] = answerTo(data);
    self.postMessage(answer, { transfer: buffers as ArrayBuffer[] });
  } catch (error) {
    const { id } = data;
    const sentence = error instanceof Error ? error.message : String(error);
    const answer: Answer = error instanceof NextIsMissing ? { id, needsNext: true } : { id, error: sentence };
    self.postMessage(answer);
  }
};
