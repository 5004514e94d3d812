// The inverse transform of a channel of a block in one frame (formats/color.md 6.3).

import { BASIS_BITS, SPACE_BASES } from "./basis.ts";

const MAX_SIDE = 32;
const HALF = 1 << (BASIS_BITS - 1);
/** Of the columns: row by row, one sum for each column. */
const columnsDone = new Int32Array(MAX_SIDE * MAX_SIDE);
const column = new Int32Array(MAX_SIDE);

/** Transforms coefficients of a block of a size, 0 to 3, row by row, of which those outside of `columns` x `rows` are 0, into the values
 *  of its pixels. Functions of even frequency are symmetric and those of odd frequency antisymmetric, so that half of each sum gives
 *  two values. */
export function inverseTransform(
  coefficients: Int32Array,
  size: number,
  extent: [columns: number, rows: number],
  fractionBits: number,
  out: Int32Array,
): void {
  const [columns, rows] = extent;
  const shift = BASIS_BITS + fractionBits + 2 + size;
  const side = 4 << size;
  if (columns === 1 && rows === 1) {
    const mean = ((coefficients[0] << BASIS_BITS) + HALF) >> BASIS_BITS;
    out.fill(((mean << BASIS_BITS) + (1 << (shift - 1))) >> shift, 0, side * side);
    return;
  }
  transformColumns(coefficients, size, columns, rows);
  // With one row of coefficients all rows of the block are one.
  const different = rows === 1 ? 1 : side;
  transformRows(size, columns, different, shift, out);
  for (let filled = different; filled < side; filled *= 2) {
    out.copyWithin(filled * side, 0, filled * side);
  }
}

function transformColumns(coefficients: Int32Array, size: number, columns: number, rows: number): void {
  const basis = SPACE_BASES[size];
  const side = 4 << size;
  for (let x = 0; x < columns; x++) {
    for (let row = 0; row < rows; row++) {
      column[row] = coefficients[row * side + x];
    }
    for (let y = 0; y < side >> 1; y++) {
      let even = HALF;
      let odd = 0;
      const first = y * side;
      for (let row = 0; row < rows; row += 2) {
        even = (even + Math.imul(column[row], basis[first + row])) | 0;
      }
      for (let row = 1; row < rows; row += 2) {
        odd = (odd + Math.imul(column[row], basis[first + row])) | 0;
      }
      columnsDone[first + x] = (even + odd) >> BASIS_BITS;
      columnsDone[(side - 1 - y) * side + x] = (even - odd) >> BASIS_BITS;
    }
  }
}

function transformRows(size: number, columns: number, rows: number, shift: number, out: Int32Array): void {
  const basis = SPACE_BASES[size];
  const side = 4 << size;
  for (let y = 0; y < rows; y++) {
    const row = y * side;
    for (let x = 0; x < side >> 1; x++) {
      let even = 1 << (shift - 1);
      let odd = 0;
      const first = x * side;
      for (let k = 0; k < columns; k += 2) {
        even = (even + Math.imul(columnsDone[row + k], basis[first + k])) | 0;
      }
      for (let k = 1; k < columns; k += 2) {
        odd = (odd + Math.imul(columnsDone[row + k], basis[first + k])) | 0;
      }
      out[row + x] = (even + odd) >> shift;
      out[row + side - 1 - x] = (even - odd) >> shift;
    }
  }
}
