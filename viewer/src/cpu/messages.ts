// Messages between the page and the worker that renders.

import type { DepthRange, Rect, Vec3 } from "../format/types.ts";
import type { Axes } from "../math.ts";
import type { TexelMap } from "../views/face.ts";
import type { Counts } from "./marched_views.ts";
import type { MarchRequest } from "./marcher.ts";

/** A face whose texels are unknown at first. */
export interface FaceOutline {
  /** Its number. */
  face: number;
  size: [number, number];
  map: TexelMap;
  range: DepthRange;
  /** Codes are of distances, and not of planar depths. */
  isDistance: boolean;
}

/** A view of a picture, by its place in the catalogue. */
export interface PlacedView {
  view: number;
  fromEye: Vec3;
  turn: Axes;
  cameraWeight: number;
  nearM: number;
}

/** A rectangle of a face of a view. */
export interface FaceArea {
  view: number;
  face: number;
  rect: Rect;
}

export type Order =
  | { kind: "load"; view: number; faces: FaceOutline[]; isLight: boolean }
  | { kind: "unload"; view: number }
  /** Depth codes of a rectangle, row by row; without them it becomes unknown. */
  | { kind: "depth"; area: FaceArea; codes: Uint16Array | undefined }
  /** Four components of each texel: bytes, or bits of halves. */
  | { kind: "color"; area: FaceArea; texels: Uint8Array | Uint16Array }
  /** The same of an overlay: codes behind the curve of sRGB. */
  | { kind: "overlay"; area: FaceArea; texels: Uint8Array }
  /** A picture; `nearest` is the place among `views` of the one nearest to the eye. */
  | { kind: "render"; request: MarchRequest; views: PlacedView[]; nearest: number };

/** The answer to `render`. */
export interface Rendered {
  /** Linear light and alpha, row by row. */
  rgba: Float32Array;
  counts: Counts;
  /** Milliseconds. */
  ms: number;
}
