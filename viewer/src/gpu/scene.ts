// Input of the rendering kernels: camera, settings, views and their images, as rows of shaders/march/layout.wgsl. Mirrors
// src/gpu/render/scene.rs.

import { scale } from "../math.ts";
import { decoder } from "../decoder/module.ts";
import type { Steps } from "../decoder/types.ts";
import type { ActiveViews } from "../views/active.ts";
import { HOLE_DIFFERENCE, segmentsOf } from "../views/active.ts";
import type { Camera } from "../views/camera.ts";
import type { ColorCoding, FaceStreams } from "../views/catalogue.ts";
import { pyramidSizes } from "../views/pyramid.ts";
import { rowsOf } from "./layout.ts";
import type { RowValues } from "./layout.ts";
import type { LightFieldTexels } from "./texels.ts";

/** What is shown of surfaces that no probe saw: nothing, the texel of the nearest depth, or what was seen behind. Alpha is 0, 0 and 1. */
export type HoleFill = "blank" | "nearest" | "behind";

export interface MarchSettings {
  /** Steps of a ray, 1 to 65536, and how often the interval before a hit is halved. */
  steps: number;
  refine: number;
  /** Rays in each row and column of a pixel with an edge, at least 1. */
  samples: number;
  holes: HoleFill;
  /** Most bounces of secondary rays. */
  maxBounces: number;
  /** Whether specular materials reflect and refract; else views are blended. */
  effects: boolean;
}

/** Settings of `lightfold render` by default. */
export const MARCH_SETTINGS: MarchSettings = {
  steps: 1024,
  refine: 8,
  samples: 1,
  holes: "behind",
  maxBounces: 4,
  effects: true,
};

/** Stands for an infinite inverse depth: shaders have no infinity. */
const NO_BOUND = 1e30;
const LARGEST_FLOAT = (2 - 2 ** -23) * 2 ** 127;
/** The word of a view that has no image of a face, and images of a view in its row. */
const NO_FACE = 0xffffffff;
const FACES_OF_VIEW = 8;
const MAX_BOUNCES = 8;
const CODINGS = { light: 0, srgb: 1, linear: 2 };
const HOLES: Readonly<Record<HoleFill, number>> = { blank: 0, nearest: 1, behind: 2 };
/** Weights by angles, coverage between texels, and thin surfaces: all departures from the paper. */
const REFINEMENTS = 7;
const BACKGROUND_OPAQUE = 0;

/** The input of a rendering kernel in words, textures apart. */
export interface SceneRows {
  scene: Uint32Array;
  views: Uint32Array;
  faces: Uint32Array;
  distancesM: Uint32Array;
}

function codingRow(coding: ColorCoding): { coding: number; gain: number } {
  return coding.name === "light"
    ? { coding: CODINGS.light, gain: 1 }
    : { coding: CODINGS[coding.transfer], gain: 2 ** -coding.exposureEv };
}

function faceRow(face: FaceStreams, view: number, texels: LightFieldTexels): RowValues {
  const { texels: texel, pyramid, layer } = texels.origin(view, face.face);
  return {
    column: texel[0],
    row: texel[1],
    layer,
    has_material: Number(face.material !== undefined),
    width: face.size[0],
    height: face.size[1],
    pyramid_column: pyramid[0],
    pyramid_row: pyramid[1],
    levels: pyramidSizes(face.size).length,
    number: face.face,
    scale: face.map.scale,
    centre: face.map.center,
    has_alpha: Number(face.alpha !== undefined),
  };
}

function sceneRow(
  { coding, views, nearest }: ActiveViews,
  { axes: [forward, right, down], half }: Camera,
  steps: Steps,
  settings: MarchSettings,
): RowValues {
  const count = steps.distancesM.length;
  const segments = segmentsOf(steps);
  return {
    forward,
    right: scale(right, half[0]),
    down: scale(down, half[1]),
    samples: settings.samples,
    view_count: views.length,
    distance_count: count,
    refine: settings.refine,
    tolerance: HOLE_DIFFERENCE + steps.uncertainty,
    holes: HOLES[settings.holes],
    ...codingRow(coding),
    max_bounces: Math.min(settings.maxBounces, MAX_BOUNCES),
    longest_segment: segments.longest,
    first_segment: segments.first,
    near_m: 0,
    far_m: LARGEST_FLOAT,
    log_step: steps.logStep,
    nearest_view: nearest,
    refinements: REFINEMENTS,
    background: BACKGROUND_OPAQUE,
  };
}

/** The rows of a picture of `width` x `height` pixels. Refractive spheres have no proxies: rays through glass meet what views saw. */
export function sceneRows(
  active: ActiveViews,
  camera: Camera,
  [width, height]: readonly [number, number],
  settings: MarchSettings,
  texels: LightFieldTexels,
): SceneRows {
  const steps = decoder().raySteps(settings.steps, active.nearM / 10, active.farM, settings.refine);
  const faces: RowValues[] = [];
  const views = active.views.map(({ view, streams, fromEye, turn, cameraWeight }): RowValues => {
    const rows = new Array<number>(FACES_OF_VIEW).fill(NO_FACE);
    for (const face of streams.faces) {
      rows[face.face] = faces.length;
      faces.push(faceRow(face, view, texels));
    }
    const [turn_x, turn_y, turn_z] = turn;
    return {
      from_eye: fromEye,
      near_m: streams.nearM,
      turn_x,
      camera_weight: cameraWeight,
      turn_y,
      greatest_inverse_depth: NO_BOUND,
      turn_z,
      faces: rows,
    };
  });
  const size = { width, height, pyramid_rows: texels.arrays.pyramidRows };
  return {
    scene: rowsOf("Scene", [{ ...sceneRow(active, camera, steps, settings), ...size }]),
    views: rowsOf("View", views),
    faces: rowsOf("Face", faces),
    distancesM: new Uint32Array(steps.distancesM.buffer),
  };
}
