// Frusta, and whether a camera sees one. Mirrors src/codec/math/frustum.rs, separation.rs and sight.rs (CALF 6.2), for frusta that end nowhere:
// what can be seen of a unit begins at near, and has no far end.

import type { Vec3 } from "../format/types.ts";
import type { Axes } from "../math.ts";
import { add, cross, distance, dot, length, normalize, scale, subtract } from "../math.ts";

/** A rectangle on the plane at distance 1 before the tip: `forward + u * right + v * down`. */
export interface PlaneWindow {
  u: readonly [number, number];
  v: readonly [number, number];
}

type Four = readonly [Vec3, Vec3, Vec3, Vec3];

/** A frustum from `nearM` metres along its axis to infinity, with what tests need. */
export interface Frustum {
  apex: Vec3;
  /** Forward, right, down. */
  axes: Axes;
  window: PlaneWindow;
  nearM: number;
  /** Directions of the four edges, of planar depth 1, in order around the frustum. */
  corners: Four;
  /** The same with length 1. */
  rays: Four;
  /** Normals of the four sides, of length 1, pointing inwards. */
  sides: Four;
  /** Length of the longest of `corners`. */
  reach: number;
}

/** Limit of lengths in calculations. */
const MAX_LENGTH = 1e100;
/** Directions within this angle of the camera's count as visible, in radians. It also bounds the intersection of two frusta to 1 / MARGIN
 *  times the distance of their tips. */
const MARGIN = 1e-7;
/** Gaps up to this part of all lengths involved may be rounding. */
const SLACK = 1e-13;
/** Cosines up to this may be rounding. */
const COSINE_SLACK = 1e-14;

/** A frustum; numbers that are not finite make one that all tests take for seen. */
export function frustum(apex: Vec3, axes: Axes, window: PlaneWindow, nearM: number): Frustum {
  const [forward, right, down] = axes;
  const [[left, farRight], [top, bottom]] = [window.u, window.v];
  const corner = (u: number, v: number): Vec3 => add(add(forward, scale(right, u)), scale(down, v));
  const corners: Four = [corner(left, top), corner(farRight, top), corner(farRight, bottom), corner(left, bottom)];
  const rays = corners.map(normalize) as unknown as Four;
  const sides: Four = [
    normalize(subtract(down, scale(forward, top))),
    normalize(subtract(scale(forward, farRight), right)),
    normalize(subtract(scale(forward, bottom), down)),
    normalize(subtract(right, scale(forward, left))),
  ];
  const reach = corners.reduce((longest, one) => Math.max(longest, length(one)), 0);
  return { apex, axes, window, nearM, corners, rays, sides, reach };
}

/** Whether tests are reliable. */
function isSound({ apex, axes, rays, sides, reach, nearM }: Frustum): boolean {
  const isUnit = (vector: Vec3): boolean => Math.abs(length(vector) - 1) < 1e-6;
  const isFinite = apex.every((value) => Number.isFinite(value)) && reach < MAX_LENGTH;
  return isFinite && [...axes, ...rays, ...sides].every(isUnit) && nearM >= 0 && nearM < MAX_LENGTH;
}

function containsDirection({ sides }: Frustum, direction: Vec3): boolean {
  return sides.every((side) => dot(side, direction) >= 0);
}

/** The same with a window that contains all directions within `angle` radians of its own; `undefined` where it is nearly a half space. */
function widened({ apex, axes, window, nearM, reach }: Frustum, angle: number): Frustum | undefined {
  const step = 2 * angle * reach * reach;
  if (!(step <= 0.2 * reach)) {
    return undefined;
  }
  const wider = ([low, high]: readonly [number, number]): [number, number] => [low - step, high + step];
  return frustum(apex, axes, { u: wider(window.u), v: wider(window.v) }, nearM);
}

/** The cross product with length 1; `undefined` where that is none. */
function normalOf(edge: Vec3, other: Vec3): Vec3 | undefined {
  const normal = cross(edge, other);
  const by = 1 / length(normal);
  return Number.isFinite(by) && by > 0 ? scale(normal, by) : undefined;
}

/** Whether no direction of `a` is one of `b`, but for those on the boundary of both. */
function directionsApart(a: Frustum, b: Frustum): boolean {
  const before = (normal: Vec3, rays: Four): boolean => rays.every((ray) => dot(normal, ray) >= -COSINE_SLACK);
  const behind = (normal: Vec3, rays: Four): boolean => rays.every((ray) => dot(normal, ray) <= COSINE_SLACK);
  if (a.sides.some((side) => behind(side, b.rays)) || b.sides.some((side) => behind(side, a.rays))) {
    return true;
  }
  const across = (edge: Vec3, other: Vec3): boolean => {
    const normal = normalOf(edge, other);
    return (
      normal !== undefined &&
      ((before(normal, a.rays) && behind(normal, b.rays)) || (behind(normal, a.rays) && before(normal, b.rays)))
    );
  };
  return a.rays.some((edge) => b.rays.some((other) => across(edge, other)));
}

/** Least and greatest product with `axis` of the points of a frustum, seen from its tip, up to `farM`. */
function extent({ corners, nearM }: Frustum, axis: Vec3, farM: number): [number, number] {
  const near = Math.min(nearM, farM);
  let [low, high] = [Infinity, -Infinity];
  for (const corner of corners) {
    const product = dot(corner, axis);
    low = Math.min(low, product);
    high = Math.max(high, product);
  }
  return [low * (low < 0 ? farM : near), high * (high < 0 ? near : farM)];
}

/** Whether no point of `a` is one of `b`, each up to `farM` metres along its axis. */
function volumesApart(a: Frustum, b: Frustum, farM: number): boolean {
  const offset = subtract(b.apex, a.apex);
  const size = farM * a.reach + farM * b.reach + length(offset) + length(a.apex) + length(b.apex);
  if (!(size <= MAX_LENGTH)) {
    return false;
  }
  const slack = SLACK * size;
  const isApart = (axis: Vec3): boolean => {
    const [aLow, aHigh] = extent(a, axis, farM);
    const [bLow, bHigh] = extent(b, axis, farM);
    const shift = dot(offset, axis);
    return bLow + shift - aHigh > slack || aLow - bHigh - shift > slack;
  };
  const normals = ({ axes, sides }: Frustum): Vec3[] => [axes[0], ...sides];
  const edges = ({ axes, rays }: Frustum): Vec3[] => [axes[1], axes[2], ...rays];
  if (normals(a).some(isApart) || normals(b).some(isApart)) {
    return true;
  }
  const others = edges(b);
  return edges(a).some((edge) =>
    others.some((other) => {
      const axis = normalOf(edge, other);
      return axis !== undefined && isApart(axis);
    }),
  );
}

/** What a viewer sees of a frustum: nothing for certain; perhaps a part; all its directions. */
export type Sight = "missed" | "partly" | "inside";

/** A camera's frustum, prepared for many comparisons. */
export class Viewer {
  readonly #frustum: Frustum;
  /** Widened by the margin; none where it is nearly a half space. */
  readonly #wide: Frustum | undefined;

  constructor(volume: Frustum) {
    this.#frustum = volume;
    this.#wide = isSound(volume) ? widened(volume, MARGIN) : undefined;
  }

  /** Visibility of a frustum and of the background behind it. */
  sight(volume: Frustum): Sight {
    if (this.#wide === undefined || !isSound(volume)) {
      return "partly";
    }
    if (volume.rays.every((ray) => containsDirection(this.#frustum, ray))) {
      return "inside";
    }
    return !directionsApart(this.#wide, volume) || !this.#isApart(volume) ? "partly" : "missed";
  }

  /** Whether no point is shared, where no direction is. */
  #isApart(volume: Frustum): boolean {
    const betweenM = distance(this.#frustum.apex, volume.apex);
    // With one tip, other directions are enough.
    return betweenM === 0 || volumesApart(this.#frustum, volume, (2 * betweenM) / MARGIN);
  }
}
