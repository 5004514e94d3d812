// The storage form of nodes: only the bits that say something (formats/depth.md 9 and 11).

import { Fields } from "../fields.ts";
import { BACKGROUND_CODE } from "./domain.ts";
import { forChildren, functionOf, type Grid, levelOf, MARKER, NODE_WORDS, type Place, placeOf } from "./nodes.ts";

const HEAD_BIQUADRATIC = 0;
const HEAD_PLATELET = 1;
const HEAD_BC4W = 2;
/** Numbers of a biquadratic function by the order in its head. */
const NUMBERS_OF_ORDER = [1, 3, 6];
/** Of the head of a leaf: bits of a value, and whether the largest value is background. */
const RAW_BITS = 0x1f;
const RAW_BACKGROUND = 0x20;

/** Nodes in the order of the walk, with eight words of coefficients each (depth.md 7). */
export interface Nodes {
  places: readonly Place[];
  words: Uint32Array;
}

/** Bits of bytes, the lowest first. */
class Bits {
  readonly #fields: Fields;
  #current = 0;
  #left = 0;

  constructor(fields: Fields) {
    this.#fields = fields;
  }

  take(): boolean {
    if (this.#left === 0) {
      this.#current = this.#fields.u8();
      this.#left = 8;
    }
    const bit = this.#current & 1;
    this.#current >>= 1;
    this.#left -= 1;
    return bit === 1;
  }

  /** Ends at a byte's end; the bits that are left must be 0. */
  finish(): void {
    if (this.#current !== 0) {
      throw this.#fields.error("The bits behind a walk are not 0");
    }
  }
}

/** Reads the nodes of a record of packed nodes behind its coverage (depth.md 9). */
export function readNodes(grid: Grid, isPartial: boolean, fields: Fields): Nodes {
  const bits = new Bits(fields);
  const places: Place[] = [];
  const visit = (place: Place): void => {
    if (!grid.has(place) || (isPartial && !bits.take())) {
      return;
    }
    if (levelOf(place) === 0 || bits.take()) {
      places.push(place);
    } else {
      forChildren(place, visit);
    }
  };
  visit(placeOf(grid.rootLevel, 0, 0));
  bits.finish();
  return readFunctions(places, fields);
}

/** Reads a record of the intermediate form: its leaves, and the functions of coarser places (depth.md 11). */
export function readTreeRecord(grid: Grid, fields: Fields): { leaves: Nodes; coarse: Nodes } {
  const bits = new Bits(fields);
  const leafPlaces: Place[] = [];
  const coarsePlaces: Place[] = [];
  const visit = (place: Place): void => {
    if (!grid.has(place) || !bits.take()) {
      return;
    }
    if (levelOf(place) === 0) {
      leafPlaces.push(place);
      return;
    }
    if (bits.take()) {
      coarsePlaces.push(place);
    }
    forChildren(place, visit);
  };
  visit(placeOf(grid.rootLevel, 0, 0));
  bits.finish();
  const leaves = readFunctions(leafPlaces, fields);
  const coarse = readFunctions(coarsePlaces, fields);
  fields.skip(2 * coarsePlaces.length);
  return { leaves, coarse };
}

/** Reads heads, numbers, lines, blocks and leaves, each in the order of the places. */
function readFunctions(places: readonly Place[], fields: Fields): Nodes {
  const coarse = places.reduce((count, place) => count + (levelOf(place) > 0 ? 1 : 0), 0);
  // Of a coarse node at least its head follows, of a leaf at least three bytes.
  if (coarse + 3 * (places.length - coarse) > fields.remaining) {
    throw fields.error(`${places.length} nodes do not fit`);
  }
  const words = new Uint32Array(NODE_WORDS * places.length);
  let head = fields.skip(coarse);
  places.forEach((place, node) => {
    if (levelOf(place) > 0) {
      readNumbers(fields.bytes[head], levelOf(place), words.subarray(NODE_WORDS * node), fields);
      head += 1;
    }
  });
  const forEach = (wanted: string, read: (at: number) => void): void => {
    places.forEach((place, node) => {
      if (functionOf(levelOf(place), words, NODE_WORDS * node) === wanted) {
        read(NODE_WORDS * node);
      }
    });
  };
  forEach("platelet", (at) => {
    words[at + 6] = fields.u32();
    if (words[at + 6] === MARKER) {
      throw fields.error("A platelet has a line that is none");
    }
  });
  forEach("bc4w", (at) => {
    for (let word = 0; word < NODE_WORDS; word += 1) {
      words[at + word] = fields.u32();
    }
    if (words[at + 7] === MARKER) {
      throw fields.error("A BC4w block ends like another function");
    }
  });
  forEach("raw", (at) => {
    readLeaf(fields, words, at);
  });
  return { places, words };
}

/** Numbers and markers of a node. A BC4w block stays zero, which no marker is, and so does a platelet's line. */
function readNumbers(head: number, level: number, words: Uint32Array, fields: Fields): void {
  const kind = head & 3;
  const precision = (head >> 2) & 0xf;
  const order = head >> 6;
  if (kind === HEAD_BIQUADRATIC && order < NUMBERS_OF_ORDER.length) {
    for (let at = 0; at < NUMBERS_OF_ORDER[order]; at += 1) {
      // a5 comes first.
      words[(at + 5) % 6] = readNumber(fields, shiftOf(at, precision, level));
    }
    words[6] = MARKER;
    words[7] = MARKER;
  } else if (kind === HEAD_PLATELET) {
    for (let side = 0; side < 2; side += 1) {
      const count = ((order >> side) & 1) === 1 ? 3 : 1;
      for (let at = 0; at < count; at += 1) {
        words[3 * side + ((at + 2) % 3)] = readNumber(fields, shiftOf(at, precision, level));
      }
    }
    words[7] = MARKER;
  } else if (kind !== HEAD_BC4W || order !== 0 || level !== 1 || precision !== 0) {
    throw fields.error(`A node of level ${level} has head ${head}, which is illegal`);
  }
}

/** Low bits that are not stored of a number: the constant, two linear ones, three quadratic ones. */
function shiftOf(at: number, precision: number, level: number): number {
  if (precision === 0) {
    return 0;
  }
  if (at === 0) {
    return precision + 5;
  }
  return Math.max(0, at < 3 ? precision + 6 - (level + 2) : precision + 15 - 2 * (level + 2));
}

function readNumber(fields: Fields, shift: number): number {
  let zigzag = 0;
  for (let place = 0; place < 5; place += 1) {
    const byte = fields.u8();
    const bits = byte & 0x7f;
    if (place === 4 && bits > 0xf) {
      throw fields.error("A coefficient has more than 32 bits");
    }
    zigzag |= bits << (7 * place);
    if (byte < 0x80) {
      const value = (zigzag >>> 1) ^ -(zigzag & 1);
      const number = value << shift;
      if (number >> shift !== value) {
        throw fields.error(`A coefficient of ${value} times 2^${shift} does not fit 32 bits`);
      }
      return number;
    }
  }
  throw fields.error("A coefficient has more than five bytes");
}

/** 16 codes of a leaf, two in a word. */
function readLeaf(fields: Fields, words: Uint32Array, to: number): void {
  const head = fields.u8();
  const bits = head & RAW_BITS;
  const hasBackground = (head & RAW_BACKGROUND) !== 0;
  if (bits > 16 || head > (RAW_BITS | RAW_BACKGROUND) || (hasBackground && (bits === 0 || bits === 16))) {
    throw fields.error(`A leaf has head ${head}, which is illegal`);
  }
  if (bits === 16) {
    for (let word = 0; word < NODE_WORDS; word += 1) {
      words[to + word] = fields.u32();
    }
    return;
  }
  const least = fields.u16();
  let at = fields.skip(2 * bits);
  const mask = (1 << bits) - 1;
  let held = 0;
  let heldBits = 0;
  for (let pixel = 0; pixel < 16; pixel += 1) {
    while (heldBits < bits) {
      held |= fields.bytes[at] << heldBits;
      at += 1;
      heldBits += 8;
    }
    const value = held & mask;
    held >>>= bits;
    heldBits -= bits;
    const code = hasBackground && value === mask ? BACKGROUND_CODE : least + value;
    if (code > 0xffff) {
      throw fields.error("A code of a leaf is above 65535");
    }
    words[to + (pixel >> 1)] |= code << (16 * (pixel & 1));
  }
}
