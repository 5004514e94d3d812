// Decoded colors, alpha and materials as texels of four components. Mirrors src/views/straight.rs and parts of face_cache.rs.

import type { Pixels } from "../codec/types.ts";
import type { Rect } from "../format/types.ts";

const ONE_HALF_FLOAT = 0x3c00;
const MOST_HALF = 65504;

/** Pixels of a unit, and where it lies in its image. */
export interface UnitPixels {
  pixels: Pixels;
  rect: Rect;
}

/** What divides light by the alpha that it was multiplied by: a component and alpha in 255ths. */
export type Straight = (component: number, alpha: number) => number;

function decoded(code: number, isLinear: boolean): number {
  const value = code / 255;
  if (isLinear) {
    return value;
  }
  return value <= 0.04045 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4;
}

function encoded(light: number, isLinear: boolean): number {
  if (isLinear) {
    return light;
  }
  return light <= 0.0031308 ? 12.92 * light : 1.055 * light ** (1 / 2.4) - 0.055;
}

/** Of 8-bit codes behind a curve, with any exposure. */
export function straightCodes(isLinear: boolean): Straight {
  const codes = new Uint8Array(1 << 16);
  for (let alpha = 1; alpha <= 255; alpha += 1) {
    for (let code = 0; code <= 255; code += 1) {
      const light = (decoded(code, isLinear) * 255) / alpha;
      const straight = Math.min(255, Math.floor(encoded(light, isLinear) * 255 + 0.5));
      codes[(alpha << 8) | code] = alpha === 255 ? code : straight;
    }
  }
  return (code, alpha) => codes[(alpha << 8) | code];
}

const floats = new Float32Array(1);
const bits = new Uint32Array(floats.buffer);

/** The value of the bits of a half float. */
function halfValue(half: number): number {
  const [exponent, fraction] = [(half >>> 10) & 31, half & 0x3ff];
  const size = exponent === 0 ? fraction * 2 ** -24 : (1 + fraction / 1024) * 2 ** (exponent - 15);
  return half & 0x8000 ? -size : size;
}

/** The bits of the half float nearest to a finite number. */
function halfBits(value: number): number {
  floats[0] = Math.max(-MOST_HALF, Math.min(MOST_HALF, value));
  const sign = (bits[0] >>> 16) & 0x8000;
  const size = Math.abs(floats[0]);
  if (size < 2 ** -14) {
    return sign | roundEven(size * 2 ** 24);
  }
  const exponent = Math.floor(Math.log2(size));
  return sign | (((exponent + 15) << 10) + roundEven((size / 2 ** exponent - 1) * 1024));
}

function roundEven(value: number): number {
  const below = Math.floor(value);
  const rest = value - below;
  return rest > 0.5 || (rest === 0.5 && below % 2 === 1) ? below + 1 : below;
}

/** Of the bits of half floats. */
export function straightHalf(half: number, alpha: number): number {
  if (alpha === 255) {
    return half;
  }
  return alpha === 0 ? 0 : halfBits((halfValue(half) * 255) / alpha);
}

/** Texels of a rectangle of an opaque image: three components, and a fourth that is 1. */
export function opaqueTexels({ pixels, rect }: UnitPixels, part: Rect): Uint8Array | Uint16Array {
  const isHalf = pixels instanceof Uint16Array;
  const texels = isHalf ? new Uint16Array(4 * part[2] * part[3]) : new Uint8Array(4 * part[2] * part[3]);
  texels.fill(isHalf ? ONE_HALF_FLOAT : 255);
  forEachPixel(part, rect, (to, from) => {
    texels[4 * to] = pixels[3 * from];
    texels[4 * to + 1] = pixels[3 * from + 1];
    texels[4 * to + 2] = pixels[3 * from + 2];
  });
  return texels;
}

/** Texels of a rectangle that a unit of color and one of alpha share. Colors are not multiplied by alpha. */
export function alphaTexels(
  color: UnitPixels,
  alpha: UnitPixels,
  part: Rect,
  straight: Straight,
): Uint8Array | Uint16Array {
  const isHalf = color.pixels instanceof Uint16Array;
  const texels = isHalf ? new Uint16Array(4 * part[2] * part[3]) : new Uint8Array(4 * part[2] * part[3]);
  forEachPixel(part, alpha.rect, (to, from) => {
    const value = alpha.pixels[from];
    texels[4 * to + 3] = isHalf ? halfBits(value / 255) : value;
  });
  const alphas = texels.slice();
  forEachPixel(part, color.rect, (to, from) => {
    const value = isHalf ? Math.round(halfValue(alphas[4 * to + 3]) * 255) : alphas[4 * to + 3];
    for (let component = 0; component < 3; component += 1) {
      texels[4 * to + component] = straight(color.pixels[3 * from + component], value);
    }
  });
  return texels;
}

/** Visits the pixels of a part of an image: their numbers in the part, and in a unit that holds it. */
function forEachPixel([left, top, width, height]: Rect, unit: Rect, visit: (to: number, from: number) => void): void {
  for (let row = 0; row < height; row += 1) {
    const start = (top + row - unit[1]) * unit[2] + left - unit[0];
    for (let column = 0; column < width; column += 1) {
      visit(row * width + column, start + column);
    }
  }
}
