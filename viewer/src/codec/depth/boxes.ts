// Chunks of codes or material in boxes: a keyframe and what changes after it (formats/depth.md 4 and 14).

import type { Rect } from "../../format/types.ts";
import { Fields } from "../fields.ts";
import type { Pixels } from "../types.ts";
import { drawPart, type Layout, partsOf, takeRectangle } from "./block_tiles.ts";
import { checkStart, readRecordTable } from "./record_table.ts";

const WHOLE = 0;
const CONSTANT = 1;
const BOXES = 2;
const MAX_BOXES = 256;
/** Sides of blocks, at multiples of which boxes in blocks start. */
const GRID = 4;

/** A rectangle of the unit, and where its stored pixels start in the payload. */
export interface Box {
  rect: Rect;
  at: number;
}

/** A rectangle that a record writes: its place in the unit, the byte that it starts at, how its pixels are stored, and in which box of the
 *  record it lies. */
export interface WrittenRect {
  rect: Rect;
  at: number;
  coding: "values" | "one value" | "blocks";
  box: number;
}

/** What a frame changes: the whole unit to one value, or rectangles to stored pixels. */
export type BoxRecord = { frame: number; constantAt: number } | { frame: number; boxes: Box[] };

/** A checked chunk. Every offset lies in its payload and every box in the unit; boxes of a record do not overlap. */
export class BoxChunk {
  readonly layout: Layout;
  readonly payload: Uint8Array;
  readonly records: readonly BoxRecord[];
  readonly #width: number;
  readonly #height: number;

  /** `size` is that of the unit, `frames` the number of frames. */
  constructor(layout: Layout, payload: Uint8Array, [width, height]: [number, number], frames: number) {
    this.layout = layout;
    this.payload = payload;
    this.#width = width;
    this.#height = height;
    const fields = new Fields(payload, layout.inBlocks ? "depth.md 14" : "depth.md 4");
    this.records = readRecordTable(fields, frames).map((row) => {
      checkStart(fields, row);
      return this.#readRecord(fields, row.frame);
    });
    fields.finish();
  }

  #readRecord(fields: Fields, frame: number): BoxRecord {
    const kind = fields.u8();
    fields.zeros(1);
    const count = fields.u16();
    if (kind !== BOXES && count !== 0) {
      throw fields.error("A whole picture announces boxes");
    }
    switch (kind) {
      case WHOLE: {
        const at = fields.at;
        takeRectangle(this.layout, fields, this.#width, this.#height);
        return { frame, boxes: [{ rect: [0, 0, this.#width, this.#height], at }] };
      }
      case CONSTANT:
        return { frame, constantAt: fields.skip(this.layout.texel.bytes) };
      case BOXES:
        if (frame === 0) {
          throw fields.error("The first record of a chunk is no whole picture");
        }
        if (count < 1 || count > MAX_BOXES) {
          throw fields.error(`A record has ${count} boxes where 1 to ${MAX_BOXES} are legal`);
        }
        return { frame, boxes: this.#readBoxes(fields, count) };
      default:
        throw fields.error(`A record is of kind ${kind}, which is unknown`);
    }
  }

  #readBoxes(fields: Fields, count: number): Box[] {
    const boxes: Box[] = [];
    for (let at = 0; at < count; at += 1) {
      const rect: Rect = [fields.u16(), fields.u16(), fields.u16(), fields.u16()];
      const [x, y, width, height] = rect;
      const name = `A box of ${width}x${height} pixels at ${x}, ${y}`;
      if (width === 0 || height === 0 || x + width > this.#width || y + height > this.#height) {
        throw fields.error(`${name} is not inside a unit of ${this.#width}x${this.#height}`);
      }
      if (this.layout.inBlocks && !(isOnGrid(x, width, this.#width) && isOnGrid(y, height, this.#height))) {
        throw fields.error(`${name} cuts blocks of 4x4 pixels`);
      }
      if (boxes.some((other) => overlap(other.rect, rect))) {
        throw fields.error("Two boxes of a record overlap");
      }
      boxes.push({ rect, at: 0 });
    }
    for (const box of boxes) {
      box.at = fields.at;
      takeRectangle(this.layout, fields, box.rect[2], box.rect[3]);
    }
    return boxes;
  }

  /** The pixels that a record writes. */
  updatedPixels(record: BoxRecord): number {
    if ("constantAt" in record) {
      return this.#width * this.#height;
    }
    return record.boxes.reduce((sum, { rect }) => sum + rect[2] * rect[3], 0);
  }

  /** The rectangles that a record writes, box by box. */
  *written(record: BoxRecord): Generator<WrittenRect> {
    if ("constantAt" in record) {
      yield { rect: [0, 0, this.#width, this.#height], at: record.constantAt, coding: "one value", box: 0 };
      return;
    }
    for (const [box, { rect, at }] of record.boxes.entries()) {
      for (const part of partsOf(this.layout, this.payload, at, rect)) {
        yield { rect: part.rect, at: part.at, coding: part.inBlocks ? "blocks" : "values", box };
      }
    }
  }

  /** Applies a record to a picture of the unit. */
  apply(record: BoxRecord, picture: Pixels): void {
    const { layout, payload } = this;
    if ("constantAt" in record) {
      const { samples } = layout.texel;
      layout.texel.decodeValues(payload, record.constantAt, picture, 0, 1);
      for (let filled = samples; filled < picture.length; filled *= 2) {
        picture.copyWithin(filled, 0, filled);
      }
      return;
    }
    for (const { rect, at } of record.boxes) {
      for (const part of partsOf(layout, payload, at, rect)) {
        drawPart(layout.texel, payload, part, picture, this.#width);
      }
    }
  }
}

function isOnGrid(start: number, size: number, limit: number): boolean {
  return start % GRID === 0 && ((start + size) % GRID === 0 || start + size === limit);
}

function overlap([x, y, width, height]: Rect, [left, top, columns, rows]: Rect): boolean {
  return x < left + columns && left < x + width && y < top + rows && top < y + height;
}
