// The records that lead a decoder from one frame to another (formats/depth.md 4). Mirrors src/codec/depth/record_table.rs.

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
