// The texels of loaded views, wherever they lie. Views are numbered as in the catalogue, streams as in the container.

import type { Rect } from "../format/types.ts";
import type { UnitFilter } from "./known_units.ts";

export interface Texels {
  /** Frees the texels of a view. */
  unload(view: number): void;
  /** Whether a unit has a picture that may be seen. */
  isKnown(stream: number, unit: number): boolean;
  /** Takes in that a unit has a new picture: where it was decoded, or all of its texels were uploaded. */
  written(stream: number, unit: number): void;
  /** Takes in that a unit shows nothing that may be seen: its texels become unknown until it is written again. */
  forget(stream: number, unit: number): void;
  /** Sends texels of a rectangle of a color stream, row by row: those of `colorTexels`. */
  uploadColor(stream: number, rect: Rect, texels: Uint8Array | Uint16Array): void;
  /** Sends the pixels of a unit of material, three bytes each, and takes in that it is written. */
  uploadMaterial(stream: number, unit: number, pixels: Uint8Array): void;
  /** Whether a unit of material of a view that passes the filter has a weight above 0. */
  isSpecular(view: number, passes: UnitFilter): boolean;
  /** Brings the texels to what was written. */
  update(): void;
}
