// BC6H without a sign: red, green and blue as half floats, 16 pixels in 16 bytes (formats/blocks.md 7).

import { anchorsOf, BlockBits, mix, subsetOf, takeWeights } from "./bptc.ts";

interface Mode {
  subsets: number;
  precision: number;
  /** Bits of the differences of red, green and blue from the first endpoint; zeros where there are none. */
  differences: number[];
  /** Of each bit behind the code, in their order: the number that it belongs to, and its place there. */
  numbers: Uint8Array;
  places: Uint8Array;
}

/** Number of the partition among those of a block; before it are red, green and blue of endpoint w, of x, of y and of z. */
const PARTITION = 12;

/** The mode of each code; codes that are missing are reserved. */
const MODES = new Map<number, Mode>([
  mode(
    0,
    10,
    [5, 5, 5],
    "gy4 by4 bz4 rw0-9 gw0-9 bw0-9 rx0-4 gz4 gy0-3 gx0-4 bz0 gz0-3 bx0-4 bz1 by0-3 ry0-4 bz2 rz0-4 bz3 d0-4",
  ),
  mode(
    1,
    7,
    [6, 6, 6],
    "gy5 gz4-5 rw0-6 bz0-1 by4 gw0-6 by5 bz2 gy4 bw0-6 bz3 bz5 bz4 rx0-5 gy0-3 gx0-5 gz0-3 bx0-5 by0-3 ry0-5 rz0-5 d0-4",
  ),
  mode(
    2,
    11,
    [5, 4, 4],
    "rw0-9 gw0-9 bw0-9 rx0-4 rw10 gy0-3 gx0-3 gw10 bz0 gz0-3 bx0-3 bw10 bz1 by0-3 ry0-4 bz2 rz0-4 bz3 d0-4",
  ),
  mode(
    6,
    11,
    [4, 5, 4],
    "rw0-9 gw0-9 bw0-9 rx0-3 rw10 gz4 gy0-3 gx0-4 gw10 gz0-3 bx0-3 bw10 bz1 by0-3 ry0-3 bz0 bz2 rz0-3 gy4 bz3 d0-4",
  ),
  mode(
    10,
    11,
    [4, 4, 5],
    "rw0-9 gw0-9 bw0-9 rx0-3 rw10 by4 gy0-3 gx0-3 gw10 bz0 gz0-3 bx0-4 bw10 by0-3 ry0-3 bz1-2 rz0-3 bz4 bz3 d0-4",
  ),
  mode(
    14,
    9,
    [5, 5, 5],
    "rw0-8 by4 gw0-8 gy4 bw0-8 bz4 rx0-4 gz4 gy0-3 gx0-4 bz0 gz0-3 bx0-4 bz1 by0-3 ry0-4 bz2 rz0-4 bz3 d0-4",
  ),
  mode(
    18,
    8,
    [6, 5, 5],
    "rw0-7 gz4 by4 gw0-7 bz2 gy4 bw0-7 bz3-4 rx0-5 gy0-3 gx0-4 bz0 gz0-3 bx0-4 bz1 by0-3 ry0-5 rz0-5 d0-4",
  ),
  mode(
    22,
    8,
    [5, 6, 5],
    "rw0-7 bz0 by4 gw0-7 gy5 gy4 bw0-7 gz5 bz4 rx0-4 gz4 gy0-3 gx0-5 gz0-3 bx0-4 bz1 by0-3 ry0-4 bz2 rz0-4 bz3 d0-4",
  ),
  mode(
    26,
    8,
    [5, 5, 6],
    "rw0-7 bz1 by4 gw0-7 by5 gy4 bw0-7 bz5 bz4 rx0-4 gz4 gy0-3 gx0-4 bz0 gz0-3 bx0-5 by0-3 ry0-4 bz2 rz0-4 bz3 d0-4",
  ),
  mode(
    30,
    6,
    [0, 0, 0],
    "rw0-5 gz4 bz0-1 by4 gw0-5 gy5 by5 bz2 gy4 bw0-5 gz5 bz3 bz5 bz4 rx0-5 gy0-3 gx0-5 gz0-3 bx0-5 by0-3 ry0-5 rz0-5 d0-4",
  ),
  mode(3, 10, [0, 0, 0], "rw0-9 gw0-9 bw0-9 rx0-9 gx0-9 bx0-9"),
  mode(7, 11, [9, 9, 9], "rw0-9 gw0-9 bw0-9 rx0-8 rw10 gx0-8 gw10 bx0-8 bw10"),
  mode(11, 12, [8, 8, 8], "rw0-9 gw0-9 bw0-9 rx0-7 rw11-10 gx0-7 gw11-10 bx0-7 bw11-10"),
  mode(15, 16, [4, 4, 4], "rw0-9 gw0-9 bw0-9 rx0-3 rw15-10 gx0-3 gw15-10 bx0-3 bw15-10"),
]);

/** A row of the table of modes. */
function mode(code: number, precision: number, differences: number[], layout: string): [number, Mode] {
  const numbers: number[] = [];
  const places: number[] = [];
  for (const [, channel, endpoint, from, to] of layout.matchAll(/([rgbd])([wxyz]?)(\d+)(?:-(\d+))?/g)) {
    const number = channel === "d" ? PARTITION : 3 * "wxyz".indexOf(endpoint) + "rgb".indexOf(channel);
    const last = Number(to ?? from);
    const step = last < Number(from) ? -1 : 1;
    for (let place = Number(from); place !== last + step; place += step) {
      numbers.push(number);
      places.push(place);
    }
  }
  const subsets = numbers.includes(PARTITION) ? 2 : 1;
  return [
    code,
    { subsets, precision, differences, numbers: Uint8Array.from(numbers), places: Uint8Array.from(places) },
  ];
}

const bits = new BlockBits();
const values = new Uint16Array(PARTITION + 1);
const weights = new Uint8Array(16);

/** Decodes the block of 16 bytes at byte `at` into bit patterns of half floats, red, green, blue of 16 pixels, row by row: 48 numbers of
 *  0 to 0x7BFF. Blocks of the reserved codes 19, 23, 27 and 31 are zeros (formats/blocks.md 7). */
export function decodeBc6hBlock(bytes: Uint8Array, at: number, out: Uint16Array): void {
  const code = bytes[at] & ((bytes[at] & 3) < 2 ? 3 : 31);
  const mode = MODES.get(code);
  if (mode === undefined) {
    out.fill(0, 0, 48);
    return;
  }
  const { subsets } = mode;
  bits.load(bytes, at);
  bits.take(code < 2 ? 2 : 5);
  values.fill(0);
  for (let bit = 0; bit < mode.numbers.length; bit++) {
    values[mode.numbers[bit]] |= bits.take(1) << mode.places[bit];
  }
  for (let value = 6 * subsets - 1; value >= 0; value--) {
    values[value] = endpoint(mode, value);
  }
  const partition = values[PARTITION];
  takeWeights(bits, subsets === 2 ? 3 : 4, anchorsOf(subsets, partition), weights);
  for (let texel = 0; texel < 16; texel++) {
    const pair = 6 * subsetOf(subsets, partition, texel);
    for (let channel = 0; channel < 3; channel++) {
      const value = mix(values[pair + channel], values[pair + 3 + channel], weights[texel]);
      out[3 * texel + channel] = (value * 31) >> 6;
    }
  }
}

/** A channel of an endpoint, in 16 bits. Those of the first endpoint must still be as they were read. */
function endpoint(mode: Mode, value: number): number {
  const { precision } = mode;
  const channel = value % 3;
  let number = values[value];
  if (value > 2 && mode.differences[channel] > 0) {
    const unused = 32 - mode.differences[channel];
    number = (values[channel] + ((number << unused) >> unused)) & ((1 << precision) - 1);
  }
  if (precision === 16 || number === 0) {
    return number;
  }
  return number === (1 << precision) - 1 ? 0xffff : ((number << 16) + 0x8000) >>> precision;
}
