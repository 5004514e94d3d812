// Texels of color from decoded pixels: straight colors, where light was multiplied by alpha, and finite ones (formats/color.md 1 and 2).

import { decoder } from "../decoder/module.ts";
import type { UnitPixels } from "../decoder/types.ts";
import type { Rect } from "../format/types.ts";
import { type ColorCoding, codingNumber } from "./catalogue.ts";

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

/** Light of an 8-bit code behind a curve, with no exposure. */
export function lightOf(code: number, transfer: "srgb" | "linear"): number {
  const value = code / 255;
  if (transfer === "linear") {
    return value;
  }
  return value <= 0.04045 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4;
}

/** Texels of four components, as textures hold them, of a rectangle that lies within a unit of color, and within one of alpha where there
 *  is alpha: bytes, or halves of light. */
export function colorTexels(
  coding: ColorCoding,
  color: UnitPixels,
  rect: Rect,
  alpha?: UnitPixels,
): Uint8Array | Uint16Array {
  const bytes = decoder().straightTexels(codingNumber(coding), color, rect, alpha);
  return coding.name === "light" ? new Uint16Array(bytes.buffer) : bytes;
}
