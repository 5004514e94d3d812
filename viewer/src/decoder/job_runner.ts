// Jobs of a worker: its decoder, the streams that it knows, and the decoders of chunks that it keeps.

import type { Answer, Job, StreamOutline } from "../player/jobs.ts";
import { DecoderCache } from "./cache.ts";
import { type Decoder, type DecoderStream, NextIsMissing } from "./decoder.ts";
import { DecoderStopped } from "./instance.ts";

/** What a decoder holds of a pixel at most: pictures, keyframes, and what prediction knows; twice that of half floats. */
const PIXEL_BYTES = 16;
/** What it holds for each byte of a payload: nodes; of the transform codec levels of regions. */
const PAYLOAD_FACTOR = 8;
const TRANSFORM_FACTOR = 96;

/** What belongs to one instance. */
interface Running {
  decoder: Decoder;
  streams: Map<number, DecoderStream>;
  cache: DecoderCache;
}

export class JobRunner {
  readonly #outlines = new Map<number, StreamOutline>();
  #running: Running | undefined;

  /** `start` makes an instance; `keptBytes` are those of the decoders that are kept, at most. */
  constructor(
    private readonly start: () => Decoder,
    private readonly keptBytes: number,
  ) {}

  /** The answer to a job, and what is transferred with it. A job at which the instance stops is tried once more with another one, whose
   *  memory is empty. */
  run(job: Job): [Answer, Transferable[]] {
    if (job.outline !== undefined) {
      this.#outlines.set(job.chunk.stream, job.outline);
    }
    try {
      try {
        return this.#answer(job);
      } catch (error) {
        if (error instanceof DecoderStopped) {
          return this.#answer(job);
        }
        throw error;
      }
    } catch (error) {
      const { id } = job;
      const sentence = error instanceof Error ? error.message : String(error);
      return [error instanceof NextIsMissing ? { id, needsNext: true } : { id, error: sentence }, []];
    }
  }

  #answer(job: Job): [Answer, Transferable[]] {
    if (this.#running === undefined || this.#running.decoder.isStopped) {
      this.#running = { decoder: this.start(), streams: new Map(), cache: new DecoderCache(this.keptBytes) };
    }
    const running = this.#running;
    const stream = this.#stream(running, job.chunk.stream);
    const { id, frame } = job;
    if (frame === undefined) {
      const prepared = running.decoder.prepare(stream, job);
      const { records, boxes, timeline } = prepared;
      const arrays = [prepared.stream, records, boxes, ...Object.values<Uint32Array>({ ...timeline })];
      return [{ id, prepared }, arrays.map(({ buffer }) => buffer as ArrayBuffer)];
    }
    const pixels = this.#withChunk(running, stream, job, (decoder) => decoder.frame(frame, () => job.next).slice());
    return [{ id, pixels }, [pixels.buffer as ArrayBuffer]];
  }

  #stream({ decoder, streams }: Running, number: number): DecoderStream {
    const outline = this.#outlines.get(number);
    if (outline === undefined) {
      throw new Error(`Stream ${number} is not known to a worker.`);
    }
    const known = streams.get(number) ?? decoder.openStream(outline.stream, outline.headerBytes);
    streams.set(number, known);
    return known;
  }

  #withChunk<T>(
    { decoder, cache }: Running,
    stream: DecoderStream,
    job: Job,
    use: Parameters<typeof cache.use<T>>[3],
  ): T {
    const { chunk, area, asksCodings } = job;
    const { header } = stream;
    const key = `${chunk.stream} ${chunk.unit} ${chunk.firstFrame} ${asksCodings ?? false}`;
    const [, , width, height] = area.rect;
    const isHalf = header.kind === "color" && header.isHalf;
    const factor = header.kind === "color" && header.coding.name === "transform" ? TRANSFORM_FACTOR : PAYLOAD_FACTOR;
    const bytes = factor * chunk.rawBytes + PIXEL_BYTES * (isHalf ? 2 : 1) * width * height;
    const make = () => (asksCodings ? decoder.openCodings(stream, job) : decoder.openChunk(stream, job));
    return cache.use(key, bytes, make, use);
  }
}
