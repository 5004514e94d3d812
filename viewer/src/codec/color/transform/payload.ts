// The payload of a chunk of the transform codec: its fields, and a substream for each region (formats/color.md 6.4).

import { FormatError, type Rect } from "../../../format/types.ts";
import { type EntropyTables, tableSet } from "../../entropy.ts";
import { Fields } from "../../fields.ts";
import type { Domain, Slopes } from "./domain.ts";
import { NO_DELTA, OFFSET_SETS, regionIndices } from "./steps.ts";

const SECTION = "color.md 6.4";
/** First byte of a payload of keyframes and weights. */
const CELLS = 255;
/** Most frames of a chunk of the transform codec. */
export const MAX_FRAMES = 96;
/** Pixels of a side of a region. */
const REGION = 32;

/** What a payload holds besides its substreams. */
export interface Layout {
  /** Number of the table set. */
  set: number;
  /** Number of the set of frequency offsets. */
  offsetSet: number;
  /** Step indices of the three channels of each region, before offsets. */
  indices: Int32Array;
  slopes: Slopes;
  /** Keys of red, green and blue of the colors that all palettes may name. */
  colors: Uint16Array;
  /** Of each region, the byte at which its substream starts; then the payload's end. */
  substreams: Uint32Array;
}

/** Whether a payload holds keyframes and weights, from its second byte on (formats/color.md 6.4). */
export function holdsCells(payload: Uint8Array): boolean {
  return payload.length > 0 && payload[0] === CELLS;
}

/** Refuses more frames than a chunk of the transform codec may have. */
export function checkFrames(frames: number): void {
  if (frames > MAX_FRAMES) {
    throw new FormatError(
      `A chunk of the transform codec has ${frames} frames, at most ${MAX_FRAMES} are legal (${SECTION}).`,
    );
  }
}

/** Left, top, width and height of a region of a cell of `size` pixels; regions are counted row by row. */
export function regionRect([width, height]: [number, number], region: number): Rect {
  const columns = Math.ceil(width / REGION);
  const left = (region % columns) * REGION;
  const top = Math.floor(region / columns) * REGION;
  return [left, top, Math.min(REGION, width - left), Math.min(REGION, height - top)];
}

/** Reads the fields of a payload of a cell of `size` pixels (formats/color.md 6.4). */
export function parseLayout(
  payload: Uint8Array,
  size: [number, number],
  tables: EntropyTables,
  domain: Domain,
): Layout {
  const fields = new Fields(payload, SECTION);
  const set = fields.u8();
  if (tableSet(tables, set) === undefined) {
    throw fields.error(`The stream has no table set ${set}`);
  }
  const [luma, chroma] = [fields.u8(), fields.u8()];
  const slopes = { green: (fields.u8() << 24) >> 24, orange: (fields.u8() << 24) >> 24 };
  const choices = fields.u8();
  const [count, offsetSet, hasDeltas] = [choices & 15, (choices >> 4) & 7, choices >= 128];
  if (offsetSet >= OFFSET_SETS.length) {
    throw fields.error(`There is no set ${offsetSet} of frequency offsets`);
  }
  const colors = new Uint16Array(3 * count);
  for (let at = 0; at < colors.length; at++) {
    colors[at] = domain.isHalf ? fields.u16() : fields.u8();
  }
  const regions = Math.ceil(size[0] / REGION) * Math.ceil(size[1] / REGION);
  const deltas = hasDeltas ? fields.skip(Math.ceil(regions / 2)) : 0;
  const indices = new Int32Array(3 * regions);
  for (let region = 0; region < regions; region++) {
    const nibble = hasDeltas ? (payload[deltas + (region >> 1)] >> (4 * (region & 1))) & 15 : NO_DELTA;
    indices.set(regionIndices(luma, chroma, nibble), 3 * region);
  }
  if (regions - 1 > fields.remaining) {
    throw fields.error(`${regions} substreams were expected where ${fields.remaining} bytes are left`);
  }
  const substreams = new Uint32Array(regions + 1);
  const sizes = substreams.subarray(1);
  for (let region = 0; region + 1 < regions; region++) {
    // No number that is cut to 32 bits here passes as a smaller one: it is more than what is left.
    const bytes = fields.varint();
    if (bytes > fields.remaining) {
      throw fields.error(`A substream of ${bytes} bytes was expected where ${fields.remaining} are left`);
    }
    sizes[region] = bytes;
  }
  substreams[0] = fields.at;
  for (let region = 0; region + 1 < regions; region++) {
    fields.skip(sizes[region]);
    sizes[region] = fields.at;
  }
  substreams[regions] = payload.length;
  return { set, offsetSet, indices, slopes, colors, substreams };
}
