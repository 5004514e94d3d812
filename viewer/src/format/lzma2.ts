// Decompresses chunks that are raw LZMA2 streams (formats/container.md 6.1).

import { FormatError } from "./types.ts";

const SECTION = "container.md 6.1";
const MIN_DICTIONARY = 1 << 12;
const MAX_DICTIONARY = 1 << 24;
/** What a stream may become before memory grows with it. */
const FIRST_OUTPUT = 1 << 16;

/** States below this one follow a literal. */
const LITERAL_STATES = 7;
const STATES = 12;
const HALF = 1 << 10;
/** Distances of slots from this one on have bits of equal probability. */
const FIRST_DIRECT_SLOT = 14;
const ALIGN_BITS = 4;
const MIN_MATCH = 2;

// Places of probabilities, before those of literals.
const IS_MATCH = 0;
const IS_REPEAT = IS_MATCH + (STATES << 4);
const IS_REPEAT_0 = IS_REPEAT + STATES;
const IS_REPEAT_1 = IS_REPEAT_0 + STATES;
const IS_REPEAT_2 = IS_REPEAT_1 + STATES;
const IS_LONG_REPEAT_0 = IS_REPEAT_2 + STATES;
const SLOT = IS_LONG_REPEAT_0 + (STATES << 4);
const SPECIAL = SLOT + (4 << 6);
const ALIGN = SPECIAL + 128;
const MATCH_LENGTH = ALIGN + (1 << ALIGN_BITS);
// Within the probabilities of a length: two choices, trees of 3 bits for each position, and one of 8 bits.
const LOW = 2;
const MIDDLE = LOW + (16 << 3);
const HIGH = MIDDLE + (16 << 3);
const REPEAT_LENGTH = MATCH_LENGTH + HIGH + 256;
const LITERAL = REPEAT_LENGTH + HIGH + 256;
const MAX_LITERAL_CONTEXTS = 1 << 4;

/** Dictionary size of a payload of `rawBytes`: the power of two that covers it, 4 KiB to 16 MiB. */
function dictionaryBytes(rawBytes: number): number {
  let size = MIN_DICTIONARY;
  while (size < rawBytes && size < MAX_DICTIONARY) {
    size *= 2;
  }
  return size;
}

/** Decompresses a stream that means exactly `rawBytes` bytes; any other is a FormatError. Memory grows with the output. */
export function decompressLzma2(stored: Uint8Array, rawBytes: number): Uint8Array {
  return new Decoder(stored, rawBytes).decode();
}

function damaged(why: string): FormatError {
  return new FormatError(`The LZMA2 stream of a chunk is damaged: ${why} (${SECTION}).`);
}

class Decoder {
  private output: Uint8Array;
  private length = 0;
  /** Where the dictionary was emptied last. */
  private origin = 0;
  private readonly dictionary: number;
  private at = 0;
  // The range coder.
  private range = 0;
  private code = 0;
  private end = 0;
  // The state between symbols.
  private readonly probabilities = new Uint16Array(LITERAL + 0x300 * MAX_LITERAL_CONTEXTS);
  private state = 0;
  private repeats: [number, number, number, number] = [0, 0, 0, 0];
  private literalContextBits = 0;
  private literalPositionMask = 0;
  private positionMask = 0;

  constructor(
    private readonly stored: Uint8Array,
    private readonly rawBytes: number,
  ) {
    this.output = new Uint8Array(Math.min(rawBytes, FIRST_OUTPUT));
    this.dictionary = dictionaryBytes(rawBytes);
  }

  decode(): Uint8Array {
    let needsDictionary = true;
    let needsProperties = true;
    for (let control = this.byte(); control !== 0; control = this.byte()) {
      if (control >= 0xe0 || control === 1) {
        needsDictionary = false;
        needsProperties = true;
        this.origin = this.length;
      } else if (needsDictionary) {
        throw damaged("it does not start with an empty dictionary");
      }
      if (control < 0x80) {
        this.copyStored(control);
        continue;
      }
      const count = ((control & 0x1f) << 16) + this.bigEndian() + 1;
      const packed = this.bigEndian() + 1;
      if (control >= 0xc0) {
        this.setProperties(this.byte());
        needsProperties = false;
      } else if (needsProperties) {
        throw damaged("its properties are missing");
      }
      if (control >= 0xa0) {
        this.reset();
      }
      this.decodeChunk(count, packed);
    }
    if (this.length !== this.rawBytes) {
      throw damaged(`it means ${this.length} bytes, the chunk table says ${this.rawBytes}`);
    }
    if (this.at !== this.stored.length) {
      throw damaged(`${this.stored.length - this.at} bytes follow its end`);
    }
    return this.output.length === this.length ? this.output : this.output.slice(0, this.length);
  }

  private byte(): number {
    if (this.at >= this.stored.length) {
      throw damaged("it ends early");
    }
    this.at += 1;
    return this.stored[this.at - 1];
  }

  private bigEndian(): number {
    const high = this.byte();
    return (high << 8) | this.byte();
  }

  /** Makes room for `count` more bytes. */
  private grow(count: number): void {
    const needed = this.length + count;
    if (needed > this.rawBytes) {
      throw damaged(`it means more than the ${this.rawBytes} bytes that the chunk table says`);
    }
    if (needed > this.output.length) {
      const larger = new Uint8Array(Math.min(this.rawBytes, Math.max(needed, 2 * this.output.length)));
      larger.set(this.output.subarray(0, this.length));
      this.output = larger;
    }
  }

  private copyStored(control: number): void {
    if (control > 2) {
      throw damaged(`it has the control byte ${control}`);
    }
    const count = this.bigEndian() + 1;
    if (count > this.stored.length - this.at) {
      throw damaged("it ends early");
    }
    this.grow(count);
    this.output.set(this.stored.subarray(this.at, this.at + count), this.length);
    this.at += count;
    this.length += count;
  }

  private setProperties(byte: number): void {
    const literalContextBits = byte % 9;
    const rest = Math.floor(byte / 9);
    const literalPositionBits = rest % 5;
    const positionBits = Math.floor(rest / 5);
    if (positionBits > 4 || literalContextBits + literalPositionBits > 4) {
      throw damaged(`it has the properties ${byte}`);
    }
    this.literalContextBits = literalContextBits;
    this.literalPositionMask = (1 << literalPositionBits) - 1;
    this.positionMask = (1 << positionBits) - 1;
  }

  private reset(): void {
    this.probabilities.fill(HALF);
    this.state = 0;
    this.repeats = [0, 0, 0, 0];
  }

  /** Decodes `count` bytes from `packed` ones. */
  private decodeChunk(count: number, packed: number): void {
    if (packed < 5 || packed > this.stored.length - this.at) {
      throw damaged("it ends early");
    }
    this.grow(count);
    this.end = this.at + packed;
    if (this.byte() !== 0) {
      throw damaged("a chunk of it does not start with 0");
    }
    this.range = 0xffffffff;
    this.code = ((this.bigEndian() << 16) | this.bigEndian()) >>> 0;
    const last = this.length + count;
    while (this.length < last) {
      this.symbol(last);
    }
    this.normalize();
    if (this.at !== this.end || this.code !== 0) {
      throw damaged("a chunk of it has another length");
    }
  }

  private normalize(): void {
    if (this.range < 0x1000000) {
      if (this.at >= this.end) {
        throw damaged("a chunk of it ends early");
      }
      this.range = (this.range << 8) >>> 0;
      this.code = ((this.code << 8) | this.stored[this.at]) >>> 0;
      this.at += 1;
    }
  }

  /** A bit with the probability at a place, which learns. */
  private bit(place: number): number {
    this.normalize();
    const probability = this.probabilities[place];
    const bound = (this.range >>> 11) * probability;
    if (this.code < bound) {
      this.range = bound;
      this.probabilities[place] = probability + ((2 * HALF - probability) >>> 5);
      return 0;
    }
    this.range -= bound;
    this.code -= bound;
    this.probabilities[place] = probability - (probability >>> 5);
    return 1;
  }

  /** So many bits of equal probability, the highest first. */
  private directBits(count: number): number {
    let value = 0;
    for (let bit = 0; bit < count; bit += 1) {
      this.normalize();
      this.range >>>= 1;
      const one = this.code >= this.range ? 1 : 0;
      if (one) {
        this.code -= this.range;
      }
      value = value * 2 + one;
    }
    return value;
  }

  /** A number of `bits` bits by a tree of probabilities, the highest bit first. */
  private tree(place: number, bits: number): number {
    let node = 1;
    for (let bit = 0; bit < bits; bit += 1) {
      node = (node << 1) | this.bit(place + node);
    }
    return node - (1 << bits);
  }

  /** The same with the lowest bit first. */
  private reverseTree(place: number, bits: number): number {
    let node = 1;
    let value = 0;
    for (let bit = 0; bit < bits; bit += 1) {
      const found = this.bit(place + node);
      node = (node << 1) | found;
      value |= found << bit;
    }
    return value;
  }

  /** A literal or a match, which ends at `last` at the latest. */
  private symbol(last: number): void {
    const position = (this.length - this.origin) & this.positionMask;
    const { state, repeats } = this;
    if (this.bit(IS_MATCH + (state << 4) + position) === 0) {
      this.literal();
      return;
    }
    if (this.bit(IS_REPEAT + state) === 0) {
      const length = this.matchLength(MATCH_LENGTH, position);
      this.repeats = [this.distance(length), repeats[0], repeats[1], repeats[2]];
      this.state = state < LITERAL_STATES ? 7 : 10;
      this.copy(length, last);
      return;
    }
    if (this.bit(IS_REPEAT_0 + state) === 0) {
      if (this.bit(IS_LONG_REPEAT_0 + (state << 4) + position) === 0) {
        this.state = state < LITERAL_STATES ? 9 : 11;
        this.copy(1, last);
        return;
      }
    } else if (this.bit(IS_REPEAT_1 + state) === 0) {
      this.repeats = [repeats[1], repeats[0], repeats[2], repeats[3]];
    } else if (this.bit(IS_REPEAT_2 + state) === 0) {
      this.repeats = [repeats[2], repeats[0], repeats[1], repeats[3]];
    } else {
      this.repeats = [repeats[3], repeats[0], repeats[1], repeats[2]];
    }
    this.state = state < LITERAL_STATES ? 8 : 11;
    this.copy(this.matchLength(REPEAT_LENGTH, position), last);
  }

  private literal(): void {
    const position = this.length - this.origin;
    const before = position > 0 ? this.output[this.length - 1] : 0;
    const high = before >>> (8 - this.literalContextBits);
    const context = ((position & this.literalPositionMask) << this.literalContextBits) + high;
    const place = LITERAL + 0x300 * context;
    let node = 1;
    if (this.state >= LITERAL_STATES) {
      // Where a match ended, the byte that would have followed is likely not to.
      let match = this.output[this.source()];
      while (node < 0x100) {
        const expected = (match >>> 7) & 1;
        match <<= 1;
        const found = this.bit(place + ((1 + expected) << 8) + node);
        node = (node << 1) | found;
        if (found !== expected) {
          break;
        }
      }
    }
    while (node < 0x100) {
      node = (node << 1) | this.bit(place + node);
    }
    this.output[this.length] = node & 0xff;
    this.length += 1;
    this.state = this.state < 4 ? 0 : this.state < 10 ? this.state - 3 : this.state - 6;
  }

  private matchLength(place: number, position: number): number {
    if (this.bit(place) === 0) {
      return MIN_MATCH + this.tree(place + LOW + (position << 3), 3);
    }
    if (this.bit(place + 1) === 0) {
      return MIN_MATCH + 8 + this.tree(place + MIDDLE + (position << 3), 3);
    }
    return MIN_MATCH + 16 + this.tree(place + HIGH, 8);
  }

  /** Bytes between a match and its source, less 1. */
  private distance(length: number): number {
    const slot = this.tree(SLOT + (Math.min(length - MIN_MATCH, 3) << 6), 6);
    if (slot < 4) {
      return slot;
    }
    const bits = (slot >>> 1) - 1;
    const base = (2 | (slot & 1)) * 2 ** bits;
    if (slot < FIRST_DIRECT_SLOT) {
      return base + this.reverseTree(SPECIAL + base - slot, bits);
    }
    const high = this.directBits(bits - ALIGN_BITS) * 2 ** ALIGN_BITS;
    return base + high + this.reverseTree(ALIGN, ALIGN_BITS);
  }

  /** Where the bytes of the last distance start. */
  private source(): number {
    const distance = this.repeats[0] + 1;
    if (distance > this.length - this.origin || distance > this.dictionary) {
      throw damaged("a match reaches too far back");
    }
    return this.length - distance;
  }

  private copy(length: number, last: number): void {
    const source = this.source();
    const { output } = this;
    const end = this.length + length;
    if (end > last) {
      throw damaged("a match is too long");
    }
    for (let from = source, to = this.length; to < end; from += 1, to += 1) {
      output[to] = output[from];
    }
    this.length = end;
  }
}
