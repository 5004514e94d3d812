// Stored bytes of chunks: fetched by ranges in the order of need, kept within a budget.

import type { ByteSource, Chunk } from "../format/types.ts";
import { FileChangedError, TransportError } from "../format/http.ts";
import type { Problem } from "./types.ts";

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

/** Failures in a row after which the page shows a message. */
const FAILURES_TO_REPORT = 4;
/** The fetch rate is a mean over this time. */
const RATE_MS = 1000;

export interface StoreStats {
  bytesFetched: number;
  requests: number;
  chunksFetched: number;
  chunksRefetched: number;
  cacheBytes: number;
  /** Bytes per second over the last second. */
  fetchRate: number;
}

interface Request {
  /** One behind the other in the file. */
  ranges: Range[];
  abort: AbortController;
}

/** Stored bytes of a file: chunks of the same bytes share one range. Ranges may overlap. */
interface Range {
  key: string;
  offset: number;
  bytes: number;
}

function rangeOf({ offset, storedBytes }: Chunk): Range {
  return { key: rangeKey({ offset, storedBytes }), offset, bytes: storedBytes };
}

/** The same for chunks of the same stored bytes. */
export function rangeKey({ offset, storedBytes }: Pick<Chunk, "offset" | "storedBytes">): string {
  return `${offset} ${storedBytes}`;
}

export class ChunkStore {
  /** Bytes that arrived, by the keys of their ranges, in the order of their last use. */
  private readonly kept = new Map<string, Uint8Array>();
  /** What is needed, the most urgent first, by key and by offset. */
  private wanted = new Map<string, Range>();
  private wantedAt = new Map<number, Range>();
  /** Keys of ranges that the last view uses. */
  private inUse = new Set<string>();
  private readonly pending = new Set<string>();
  private readonly requests = new Set<Request>();
  private readonly everFetched = new Set<string>();
  private readonly arrivals: { at: number; bytes: number }[] = [];
  private timer: ReturnType<typeof setTimeout> | undefined;
  private failures = 0;
  private closed = false;
  private counts = { bytesFetched: 0, requests: 0, chunksFetched: 0, chunksRefetched: 0 };
  private cachedBytes = 0;

  /** A wanted range has arrived; its key. */
  onChunk: (key: string) => void = () => {};
  /** A sentence for the viewer. Where it is fatal nothing more is fetched. */
  onProblem: (problem: Problem) => void = () => {};

  constructor(
    private readonly source: ByteSource,
    private readonly settings: StoreSettings = STORE_SETTINGS,
  ) {}

  /** Replaces the list of what is to be fetched, the most urgent first; what is here is not fetched again. `inUse` is kept beyond the budget,
   *  and not fetched. Requests in flight go on: their bytes are used or kept. */
  want(chunks: readonly Chunk[], inUse: readonly Chunk[] = []): void {
    // An empty chunk is not fetched.
    const ranges = chunks.filter(({ storedBytes }) => storedBytes > 0).map(rangeOf);
    this.wanted = new Map(ranges.map((range) => [range.key, range]));
    this.wantedAt = new Map(ranges.map((range) => [range.offset, range]));
    this.inUse = new Set(inUse.map(rangeKey));
    for (const key of [...this.inUse, ...this.wanted.keys()]) {
      this.touch(key);
    }
    this.trim();
    this.pump();
  }

  /** The stored bytes of a chunk, if they are here. */
  get(chunk: Chunk): Uint8Array | undefined {
    return chunk.storedBytes === 0 ? new Uint8Array(0) : this.kept.get(rangeKey(chunk));
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

  private touch(key: string): void {
    const bytes = this.kept.get(key);
    if (bytes !== undefined) {
      this.kept.delete(key);
      this.kept.set(key, bytes);
    }
  }

  /** Drops what was used longest ago, down to the budget. */
  private trim(): void {
    for (const [key, bytes] of this.kept) {
      if (this.cachedBytes <= this.settings.cacheBytes) {
        return;
      }
      if (!this.wanted.has(key) && !this.inUse.has(key)) {
        this.kept.delete(key);
        this.cachedBytes -= bytes.length;
      }
    }
  }

  private isMissing(range: Range | undefined): range is Range {
    return range !== undefined && !this.kept.has(range.key) && !this.pending.has(range.key);
  }

  private pump(): void {
    if (this.closed || this.timer !== undefined) {
      return;
    }
    for (const range of this.wanted.values()) {
      if (this.requests.size >= this.settings.parallel) {
        return;
      }
      if (this.isMissing(range)) {
        void this.fetch(this.runFrom(range));
      }
    }
  }

  /** A range and those wanted behind it in the file, without a gap. */
  private runFrom(first: Range): Range[] {
    const ranges = [first];
    let end = first.offset + first.bytes;
    for (;;) {
      const next = this.wantedAt.get(end);
      if (!this.isMissing(next) || end + next.bytes - first.offset > this.settings.requestBytes) {
        return ranges;
      }
      ranges.push(next);
      end += next.bytes;
    }
  }

  private async fetch(ranges: Range[]): Promise<void> {
    const request: Request = { ranges, abort: new AbortController() };
    const count = ranges.reduce((sum, { bytes }) => sum + bytes, 0);
    this.requests.add(request);
    ranges.forEach(({ key }) => this.pending.add(key));
    this.counts.requests += 1;
    let failure: unknown;
    try {
      const bytes = await this.source.read(ranges[0].offset, count, request.abort.signal);
      if (!this.closed) {
        this.failures = 0;
        this.arrive(ranges, bytes);
      }
    } catch (error) {
      failure = error;
    }
    this.requests.delete(request);
    ranges.forEach(({ key }) => this.pending.delete(key));
    if (this.closed) {
      return;
    }
    if (failure !== undefined) {
      this.fail(failure);
    } else {
      ranges.filter(({ key }) => this.wanted.has(key)).forEach(({ key }) => this.onChunk(key));
    }
    this.pump();
  }

  private arrive(ranges: readonly Range[], bytes: Uint8Array): void {
    let at = 0;
    for (const { key, bytes: size } of ranges) {
      // A copy, so that dropping a chunk frees its bytes.
      this.kept.set(key, bytes.slice(at, at + size));
      this.cachedBytes += size;
      this.counts.chunksFetched += 1;
      this.counts.chunksRefetched += Number(this.everFetched.has(key));
      this.everFetched.add(key);
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
    if (this.failures >= FAILURES_TO_REPORT) {
      this.onProblem({ fatal: false, passes: true, message: `${error.message}; trying again` });
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
