// The units that rays from cameras can look up (CALF 6.2), as src/render/views/visible_set.rs finds them.

import { decoder } from "../decoder/module.ts";
import type { Container } from "../format/container.ts";
import type { Stream } from "../format/types.ts";
import type { Camera } from "./camera.ts";
import { isSameCamera } from "./camera.ts";

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

/** What a container says of its probes and streams. */
type Layout = Pick<Container, "probes" | "streams" | "footage" | "unitCount">;

/** The units that cameras can see, found stream by stream when they are asked for. Results for the same cameras are kept. */
export class VisibleUnits {
  readonly #container: Layout;
  readonly #near: ReadonlyMap<number, number>;
  #cameras: readonly Camera[] = [];
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
    return isMoving
      ? new Uint8Array(this.#container.unitCount(stream.index)).fill(1)
      : decoder().visibleUnits(stream, probe, this.#near.get(stream.probe) ?? 0, this.#cameras);
  }
}
