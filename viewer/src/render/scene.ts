// Input of the rendering kernels: camera, settings, views and their images, as rows of shaders/march/layout.wgsl. Mirrors
// src/gpu/render/scene.rs and src/march/{active_views,ray}.rs.

import type { Probe, Vec3 } from "../format/types.ts";
import { CONSTANTS, type RowValues, rowsOf } from "../gpu/layout.ts";
import { type Camera, rayLengthFactor, type TexelMap, VIEW_FACE } from "./camera.ts";
import { NO_BOUND_BITS } from "./planes.ts";
import type { Origin } from "./textures.ts";
import { length, rotation, scaled, subtract } from "./vectors.ts";

/** Tolerance between a hit and the texel whose surface it has, in logarithms of distance. */
const HOLE_DIFFERENCE = 0.1;
/** Added to relative distances of views, so that weights are finite. */
const CAMERA_EPSILON = 0.01;
const CODING = { light: 0, srgb: 1, linear: 2 } as const;
const HOLES = { blank: 0, nearest: 1, behind: 2 } as const;
/** Angles, edges and thin surfaces. */
const ALL_REFINEMENTS = 7;
const FACES_OF_VIEW = 8;

/** How colors are coded: codes behind a curve and an exposure, or linear light. */
export interface Coding {
  transfer: keyof typeof CODING;
  exposureEv: number;
}

/** An image of a view, in the textures. */
export interface SceneFace {
  face: number;
  size: [number, number];
  map: TexelMap;
  origin: Origin;
  levels: number;
  hasAlpha: boolean;
  hasMaterial: boolean;
}

/** A view that takes part in a picture. */
export interface SceneView {
  /** Where its probe stands in the frame. */
  probe: Probe;
  /** No surface is nearer in distance, none farther in planar depth or distance; metres. */
  nearM: number;
  farM: number;
  faces: SceneFace[];
}

export interface MarchSettings {
  /** Width and height in pixels. */
  size: [number, number];
  /** Steps of a ray, at least 1, and how often the interval before a hit is halved. */
  steps: number;
  refine: number;
  /** What is shown of surfaces that no view saw; only blank and nearest give holes an alpha of 0. */
  holes: keyof typeof HOLES;
  maxBounces: number;
}

/** Rows of a picture, in words. */
export interface SceneRows {
  scene: Uint32Array;
  views: Uint32Array;
  faces: Uint32Array;
  distances: Uint32Array;
}

/** Distances at which a ray is tested, in metres, as single floats; from a tenth of the nearest surface to beyond all surfaces. */
function distancesOf(views: readonly SceneView[], eye: Vec3, steps: number): Float32Array<ArrayBuffer> {
  const near = Math.fround(Math.min(...views.map(({ nearM }) => nearM)) / 10);
  const far = Math.fround(Math.max(...views.map((view) => reachOf(view, eye))));
  if (!(far > near)) {
    return Float32Array.of(near);
  }
  const step = Math.log(far / near) / steps;
  return Float32Array.from({ length: steps + 1 }, (_, at) => near * Math.exp(step * at));
}

/** Greatest distance of a surface of a view from the eye. A planar depth is farther in the corners of an image. */
function reachOf({ probe, farM, faces }: SceneView, eye: Vec3): number {
  const corners = faces.flatMap(({ size: [width, height], map }) =>
    [0, width - 1].flatMap((column) => [0, height - 1].map((row) => rayLengthFactor(map, column, row))),
  );
  return length(subtract(probe.position, eye)) + farM * Math.max(1, ...corners);
}

/** Rows of a picture by these views, of which there is at least one, in the order of their distance from the eye. */
export function sceneRows(
  views: readonly SceneView[],
  camera: Camera,
  coding: Coding,
  settings: MarchSettings,
  pyramidRows: number,
): SceneRows {
  const distances = distancesOf(views, camera.eye, settings.steps);
  const logStep = distances.length > 1 ? Math.fround(Math.log(distances[1] / distances[0])) : 0;
  const left = -Math.expm1(-logStep) * 0.5 ** settings.refine;
  const samples = 2 ** Math.ceil(Math.log2(distances.length));
  const fromEye = views.map(({ probe }) => subtract(probe.position, camera.eye));
  const distance = fromEye.map(length);
  const [forward, right, down] = camera.axes;
  const scene: RowValues = {
    forward,
    width: settings.size[0],
    right: scaled(right, camera.half[0]),
    height: settings.size[1],
    down: scaled(down, camera.half[1]),
    samples: 1,
    view_count: views.length,
    distance_count: distances.length,
    refine: settings.refine,
    tolerance: HOLE_DIFFERENCE - Math.log1p(-left),
    holes: HOLES[settings.holes],
    coding: CODING[coding.transfer],
    gain: coding.transfer === "light" ? 1 : 2 ** -coding.exposureEv,
    max_bounces: settings.maxBounces,
    pyramid_rows: pyramidRows,
    longest_segment: samples,
    first_segment: Math.max(1, samples / 4),
    near_m: 0,
    far_m: 3.4028234663852886e38,
    log_step: logStep,
    nearest_view: distance.indexOf(Math.min(...distance)),
    refinements: ALL_REFINEMENTS,
  };
  const faces: RowValues[] = [];
  const rows = views.map((view, at) => viewRow(view, fromEye[at], Math.max(...distance), faces));
  return {
    scene: rowsOf("Scene", [scene]),
    views: rowsOf("View", rows),
    faces: rowsOf("Face", faces),
    distances: new Uint32Array(distances.buffer),
  };
}

/** The row of a view; those of its images are added to `faces`. */
function viewRow(view: SceneView, fromEye: Vec3, farthestM: number, faces: RowValues[]): RowValues {
  const numbers = new Array<number>(FACES_OF_VIEW).fill(CONSTANTS.NONE);
  for (const one of view.faces) {
    numbers[one.face] = faces.length;
    faces.push(faceRow(one));
  }
  const turn = rotation(view.probe.orientation) ?? [
    [1, 0, 0],
    [0, 1, 0],
    [0, 0, 1],
  ];
  // Rows of the rotation are the columns of its inverse, which turns the world into the axes of the probe.
  return {
    from_eye: fromEye,
    near_m: view.nearM,
    turn_x: turn[0],
    camera_weight: farthestM > 0 ? 1 / (length(fromEye) / farthestM + CAMERA_EPSILON) : 1,
    turn_y: turn[1],
    greatest_inverse_depth: new Float32Array(Uint32Array.of(NO_BOUND_BITS).buffer)[0],
    turn_z: turn[2],
    reach_m: 0,
    faces: numbers,
  };
}

function faceRow({ face, size, map, origin, levels, hasAlpha, hasMaterial }: SceneFace): RowValues {
  return {
    column: origin.column,
    row: origin.row,
    layer: origin.layer,
    has_material: Number(hasMaterial),
    width: size[0],
    height: size[1],
    pyramid_column: origin.pyramidColumn,
    pyramid_row: origin.pyramidRow,
    levels,
    number: face,
    scale: map.scale,
    centre: map.centre,
    has_alpha: Number(hasAlpha),
  };
}

/** Whether a view has a face in every direction, so that its greatest inverse depth bounds all. */
export function isWholeCube({ faces }: SceneView): boolean {
  return faces.length === 6 && faces.every(({ face }) => face !== VIEW_FACE);
}
