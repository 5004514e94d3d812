// The worker: checks, decompresses, parses and decodes chunks.

import { chunkCodings, chunkDecoder, prepare } from "./codec/decode.ts";
import { parseCodecHeader } from "./codec/headers.ts";
import type { ChunkDecoder } from "./codec/types.ts";
import { unpack } from "./format/payload.ts";
import type { CodecHeader } from "./format/types.ts";
import type { Answer, Job, StreamOutline } from "./player/jobs.ts";

/** Decoders are kept for so many bytes: a frame is a step from the one before. */
const KEPT_BYTES = 64 << 20;
/** What a decoder holds of a pixel at most: pictures, keyframes, and what prediction knows. */
const PIXEL_BYTES = 32;

/** Thrown where a frame blends into a chunk that the job did not have. */
class NextIsMissing extends Error {}

const headers = new Map<number, CodecHeader>();
/** By the places of chunks in their streams and what is asked of them, in the order of their last use. */
const decoders = new Map<string, { decoder: ChunkDecoder; bytes: number }>();
let keptBytes = 0;

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
  const kept = decoders.get(key) ?? {
    decoder: make(header, unpack(chunk, stored), area),
    bytes: chunk.rawBytes + PIXEL_BYTES * width * height,
  };
  keptBytes += decoders.delete(key) ? 0 : kept.bytes;
  decoders.set(key, kept);
  for (const [oldest, { bytes }] of decoders) {
    if (keptBytes <= KEPT_BYTES || oldest === key) {
      break;
    }
    decoders.delete(oldest);
    keptBytes -= bytes;
  }
  return kept.decoder;
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

self.onmessage = ({ data }: MessageEvent<Job>) => {
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
