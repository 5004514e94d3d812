// The views that take part in a picture, relative to its eye, and the distances at which rays are sampled. Mirrors
// src/render/march/active_views.rs and src/render/march/ray.rs (CALF 6, equation 13).
//
// Positions are subtracted in double precision, so that pictures far from the world's origin lose no precision.

import type { Steps } from "../decoder/types.ts";
import type { Probe, Vec3 } from "../format/types.ts";
import type { Axes } from "../math.ts";
import { inverse, length, rotate, rotation, subtract } from "../math.ts";
import type { Catalogue, ProbeStreams } from "./catalogue.ts";
import { rayLength } from "./face.ts";

/** The weight of a view by its distance from the eye, relative to the farthest active view, has this beside it. */
const CAMERA_EPSILON = 0.01;

/** A hit has a texel's surface where the logarithms of their distances differ by no more than this, beyond the uncertainty of steps. */
export const HOLE_DIFFERENCE = 0.1;
/** Views with a nearer surface have no bound on inverse depths. Metres. */
export const MIN_M = 1e-18;

export interface ActiveView {
  /** Its place in the catalogue. */
  view: number;
  streams: ProbeStreams;
  /** Metres, along the axes of the world. */
  fromEye: Vec3;
  /** The columns of the matrix that turns directions of the world into those of the probe. */
  turn: Axes;
  cameraWeight: number;
}

/** The active views of a picture, at least one, by priority. */
export interface ActiveViews {
  views: ActiveView[];
  coding: Catalogue["coding"];
  /** Number in `views` of the one nearest to the eye, the first of several. */
  nearest: number;
  /** Least distance of a surface of these views from its own view, in metres. */
  nearM: number;
  /** Greatest distance of a surface of these views from the eye, in metres. */
  farM: number;
}

/** The columns of the matrix that turns directions of the world into those of a probe. */
function turnOf({ orientation }: Probe): Axes {
  const turn = inverse(rotation(orientation) ?? [0, 0, 0, 1]);
  return [rotate(turn, [1, 0, 0]), rotate(turn, [0, 1, 0]), rotate(turn, [0, 0, 1])];
}

/** The greatest distance over planar depth of a texel: in the corners of images. */
function greatestRayLength({ faces }: ProbeStreams): number {
  const corners = faces.flatMap(({ size: [width, height], map }) =>
    [0, width - 1].flatMap((column) => [0, height - 1].map((row) => rayLength(map, column, row))),
  );
  return Math.max(1, ...corners);
}

/** Views by their places in a catalogue, seen from an eye; `probeOf` answers a probe as it stands in the frame. */
export function activeViews(
  { views, coding }: Catalogue,
  places: readonly number[],
  eye: Vec3,
  probeOf: (probe: number) => Probe,
): ActiveViews {
  const single = (vector: Vec3): Vec3 => [Math.fround(vector[0]), Math.fround(vector[1]), Math.fround(vector[2])];
  const active = places.map((view): ActiveView => {
    const streams = views[view];
    const probe = probeOf(streams.probe);
    return { view, streams, fromEye: single(subtract(probe.position, eye)), turn: turnOf(probe), cameraWeight: 1 };
  });
  const distances = active.map(({ fromEye }) => length(fromEye));
  const farthestM = Math.max(0, ...distances);
  if (farthestM > 0) {
    active.forEach((one, at) => (one.cameraWeight = 1 / (distances[at] / farthestM + CAMERA_EPSILON)));
  }
  return {
    views: active,
    coding,
    nearest: distances.indexOf(Math.min(...distances)),
    nearM: Math.min(...active.map(({ streams }) => streams.nearM)),
    farM: Math.max(...active.map(({ streams }, at) => distances[at] + streams.farM * greatestRayLength(streams))),
  };
}

/** Points of the longest segment that one test may prove empty, a power of two, and of the first one. */
export function segmentsOf({ distancesM }: Steps): { longest: number; first: number } {
  const longest = 2 ** Math.ceil(Math.log2(distancesM.length));
  return { longest, first: Math.max(longest / 4, 1) };
}
