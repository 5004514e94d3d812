// The color of a point: CalculateColor of algorithm 4 (CALF 6), with weights by angles and coverage. Mirrors src/render/march/interpolate.rs.

import { HOLE_DIFFERENCE } from "../views/active.ts";
import { BACKGROUND, type FaceTexels, UNKNOWN } from "./face_texels.ts";
import type { MarchedView, MarchedViews } from "./marched_views.ts";

const DEPTH_EPSILON = 0.02;
const ANGLE_EPSILON = 0.0005;
const CAMERA_EPSILON = 0.01;
const EDGE_PENALTY = 6;
const BACKGROUND_EDGE_PENALTY = 20;
/** A surface is nearer than another one where its inverse depth is so many times that. */
const NEARER = Math.exp(HOLE_DIFFERENCE);
const DEPTH_CUT = 0.2;
const CUT_WEIGHT = 0.001;
const MIN_POSITIVE = 2 ** -126;

/** What views see of the last point: a color as it is coded (codes over 255, or light), and how well texels fit. */
export class Colors {
  /** Whether any view saw something. */
  isFound = false;
  red = 0;
  green = 0;
  blue = 0;
  /** The least difference between the logarithms of the distances of the point and of a texel. */
  difference = Infinity;
  /** The part of the texels around the point that have its surface, of those that do not have a nearer one. */
  coverage = 1;
  alpha = 0;
  readonly #texels = new Int32Array(4);
  readonly #weights = new Float64Array(4);
  /** Sums of weights, and of those of colors: times alpha. */
  #weight = 0;
  #shown = 0;
  /** What a step of a component is: 1 of light, 1/255 of codes. */
  readonly #unit: number;

  /** `tolerance`: a hit whose texels differ more, in the logarithm of distances, is disoccluded. `showsOverlay`: colors are those of the
   *  overlay. */
  constructor(
    private readonly marched: MarchedViews,
    private readonly tolerance: number,
    private readonly showsOverlay: boolean,
  ) {
    this.#unit = marched.isLight ? 1 : 1 / 255;
  }

  /** Looks at a point on a surface that the eye sees, in metres from the eye. */
  lookAt(x: number, y: number, z: number): void {
    const { marched, tolerance } = this;
    this.#begin();
    let opaque = 0;
    let covered = 0;
    let all = 0;
    for (const view of marched.views) {
      if (!marched.projectPoint(view, x, y, z)) {
        continue;
      }
      const ofView = angleWeight(view, x, y, z);
      const edgePart = edgePartOf(view, ofView, ANGLE_EPSILON, EDGE_PENALTY);
      const face = marched.face!;
      const { inverseDepth } = marched;
      this.#findTaps(face);
      for (let tap = 0; tap < 4; tap += 1) {
        const texel = this.#texels[tap];
        const surface = face.inverseDepths[texel];
        const weight = this.#weights[tap] * ofView;
        if (surface === UNKNOWN) {
          continue;
        }
        if (surface === BACKGROUND) {
          all += weight;
          continue;
        }
        const nearer = Math.log(surface / inverseDepth);
        const difference = Math.abs(nearer);
        all += nearer <= tolerance ? weight : 0;
        const covers = difference <= tolerance ? weight : 0;
        covered += covers;
        opaque += covers * this.#colorsOf(face)[4 * texel + 3] * this.#unit;
        const isEdge = edgePart < 1 && isBesideNearer(face, texel, surface * NEARER);
        this.#add(face, texel, weight * fitWeight(difference) * (isEdge ? edgePart : 1));
        this.difference = Math.min(this.difference, difference);
      }
    }
    this.#end();
    this.coverage = all > 0 ? covered / all : 1;
    this.alpha = covered > 0 ? opaque / covered : this.alpha;
  }

  /** Looks at the background in a direction. */
  lookBehind(x: number, y: number, z: number): void {
    const { marched } = this;
    this.#begin();
    for (const view of marched.views) {
      marched.turn(view, x, y, z);
      if (!marched.project(view)) {
        continue;
      }
      const edgePart = edgePartOf(view, view.cameraWeight, CAMERA_EPSILON, BACKGROUND_EDGE_PENALTY);
      const face = marched.face!;
      this.#findTaps(face);
      for (let tap = 0; tap < 4; tap += 1) {
        const texel = this.#texels[tap];
        if (face.inverseDepths[texel] === BACKGROUND) {
          const isEdge = edgePart < 1 && isBesideNearer(face, texel, 0);
          this.#add(face, texel, this.#weights[tap] * view.cameraWeight * (isEdge ? edgePart : 1));
        }
      }
    }
    this.#end();
  }

  /** Finds the four texels around the projected point, the first two above the others, and their weights. */
  #findTaps({ width, height }: FaceTexels): void {
    const { x, y } = this.marched;
    const left = Math.floor(x - 0.5);
    const top = Math.floor(y - 0.5);
    const partX = x - 0.5 - left;
    const partY = y - 0.5 - top;
    const first = Math.min(Math.max(left, 0), width - 1);
    const second = Math.min(Math.max(left + 1, 0), width - 1);
    const upper = Math.min(Math.max(top, 0), height - 1) * width;
    const lower = Math.min(Math.max(top + 1, 0), height - 1) * width;
    this.#texels[0] = upper + first;
    this.#texels[1] = upper + second;
    this.#texels[2] = lower + first;
    this.#texels[3] = lower + second;
    this.#weights[0] = (1 - partX) * (1 - partY);
    this.#weights[1] = partX * (1 - partY);
    this.#weights[2] = (1 - partX) * partY;
    this.#weights[3] = partX * partY;
  }

  #begin(): void {
    this.red = 0;
    this.green = 0;
    this.blue = 0;
    this.#weight = 0;
    this.#shown = 0;
    this.difference = Infinity;
  }

  #colorsOf({ colors, overlay }: FaceTexels): Uint8Array | Float32Array {
    return this.showsOverlay && overlay !== undefined ? overlay : colors;
  }

  #add(face: FaceTexels, texel: number, weight: number): void {
    const colors = this.#colorsOf(face);
    const shown = weight * colors[4 * texel + 3] * this.#unit;
    this.red += shown * colors[4 * texel];
    this.green += shown * colors[4 * texel + 1];
    this.blue += shown * colors[4 * texel + 2];
    this.#weight += weight;
    this.#shown += shown;
  }

  #end(): void {
    this.isFound = this.#weight > 0;
    this.alpha = this.isFound ? this.#shown / this.#weight : 0;
    const scale = this.#shown > 0 ? this.#unit / this.#shown : 0;
    this.red *= scale;
    this.green *= scale;
    this.blue *= scale;
  }
}

/** The weight of a view for a point that the eye sees, by the angle between their rays and by resolution. */
function angleWeight({ fromEye }: MarchedView, x: number, y: number, z: number): number {
  const fromX = x - fromEye[0];
  const fromY = y - fromEye[1];
  const fromZ = z - fromEye[2];
  const fromEyeM = Math.sqrt(x * x + y * y + z * z);
  const fromViewM = Math.sqrt(fromX * fromX + fromY * fromY + fromZ * fromZ);
  const crossX = y * fromZ - z * fromY;
  const crossY = z * fromX - x * fromZ;
  const crossZ = x * fromY - y * fromX;
  const cross = Math.sqrt(crossX * crossX + crossY * crossY + crossZ * crossZ);
  const isFront = x * fromX + y * fromY + z * fromZ > 0;
  const angle = isFront ? cross / Math.max(fromEyeM * fromViewM, MIN_POSITIVE) : 1;
  const blur = Math.max(fromViewM / Math.max(fromEyeM, MIN_POSITIVE) - 1, 0);
  return 1 / (angle + blur + ANGLE_EPSILON);
}

/** The part of the weight of a view that its texels beside a nearer surface have; `epsilon` is that of the weight. */
function edgePartOf({ fromEye }: MarchedView, weight: number, epsilon: number, penalty: number): number {
  const isEye = fromEye[0] === 0 && fromEye[1] === 0 && fromEye[2] === 0;
  return isEye ? 1 : 1 / (1 + penalty - penalty * epsilon * weight);
}

function fitWeight(difference: number): number {
  const weight = 1 / (difference + DEPTH_EPSILON);
  return Math.max(weight - 1 / (DEPTH_CUT + DEPTH_EPSILON), CUT_WEIGHT * weight);
}

/** Whether a known texel above, below, left or right of one has a greater inverse depth. */
function isBesideNearer({ width, height, inverseDepths }: FaceTexels, texel: number, inverseDepth: number): boolean {
  const column = texel % width;
  const isNearer = (other: number): boolean => inverseDepths[other] !== UNKNOWN && inverseDepths[other] > inverseDepth;
  return (
    (column > 0 && isNearer(texel - 1)) ||
    (column + 1 < width && isNearer(texel + 1)) ||
    (texel >= width && isNearer(texel - width)) ||
    (texel + width < width * height && isNearer(texel + width))
  );
}
