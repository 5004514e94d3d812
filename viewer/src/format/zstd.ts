// Decompresses chunks that are Zstandard frames (formats/container.md 6.2; RFC 8878, 3.1.1). It is our own since the decoders in JavaScript
// that there are take frames that the format refuses: of 1,500 changed frames fzstd took 254 that zstd does not.

import {
  BackwardBits,
  damagedFrame,
  type FseLimits,
  fseOfOne,
  type FseTable,
  fseTable,
  huffmanStream,
  type HuffmanTable,
  readDistribution,
  readHuffman,
} from "./zstd_tables.ts";

const MAGIC = 0xfd2fb528;
const MAX_WINDOW = 1 << 24;
const MAX_BLOCK = 1 << 17;
/** Offsets of codes above it reach beyond any window. */
const MAX_OFFSET_CODE = 24;
const MIN_OF_FOUR_STREAMS = 6;

/** Least value and number of extra bits of each code. */
interface LengthCodes {
  bases: Uint32Array;
  bits: Uint8Array;
}

function lengthCodes(first: number, bits: number[]): LengthCodes {
  let next = first;
  const bases = bits.map((count) => {
    const base = next;
    next += 2 ** count;
    return base;
  });
  return { bases: Uint32Array.from(bases), bits: Uint8Array.from(bits) };
}

/** RFC 8878, 3.1.1.3.2.1.1. */
const LITERAL_LENGTHS = lengthCodes(0, [
  ...Array<number>(16).fill(0),
  ...[1, 1, 1, 1, 2, 2, 3, 3, 4, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16],
]);
const MATCH_LENGTHS = lengthCodes(3, [
  ...Array<number>(32).fill(0),
  ...[1, 1, 1, 1, 2, 2, 3, 3, 4, 4, 5, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16],
]);

// Of literal lengths, offsets and match lengths, in this order.
const LIMITS: readonly FseLimits[] = [
  [9, 36],
  [8, 32],
  [9, 53],
];
/** RFC 8878, 3.1.1.3.2.2. */
const DEFAULTS: readonly FseTable[] = [
  {
    accuracy: 6,
    counts: [4, 3, ...ones(2, 11), ...ones(1, 3), ...ones(2, 9), 3, 2, ...ones(1, 5), ...ones(-1, 4)],
  },
  { accuracy: 5, counts: [...ones(1, 6), 2, 2, 2, ...ones(1, 15), ...ones(-1, 5)] },
  { accuracy: 6, counts: [1, 4, 3, ...ones(2, 6), ...ones(1, 37), ...ones(-1, 7)] },
].map(fseTable);

function ones(value: number, count: number): number[] {
  return Array<number>(count).fill(value);
}

/** Decompresses a frame that means exactly `rawBytes` bytes, which are reserved at once; any other is a FormatError. */
export function decompressZstd(stored: Uint8Array, rawBytes: number): Uint8Array {
  return new Frame(stored, rawBytes).decode();
}

class Frame {
  private readonly out: Uint8Array;
  private length = 0;
  private at = 0;
  private window = 0;
  // What blocks leave to those that follow.
  private huffman: HuffmanTable | undefined;
  private readonly tables: (FseTable | undefined)[] = [undefined, undefined, undefined];
  private repeats: [number, number, number] = [1, 4, 8];

  constructor(
    private readonly stored: Uint8Array,
    private readonly rawBytes: number,
  ) {
    this.readHeader();
    this.out = new Uint8Array(rawBytes);
  }

  decode(): Uint8Array {
    const mostBlock = Math.min(MAX_BLOCK, this.window);
    for (let isLast = false; !isLast;) {
      const head = this.number(3);
      isLast = (head & 1) === 1;
      const [kind, size] = [(head >>> 1) & 3, head >>> 3];
      if (kind === 3 || size > mostBlock) {
        throw damagedFrame("a block is illegal");
      }
      const end = Math.min(this.rawBytes, this.length + mostBlock);
      if (kind === 0) {
        this.append(this.take(size), end);
      } else if (kind === 1) {
        this.append(new Uint8Array(size).fill(this.number(1)), end);
      } else {
        this.block(this.take(size), end);
      }
    }
    if (this.at !== this.stored.length) {
      throw damagedFrame(`${this.stored.length - this.at} bytes follow its end`);
    }
    if (this.length !== this.rawBytes) {
      throw damagedFrame(`it means ${this.length} bytes, the chunk table says ${this.rawBytes}`);
    }
    return this.out;
  }

  private readHeader(): void {
    if (this.number(4) !== MAGIC) {
      throw damagedFrame("its magic number is other");
    }
    const descriptor = this.number(1);
    if ((descriptor & 0x1f) !== 0) {
      throw damagedFrame("it has a dictionary, a checksum or reserved bits");
    }
    const isSingle = (descriptor & 0x20) !== 0;
    this.window = this.rawBytes;
    if (!isSingle) {
      const byte = this.number(1);
      const base = 2 ** (10 + (byte >>> 3));
      this.window = base + (base / 8) * (byte & 7);
    }
    if (this.window > MAX_WINDOW) {
      throw damagedFrame(`its window has ${this.window} bytes, at most ${MAX_WINDOW} are legal`);
    }
    const width = descriptor >>> 6;
    if (width === 0 && !isSingle) {
      throw damagedFrame("it lacks its content size");
    }
    const content = this.number(1 << width) + (width === 1 ? 256 : 0);
    if (content !== this.rawBytes) {
      throw damagedFrame(`it means ${content} bytes, the chunk table says ${this.rawBytes}`);
    }
  }

  private take(count: number): Uint8Array {
    if (count > this.stored.length - this.at) {
      throw damagedFrame("it ends early");
    }
    this.at += count;
    return this.stored.subarray(this.at - count, this.at);
  }

  private number(bytes: number): number {
    return this.take(bytes).reduceRight((value, byte) => value * 256 + byte, 0);
  }

  /** Writes bytes, which end at `end` at the latest. */
  private append(bytes: Uint8Array, end: number): void {
    if (bytes.length > end - this.length) {
      throw damagedFrame("it means more bytes than it may");
    }
    this.out.set(bytes, this.length);
    this.length += bytes.length;
  }

  private block(bytes: Uint8Array, end: number): void {
    const [literals, used] = this.literals(bytes);
    this.sequences(bytes.subarray(used), literals, end);
  }

  /** The literals of a block, and the bytes that they take (RFC 8878, 3.1.1.3.1). */
  private literals(bytes: Uint8Array): [Uint8Array, number] {
    const early = () => damagedFrame("literals end early");
    if (bytes.length === 0) {
      throw early();
    }
    const [kind, form] = [bytes[0] & 3, (bytes[0] >>> 2) & 3];
    const head = kind < 2 ? [1, 2, 1, 3][form] : [3, 3, 4, 5][form];
    if (head > bytes.length) {
      throw early();
    }
    const sizes = bytes.subarray(0, head).reduceRight((value, byte) => value * 256 + byte, 0);
    if (kind < 2) {
      const count = Math.floor(sizes / (form % 2 === 0 ? 8 : 16));
      const size = kind === 0 ? count : 1;
      if (count > MAX_BLOCK || head + size > bytes.length) {
        throw early();
      }
      const found = bytes.subarray(head, head + size);
      return [kind === 0 ? found : new Uint8Array(count).fill(found[0]), head + size];
    }
    const width = 2 ** [10, 10, 14, 18][form];
    const count = Math.floor(sizes / 16) % width;
    const size = Math.floor(sizes / 16 / width);
    if (count > MAX_BLOCK || head + size > bytes.length) {
      throw early();
    }
    let body = bytes.subarray(head, head + size);
    if (kind === 2) {
      const [huffman, used] = readHuffman(body);
      this.huffman = huffman;
      body = body.subarray(used);
    }
    if (!this.huffman) {
      throw damagedFrame("a Huffman table is missing");
    }
    if (count < (form === 0 ? 1 : MIN_OF_FOUR_STREAMS)) {
      throw damagedFrame(`${form === 0 ? "a Huffman stream" : "four streams"} of ${count} literals`);
    }
    const out = new Uint8Array(count);
    if (form === 0) {
      huffmanStream(body, this.huffman, out);
    } else {
      fourStreams(body, this.huffman, out);
    }
    return [out, head + size];
  }

  /** Copies literals and matches as the sequences of a block say (RFC 8878, 3.1.1.3.2). */
  private sequences(bytes: Uint8Array, literals: Uint8Array, end: number): void {
    const early = () => damagedFrame("sequences end early");
    const head = bytes.length === 0 ? 0 : bytes[0] < 128 ? 1 : bytes[0] < 255 ? 2 : 3;
    if (head === 0 || head > bytes.length) {
      throw early();
    }
    const count = [bytes[0], ((bytes[0] - 128) << 8) + bytes[1], bytes[1] + (bytes[2] << 8) + 0x7f00][head - 1];
    if (count === 0) {
      if (head !== bytes.length) {
        throw damagedFrame("bytes follow the sequences");
      }
      this.append(literals, end);
      return;
    }
    if (head === bytes.length || (bytes[head] & 3) !== 0) {
      throw damagedFrame("the modes of sequences are illegal");
    }
    const used = this.readTables(bytes, head);
    const place = this.copySequences(new BackwardBits(bytes.subarray(used)), [count, end], literals);
    this.append(literals.subarray(place), end);
  }

  /** Reads the tables of sequences from the modes at `at` on; answers where they end. */
  private readTables(bytes: Uint8Array, at: number): number {
    const modes = bytes[at];
    let used = at + 1;
    LIMITS.forEach((limits, which) => {
      const mode = (modes >>> (6 - 2 * which)) & 3;
      if (mode === 0) {
        this.tables[which] = DEFAULTS[which];
      } else if (mode === 1) {
        if (used >= bytes.length || bytes[used] >= limits[1]) {
          throw damagedFrame("the code of a table is illegal");
        }
        this.tables[which] = fseOfOne(bytes[used]);
        used += 1;
      } else if (mode === 2) {
        const [distribution, size] = readDistribution(bytes.subarray(used), limits);
        this.tables[which] = fseTable(distribution);
        used += size;
      }
    });
    return used;
  }

  /** Copies `count` sequences, which end at `end` at the latest; answers the number of literals that they take. */
  private copySequences(bits: BackwardBits, [count, end]: [number, number], literals: Uint8Array): number {
    const [lengths, offsets, matches] = this.tables;
    if (!lengths || !offsets || !matches) {
      throw damagedFrame("a table of sequences is missing");
    }
    const { out } = this;
    let [length, offset, match] = [lengths, offsets, matches].map((table) => bits.take(table.accuracy));
    let place = 0;
    for (let left = count; left > 0; left -= 1) {
      const offsetCode = offsets.symbols[offset];
      if (offsetCode > MAX_OFFSET_CODE) {
        throw damagedFrame("a match reaches too far back");
      }
      const value = (1 << offsetCode) + bits.take(offsetCode);
      const matchCode = matches.symbols[match];
      const matchLength = MATCH_LENGTHS.bases[matchCode] + bits.take(MATCH_LENGTHS.bits[matchCode]);
      const lengthCode = lengths.symbols[length];
      const literalLength = LITERAL_LENGTHS.bases[lengthCode] + bits.take(LITERAL_LENGTHS.bits[lengthCode]);
      if (left > 1) {
        length = lengths.bases[length] + bits.take(lengths.bits[length]);
        match = matches.bases[match] + bits.take(matches.bits[match]);
        offset = offsets.bases[offset] + bits.take(offsets.bits[offset]);
      }
      if (bits.left < 0 || literalLength > literals.length - place) {
        throw damagedFrame("sequences end early");
      }
      const distance = this.distance(value, literalLength);
      const start = this.length + literalLength;
      if (start + matchLength > end) {
        throw damagedFrame("it means more bytes than it may");
      }
      if (distance > Math.min(start, this.window)) {
        throw damagedFrame("a match reaches too far back");
      }
      for (let to = this.length; to < start; to += 1, place += 1) {
        out[to] = literals[place];
      }
      this.length = start + matchLength;
      for (let to = start; to < this.length; to += 1) {
        out[to] = out[to - distance];
      }
    }
    if (bits.left !== 0) {
      throw damagedFrame("sequences have another length");
    }
    return place;
  }

  /** Bytes between a match and its source (RFC 8878, 3.1.1.5). */
  private distance(value: number, literalLength: number): number {
    const [first, second, third] = this.repeats;
    if (value > 3) {
      this.repeats = [value - 3, first, second];
      return value - 3;
    }
    const which = value - 1 + (literalLength === 0 ? 1 : 0);
    const chosen = [first, second, third, first - 1][which];
    if (chosen === 0) {
      throw damagedFrame("a match is of itself");
    }
    if (which > 0) {
      this.repeats = [chosen, first, which === 1 ? third : second];
    }
    return chosen;
  }
}

/** Decodes literals in four streams, which a table of sizes precedes. */
function fourStreams(body: Uint8Array, huffman: HuffmanTable, out: Uint8Array): void {
  const part = (out.length + 3) >>> 2;
  const ends = [0, 2, 4].map((at) => body[at] | (body[at + 1] << 8));
  const sizes = ends.reduce((sum, size) => sum + size, 6);
  if (body.length < 6 || sizes > body.length) {
    throw damagedFrame("literals end early");
  }
  let at = 6;
  [...ends, body.length - sizes].forEach((size, stream) => {
    const last = stream < 3 ? (stream + 1) * part : out.length;
    huffmanStream(body.subarray(at, at + size), huffman, out.subarray(stream * part, last));
    at += size;
  });
}
