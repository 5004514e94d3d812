// Decodes the functions of nodes into codes (formats/depth.md 7 and 8, formats/arithmetic.md 6). Numbers have 32 bits and wrap.

import { BACKGROUND_CODE } from "./domain.ts";
import { functionOf, sideOf } from "./nodes.ts";

/** Where the pixels of a node that lie in the unit go: row by row, from element `start` of a picture of `stride` columns. */
export interface Target {
  picture: Uint16Array;
  start: number;
  stride: number;
  width: number;
  height: number;
}

/** Decodes a node of `level` whose coefficients start at word `at`. `code` turns values with 14 fraction bits into codes. */
export function decodeNode(
  level: number,
  words: Uint32Array,
  at: number,
  code: (value: number) => number,
  target: Target,
): void {
  switch (functionOf(level, words, at)) {
    case "raw":
      decodeLeaf(words, at, target);
      break;
    case "biquadratic":
      decodeBiquadratic(words, at, code, target);
      break;
    case "platelet":
      decodePlatelet(level, words, at, code, target);
      break;
    case "bc4w":
      decodeBc4w(words, at, target);
      break;
  }
}

function decodeLeaf(words: Uint32Array, at: number, { picture, start, stride, width, height }: Target): void {
  for (let y = 0; y < height; y += 1) {
    for (let x = 0; x < width; x += 1) {
      picture[start + y * stride + x] = words[at + 2 * y + (x >> 1)] >>> (16 * (x & 1));
    }
  }
}

function decodeBiquadratic(words: Uint32Array, at: number, code: (value: number) => number, target: Target): void {
  const { picture, start, stride, width, height } = target;
  const [a0, a1, a2, a3, a4, a5] = [0, 1, 2, 3, 4, 5].map((number) => words[at + number] | 0);
  if ((a0 | a1 | a2 | a3 | a4) === 0) {
    const constant = code(a5);
    for (let y = 0; y < height; y += 1) {
      picture.fill(constant, start + y * stride, start + y * stride + width);
    }
    return;
  }
  for (let y = 0; y < height; y += 1) {
    const v = (a1 + ((Math.imul(a4, y) + 128) >> 8)) | 0;
    const first = (a5 + Math.imul(v, y)) | 0;
    let bend = (Math.imul(a2, y) + 128) | 0;
    const row = start + y * stride;
    for (let x = 0; x < width; x += 1) {
      const u = (a0 + (bend >> 8)) | 0;
      picture[row + x] = code((first + Math.imul(u, x)) | 0);
      bend = (bend + a3) | 0;
    }
  }
}

function decodePlatelet(
  level: number,
  words: Uint32Array,
  at: number,
  code: (value: number) => number,
  { picture, start, stride, width, height }: Target,
): void {
  const [a0, a1, a5, b0, b1, b5] = [0, 1, 2, 3, 4, 5].map((number) => words[at + number] | 0);
  const [x0, y0, x1, y1] = [0, 8, 16, 24].map((shift) => (words[at + 6] >>> shift) & 0xff);
  // Pixel centres are (2x + 1) / (2 side), points of the line x0 / 256: over a common denominator, below 2^24.
  const units = 2 * sideOf(level);
  const common = Math.min(units, 256);
  const ofPixels = 256 / common;
  const ofPoints = units / common;
  const across = -(y1 - y0) * 2 * ofPixels;
  const down = (x1 - x0) * 2 * ofPixels;
  const first = (x1 - x0) * (ofPixels - y0 * ofPoints) - (y1 - y0) * (ofPixels - x0 * ofPoints);
  for (let y = 0; y < height; y += 1) {
    let cross = first + down * y;
    let a = (a5 + Math.imul(a1, y)) | 0;
    let b = (b5 + Math.imul(b1, y)) | 0;
    const row = start + y * stride;
    for (let x = 0; x < width; x += 1) {
      picture[row + x] = code(cross > 0 ? b : a);
      cross += across;
      a = (a + a0) | 0;
      b = (b + b0) | 0;
    }
  }
}

const palettes = new Uint16Array(16);

/** Decodes a block of 8x8 codes whose 32 bytes are eight words from `at` on (depth.md 8). */
function decodeBc4w(words: Uint32Array, at: number, { picture, start, stride, width, height }: Target): void {
  const low = words[at + 6];
  const high = words[at + 7];
  fillPalette(low & 0x1fff, (low >>> 13) & 0x1fff, 0);
  fillPalette(((low >>> 26) | (high << 6)) & 0x1fff, (high >>> 7) & 0x1fff, 8);
  const [x0, y0, x1, y1] = [20, 23, 26, 29].map((shift) => (high >>> shift) & 7);
  for (let y = 0; y < height; y += 1) {
    // 24 bits of indices.
    const word = at + ((24 * y) >> 5);
    const shift = (24 * y) & 31;
    let indices = words[word] >>> shift;
    if (shift > 8) {
      indices |= words[word + 1] << (32 - shift);
    }
    let cross = (x1 - x0) * (y - y0) + (y1 - y0) * x0;
    const row = start + y * stride;
    for (let x = 0; x < width; x += 1) {
      picture[row + x] = palettes[((indices >>> (3 * x)) & 7) | (cross > 0 ? 8 : 0)];
      cross -= y1 - y0;
    }
  }
}

/** The codes of a pair of endpoints of 13 bits. */
function fillPalette(e0: number, e1: number, to: number): void {
  const d0 = (e0 << 3) | (e0 >> 10);
  const d1 = (e1 << 3) | (e1 >> 10);
  palettes[to] = d0;
  palettes[to + 1] = d1;
  if (e0 > e1) {
    for (let i = 2; i < 8; i += 1) {
      palettes[to + i] = Math.floor(((8 - i) * d0 + (i - 1) * d1 + 3) / 7);
    }
    return;
  }
  for (let i = 2; i < 6; i += 1) {
    palettes[to + i] = Math.floor(((6 - i) * d0 + (i - 1) * d1 + 2) / 5);
  }
  palettes[to + 6] = 0;
  palettes[to + 7] = BACKGROUND_CODE;
}
