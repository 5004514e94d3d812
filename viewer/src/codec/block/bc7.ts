// BC7: red, green, blue and alpha, 16 pixels in 16 bytes (formats/blocks.md 8). Codecs drop alpha, and so does this decoder.

import { anchorsOf, BlockBits, mix, subsetOf, takeWeights } from "./bptc.ts";

/** A row of the table of modes. */
interface Mode {
  subsets: number;
  partitionBits: number;
  rotationBits: number;
  selectionBits: number;
  colorBits: number;
  alphaBits: number;
  lowBits: "none" | "endpoint" | "subset";
  indexBits: number;
  /** 0: there are no second indices. */
  secondIndexBits: number;
}

const MODES: Mode[] = [
  mode([3, 4, 0, 0, 4, 0], "endpoint", [3, 0]),
  mode([2, 6, 0, 0, 6, 0], "subset", [3, 0]),
  mode([3, 6, 0, 0, 5, 0], "none", [2, 0]),
  mode([2, 6, 0, 0, 7, 0], "endpoint", [2, 0]),
  mode([1, 0, 2, 1, 5, 6], "none", [2, 3]),
  mode([1, 0, 2, 0, 7, 8], "none", [2, 2]),
  mode([1, 0, 0, 0, 7, 7], "endpoint", [4, 0]),
  mode([2, 6, 0, 0, 5, 5], "endpoint", [2, 0]),
];

function mode(counts: number[], lowBits: Mode["lowBits"], indices: number[]): Mode {
  const [subsets, partitionBits, rotationBits, selectionBits, colorBits, alphaBits] = counts;
  const [indexBits, secondIndexBits] = indices;
  return {
    subsets,
    partitionBits,
    rotationBits,
    selectionBits,
    colorBits,
    alphaBits,
    lowBits,
    indexBits,
    secondIndexBits,
  };
}

const ENDPOINTS = 6;
const bits = new BlockBits();
/** Of each channel, the values of all endpoints. */
const ends = new Uint8Array(4 * ENDPOINTS);
const low = new Uint8Array(ENDPOINTS);
const first = new Uint8Array(16);
const second = new Uint8Array(16);

/** Decodes the block of 16 bytes at byte `at` into red, green, blue of 16 pixels, row by row: 48 bytes. A block whose first byte is 0 is
 *  reserved, and black (formats/blocks.md 8). */
export function decodeBc7Block(bytes: Uint8Array, at: number, out: Uint8Array): void {
  if (bytes[at] === 0) {
    out.fill(0, 0, 48);
    return;
  }
  bits.load(bytes, at);
  const number = 31 - Math.clz32(bytes[at] & -bytes[at]);
  const mode = MODES[number];
  const { subsets } = mode;
  bits.take(number + 1);
  const partition = bits.take(mode.partitionBits);
  const rotation = bits.take(mode.rotationBits);
  const selection = bits.take(mode.selectionBits);
  takeEndpoints(mode);
  takeWeights(bits, mode.indexBits, anchorsOf(subsets, partition), first);
  if (mode.secondIndexBits > 0) {
    takeWeights(bits, mode.secondIndexBits, 1, second);
  }
  const ofColor = selection === 1 ? second : first;
  const ofAlpha = mode.secondIndexBits > 0 && selection === 0 ? second : first;
  for (let texel = 0; texel < 16; texel++) {
    const pair = 2 * subsetOf(subsets, partition, texel);
    for (let channel = 0; channel < 3; channel++) {
      // The channel that changes places with alpha shows what alpha is.
      const isAlpha = channel === rotation - 1;
      const from = (isAlpha ? 3 : channel) * ENDPOINTS + pair;
      out[3 * texel + channel] = mix(ends[from], ends[from + 1], (isAlpha ? ofAlpha : ofColor)[texel]);
    }
  }
}

/** Reads the endpoints of all subsets and brings them to 8 bits. */
function takeEndpoints(mode: Mode): void {
  const count = 2 * mode.subsets;
  for (let channel = 0; channel < 4; channel++) {
    for (let end = 0; end < count; end++) {
      ends[channel * ENDPOINTS + end] = bits.take(channel < 3 ? mode.colorBits : mode.alphaBits);
    }
  }
  for (let end = 0; mode.lowBits !== "none" && end < count; end++) {
    low[end] = mode.lowBits === "subset" && end % 2 === 1 ? low[end - 1] : bits.take(1);
  }
  for (let channel = 0; channel < 4; channel++) {
    const stored = channel < 3 ? mode.colorBits : mode.alphaBits;
    for (let end = 0; end < count; end++) {
      const at = channel * ENDPOINTS + end;
      const [value, width] = mode.lowBits === "none" ? [ends[at], stored] : [(ends[at] << 1) | low[end], stored + 1];
      ends[at] = stored === 0 ? 255 : (value << (8 - width)) | (value >> (2 * width - 8));
    }
  }
}
