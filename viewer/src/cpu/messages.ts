// Messages between the page and the worker that renders.

import type { DepthRange, Probe, Rect } from "../format/types.ts";
import type { Camera } from "../views/camera.ts";
import type { ColorCoding } from "../views/catalogue.ts";
import type { TexelMap } from "../views/face.ts";

/** The first message. */
export interface FieldSettings {
  module: WebAssembly.Module;
  /** Of the film's colors. */
  coding: ColorCoding;
}

/** A face whose texels are unknown at first. */
export interface FaceOutline {
  /** Its number. */
  face: number;
  size: [number, number];
  map: TexelMap;
  range: DepthRange;
  /** Codes are of distances, and not of planar depths. */
  isDistance: boolean;
  hasAlpha: boolean;
  hasMaterial: boolean;
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
  | { kind: "load"; view: number; nearM: number; farM: number; faces: FaceOutline[] }
  | { kind: "unload"; view: number }
  /** Depth codes of a rectangle, row by row; without them it becomes unknown. */
  | { kind: "depth"; area: FaceArea; codes: Uint16Array | undefined }
  /** Four components of each texel: bytes, or bits of halves. */
  | { kind: "color"; area: FaceArea; texels: Uint8Array | Uint16Array }
  /** Three bytes of each texel. */
  | { kind: "material"; area: FaceArea; texels: Uint8Array }
  /** Four bytes of each texel: codes behind the curve of sRGB, and one that counts for nothing. */
  | { kind: "overlay"; area: FaceArea; texels: Uint8Array }
  /** A picture of views, the nearest to the eye first. */
  | { kind: "render"; request: PictureRequest; views: PlacedView[] };

/** Counts of a picture, by the names of `lightfold render --stats`. */
export const COUNTS = [
  "primary_rays",
  "march_steps",
  "refine_steps",
  "secondary_rays",
  "normal_evals",
  "material_samples",
  "hole_rays",
  "background_rays",
] as const;
export type Counts = Record<(typeof COUNTS)[number], number>;

/** The answer to `render`. */
export interface Rendered {
  /** Linear light and alpha, row by row. */
  rgba: Float32Array;
  counts: Counts;
  /** Milliseconds. */
  ms: number;
}
