// Texels of color from decoded pixels: straight colors, where light was multiplied by alpha, and finite ones. Mirrors src/render/views/straight.rs
// and what src/render/views/face_cache.rs does with colors (formats/color.md 1 and 2).

import type { Pixels } from "../decoder/types.ts";
import type { Rect } from "../format/types.ts";
import type { ColorCoding } from "./catalogue.ts";

/** Decoded pixels of a unit, row by row, and its rectangle in the image. */
export interface UnitPixels {
  pixels: Pixels;
  rect: Rect;
}

const LARGEST_HALF = 0x7bff;

/** The number of a half float's bit pattern. */
export function halfValue(bits: number): number {
  const sign = bits & 0x8000 ? -1 : 1;
  const [exponent, fraction] = [(bits >> 10) & 31, bits & 1023];
  if (exponent === 31) {
    return fraction === 0 ? sign * Infinity : NaN;
  }
  return sign * (exponent === 0 ? fraction * 2 ** -24 : (1024 + fraction) * 2 ** (exponent - 25));
}

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

/** Light as the device is given it: 0 for what is not a number, and the largest half for infinities. */
function finiteHalf(bits: number): number {
  const size = bits & 0x7fff;
  if (size < 0x7c00) {
    return bits;
  }
  return size > 0x7c00 ? 0 : (bits & 0x8000) | LARGEST_HALF;
}

function straightHalf(bits: number, alpha: number): number {
  if (alpha === 1) {
    return bits;
  }
  return alpha > 0 ? halfBits(Math.fround(halfValue(bits) / Math.fround(alpha))) : 0;
}

/** Light of an 8-bit code behind a curve, with no exposure. */
export function lightOf(code: number, transfer: "srgb" | "linear"): number {
  const value = code / 255;
  if (transfer === "linear") {
    return value;
  }
  return value <= 0.04045 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4;
}

function codeOf(light: number, transfer: "srgb" | "linear"): number {
  const curved = light <= 0.0031308 ? light * 12.92 : 1.055 * light ** (1 / 2.4) - 0.055;
  return Math.min(Math.round((transfer === "linear" ? light : curved) * 255), 255);
}

/** The straight codes of 8-bit colors: by alpha in 255ths, then by code. */
function straightCodes(transfer: "srgb" | "linear"): Uint8Array {
  const codes = new Uint8Array(1 << 16);
  for (let alpha = 1; alpha < 256; alpha += 1) {
    for (let code = 0; code < 256; code += 1) {
      codes[alpha * 256 + code] = alpha === 255 ? code : codeOf((lightOf(code, transfer) * 255) / alpha, transfer);
    }
  }
  return codes;
}

/** Makes texels of four components, as textures hold them: bytes, or halves of light. */
export class ColorTexels {
  readonly #codes: Uint8Array | undefined;

  /** For colors of a coding; `hasAlpha` where some have alpha. */
  constructor(coding: ColorCoding, hasAlpha: boolean) {
    this.#codes = coding.name === "codes" && hasAlpha ? straightCodes(coding.transfer) : undefined;
  }

  /** Texels of a rectangle that lies within a unit of color, and within one of alpha where there is alpha. */
  of(color: UnitPixels, rect: Rect, alpha?: UnitPixels): Uint8Array | Uint16Array {
    const [left, top, width, height] = rect;
    const isHalf = color.pixels instanceof Uint16Array;
    const texels = isHalf ? new Uint16Array(4 * width * height) : new Uint8Array(4 * width * height);
    for (let row = 0; row < height; row += 1) {
      let from = 3 * ((top + row - color.rect[1]) * color.rect[2] + left - color.rect[0]);
      let under = alpha && (top + row - alpha.rect[1]) * alpha.rect[2] + left - alpha.rect[0];
      for (let at = 4 * row * width; at < 4 * (row + 1) * width; at += 4) {
        const byte = alpha && under !== undefined ? Math.min(alpha.pixels[under++], 255) : 255;
        for (let channel = 0; channel < 3; channel += 1) {
          const value = color.pixels[from++];
          if (isHalf) {
            texels[at + channel] = straightHalf(finiteHalf(value), byte / 255);
          } else {
            texels[at + channel] = this.#codes?.[byte * 256 + value] ?? value;
          }
        }
        texels[at + 3] = isHalf ? halfBits(byte / 255) : byte;
      }
    }
    return texels;
  }
}
