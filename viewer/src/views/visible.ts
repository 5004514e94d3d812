// The units that rays from cameras can look up (CALF 6.2). Mirrors src/render/views/visible_set.rs and visibility.rs.
//
// A ray looks up points before and behind the surfaces of a probe. Points nearer to the probe than its near plane need no texel; from there
// to any distance the unit under a point is needed. So frusta of units begin at near, and end nowhere.

import type { Container } from "../format/container.ts";
import type { Stream } from "../format/types.ts";
import type { Camera } from "./camera.ts";
import { isSameCamera } from "./camera.ts";
import type { FaceImage } from "./face.ts";
import { faceImage, unitFrustum } from "./face.ts";
import { frustum, Viewer } from "./frustum.ts";

/** Margin around a unit in pixels: half of one for bilinear lookups, one more for the texels beside theirs, the rest for rounding. */
const MARGIN_PIXELS = 2;
/** Part of near at which frusta begin, as rays compute distances in single precision. */
const NEAR_PART = 0.99;

/** The nearest surface of each probe that has depth, in metres of distance. */
function nearOfProbes(streams: readonly Stream[]): ReadonlyMap<number, number> {
  const near = new Map<number, number>();
  for (const { probe, header } of streams) {
    if (header.kind === "depth") {
      near.set(probe, Math.min(header.range.nearM, near.get(probe) ?? Infinity));
    }
  }
  return near;
}

/** Finds visible units by descending a quadtree of them: a camera that misses a node misses its children. */
class Descent {
  /** 1 for each unit that is seen. */
  readonly seen: Uint8Array;
  readonly #columns: number;
  readonly #rows: number;

  constructor(
    private readonly image: FaceImage,
    private readonly stream: Stream,
    private readonly nearM: number,
    private readonly viewers: readonly Viewer[],
  ) {
    this.#columns = Math.ceil(stream.width / stream.unitWidth);
    this.#rows = Math.ceil(stream.height / stream.unitHeight);
    this.seen = new Uint8Array(this.#columns * this.#rows);
    let side = 1;
    while (side < Math.max(this.#columns, this.#rows)) {
      side *= 2;
    }
    this.#visit([0, 0], side, 0);
  }

  /** Tests a square of `side` x `side` units against the viewers from `first` on. */
  #visit([column, row]: readonly [number, number], side: number, first: number): void {
    const end = [Math.min(column + side, this.#columns), Math.min(row + side, this.#rows)] as const;
    const volume = unitFrustum(this.image, this.#pixel([column, row]), this.#pixel(end), {
      margin: MARGIN_PIXELS,
      nearM: NEAR_PART * this.nearM,
    });
    for (let at = first; at < this.viewers.length; at += 1) {
      const sight = this.viewers[at].sight(volume);
      if (sight === "partly" && side > 1) {
        this.#visitChildren([column, row], side / 2, at);
        return;
      }
      if (sight !== "missed") {
        for (let marked = row; marked < end[1]; marked += 1) {
          this.seen.fill(1, marked * this.#columns + column, marked * this.#columns + end[0]);
        }
        return;
      }
    }
  }

  #visitChildren([column, row]: readonly [number, number], side: number, first: number): void {
    for (const [right, down] of [
      [0, 0],
      [side, 0],
      [0, side],
      [side, side],
    ] as const) {
      if (column + right < this.#columns && row + down < this.#rows) {
        this.#visit([column + right, row + down], side, first);
      }
    }
  }

  /** Pixel at which a unit starts, or the image ends. */
  #pixel([column, row]: readonly [number, number]): [number, number] {
    const { width, height, unitWidth, unitHeight } = this.stream;
    return [Math.min(column * unitWidth, width), Math.min(row * unitHeight, height)];
  }
}

/** What a container says of its probes and streams. */
type Layout = Pick<Container, "probes" | "streams" | "footage" | "unitCount">;

/** The units that cameras can see, found stream by stream when they are asked for. Results for the same cameras are kept. */
export class VisibleUnits {
  readonly #container: Layout;
  readonly #near: ReadonlyMap<number, number>;
  #cameras: readonly Camera[] = [];
  #viewers: readonly Viewer[] = [];
  readonly #seen = new Map<number, Uint8Array>();

  constructor(container: Layout) {
    this.#container = container;
    this.#near = nearOfProbes(container.streams);
  }

  /** Looks from other cameras: the eyes of a picture, or those of where the viewer is heading. */
  look(cameras: readonly Camera[]): void {
    const isSame =
      cameras.length === this.#cameras.length && cameras.every((camera, at) => isSameCamera(camera, this.#cameras[at]));
    if (isSame) {
      return;
    }
    this.#cameras = cameras;
    this.#viewers = cameras.map(({ eye, axes, half: [u, v] }) => {
      return new Viewer(frustum(eye, axes, { u: [-u, u], v: [-v, v] }, 0));
    });
    this.#seen.clear();
  }

  /** 1 for each unit of a stream, by its number, that a camera may see; of moving probes and images without known directions all. */
  units(stream: Stream): Uint8Array {
    const known = this.#seen.get(stream.index) ?? this.#find(stream);
    this.#seen.set(stream.index, known);
    return known;
  }

  /** Whether a camera may see a unit. */
  sees(stream: Stream, unit: number): boolean {
    return this.units(stream)[unit] === 1;
  }

  #find(stream: Stream): Uint8Array {
    const probe = this.#container.probes[stream.probe];
    const isMoving = (this.#container.footage.poses.get(probe.name) ?? []).length > 0;
    const image = isMoving ? undefined : faceImage(probe, stream.face, [stream.width, stream.height]);
    if (image === undefined) {
      return new Uint8Array(this.#container.unitCount(stream.index)).fill(1);
    }
    return new Descent(image, stream, this.#near.get(stream.probe) ?? 0, this.#viewers).seen;
  }
}
