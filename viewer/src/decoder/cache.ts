// Decoders of chunks that a worker keeps: the next frame of a chunk is a step from the one before.

import type { ChunkDecoder } from "./decoder.ts";

/** A decoder that was not used for so long may go. Milliseconds. */
const STALE_MS = 2000;

interface Kept {
  decoder: ChunkDecoder;
  bytes: number;
  usedMs: number;
}

export class DecoderCache {
  /** By their keys, in the order of their last use. */
  readonly #kept = new Map<string, Kept>();
  #bytes = 0;

  /** Keeps decoders of `mostBytes` at most. */
  constructor(
    private readonly mostBytes: number,
    private readonly now: () => number = () => performance.now(),
  ) {}

  /** What `use` makes of the decoder of a key, which is made where it is not kept; it takes so many bytes. Where there is no room beside
   *  those that are in use it is closed again: a film that plays asks for all of them in turn, so that one in the place of another would
   *  help neither. */
  use<T>(key: string, bytes: number, make: () => ChunkDecoder, use: (decoder: ChunkDecoder) => T): T {
    const usedMs = this.now();
    const known = this.#kept.get(key);
    if (known !== undefined) {
      this.#kept.delete(key);
      this.#kept.set(key, { ...known, usedMs });
      return use(known.decoder);
    }
    this.#makeRoom(bytes, usedMs);
    const decoder = make();
    if (this.#bytes + bytes <= this.mostBytes) {
      this.#kept.set(key, { decoder, bytes, usedMs });
      this.#bytes += bytes;
      return use(decoder);
    }
    try {
      return use(decoder);
    } finally {
      decoder.close();
    }
  }

  #makeRoom(bytes: number, usedMs: number): void {
    for (const [oldest, kept] of this.#kept) {
      if (this.#bytes + bytes <= this.mostBytes || usedMs - kept.usedMs < STALE_MS) {
        return;
      }
      this.#kept.delete(oldest);
      this.#bytes -= kept.bytes;
      kept.decoder.close();
    }
  }
}
