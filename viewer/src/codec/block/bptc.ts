// What BC6H and BC7 share (formats/blocks.md 6): bits in ascending order, partitions of the pixels into subsets, indices with anchors,
// and weights between two endpoints.

/** Reads the bits of a block of 16 bytes, the lowest first. */
export class BlockBits {
  /** The block, and a zero behind it. */
  private readonly words = new Uint32Array(5);
  private at = 0;

  load(bytes: Uint8Array, at: number): void {
    for (let word = 0; word < 4; word++) {
      const from = at + 4 * word;
      this.words[word] = bytes[from] | (bytes[from + 1] << 8) | (bytes[from + 2] << 16) | (bytes[from + 3] << 24);
    }
    this.at = 0;
  }

  /** The next bits as a number; 0 to 16 of them. */
  take(count: number): number {
    const word = this.at >>> 5;
    const shift = this.at & 31;
    this.at += count;
    // A shift by 32 is one by 0 here, so that it is split.
    const bits = (this.words[word] >>> shift) | ((this.words[word + 1] << 1) << (31 - shift));
    return bits & ((1 << count) - 1);
  }
}

/** The subset of a pixel, 0 to 2, in partition `number` of `subsets`. */
export function subsetOf(subsets: number, number: number, texel: number): number {
  return subsets === 1 ? 0 : subsets === 2 ? (TWO[number] >>> texel) & 1 : (THREE[number] >>> (2 * texel)) & 3;
}

/** Bit t is 1 where pixel t is the anchor of its subset. */
export function anchorsOf(subsets: number, number: number): number {
  switch (subsets) {
    case 1:
      return 1;
    case 2:
      return 1 | (1 << ANCHOR_OF_TWO[number]);
    default:
      return 1 | (1 << ANCHORS_OF_THREE[2 * number]) | (1 << ANCHORS_OF_THREE[2 * number + 1]);
  }
}

/** Reads the indices of 16 pixels, of `bits` bits and of one less at the anchors, and writes their weights in 64ths. */
export function takeWeights(from: BlockBits, bits: number, anchors: number, weights: Uint8Array): void {
  const table = WEIGHTS[bits - 2];
  for (let texel = 0; texel < 16; texel++) {
    weights[texel] = table[from.take(bits - ((anchors >>> texel) & 1))];
  }
}

/** `weight` 64ths of the way from a to b (formats/blocks.md 6). */
export function mix(a: number, b: number, weight: number): number {
  return (a * (64 - weight) + b * weight + 32) >> 6;
}

/** Weights of the second endpoint by the index, for indices of 2, 3 and 4 bits. */
const WEIGHTS = [
  Uint8Array.of(0, 21, 43, 64),
  Uint8Array.of(0, 9, 18, 27, 37, 46, 55, 64),
  Uint8Array.of(0, 4, 9, 13, 17, 21, 26, 30, 34, 38, 43, 47, 51, 55, 60, 64),
];

/** Partitions in two subsets: bit t is the subset of pixel t. */
const TWO = Uint16Array.from(
  `cccc 8888 eeee ecc8 c880 feec fec8 ec80 c800 ffec fe80 e800 ffe8 ff00 fff0 f000
   f710 008e 7100 08ce 008c 7310 3100 8cce 088c 3110 6666 366c 17e8 0ff0 718e 399c
   aaaa f0f0 5a5a 33cc 3c3c 55aa 9696 a55a 73ce 13c8 324c 3bdc 6996 c33c 9966 0660
   0272 04e4 4e40 2720 c936 936c 39c6 639c 9336 9cc6 817e e718 ccf0 0fcc 7744 ee22`.split(/\s+/),
  (word) => parseInt(word, 16),
);

/** Partitions in three subsets: bits 2t and 2t + 1 are the subset of pixel t. */
const THREE = Uint32Array.from(
  `aa685050 6a5a5040 5a5a4200 5450a0a8 a5a50000 a0a05050 5555a0a0 5a5a5050
   aa550000 aa555500 aaaa5500 90909090 94949494 a4a4a4a4 a9a59450 2a0a4250
   a5945040 0a425054 a5a5a500 55a0a0a0 a8a85454 6a6a4040 a4a45000 1a1a0500
   0050a4a4 aaa59090 14696914 69691400 a08585a0 aa821414 50a4a450 6a5a0200
   a9a58000 5090a0a8 a8a09050 24242424 00aa5500 24924924 24499224 50a50a50
   500aa550 aaaa4444 66660000 a5a0a5a0 50a050a0 69286928 44aaaa44 66666600
   aa444444 54a854a8 95809580 96969600 a85454a8 80959580 aa141414 96960000
   aaaa1414 a05050a0 a0a5a5a0 96000000 40804080 a9a8a9a8 aaaaaa44 2a4a5254`.split(/\s+/),
  (word) => parseInt(word, 16),
);

/** The anchor of subset 1 of each partition in two subsets. */
const ANCHOR_OF_TWO = Uint8Array.from(
  `15 15 15 15 15 15 15 15 15 15 15 15 15 15 15 15 15 2 8 2 2 8 8 15 2 8 2 2 8 8 2 2
   15 15 6 8 2 8 15 15 2 8 2 2 2 15 15 6 6 2 6 8 15 15 2 2 15 15 15 15 15 2 2 15`.split(/\s+/),
  Number,
);

/** The anchors of subsets 1 and 2 of each partition in three subsets. */
const ANCHORS_OF_THREE = Uint8Array.from(
  `3,15 3,8 15,8 15,3 8,15 3,15 15,3 15,8 8,15 8,15 6,15 6,15 6,15 5,15 3,15 3,8
   3,15 3,8 8,15 15,3 3,15 3,8 6,15 10,8 5,3 8,15 8,6 6,10 8,15 5,15 15,10 15,8
   8,15 15,3 3,15 5,10 6,10 10,8 8,9 15,10 15,6 3,15 15,8 5,15 15,3 15,6 15,6 15,8
   3,15 15,3 5,15 5,15 5,15 8,15 5,15 10,15 5,15 10,15 8,15 13,15 15,3 12,15 3,15 3,8`.split(/[\s,]+/),
  Number,
);
