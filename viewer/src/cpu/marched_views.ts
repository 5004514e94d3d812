// The views that are marched: where points lie in their images, and whether they see past them (CALF 6, algorithm 4). Mirrors
// src/render/march/active_views.rs and View::project of src/render/views/light_field.rs.
//
// Points are in metres from the eye, along the axes of the world. Numbers of a point are written to fields and not returned: a picture
// projects some millions of points.

import type { Axes } from "../math.ts";
import { VIEW_FACE } from "../views/face.ts";
import { type FaceTexels, UNKNOWN } from "./face_texels.ts";

/** How far texels that decide about a point reach beyond the one that contains it, in texels. */
export const AROUND_REACH = 0.5 - 1 / 64;
/** Squares of lengths that are no greater are those of no direction. */
const MIN_SQUARED = 2 ** -126;
/** Planar depths that are less have no inverse. */
const MIN_DEPTH_M = 1e-37;

/** What a view says about a point. */
export const EMPTY = 0;
export const OCCUPIED = 1;
const NOT_KNOWN = 2;

/** A view, relative to the eye. */
export interface MarchedView {
  /** Metres, along the axes of the world. */
  fromEye: readonly [number, number, number];
  /** The columns of the matrix that turns directions of the world into those of the probe. */
  turn: Axes;
  cameraWeight: number;
  /** No surface is nearer, in metres. */
  nearM: number;
  /** By their numbers. */
  faces: readonly (FaceTexels | undefined)[];
  /** Of all texels; {@link UNKNOWN} where a direction has none. */
  greatest: number;
}

/** Counts of a picture, by the names of `lightfold render --stats`. */
export interface Counts {
  primary_rays: number;
  march_steps: number;
  refine_steps: number;
  hole_rays: number;
  background_rays: number;
}

export class MarchedViews {
  readonly counts: Counts = {
    primary_rays: 0,
    march_steps: 0,
    refine_steps: 0,
    hole_rays: 0,
    background_rays: 0,
  };
  /** The place of the single view that is marched, or -1. */
  alone = -1;
  /** Whether marching also ends where no view sees past a point, though none knows a surface there. */
  untilUnknown = false;
  /** The last view that found a point empty is tested first. */
  emptyView = 0;

  /** Of the last direction or point: along the axes of the probe. */
  localX = 0;
  localY = 0;
  localZ = 0;
  /** Of the last point in front of a face: the face, (u, v) times the planar depth, and the planar depth in metres. */
  face: FaceTexels | undefined;
  faceNumber = 0;
  planeX = 0;
  planeY = 0;
  planarM = 0;
  /** Of the last projected point: its position in the image in texels, and the inverse of its planar depth. */
  x = 0;
  y = 0;
  inverseDepth = 0;

  /** `nearest` is the place of the view nearest to the eye; `isLight` where colors are light, and not 8-bit codes. */
  constructor(
    readonly views: readonly MarchedView[],
    readonly nearest: number,
    readonly isLight: boolean,
  ) {}

  /** Turns a direction of the world into one of a probe: {@link localX} and so on. */
  turn(view: MarchedView, x: number, y: number, z: number): void {
    const a = view.turn[0];
    const b = view.turn[1];
    const c = view.turn[2];
    this.localX = a[0] * x + b[0] * y + c[0] * z;
    this.localY = a[1] * x + b[1] * y + c[1] * z;
    this.localZ = a[2] * x + b[2] * y + c[2] * z;
  }

  /** Finds the face that the local direction meets: {@link face} and so on. Answers whether there is one. */
  findFace(view: MarchedView): boolean {
    const x = this.localX;
    const y = this.localY;
    const z = this.localZ;
    if (view.faces[VIEW_FACE] !== undefined) {
      this.faceNumber = VIEW_FACE;
      this.face = view.faces[VIEW_FACE];
      this.planeX = x;
      this.planeY = -y;
      this.planarM = -z;
      return z < 0;
    }
    const sizeX = Math.abs(x);
    const sizeY = Math.abs(y);
    const sizeZ = Math.abs(z);
    if (sizeX >= sizeY && sizeX >= sizeZ) {
      this.faceNumber = x < 0 ? 1 : 0;
      this.planeX = x < 0 ? z : -z;
      this.planeY = -y;
      this.planarM = sizeX;
    } else if (sizeY >= sizeZ) {
      this.faceNumber = y < 0 ? 3 : 2;
      this.planeX = x;
      this.planeY = y < 0 ? -z : z;
      this.planarM = sizeY;
    } else {
      this.faceNumber = z < 0 ? 5 : 4;
      this.planeX = z < 0 ? -x : x;
      this.planeY = -y;
      this.planarM = sizeZ;
    }
    this.face = view.faces[this.faceNumber];
    return this.face !== undefined;
  }

  /** Projects the local direction into an image: {@link x}, {@link y} and {@link inverseDepth}. Answers whether it lies in one. */
  project(view: MarchedView): boolean {
    if (!this.findFace(view) || this.planarM < MIN_DEPTH_M) {
      return false;
    }
    const { map, width, height } = this.face!;
    const inverse = 1 / this.planarM;
    this.inverseDepth = inverse;
    this.x = this.planeX * inverse * map.scale[0] + map.center[0];
    this.y = this.planeY * inverse * map.scale[1] + map.center[1];
    return this.faceNumber !== VIEW_FACE || (this.x >= 0 && this.y >= 0 && this.x < width && this.y < height);
  }

  /** Projects a point. */
  projectPoint(view: MarchedView, x: number, y: number, z: number): boolean {
    const { fromEye } = view;
    this.turn(view, x - fromEye[0], y - fromEye[1], z - fromEye[2]);
    return this.project(view);
  }

  /** What a view says about a point: {@link EMPTY}, {@link OCCUPIED} or {@link NOT_KNOWN}. */
  occupancy(view: MarchedView, x: number, y: number, z: number): number {
    const isProjected = this.projectPoint(view, x, y, z);
    const squared = this.localX * this.localX + this.localY * this.localY + this.localZ * this.localZ;
    const isNear = squared < view.nearM * view.nearM;
    if (!isProjected) {
      // The center itself has no direction.
      return isNear && squared <= MIN_SQUARED ? EMPTY : NOT_KNOWN;
    }
    // Within near, whatever the texels say.
    if (isNear) {
      return EMPTY;
    }
    const surface = this.#greatestAround();
    if (surface === UNKNOWN) {
      return NOT_KNOWN;
    }
    return surface < this.inverseDepth ? EMPTY : OCCUPIED;
  }

  /** The greatest inverse depth of the texels that decide about the projected point. */
  #greatestAround(): number {
    const { width, height, inverseDepths } = this.face!;
    const left = Math.min(Math.max(this.x - AROUND_REACH, 0), width - 1) | 0;
    const right = Math.min(Math.max(this.x + AROUND_REACH, 0), width - 1) | 0;
    const top = Math.min(Math.max(this.y - AROUND_REACH, 0), height - 1) | 0;
    const bottom = Math.min(Math.max(this.y + AROUND_REACH, 0), height - 1) | 0;
    let greatest = inverseDepths[top * width + left];
    if (right !== left) {
      greatest = Math.max(greatest, inverseDepths[top * width + right]);
    }
    if (bottom !== top) {
      greatest = Math.max(greatest, inverseDepths[bottom * width + left]);
      if (right !== left) {
        greatest = Math.max(greatest, inverseDepths[bottom * width + right]);
      }
    }
    return greatest;
  }

  /** How many views are marched. */
  get count(): number {
    return this.alone < 0 ? this.views.length : 1;
  }

  /** The place of the view of a turn: the last one that found a point empty has changed places with the first. */
  placeOf(turn: number): number {
    if (this.alone >= 0) {
      return this.alone;
    }
    return turn === 0 ? this.emptyView : turn === this.emptyView ? 0 : turn;
  }

  /** Whether a point is in no view empty, and in one occupied. */
  isSurface(x: number, y: number, z: number): boolean {
    let isBehind = false;
    for (let turn = 0; turn < this.count; turn += 1) {
      const place = this.placeOf(turn);
      const says = this.occupancy(this.views[place], x, y, z);
      if (says === EMPTY) {
        this.remember(place);
        return false;
      }
      isBehind ||= says === OCCUPIED;
    }
    return isBehind || this.untilUnknown;
  }

  /** A view has found a point empty. */
  remember(place: number): void {
    this.emptyView = this.alone < 0 ? place : this.emptyView;
  }
}
