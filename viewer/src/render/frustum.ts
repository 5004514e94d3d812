// Frusta, and whether one can be seen from another (CALF 6.2). Mirrors src/math/{frustum,sight,separation}.rs.

import type { Vec3 } from "../format/types.ts";
import { add, cross, dot, length, normalized, scaled, subtract } from "./vectors.ts";

/** A rectangle on the plane at distance 1 before the tip: forward + u right + v down. */
export interface Window {
  u: [number, number];
  v: [number, number];
}

/** Limit of lengths in calculations. */
const MAX_LENGTH = 1e100;
/** Directions within this angle of a camera's count as visible, in radians. */
const MARGIN = 1e-7;
/** Gaps up to this part of all lengths involved may be rounding. */
const SLACK = 1e-13;
/** Cosines up to this may be rounding. */
const COSINE_SLACK = 1e-14;

/** A tip, its axes forward, right and down, a window, and where along forward it begins and ends in metres. Where its numbers are not
 *  finite it is unsound, and can be seen from anywhere. */
export class Frustum {
  /** Directions of the four edges, of planar depth 1, in order around. */
  readonly corners: readonly Vec3[];
  /** The same with length 1. */
  readonly rays: readonly Vec3[];
  /** Normals of the four sides, of length 1, inwards. */
  readonly sides: readonly Vec3[];
  /** Length of the longest corner. */
  readonly reach: number;
  readonly isSound: boolean;

  constructor(
    readonly apex: Vec3,
    readonly axes: readonly [Vec3, Vec3, Vec3],
    readonly window: Window,
    readonly depthM: readonly [number, number],
  ) {
    const [forward, right, down] = axes;
    const {
      u: [left, farRight],
      v: [top, bottom],
    } = window;
    const corner = (u: number, v: number): Vec3 => add(forward, add(scaled(right, u), scaled(down, v)));
    this.corners = [corner(left, top), corner(farRight, top), corner(farRight, bottom), corner(left, bottom)];
    const sides = [
      subtract(down, scaled(forward, top)),
      subtract(scaled(forward, farRight), right),
      subtract(scaled(forward, bottom), down),
      subtract(right, scaled(forward, left)),
    ];
    const rays = this.corners.map(normalized);
    const normals = sides.map(normalized);
    const isUnit = (a: Vec3 | undefined): a is Vec3 => a !== undefined && Math.abs(length(a) - 1) < 1e-6;
    this.reach = Math.max(...this.corners.map(length));
    const [near, far] = depthM;
    const areFinite = apex.every(Number.isFinite) && this.reach < MAX_LENGTH;
    this.isSound =
      areFinite && near >= 0 && near < MAX_LENGTH && near <= far && [...axes, ...rays, ...normals].every(isUnit);
    this.rays = rays.map((ray) => ray ?? [0, 0, 0]);
    this.sides = normals.map((side) => side ?? [0, 0, 0]);
  }

  hasDirection(direction: Vec3): boolean {
    return this.sides.every((side) => dot(side, direction) >= 0);
  }

  /** With a window that has all directions within `angle` radians of its own; `undefined` where it is nearly a half space. */
  widened(angle: number): Frustum | undefined {
    const step = 2 * angle * this.reach * this.reach;
    if (!(step <= 0.2 * this.reach)) {
      return undefined;
    }
    const wide = ([low, high]: [number, number]): [number, number] => [low - step, high + step];
    return new Frustum(this.apex, this.axes, { u: wide(this.window.u), v: wide(this.window.v) }, this.depthM);
  }
}

/** What a camera sees of a frustum and of the background behind it. "missed" is certain; "inside": all its directions. */
export type Sight = "missed" | "partly" | "inside";

/** A camera's frustum, for many comparisons. */
export class Viewer {
  readonly #wide: Frustum | undefined;

  constructor(readonly frustum: Frustum) {
    this.#wide = frustum.isSound ? frustum.widened(MARGIN) : undefined;
  }

  sight(volume: Frustum): Sight {
    if (this.#wide === undefined || !volume.isSound) {
      return "partly";
    }
    if (volume.rays.every((ray) => this.frustum.hasDirection(ray))) {
      return "inside";
    }
    return directionsApart(this.#wide, volume) && this.#isApart(volume) ? "missed" : "partly";
  }

  /** Whether no point is shared, where no direction is. */
  #isApart(volume: Frustum): boolean {
    const betweenM = length(subtract(this.frustum.apex, volume.apex));
    if (betweenM === 0) {
      return true;
    }
    const [viewerM, volumeM] = [this.frustum, volume].map(({ depthM, reach }) => depthM[1] * reach);
    let farM: [number, number] = [this.frustum.depthM[1], volume.depthM[1]];
    if (viewerM === Infinity && volumeM === Infinity) {
      farM = [(2 * betweenM) / MARGIN, (2 * betweenM) / MARGIN];
    } else if (viewerM === Infinity) {
      farM = [volumeM + betweenM, volume.depthM[1]];
    } else if (volumeM === Infinity) {
      farM = [this.frustum.depthM[1], viewerM + betweenM];
    }
    return volumesApart(this.frustum, volume, farM);
  }
}

/** Whether no direction of `a` is one of `b`, but for those on the boundary of both. */
function directionsApart(a: Frustum, b: Frustum): boolean {
  const isBefore = (normal: Vec3, rays: readonly Vec3[]): boolean =>
    rays.every((ray) => dot(normal, ray) >= -COSINE_SLACK);
  const isBehind = (normal: Vec3, rays: readonly Vec3[]): boolean =>
    rays.every((ray) => dot(normal, ray) <= COSINE_SLACK);
  if (a.sides.some((side) => isBehind(side, b.rays)) || b.sides.some((side) => isBehind(side, a.rays))) {
    return true;
  }
  return a.rays.some((edge) =>
    b.rays.some((other) => {
      const normal = normalized(cross(edge, other));
      return (
        normal !== undefined &&
        ((isBefore(normal, a.rays) && isBehind(normal, b.rays)) ||
          (isBehind(normal, a.rays) && isBefore(normal, b.rays)))
      );
    }),
  );
}

/** Whether no point of `a`, up to `farM[0]` metres along its axis, is one of `b`, up to `farM[1]`. */
function volumesApart(a: Frustum, b: Frustum, farM: [number, number]): boolean {
  const offset = subtract(b.apex, a.apex);
  const size = farM[0] * a.reach + farM[1] * b.reach + length(offset) + length(a.apex) + length(b.apex);
  if (!(size <= MAX_LENGTH)) {
    return false;
  }
  const slack = SLACK * size;
  const isApart = (axis: Vec3): boolean => {
    const [aLow, aHigh] = extent(a, axis, farM[0]);
    const [bLow, bHigh] = extent(b, axis, farM[1]);
    const shift = dot(offset, axis);
    return bLow + shift - aHigh > slack || aLow - bHigh - shift > slack;
  };
  if ([a, b].some(({ axes, sides }) => [axes[0], ...sides].some(isApart))) {
    return true;
  }
  const edges = ({ axes, rays }: Frustum): Vec3[] => [axes[1], axes[2], ...rays];
  const bEdges = edges(b);
  return edges(a).some((edge) =>
    bEdges.some((other) => {
      const axis = normalized(cross(edge, other));
      return axis !== undefined && isApart(axis);
    }),
  );
}

/** Least and greatest product with `axis` of the points of a frustum, seen from its tip, up to `farM`. */
function extent({ depthM, corners }: Frustum, axis: Vec3, farM: number): [number, number] {
  const nearM = Math.min(depthM[0], farM);
  const products = corners.map((corner) => dot(corner, axis));
  const [low, high] = [Math.min(...products), Math.max(...products)];
  return [low * (low < 0 ? farM : nearM), high * (high < 0 ? nearM : farM)];
}
