// Cosine bases in integers (formats/color.md 6.1).

/** round(256·√2·cos(jπ/192)) for j from 0 to 96. */
const COSINES = Int32Array.of(
  ...[
    362, 362, 362, 362, 361, 361, 360, 360, 359, 358, 357, 356, 355, 354, 353, 351, 350, 348, 346, 345, 343, 341, 339,
  ],
  ...[
    337, 334, 332, 330, 327, 325, 322, 319, 316, 314, 311, 307, 304, 301, 298, 294, 291, 287, 284, 280, 276, 272, 268,
  ],
  ...[
    264, 260, 256, 252, 247, 243, 239, 234, 230, 225, 220, 216, 211, 206, 201, 196, 191, 186, 181, 176, 171, 165, 160,
  ],
  ...[155, 149, 144, 139, 133, 128, 122, 116, 111, 105, 99, 94, 88, 82, 76, 71, 65, 59, 53, 47, 41, 35, 30, 24, 18, 12],
  ...[6, 0],
);

/** Bits of the fraction of a basis value: 1 is 256. */
export const BASIS_BITS = 8;

/** Numbers of frames that a block may span, ascending (formats/color.md 6.3). */
export const LENGTHS: readonly number[] = [1, 2, 3, 4, 6, 8, 12, 16, 24];
/** Most frames of a block. */
export const MAX_LENGTH = 24;

/** Index of each number of frames among the lengths; 9 of those that are none. */
const INDEX_OF = Uint8Array.from({ length: 97 }, (_, frames) => {
  const index = LENGTHS.indexOf(frames);
  return index < 0 ? LENGTHS.length : index;
});

/** Index of a number of frames, 0 to 96, among the lengths; 9 where it is none. */
export function lengthIndex(frames: number): number {
  return INDEX_OF[frames];
}

/** Sample `n` of cosine function `k` of `points` points in 256ths (formats/color.md 6.1). */
export function basis(points: number, k: number, n: number): number {
  if (k === 0) {
    return 1 << BASIS_BITS;
  }
  const turn = ((2 * n + 1) * k * (96 / points)) % 384;
  const half = turn > 192 ? 384 - turn : turn;
  return half > 96 ? -COSINES[192 - half] : COSINES[half];
}

/** Bases of all lengths by the length's index: sample `n` of function `k` is number `n * length + k`. */
export const TIME_BASES: readonly Int32Array[] = LENGTHS.map(bySample);

/** Bases of blocks of 4, 8, 16 and 32 points in space, by the size: sample `n` of function `k` is number `n * points + k`. */
export const SPACE_BASES: readonly Int32Array[] = [4, 8, 16, 32].map(bySample);

function bySample(points: number): Int32Array {
  return Int32Array.from({ length: points * points }, (_, at) => basis(points, at % points, Math.floor(at / points)));
}
