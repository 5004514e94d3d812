// Units that cameras see (CALF 6.2). Mirrors src/views/{visible_set,visibility}.rs.

import type { Container } from "../format/container.ts";
import type { Stream } from "../format/types.ts";
import { type Camera, faceImage, type FaceImage, frustumOf, sightLines } from "./camera.ts";
import { Viewer } from "./frustum.ts";

/** Pixels around a unit: half a one for bilinear lookups, one for the texels beside theirs, the rest for rounding. */
const MARGIN_PIXELS = 2;
/** Part of near at which frusta begin, as rays compute distances in single precision. */
const NEAR_PART = 0.99;

/** Whether each unit of a stream can be seen. */
export type Seen = readonly boolean[];

/** Finds the units of streams that cameras see, and keeps the last answers. */
export class VisibleUnits {
  readonly #container: Container;
  /** The nearest surface of each probe, in metres of distance. */
  readonly #nearM = new Map<number, number>();
  #key = "";
  #viewers: Viewer[] = [];
  #seen = new Map<string, Seen>();

  constructor(container: Container) {
    this.#container = container;
    for (const { header, probe } of container.streams) {
      if (header.kind === "depth") {
        this.#nearM.set(probe, Math.min(this.#nearM.get(probe) ?? Infinity, header.range.nearM));
      }
    }
  }

  /** The units of a stream that any of the cameras sees. All are those of a probe that moves. */
  units(stream: Stream, cameras: readonly Camera[]): Seen {
    const key = JSON.stringify(cameras);
    if (key !== this.#key) {
      this.#key = key;
      this.#seen = new Map();
      this.#viewers = cameras.map((camera) => new Viewer(sightLines(camera)));
    }
    // Streams of a face that are cut alike have the same answer.
    const { probe, face, width, height, unitWidth, unitHeight } = stream;
    const shape = [probe, face, width, height, unitWidth, unitHeight].join();
    const seen = this.#seen.get(shape) ?? this.#find(stream);
    this.#seen.set(shape, seen);
    return seen;
  }

  #find(stream: Stream): Seen {
    const { probe, face, width, height, unitWidth, unitHeight } = stream;
    const [columns, rows] = [Math.ceil(width / unitWidth), Math.ceil(height / unitHeight)];
    const still = this.#container.probes[probe];
    const moves = (this.#container.footage.poses.get(still.name)?.length ?? 0) > 0;
    const image = moves
      ? undefined
      : faceImage(still, face, [width, height], NEAR_PART * (this.#nearM.get(probe) ?? 0));
    const seen = new Array<boolean>(columns * rows).fill(image === undefined);
    if (image !== undefined) {
      const descent = new Descent(image, stream, this.#viewers, seen);
      descent.visit(Math.ceil(Math.log2(Math.max(columns, rows))), 0, 0);
    }
    return seen;
  }
}

/** A descent of the quadtree whose leaves are units: a camera that misses a node misses all below it. */
class Descent {
  readonly #columns: number;
  readonly #rows: number;

  constructor(
    readonly image: FaceImage,
    readonly stream: Stream,
    readonly viewers: readonly Viewer[],
    readonly seen: boolean[],
  ) {
    this.#columns = Math.ceil(stream.width / stream.unitWidth);
    this.#rows = Math.ceil(stream.height / stream.unitHeight);
  }

  /** Visits a square of 2^level units along a side, the one of this column and row of its level. */
  visit(level: number, column: number, row: number): void {
    const side = 2 ** level;
    const from: [number, number] = [column * side, row * side];
    const to: [number, number] = [Math.min(from[0] + side, this.#columns), Math.min(from[1] + side, this.#rows)];
    if (from[0] >= to[0] || from[1] >= to[1]) {
      return;
    }
    const frustum = frustumOf(this.image, this.#pixel(from), this.#pixel(to), MARGIN_PIXELS);
    const sights = this.viewers.map((viewer) => viewer.sight(frustum));
    if (sights.every((sight) => sight === "missed")) {
      return;
    }
    if (level === 0 || sights.includes("inside")) {
      for (let at = from[1]; at < to[1]; at += 1) {
        this.seen.fill(true, at * this.#columns + from[0], at * this.#columns + to[0]);
      }
      return;
    }
    for (const [right, below] of [
      [0, 0],
      [1, 0],
      [0, 1],
      [1, 1],
    ]) {
      this.visit(level - 1, 2 * column + right, 2 * row + below);
    }
  }

  /** The pixel at which a unit starts, or the image ends. */
  #pixel([column, row]: [number, number]): [number, number] {
    const { width, height, unitWidth, unitHeight } = this.stream;
    return [Math.min(column * unitWidth, width), Math.min(row * unitHeight, height)];
  }
}
