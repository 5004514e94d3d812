// Stored bytes of chunks: fetched by ranges in the order of need, kept within a budget.

import type { ByteSource, Chunk } from "../format/types.ts";
import { FileChangedError, TransportError } from "../format/http.ts";

export interface StoreSettings {
  /** Bytes of chunks that are kept. What the last view needs is kept beyond it. */
  cacheBytes: number;
  /** Requests at a time. */
  parallel: number;
  /** Most bytes of a request for neighbours in the file. */
  requestBytes: number;
  /** Milliseconds before the first retry; each later one waits twice as long, up to `maxDelayMs`. */
  retryDelayMs: number;
  maxDelayMs: number;
}

export const STORE_SETTINGS: StoreSettings = {
  cacheBytes: 256 << 20,
  parallel: 6,
  requestBytes: 2 << 20,
  retryDelayMs: 200,
  maxDelayMs: 10_000,
};

/** Failures in a row after which the viewer is told. */
const FAILURES_TO_REPORT = 4;
/** The fetch rate is a mean over this time. */
const RATE_MS = 1000;

interface Request {
  /** Offsets of its chunks, ascending; the chunks lie one behind the other. */
  offsets: number[];
  abort: AbortController;
}

export interface StoreStats {
  bytesFetched: number;
  requests: number;
  chunksFetched: number;
  chunksRefetched: number;
  cacheBytes: number;
  /** Bytes per second over the last second. */
  fetchRate: number;
}

/** Chunks by their offsets: chunks of the same bytes share one. */
export class ChunkStore {
  /** Bytes that arrived. In the order of their last use. */
  private readonly kept = new Map<number, Uint8Array>();
  private readonly sizes = new Map<number, number>();
  /** Offsets in the order of need. */
  private wanted: number[] = [];
  private wantedSet = new Set<number>();
  private readonly pending = new Map<number, Request>();
  private readonly requests = new Set<Request>();
  private readonly everFetched = new Set<number>();
  private readonly arrivals: { at: number; bytes: number }[] = [];
  private timer: ReturnType<typeof setTimeout> | undefined;
  private failures = 0;
  private closed = false;
  private counts = { bytesFetched: 0, requests: 0, chunksFetched: 0, chunksRefetched: 0 };
  private cachedBytes = 0;

  /** A wanted chunk has arrived; its offset. */
  onChunk: (offset: number) => void = () => {};
  /** A sentence for the viewer. Where it is fatal nothing more is fetched. */
  onProblem: (problem: { fatal: boolean; message: string }) => void = () => {};

  constructor(
    private readonly source: ByteSource,
    private readonly settings: StoreSettings = STORE_SETTINGS,
  ) {}

  /** Replaces the list of what is needed, the most urgent first. Requests in flight go on: their bytes are used or kept. */
  want(chunks: readonly Chunk[]): void {
    this.wanted = [];
    this.wantedSet = new Set();
    for (const chunk of chunks) {
      // An empty chunk may lie where another begins, and is not fetched.
      if (chunk.storedBytes > 0 && !this.wantedSet.has(chunk.offset)) {
        this.wantedSet.add(chunk.offset);
        this.wanted.push(chunk.offset);
        this.sizes.set(chunk.offset, chunk.storedBytes);
      }
    }
    for (const offset of this.wanted) {
      this.touch(offset);
    }
    this.trim();
    this.pump();
  }

  /** The stored bytes of a chunk, if they are here. */
  get(chunk: Chunk): Uint8Array | undefined {
    return chunk.storedBytes === 0 ? new Uint8Array(0) : this.kept.get(chunk.offset);
  }

  get stats(): StoreStats {
    const now = performance.now();
    while (this.arrivals.length > 0 && this.arrivals[0].at < now - RATE_MS) {
      this.arrivals.shift();
    }
    const recent = this.arrivals.reduce((sum, arrival) => sum + arrival.bytes, 0);
    return { ...this.counts, cacheBytes: this.cachedBytes, fetchRate: (recent * 1000) / RATE_MS };
  }

  close(): void {
    this.closed = true;
    clearTimeout(this.timer);
    this.requests.forEach((request) => request.abort.abort());
  }

  private touch(offset: number): void {
    const bytes = this.kept.get(offset);
    if (bytes !== undefined) {
      this.kept.delete(offset);
      this.kept.set(offset, bytes);
    }
  }

  /** Drops what was used longest ago, down to the budget. */
  private trim(): void {
    for (const [offset, bytes] of this.kept) {
      if (this.cachedBytes <= this.settings.cacheBytes) {
        return;
      }
      if (!this.wantedSet.has(offset)) {
        this.kept.delete(offset);
        this.cachedBytes -= bytes.length;
      }
    }
  }

  private isMissing(offset: number): boolean {
    return !this.kept.has(offset) && !this.pending.has(offset);
  }

  private pump(): void {
    if (this.closed || this.timer !== undefined) {
      return;
    }
    for (const offset of this.wanted) {
      if (this.requests.size >= this.settings.parallel) {
        return;
      }
      if (this.isMissing(offset)) {
        void this.fetch(this.runAround(offset));
      }
    }
  }

  /** A chunk and those wanted behind it in the file, without a gap. */
  private runAround(offset: number): number[] {
    const offsets = [offset];
    let end = offset + this.sizes.get(offset)!;
    while (
      this.wantedSet.has(end) &&
      this.isMissing(end) &&
      end - offset + this.sizes.get(end)! <= this.settings.requestBytes
    ) {
      offsets.push(end);
      end += this.sizes.get(end)!;
    }
    return offsets;
  }

  private async fetch(offsets: number[]): Promise<void> {
    const request: Request = { offsets, abort: new AbortController() };
    const first = offsets[0];
    const count = offsets.reduce((sum, offset) => sum + this.sizes.get(offset)!, 0);
    this.requests.add(request);
    offsets.forEach((offset) => this.pending.set(offset, request));
    this.counts.requests += 1;
    let failure: unknown;
    try {
      const bytes = await this.source.read(first, count, request.abort.signal);
      if (!this.closed) {
        this.failures = 0;
        this.arrive(request, bytes);
      }
    } catch (error) {
      failure = error;
    }
    this.requests.delete(request);
    offsets.forEach((offset) => this.pending.delete(offset));
    if (this.closed) {
      return;
    }
    if (failure !== undefined) {
      this.fail(failure);
    } else {
      offsets.filter((offset) => this.wantedSet.has(offset)).forEach((offset) => this.onChunk(offset));
    }
    this.pump();
  }

  private arrive(request: Request, bytes: Uint8Array): void {
    let at = 0;
    for (const offset of request.offsets) {
      const size = this.sizes.get(offset)!;
      // A copy, so that dropping a chunk frees its bytes.
      this.kept.set(offset, bytes.slice(at, at + size));
      this.cachedBytes += size;
      this.counts.chunksFetched += 1;
      this.counts.chunksRefetched += Number(this.everFetched.has(offset));
      this.everFetched.add(offset);
      at += size;
    }
    this.counts.bytesFetched += bytes.length;
    this.arrivals.push({ at: performance.now(), bytes: bytes.length });
    this.trim();
  }

  private fail(error: unknown): void {
    if (error instanceof FileChangedError) {
      this.closed = true;
      this.requests.forEach((request) => request.abort.abort());
      this.onProblem({ fatal: true, message: error.message });
      return;
    }
    if (!(error instanceof TransportError)) {
      this.closed = true;
      this.onProblem({ fatal: true, message: error instanceof Error ? error.message : String(error) });
      return;
    }
    this.failures += 1;
    if (this.failures === FAILURES_TO_REPORT) {
      this.onProblem({ fatal: false, message: `${error.message}; trying again` });
    }
    if (this.timer === undefined) {
      const delay = this.settings.retryDelayMs * 2 ** Math.min(this.failures - 1, 16);
      this.timer = setTimeout(
        () => {
          this.timer = undefined;
          this.pump();
        },
        Math.min(delay, this.settings.maxDelayMs),
      );
    }
  }
}
