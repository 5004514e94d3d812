// Pictures of the program in OpenEXR files: half floats, ZIP compression of 16 lines, as `lightfold render` writes them.

import { inflateSync } from "node:zlib";

const LINES = 16;
/** Components of pixels in the order of the names of channels: A, B, G, R. */
const COMPONENTS = [3, 2, 1, 0];

const LARGEST_HALF = 0x7bff;

/** The bit pattern of the half float that is nearest to a number, and the largest for those beyond. */
export function halfBits(value: number): number {
  const sign = value < 0 ? 0x8000 : 0;
  const size = Math.abs(value);
  if (!(size < 65520)) {
    return sign | (Number.isNaN(value) ? 0 : LARGEST_HALF);
  }
  const exponent = Math.max(Math.floor(Math.log2(size)), -14);
  const units = size * 2 ** (10 - exponent);
  const floor = Math.floor(units);
  const rest = units - floor;
  const rounded = rest > 0.5 || (rest === 0.5 && floor % 2 === 1) ? floor + 1 : floor;
  // The fraction has a leading 1 unless the number is subnormal; a carry is the next exponent.
  return sign | ((exponent + 14) * 1024 + rounded);
}

/** Bits of red, green, blue and alpha of an image of `width` x `height` pixels, row by row. */
export function exrHalves(file: Uint8Array, [width, height]: readonly [number, number]): Uint16Array {
  const data = new DataView(file.buffer, file.byteOffset, file.byteLength);
  const halves = new Uint16Array(4 * width * height);
  const table = endOfHeader(file);
  for (let first = 0; first < height; first += LINES) {
    const at = Number(data.getBigUint64(table + (8 * first) / LINES, true));
    const lines = Math.min(LINES, height - first);
    const bytes = unpacked(file.subarray(at + 8, at + 8 + data.getInt32(at + 4, true)), 8 * width * lines);
    for (let row = 0; row < lines; row += 1) {
      COMPONENTS.forEach((component, channel) => {
        for (let column = 0; column < width; column += 1) {
          const from = 2 * ((4 * row + channel) * width + column);
          halves[4 * ((first + row) * width + column) + component] = bytes[from] | (bytes[from + 1] << 8);
        }
      });
    }
  }
  return halves;
}

/** Attributes are a name, a type, a length and so many bytes; an empty name ends them. */
function endOfHeader(file: Uint8Array): number {
  let at = 8;
  const text = (): string => {
    const begin = at;
    at = file.indexOf(0, at) + 1;
    return new TextDecoder().decode(file.subarray(begin, at - 1));
  };
  for (let name = text(); name !== ""; name = text()) {
    text();
    const length = file[at] | (file[at + 1] << 8);
    const value = file.subarray(at + 4, at + 4 + length);
    if (name === "compression" && value[0] !== 3) {
      throw new Error(`an image of compression ${value[0]}`);
    }
    at += 4 + length;
  }
  return at;
}

/** Bytes of a block: differences of the even bytes, then of the odd ones. */
function unpacked(packed: Uint8Array, length: number): Uint8Array {
  if (packed.length === length) {
    return packed;
  }
  const sums = inflateSync(packed);
  for (let at = 1; at < length; at += 1) {
    sums[at] = sums[at - 1] + sums[at] - 128;
  }
  return Uint8Array.from({ length }, (_, at) => sums[(at >> 1) + (at % 2) * Math.ceil(length / 2)]);
}
