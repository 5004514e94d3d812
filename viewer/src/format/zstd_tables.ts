// Bits and entropy tables of Zstandard frames (RFC 8878, 4): FSE and Huffman codes.

import { FormatError } from "./types.ts";

/** An error of the chunk's frame; `why` is a clause. */
export function damagedFrame(why: string): FormatError {
  return new FormatError(`The Zstandard frame of a chunk is damaged: ${why} (container.md 6.2).`);
}

/** Bits from the first byte on, the lowest first. */
export class ForwardBits {
  /** Bits that were taken. */
  at = 0;

  constructor(private readonly bytes: Uint8Array) {}

  /** A number of at most 16 bits. */
  take(bits: number): number {
    if (this.at + bits > 8 * this.bytes.length) {
      throw damagedFrame("a table ends early");
    }
    const byte = this.at >>> 3;
    const word = this.bytes[byte] | (this.bytes[byte + 1] << 8) | (this.bytes[byte + 2] << 16);
    const value = (word >>> (this.at & 7)) & ((1 << bits) - 1);
    this.at += bits;
    return value;
  }
}

/** Bits from the last byte back, below the highest one that is set. Bits before the first are 0. */
export class BackwardBits {
  /** Bits that are left; below 0 once more were taken than there are. */
  left: number;

  constructor(private readonly bytes: Uint8Array) {
    const last = bytes.length > 0 ? bytes[bytes.length - 1] : 0;
    if (last === 0) {
      throw damagedFrame("a bit stream has no end mark");
    }
    this.left = 8 * bytes.length - 1 - (Math.clz32(last) - 24);
  }

  /** A number of at most 25 bits. */
  take(bits: number): number {
    this.left -= bits;
    const mask = (1 << bits) - 1;
    if (this.left >= 0) {
      return (this.word(this.left >>> 3) >>> (this.left & 7)) & mask;
    }
    return this.left > -bits ? (this.word(0) << -this.left) & mask : 0;
  }

  private word(at: number): number {
    const { bytes } = this;
    return bytes[at] | (bytes[at + 1] << 8) | (bytes[at + 2] << 16) | (bytes[at + 3] << 24);
  }
}

/** What each state of an FSE code means: its symbol, and the next state, which is a base and so many bits more. */
export interface FseTable {
  accuracy: number;
  symbols: Uint8Array;
  bits: Uint8Array;
  bases: Uint16Array;
}

/** Probabilities of symbols, whose sum is 2^accuracy; -1 is one of less than 1 (RFC 8878, 4.1.1). */
export interface Distribution {
  accuracy: number;
  counts: number[];
}

/** Most bits of accuracy, and most symbols. */
export type FseLimits = readonly [number, number];

/** A distribution, and the bytes that it takes. */
export function readDistribution(bytes: Uint8Array, [mostAccuracy, mostSymbols]: FseLimits): [Distribution, number] {
  const bits = new ForwardBits(bytes);
  const accuracy = bits.take(4) + 5;
  if (accuracy > mostAccuracy) {
    throw damagedFrame("a table is too large");
  }
  const counts: number[] = [];
  let left = (1 << accuracy) + 1;
  while (left > 1 && counts.length < mostSymbols) {
    const width = 32 - Math.clz32(left);
    const low = (1 << width) - 1 - left;
    let value = bits.take(width - 1);
    if (value >= low) {
      value |= bits.take(1) << (width - 1);
      value -= value >= 1 << (width - 1) ? low : 0;
    }
    const count = value - 1;
    counts.push(count);
    left -= Math.abs(count);
    for (let repeat = count === 0 ? 3 : 0; repeat === 3;) {
      repeat = bits.take(2);
      counts.push(...Array<number>(repeat).fill(0));
    }
  }
  if (left !== 1 || counts.length > mostSymbols) {
    throw damagedFrame("the probabilities of a table have another sum");
  }
  return [{ accuracy, counts }, (bits.at + 7) >>> 3];
}

/** The table of a distribution. */
export function fseTable({ accuracy, counts }: Distribution): FseTable {
  const size = 1 << accuracy;
  const symbols = new Uint8Array(size);
  let high = size;
  counts.forEach((count, symbol) => {
    if (count === -1) {
      high -= 1;
      symbols[high] = symbol;
    }
  });
  const step = (size >>> 1) + (size >>> 3) + 3;
  let at = 0;
  counts.forEach((count, symbol) => {
    for (let row = 0; row < count; row += 1) {
      symbols[at] = symbol;
      do {
        at = (at + step) & (size - 1);
      } while (at >= high);
    }
  });
  const next = counts.map((count) => Math.abs(count));
  const [bits, bases] = [new Uint8Array(size), new Uint16Array(size)];
  symbols.forEach((symbol, row) => {
    const state = next[symbol];
    next[symbol] += 1;
    bits[row] = accuracy - (31 - Math.clz32(state));
    bases[row] = (state << bits[row]) - size;
  });
  return { accuracy, symbols, bits, bases };
}

/** A code of one symbol. */
export function fseOfOne(symbol: number): FseTable {
  return { accuracy: 0, symbols: Uint8Array.of(symbol), bits: new Uint8Array(1), bases: new Uint16Array(1) };
}

/** For each number of `longest` bits the symbol that it starts with, times 16, and the bits of that. */
export interface HuffmanTable {
  longest: number;
  rows: Uint16Array;
}

const MAX_HUFFMAN_BITS = 11;

function huffmanTable(weights: number[]): HuffmanTable {
  const total = weights.reduce((sum, weight) => sum + (weight > 0 ? 2 ** (weight - 1) : 0), 0);
  const longest = total > 0 && total < 1 << MAX_HUFFMAN_BITS ? 32 - Math.clz32(total) : 0;
  const rest = 2 ** longest - total;
  const all = [...weights, 32 - Math.clz32(rest)];
  // A code of which no symbol has the longest length is one of fewer bits.
  if (longest === 0 || (rest & (rest - 1)) !== 0 || !all.includes(1)) {
    throw damagedFrame("a Huffman table is illegal");
  }
  const rows = new Uint16Array(1 << longest);
  let at = 0;
  for (let weight = 1; weight <= longest; weight += 1) {
    all.forEach((found, symbol) => {
      if (found === weight) {
        rows.fill((symbol << 4) | (longest + 1 - weight), at, at + (1 << (weight - 1)));
        at += 1 << (weight - 1);
      }
    });
  }
  return { longest, rows };
}

/** A Huffman table, and the bytes that it takes (RFC 8878, 4.2.1). */
export function readHuffman(bytes: Uint8Array): [HuffmanTable, number] {
  const head = bytes.length > 0 ? bytes[0] : 0;
  const size = head >= 128 ? (head - 126) >>> 1 : head;
  if (1 + size > bytes.length) {
    throw damagedFrame("a Huffman table ends early");
  }
  const packed = bytes.subarray(1, 1 + size);
  if (head >= 128) {
    const weights = Array.from(packed, (byte) => [byte >>> 4, byte & 15]).flat();
    return [huffmanTable(weights.slice(0, head - 127)), 1 + size];
  }
  return [huffmanTable(fseWeights(packed)), 1 + size];
}

function fseWeights(packed: Uint8Array): number[] {
  const [distribution, used] = readDistribution(packed, [6, 256]);
  const table = fseTable(distribution);
  const bits = new BackwardBits(packed.subarray(used));
  const states = [bits.take(table.accuracy), bits.take(table.accuracy)];
  if (bits.left < 0) {
    throw damagedFrame("the weights of a Huffman table end early");
  }
  const weights: number[] = [];
  for (let turn = 0; ; turn = 1 - turn) {
    const state = states[turn];
    weights.push(table.symbols[state]);
    if (weights.length >= 255) {
      throw damagedFrame("a Huffman table has too many weights");
    }
    states[turn] = table.bases[state] + bits.take(table.bits[state]);
    if (bits.left < 0) {
      weights.push(table.symbols[states[1 - turn]]);
      return weights;
    }
  }
}

/** Decodes a stream of Huffman codes, which fills `out` exactly. */
export function huffmanStream(bytes: Uint8Array, { longest, rows }: HuffmanTable, out: Uint8Array): void {
  let { left } = new BackwardBits(bytes);
  const mask = (1 << longest) - 1;
  for (let at = 0; at < out.length; at += 1) {
    const low = left - longest;
    const byte = low >>> 3;
    const number =
      low >= 0
        ? (bytes[byte] | (bytes[byte + 1] << 8) | (bytes[byte + 2] << 16)) >>> (low & 7)
        : (bytes[0] | (bytes[1] << 8)) << -low;
    const row = rows[number & mask];
    out[at] = row >>> 4;
    left -= row & 15;
    if (left < 0) {
      break;
    }
  }
  if (left !== 0) {
    throw damagedFrame("a stream of literals has another length");
  }
}
