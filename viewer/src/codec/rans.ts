// rANS with static distributions: formats/entropy.md.

/** Most values of a symbol. */
export const SYMBOLS = 16;
/** Slots of a distribution: frequencies are counted in 4096ths. */
export const SLOTS = 4096;
/** Words of a distribution in `Distributions.starts`. */
const STARTS = SYMBOLS + 1;
/** A bucket is 64 slots. */
const BUCKET_BITS = 6;
const BUCKETS = SLOTS >> BUCKET_BITS;
/** Least state between symbols. */
const LOW = 0x10000;
/** Most bits of one raw value; longer ones are two. */
const RAW_BITS = 12;

/** Distributions of symbols in 4096ths (entropy.md 2). Plain data, which can be sent to a worker. */
export interface Distributions {
  /** 17 numbers for each distribution: symbol s owns the slots from number s to before number s + 1, the last is 4096. */
  starts: Uint16Array;
  /** 64 for each distribution: the symbol that owns the first slot of each 64. */
  buckets: Uint8Array;
}

/** Distributions of ascending starts, 17 for each distribution, the first of each 0 and the last 4096. */
export function distributionsOf(starts: Uint16Array): Distributions {
  const count = starts.length / STARTS;
  const buckets = new Uint8Array(count * BUCKETS);
  for (let at = 0; at < count; at += 1) {
    let symbol = 0;
    for (let bucket = 0; bucket < BUCKETS; bucket += 1) {
      while (bucket << BUCKET_BITS >= starts[at * STARTS + symbol + 1]) {
        symbol += 1;
      }
      buckets[at * BUCKETS + bucket] = symbol;
    }
  }
  return { starts, buckets };
}

/** Reads symbols and raw bits of one substream (entropy.md 3). Words behind its end are read as 0: see `isShort`. */
export class RansDecoder {
  readonly #bytes: Uint8Array;
  readonly #starts: Uint16Array;
  readonly #buckets: Uint8Array;
  readonly #distributionOf: Uint8Array;
  #at = 4;
  #missing = false;
  /** In a typed array, as numbers of 32 bits are no small integers of a JavaScript engine. */
  readonly #state = new Uint32Array(1);

  /** `distributionOf` has the distribution of each context. */
  constructor(bytes: Uint8Array, distributions: Distributions, distributionOf: Uint8Array) {
    this.#bytes = bytes;
    this.#starts = distributions.starts;
    this.#buckets = distributions.buckets;
    this.#distributionOf = distributionOf;
    if (bytes.length < 4) {
      // A state in short form, without words.
      this.#at = bytes.length;
      this.#state[0] = LOW + bytes.reduceRight((value, byte) => (value << 8) | byte, 0);
    } else {
      this.#state[0] = bytes[0] | (bytes[1] << 8) | (bytes[2] << 16) | (bytes[3] << 24);
      this.#missing = this.#state[0] < LOW;
    }
  }

  /** A symbol of a context's distribution, 0 to 15. */
  symbol(context: number): number {
    const state = this.#state[0];
    const slot = state & (SLOTS - 1);
    const distribution = this.#distributionOf[context];
    let symbol = this.#buckets[distribution * BUCKETS + (slot >> BUCKET_BITS)];
    const first = distribution * STARTS;
    let end = this.#starts[first + symbol + 1];
    while (slot >= end) {
      symbol += 1;
      end = this.#starts[first + symbol + 1];
    }
    const start = this.#starts[first + symbol];
    this.#set((Math.imul(end - start, state >>> 12) + slot - start) | 0);
    return symbol;
  }

  /** `count` raw bits, 0 to 24, as a number. */
  bits(count: number): number {
    if (count > RAW_BITS) {
      const high = this.bits(count - RAW_BITS);
      return (high << RAW_BITS) | this.bits(RAW_BITS);
    }
    const state = this.#state[0];
    this.#set(state >>> count);
    return state & ((1 << count) - 1);
  }

  #set(state: number): void {
    if (state >>> 16 === 0) {
      const at = this.#at;
      let word = 0;
      if (at + 2 <= this.#bytes.length) {
        word = this.#bytes[at] | (this.#bytes[at + 1] << 8);
        this.#at = at + 2;
      } else {
        this.#missing = true;
      }
      this.#state[0] = (state << 16) | word;
    } else {
      this.#state[0] = state;
    }
  }

  /** Whether more was read than there is, or the first state is one that no encoder leaves. */
  get isShort(): boolean {
    return this.#missing;
  }

  /** Whether the substream ends here: all bytes are read, none was missing, and the state is the encoder's first. */
  get isFinished(): boolean {
    return this.#state[0] === LOW && this.#at === this.#bytes.length && !this.#missing;
  }
}
