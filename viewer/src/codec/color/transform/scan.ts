// The order of levels in a plane (formats/color.md 6.6).

/** Numbers in a row of magnitudes: two beyond the largest block are always 0. */
export const MAGNITUDE_ROW = 34;

/** Positions of the planes of a size, in the order of coding. */
export interface Scan {
  /** 32 · vertical + horizontal frequency. */
  places: Uint16Array;
  /** The place among magnitudes: 34 · vertical + horizontal frequency. */
  magnitudes: Uint16Array;
  /** Class of the position by the sum of its frequencies, 0 to 5: p in color.md 6.6. */
  classes: Uint8Array;
}

/** Classes of sums of frequencies; those of greater sums are 5. */
const CLASSES = [0, 1, 2, 2, 3, 3, 3, 4, 4, 4, 4, 4];

/** The scan of each size of a block, 0 to 3, of 4 to 32 pixels square (formats/color.md 6.6). */
export const SCANS: readonly Scan[] = [4, 8, 16, 32].map((side) => {
  const positions: [number, number][] = [];
  for (let sum = 0; sum < 2 * side - 1; sum++) {
    for (let at = 0; at <= sum; at++) {
      const y = sum % 2 === 1 ? at : sum - at;
      if (y < side && sum - y < side) {
        positions.push([sum - y, y]);
      }
    }
  }
  return {
    places: Uint16Array.from(positions, ([x, y]) => 32 * y + x),
    magnitudes: Uint16Array.from(positions, ([x, y]) => MAGNITUDE_ROW * y + x),
    classes: Uint8Array.from(positions, ([x, y]) => CLASSES[x + y] ?? 5),
  };
});
