// How long a device reads the regions of a chunk. Mirrors `passes_of` of src/gpu/prepare.rs.

import { CONSTANTS } from "../../../gpu/layout.ts";
import * as leaf from "./leaves.ts";
import type { Leaves } from "./leaves.ts";

const { STEP_ITERATIONS, PASS_ITERATIONS } = CONSTANTS;

/** Upper bound of the iterations that `shaders/color/transform/region.wgsl` counts for a leaf. */
function iterationsOf({ rows, places }: Leaves, row: number): number {
  const place = rows[row + leaf.LEAF_PLACE];
  const frames = rows[row + leaf.LEAF_FRAMES] >> 8;
  const pixels = 16 << (2 * ((place >> 16) & 3));
  // At most one node that is split for each leaf.
  let sum = 2 * STEP_ITERATIONS;
  if ((place & leaf.IS_PALETTE) !== 0) {
    return sum + 17 * rows[row + leaf.LEAF_COLOR_COUNT] + (frames + 1) * (STEP_ITERATIONS + 2 * pixels);
  }
  for (let channel = 0; channel < 3; channel++) {
    const extent = rows[row + leaf.LEAF_EXTENTS] >> (10 * channel);
    // Positions are in the order of their diagonals.
    const diagonals = (extent & 31) + ((extent >> 5) & 31) + 1;
    const positions = Math.min((diagonals * (diagonals + 1)) / 2, pixels);
    const [start, end] = [rows[row + leaf.LEAF_LEVELS + channel], rows[row + leaf.LEAF_LEVELS + channel + 1]];
    const planes = start === end ? 0 : (places[end - 1] >> 10) + 1;
    sum += STEP_ITERATIONS + (3 * pixels) / 16 + planes * (STEP_ITERATIONS + positions);
  }
  return sum;
}

/** Passes in which the regions of a chunk are read, at most. */
export function passesOf(leaves: Leaves): number {
  const iterations: number[] = [];
  for (let row = 0; row < leaves.count * leaf.LEAF_ROW; row += leaf.LEAF_ROW) {
    const region = leaves.rows[row + leaf.LEAF_REGION];
    iterations[region] = (iterations[region] ?? 0) + iterationsOf(leaves, row);
  }
  return iterations.reduce((most, sum) => Math.max(most, 1 + Math.floor(sum / PASS_ITERATIONS)), 1);
}
