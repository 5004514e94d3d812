// The table at the start of a chunk's payload, which leads from frames to records, and the steps of a decoder over it (formats/depth.md
// 4). Chunks of boxes and of nodes share it.

import type { Fields } from "../fields.ts";

/** A row: a frame of the chunk, and the offset of its record in the payload. */
export interface Row {
  frame: number;
  offset: number;
}

const ROW_BYTES = 8;

/** Reads the table of a chunk of `frames` frames: at least one row, frame 0 first, frames ascending. */
export function readRecordTable(fields: Fields, frames: number): Row[] {
  const count = fields.u32();
  if (count * ROW_BYTES > fields.remaining || count > frames || count === 0) {
    throw fields.error(`${count} records for ${frames} frames do not fit`);
  }
  const rows: Row[] = [];
  let before = -1;
  for (let at = 0; at < count; at += 1) {
    const row = { frame: fields.u32(), offset: fields.u32() };
    if (row.frame <= before || row.frame >= frames || (at === 0 && row.frame !== 0)) {
      throw fields.error(`Record ${at} is for frame ${row.frame}, out of order or out of range`);
    }
    before = row.frame;
    rows.push(row);
  }
  return rows;
}

/** Checks that a record starts where its row says. */
export function checkStart(fields: Fields, { frame, offset }: Row): void {
  if (offset !== fields.at) {
    throw fields.error(`The record of frame ${frame} was announced at offset ${offset}`);
  }
}

/** Indices of the records that lead to frame `target` from frame `at` (`undefined`: nothing is shown yet) in steps of at most `window`
 *  frames: a shorter one at the end. To go back, it starts again at frame 0. `frames` are those of records: they ascend from 0. With a
 *  window of 0 all records are whole, and the last one leads there at once. */
export function stepsOver(frames: Uint32Array, at: number | undefined, target: number, window: number): number[] {
  if (at === target) {
    return [];
  }
  if (window === 0) {
    return [firstAbove(frames, target) - 1];
  }
  const isStart = at === undefined || at > target;
  const found = isStart ? [0] : [];
  let frame = isStart ? 0 : at;
  while (frame < target) {
    // Steps that land on no record do nothing. They are taken at once: a payload of a few bytes may claim 2³¹ frames.
    const next = firstAbove(frames, frame);
    const stop = Math.min(next < frames.length ? frames[next] : target, target);
    frame += Math.floor((stop - frame - 1) / window) * window;
    frame += Math.min(window, target - frame);
    const record = firstAbove(frames, frame) - 1;
    if (frames[record] === frame) {
      found.push(record);
    }
  }
  return found;
}

/** Index of the first number that is above `value`. */
function firstAbove(ascending: Uint32Array, value: number): number {
  let low = 0;
  let high = ascending.length;
  while (low < high) {
    const middle = (low + high) >>> 1;
    if (ascending[middle] <= value) {
      low = middle + 1;
    } else {
      high = middle;
    }
  }
  return low;
}
