// Rectangles of pixels: as values, or cut into block tiles of 16x16 pixels, each in blocks of a texture format or as values
// (formats/depth.md 14).

import type { Rect } from "../../format/types.ts";
import type { Fields } from "../fields.ts";
import type { Pixels } from "../types.ts";
import type { Texel } from "./texel.ts";

const SIDE = 4;
const TILE_SIDE = 16;

/** How pixels of rectangles are stored. */
export interface Layout {
  texel: Texel;
  /** In block tiles behind a map, else as values. */
  inBlocks: boolean;
}

/** A part of a rectangle: its place in the unit, and the bytes that it starts at. */
export interface Part {
  rect: Rect;
  inBlocks: boolean;
  at: number;
}

/** Reads the bytes of a rectangle. */
export function takeRectangle({ texel, inBlocks }: Layout, fields: Fields, width: number, height: number): void {
  if (!inBlocks) {
    fields.skip(width * height * texel.bytes);
    return;
  }
  const count = Math.ceil(width / TILE_SIDE) * Math.ceil(height / TILE_SIDE);
  const map = fields.skip(Math.ceil(count / 8));
  if (count % 8 !== 0 && fields.bytes[fields.at - 1] >> (count % 8) !== 0) {
    throw fields.error("Spare bits of a map of block tiles are not 0");
  }
  let bytes = 0;
  for (const { rect, inBlocks } of blockTiles(texel, fields.bytes, map, [0, 0, width, height])) {
    bytes += bytesOf(texel, rect, inBlocks);
  }
  fields.skip(bytes);
}

/** The parts of a rectangle of the unit that is stored from byte `at` on, in the order of the format. */
export function partsOf({ texel, inBlocks }: Layout, bytes: Uint8Array, at: number, rect: Rect): Iterable<Part> {
  return inBlocks ? blockTiles(texel, bytes, at, rect) : [{ rect, inBlocks: false, at }];
}

function* blockTiles(texel: Texel, bytes: Uint8Array, map: number, rect: Rect): Generator<Part> {
  const [left, top, width, height] = rect;
  const count = Math.ceil(width / TILE_SIDE) * Math.ceil(height / TILE_SIDE);
  let at = map + Math.ceil(count / 8);
  let tile = 0;
  for (let y = 0; y < height; y += TILE_SIDE) {
    for (let x = 0; x < width; x += TILE_SIDE) {
      const inBlocks = ((bytes[map + (tile >> 3)] >> (tile & 7)) & 1) === 1;
      const part: Rect = [left + x, top + y, Math.min(TILE_SIDE, width - x), Math.min(TILE_SIDE, height - y)];
      yield { rect: part, inBlocks, at };
      at += bytesOf(texel, part, inBlocks);
      tile += 1;
    }
  }
}

function bytesOf(texel: Texel, [, , width, height]: Rect, inBlocks: boolean): number {
  return inBlocks
    ? Math.ceil(width / SIDE) * Math.ceil(height / SIDE) * texel.blockBytes
    : width * height * texel.bytes;
}

/** Writes a part to a picture of `stride` pixels a row. */
export function drawPart(texel: Texel, bytes: Uint8Array, part: Part, picture: Pixels, stride: number): void {
  const { samples } = texel;
  const [left, top, width, height] = part.rect;
  if (!part.inBlocks) {
    for (let y = 0; y < height; y += 1) {
      const to = samples * ((top + y) * stride + left);
      texel.decodeValues(bytes, part.at + y * width * texel.bytes, picture, to, width);
    }
    return;
  }
  const block = texel.picture(SIDE * SIDE);
  let { at } = part;
  for (let y = 0; y < height; y += SIDE) {
    for (let x = 0; x < width; x += SIDE) {
      texel.decodeBlock(bytes, at, block);
      at += texel.blockBytes;
      const inside = samples * Math.min(SIDE, width - x);
      for (let row = 0; row < Math.min(SIDE, height - y); row += 1) {
        const from = row * SIDE * samples;
        picture.set(block.subarray(from, from + inside), samples * ((top + y + row) * stride + left + x));
      }
    }
  }
}
