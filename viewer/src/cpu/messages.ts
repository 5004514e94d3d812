// Messages between the page and the worker that renders.

import type { Probe, Rect } from "../format/types.ts";
import type { Camera } from "../views/camera.ts";
import type { ColorCoding } from "../views/catalogue.ts";
import type { Counts } from "../views/counts.ts";

/** The first message. */
export interface FieldSettings {
  module: WebAssembly.Module;
  /** Of the film's colors. */
  coding: ColorCoding;
}

/** A view of a picture, by its place in the catalogue, and its pose in the frame. */
export interface PlacedView extends Pick<Probe, "position" | "orientation"> {
  view: number;
}

/** A rectangle of a face of a view. */
export interface FaceArea {
  view: number;
  face: number;
  rect: Rect;
}

/** What a picture is rendered with. */
export interface PictureRequest {
  camera: Camera;
  /** Width and height in pixels. */
  size: readonly [number, number];
  /** Steps of a ray. */
  steps: number;
  /** Whether colors are those of the overlay. */
  showsOverlay: boolean;
  /** Whether pixels whose surface no probe saw have an alpha of 0; else they show what was seen behind. */
  marksHoles: boolean;
}

export type Order =
  /** A view whose texels are unknown at first, as numbers of `PictureField::load` (src/wasm/picture.rs). */
  | { kind: "load"; view: number; numbers: Float64Array }
  | { kind: "unload"; view: number }
  /** Depth codes of a rectangle, row by row; without them it becomes unknown. */
  | { kind: "depth"; area: FaceArea; codes: Uint16Array | undefined }
  /** Four components of each texel of color: bytes, or bits of halves. Three bytes of material. Four bytes of an overlay: codes behind the
   *  curve of sRGB, and one that counts for nothing. */
  | { kind: "color" | "material" | "overlay"; area: FaceArea; texels: Uint8Array | Uint16Array }
  /** A picture of views, the nearest to the eye first. */
  | { kind: "render"; request: PictureRequest; views: PlacedView[] };

/** The answer to `render`. */
export interface Rendered {
  /** Linear light and alpha, row by row. */
  rgba: Float32Array;
  counts: Counts;
  /** Milliseconds. */
  ms: number;
}
