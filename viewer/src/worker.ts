// The worker: checks, decompresses and parses chunks.

import { chunkDecoder, prepare } from "./codec/decode.ts";
import { parseCodecHeader } from "./codec/headers.ts";
import { unpack } from "./format/payload.ts";
import { FormatError, UnsupportedError } from "./format/types.ts";
import type { CodecHeader } from "./format/types.ts";
import type { Answer, Job } from "./player/jobs.ts";

const headers = new Map<number, CodecHeader>();

function headerOf(job: Job): CodecHeader {
  const known = headers.get(job.stream);
  if (known !== undefined) {
    return known;
  }
  if (job.outline === undefined) {
    throw new Error(`stream ${job.stream} is not known to this worker`);
  }
  const header = parseCodecHeader(job.outline, job.outline.headerBytes);
  headers.set(job.stream, header);
  return header;
}

function answer(job: Job): [Answer, Transferable[]] {
  const header = headerOf(job);
  const payload = unpack(job.chunk, job.stored);
  if (job.frame === undefined) {
    const prepared = prepare(header, payload, job.area);
    const { stream, records, boxes, timeline } = prepared;
    const arrays = [stream, records, boxes, ...Object.values(timeline as unknown as Record<string, Uint32Array>)];
    const buffers = new Set(arrays.map((array) => array.buffer as ArrayBuffer));
    return [{ id: job.id, prepared }, [...buffers]];
  }
  const next = job.next;
  const decoder = chunkDecoder(header, payload, job.area);
  const decoded = decoder.frame(job.frame, next && (() => unpack(next.chunk, next.stored)));
  const pixels = decoded.slice();
  return [{ id: job.id, pixels }, [pixels.buffer as ArrayBuffer]];
}

self.onmessage = (event: MessageEvent<Job>) => {
  const job = event.data;
  try {
    const [message, transfer] = answer(job);
    self.postMessage(message, { transfer });
  } catch (error) {
    const isFormat = error instanceof FormatError || error instanceof UnsupportedError;
    const message: Answer = { id: job.id, error: error instanceof Error ? error.message : String(error), isFormat };
    self.postMessage(message);
  }
};
