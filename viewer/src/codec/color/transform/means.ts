// Means of squares of 4x4 pixels of a region, from which the mean of the next block is predicted (formats/color.md 6.5).

import { BASIS_BITS } from "./basis.ts";
import { CHANNELS } from "./domain.ts";

/** Squares in a row of a region. */
const SIDE = 8;

/** Squares of a block: column and row of the first, and the size of the block, 0 to 3. */
export interface Squares {
  x: number;
  y: number;
  size: number;
}

/** The mean of each square in the last of its decoded frames. */
export class Means {
  readonly #of = new Int32Array(CHANNELS * SIDE * SIDE);

  /** Starts a region. */
  clear(): void {
    this.#of.fill(0);
  }

  /** The level that is predicted for the mean of a channel of a block: from the frame before, else from the squares on the left and
   *  above. */
  predict(channel: number, { x, y, size }: Squares, isFirstFrame: boolean, step: number): number {
    const mean = isFirstFrame
      ? this.#around(channel, x, y, size)
      : this.#sum(channel, x, y, 1 << size, 1 << size) >> (2 * size);
    const scaled = Math.imul(mean, 32 << size);
    // The quotient is exact enough: two such differ by more than a double's last place.
    return Math.floor(((scaled + (step >> 1)) | 0) / step) | 0;
  }

  #around(channel: number, x: number, y: number, size: number): number {
    const left = x > 0 ? this.#sum(channel, x - 1, y, 1, 1 << size) : 0;
    const above = y > 0 ? this.#sum(channel, x, y - 1, 1 << size, 1) : 0;
    return ((left + above) | 0) >> (size + (x > 0 && y > 0 ? 1 : 0));
  }

  #sum(channel: number, x: number, y: number, columns: number, rows: number): number {
    let sum = 0;
    for (let row = y; row < y + rows; row++) {
      const first = (channel * SIDE + row) * SIDE + x;
      for (let at = first; at < first + columns; at++) {
        sum = (sum + this.#of[at]) | 0;
      }
    }
    return sum;
  }

  /** Notes the mean of a channel of a transformed block. `constants` are the coefficients of frequency 0 in space of its planes,
   *  `weights` what each plane weighs in the last frame. */
  setBlock(channel: number, { x, y, size }: Squares, constants: Int32Array, weights: Int32Array): void {
    let sum = 1 << (BASIS_BITS - 1);
    for (let plane = 0; plane < weights.length; plane++) {
      sum = (sum + Math.imul(constants[plane], weights[plane])) | 0;
    }
    const mean = (sum >> BASIS_BITS) >> (2 + size);
    for (let row = y; row < y + (1 << size); row++) {
      const first = (channel * SIDE + row) * SIDE + x;
      this.#of.fill(mean, first, first + (1 << size));
    }
  }

  /** Notes the means of the channels of one square. */
  setSquare(x: number, y: number, means: Int32Array): void {
    for (let channel = 0; channel < CHANNELS; channel++) {
      this.#of[(channel * SIDE + y) * SIDE + x] = means[channel];
    }
  }
}
