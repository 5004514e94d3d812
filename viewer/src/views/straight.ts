// Texels of color from decoded pixels: straight colors, where light was multiplied by alpha, and finite ones (formats/color.md 1 and 2).

import { decoder } from "../decoder/module.ts";
import type { UnitPixels } from "../decoder/types.ts";
import type { Rect } from "../format/types.ts";
import { type ColorCoding, codingNumber } from "./catalogue.ts";

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
