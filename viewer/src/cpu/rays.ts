// Where a ray from the eye meets a surface: RayIntersection of algorithm 4 (CALF 6), over segments that one view proves empty. Mirrors
// src/render/march/segments.rs and src/render/march/intersect.rs.

import { VIEW_FACE } from "../views/face.ts";
import { MIN_M, segmentsOf, type Steps } from "../views/active.ts";
import { UNKNOWN } from "./face_texels.ts";
import { AROUND_REACH, EMPTY, type MarchedView, type MarchedViews, OCCUPIED } from "./marched_views.ts";

/** Relative error of a position, and room for it. */
const ROUNDING = 2 ** -20;
const SURELY_BELOW_ONE = 1 - ROUNDING;

/** Rays from the eye. {@link x}, {@link y} and {@link z} are the direction, of length 1. */
export class Rays {
  x = 0;
  y = 0;
  z = 0;
  readonly #distancesM: Float32Array;
  readonly #segments: { longest: number; first: number };

  constructor(
    private readonly marched: MarchedViews,
    steps: Steps,
    private readonly refine: number,
  ) {
    this.#distancesM = steps.distancesM;
    this.#segments = segmentsOf(steps);
  }

  /** Whether a point of the ray is on or behind a surface. */
  isSurfaceAt(distanceM: number): boolean {
    return this.marched.isSurface(this.x * distanceM, this.y * distanceM, this.z * distanceM);
  }

  /** The distance in metres of the first surface from a step on, or -1. */
  intersectFrom(first: number): number {
    return this.refined(this.firstStep(first));
  }

  /** The distance of the surface that begins in the interval before a step, or -1 behind the last step. */
  refined(step: number): number {
    if (step >= this.#distancesM.length) {
      return -1;
    }
    let emptyM = step > 0 ? this.#distancesM[step - 1] : 0;
    let surfaceM = this.#distancesM[step];
    this.marched.counts.refine_steps += this.refine;
    for (let turn = 0; turn < this.refine; turn += 1) {
      const middleM = 0.5 * (emptyM + surfaceM);
      if (this.isSurfaceAt(middleM)) {
        surfaceM = middleM;
      } else {
        emptyM = middleM;
      }
    }
    return surfaceM;
  }

  /** The first step from `first` on at which marching ends, or the number of steps. */
  firstStep(first: number): number {
    const { marched } = this;
    const distancesM = this.#distancesM;
    const count = distancesM.length;
    const { longest, first: start } = this.#segments;
    const direction = Math.max(Math.abs(this.x), Math.abs(this.y), Math.abs(this.z));
    let at = first;
    // As long as one may be that begins here.
    let length = first === 0 ? start : Math.min(first & -first, start);
    // The last point that is empty in no view, and whether it is occupied in one.
    let blocked = count;
    let isSurfaceThere = false;
    while (at < count) {
      const last = Math.min(at + length, count) - 1;
      let isPassed = false;
      if (blocked === last) {
        // A segment that ends there is not empty: it is halved.
        if (last > at) {
          length /= 2;
        } else if (isSurfaceThere) {
          return at;
        } else {
          length = 1;
          isPassed = true;
        }
      } else {
        length = last === at ? 1 : length;
        marched.counts.march_steps += 1;
        let seesPast = false;
        let isBehind = false;
        for (let turn = 0; turn < marched.count && !isPassed; turn += 1) {
          const place = marched.placeOf(turn);
          const view = marched.views[place];
          const toM = distancesM[last];
          const says = marched.occupancy(view, this.x * toM, this.y * toM, this.z * toM);
          seesPast ||= says === EMPTY;
          isBehind ||= says === OCCUPIED;
          if (says === EMPTY && (at === last || this.#isEmpty(view, distancesM[at], toM, direction * toM))) {
            marched.remember(place);
            isPassed = true;
          }
        }
        if (!isPassed && !seesPast) {
          blocked = last;
          isSurfaceThere = isBehind || marched.untilUnknown;
        }
        if (!isPassed && last > at) {
          length /= 2;
        }
      }
      if (isPassed) {
        at += length;
        if (at % (2 * length) === 0 && length < longest) {
          length *= 2;
        }
      }
    }
    return count;
  }

  /** Whether a view proves that a segment is empty. Its last point is the one whose face `marched` holds. */
  #isEmpty(view: MarchedView, fromM: number, toM: number, reachM: number): boolean {
    const { marched } = this;
    const fromX = view.fromEye[0];
    const fromY = view.fromEye[1];
    const fromZ = view.fromEye[2];
    const errorM = ROUNDING * (reachM + Math.max(Math.abs(fromX), Math.abs(fromY), Math.abs(fromZ))) + MIN_M;
    marched.turn(view, this.x * toM - fromX, this.y * toM - fromY, this.z * toM - fromZ);
    let allM = Math.max(Math.abs(marched.localX), Math.abs(marched.localY), Math.abs(marched.localZ));
    const hasTo = marched.findFace(view);
    const { face, faceNumber, planeX, planeY, planarM } = marched;
    marched.turn(view, this.x * fromM - fromX, this.y * fromM - fromY, this.z * fromM - fromZ);
    allM = Math.max(allM, Math.abs(marched.localX), Math.abs(marched.localY), Math.abs(marched.localZ));
    if (view.greatest * (allM + 2 * errorM) < SURELY_BELOW_ONE) {
      return true;
    }
    const hasFrom = marched.findFace(view);
    const nearestM = Math.min(planarM, marched.planarM);
    const farthestM = Math.max(planarM, marched.planarM) + 2 * errorM;
    if (!hasTo || !hasFrom || face === undefined || marched.faceNumber !== faceNumber || nearestM < 4 * errorM) {
      return false;
    }
    const oneX = marched.planeX / marched.planarM;
    const oneY = marched.planeY / marched.planarM;
    const twoX = planeX / planarM;
    const twoY = planeY / planarM;
    const widest = Math.max(Math.abs(oneX), Math.abs(oneY), Math.abs(twoX), Math.abs(twoY));
    const slack = (1 + widest) * ((4 * errorM) / nearestM + ROUNDING);
    const isView = faceNumber === VIEW_FACE;
    if (!isView && widest + slack > 1) {
      return false;
    }
    const { width, height, map } = face;
    const scaleX = map.scale[0];
    const scaleY = map.scale[1];
    const marginX = slack * Math.abs(scaleX) + width * ROUNDING;
    const marginY = slack * Math.abs(scaleY) + height * ROUNDING;
    const left = Math.min(oneX * scaleX, twoX * scaleX) + map.center[0] - marginX;
    const right = Math.max(oneX * scaleX, twoX * scaleX) + map.center[0] + marginX;
    const top = Math.min(oneY * scaleY, twoY * scaleY) + map.center[1] - marginY;
    const bottom = Math.max(oneY * scaleY, twoY * scaleY) + map.center[1] + marginY;
    if (isView && !(left >= 0 && top >= 0 && right < width && bottom < height)) {
      return false;
    }
    const greatest = face.greatestBetween(
      Math.min(Math.max(left - AROUND_REACH, 0), width - 1) | 0,
      Math.min(Math.max(top - AROUND_REACH, 0), height - 1) | 0,
      Math.min(Math.max(right + AROUND_REACH, 0), width - 1) | 0,
      Math.min(Math.max(bottom + AROUND_REACH, 0), height - 1) | 0,
    );
    return greatest !== UNKNOWN && greatest * farthestM < SURELY_BELOW_ONE;
  }
}
