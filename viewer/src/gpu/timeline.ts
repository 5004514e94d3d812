// How frames of a color chunk on a device are made, and what changes between them (`Timeline` of src/kernels/prepare.rs).

import type { Timeline } from "../decoder/types.ts";

/** How a frame is made (formats/color.md 4). */
export interface Blend {
  /** The last keyframe at or before the frame, by its number in the chunk. */
  keyframe: number;
  /** Of the keyframe after it, in 255ths; 0 shows the keyframe itself. */
  weight: number;
  /** Whether the keyframe after it is the first one of the cell's next chunk. */
  needsNext: boolean;
}

/** How a frame is made, counted from the chunk's first (formats/color.md 4). */
export function blendOf(timeline: Pick<Timeline, "keyframes" | "weights">, frame: number): Blend {
  const { keyframes, weights } = timeline;
  let [low, high] = [0, keyframes.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (keyframes[middle] <= frame) {
      low = middle + 1;
    } else {
      high = middle;
    }
  }
  const keyframe = Math.max(low - 1, 0);
  const weight = frame < weights.length ? weights[frame] : 0;
  return { keyframe, weight, needsNext: weight > 0 && keyframe + 1 === keyframes.length };
}

/** Pixels of a color cell of `pixels` that differ between a frame and the one that is shown; `undefined`: none of this chunk. */
export function changedPixels(timeline: Timeline, frame: number, shown: number | undefined, pixels: number): number {
  if (shown === undefined) {
    return pixels;
  }
  const { frameSets, framePixels } = timeline;
  if (framePixels.length === 0) {
    const [one, other] = [blendOf(timeline, shown), blendOf(timeline, frame)];
    return one.keyframe === other.keyframe && one.weight === other.weight ? 0 : pixels;
  }
  const has = (set: number, frame: number) => ((frameSets[4 * set + (frame >> 5)] >>> (frame & 31)) & 1) === 1;
  let changed = 0;
  for (let set = 0; set < framePixels.length; set++) {
    if (has(set, frame) && !has(set, shown)) {
      changed += framePixels[set];
    }
  }
  return changed;
}
