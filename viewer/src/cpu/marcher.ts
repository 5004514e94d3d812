// Marching on the processor: rays, the surfaces that they meet one behind the other, and the background. Mirrors
// src/render/march/layers.rs and src/render/march/render.rs (CALF 6), with their default settings and no secondary rays.

import { HOLE_DIFFERENCE, type Steps, stepsOf } from "../views/active.ts";
import type { Camera } from "../views/camera.ts";
import type { ColorCoding } from "../views/catalogue.ts";
import { lightOf } from "../views/straight.ts";
import { Colors } from "./colors.ts";
import { type MarchedViews } from "./marched_views.ts";
import { Rays } from "./rays.ts";

const MIN_LAYER = 1 / 64;
const MAX_LAYERS = 8;
const MAX_EXITS = 64;
const BEHIND = Math.exp(HOLE_DIFFERENCE);

/** What a picture is rendered with. */
export interface MarchRequest {
  camera: Pick<Camera, "axes" | "half">;
  /** Width and height in pixels. */
  size: readonly [number, number];
  coding: ColorCoding;
  /** Whether colors are those of the overlay, and so is their coding. */
  showsOverlay: boolean;
  /** Least and greatest distance of surfaces, in metres. */
  nearM: number;
  farM: number;
  /** Steps of a ray, and how often the interval before a hit is halved. */
  steps: number;
  refine: number;
  /** Whether a ray goes on behind a surface that no probe saw; else the pixel is a hole, with an alpha of 0. */
  looksBehindHoles: boolean;
}

/** Renders rows of a picture. */
export class Marcher {
  readonly #steps: Steps;
  readonly #rays: Rays;
  readonly #colors: Colors;
  readonly #tolerance: number;
  readonly #light: (code: number) => number;
  /** Of the ray: linear light so far, the part that is left, and whether it first met a surface that no view saw. */
  #red = 0;
  #green = 0;
  #blue = 0;
  #left = 1;
  #isHole = false;
  /** Surfaces that show, and the distance before which no other does. */
  #layers = 0;
  #leastM = 0;
  /** Whether the ray is within a surface with alpha, which has shown. */
  #isWithin = false;
  /** A color for a ray that ends in a hole. */
  #unseen: readonly [number, number, number] | undefined;

  constructor(
    private readonly marched: MarchedViews,
    private readonly request: MarchRequest,
  ) {
    this.#steps = stepsOf(request, request.steps, request.refine);
    this.#tolerance = HOLE_DIFFERENCE + this.#steps.uncertainty;
    this.#rays = new Rays(marched, this.#steps, request.refine);
    this.#colors = new Colors(marched, this.#tolerance, request.showsOverlay);
    this.#light = lightOfCoding(request.coding);
  }

  /** Writes red, green and blue of linear light, and alpha, of rows from `first` up to, but without, `end`. */
  render(first: number, end: number, rgba: Float32Array): void {
    const { camera, size, looksBehindHoles } = this.request;
    const [width, height] = size;
    const [forward, right, down] = camera.axes;
    const { counts } = this.marched;
    for (let row = first; row < end; row += 1) {
      const v = ((2 * (row + 0.5)) / height - 1) * camera.half[1];
      for (let column = 0; column < width; column += 1) {
        const u = ((2 * (column + 0.5)) / width - 1) * camera.half[0];
        const x = forward[0] + u * right[0] + v * down[0];
        const y = forward[1] + u * right[1] + v * down[1];
        const z = forward[2] + u * right[2] + v * down[2];
        const scale = 1 / Math.sqrt(x * x + y * y + z * z);
        [this.#rays.x, this.#rays.y, this.#rays.z] = [x * scale, y * scale, z * scale];
        counts.primary_rays += 1;
        const share = this.#follow();
        counts.hole_rays += Number(this.#isHole);
        const at = 4 * (row * width + column);
        const part = share > 0 ? 1 / share : 0;
        rgba[at] = this.#red * part;
        rgba[at + 1] = this.#green * part;
        rgba[at + 2] = this.#blue * part;
        rgba[at + 3] = this.#isHole && !looksBehindHoles ? 0 : share;
      }
    }
  }

  /** Follows the ray; answers the part of it that has a color. */
  #follow(): number {
    [this.#red, this.#green, this.#blue, this.#left] = [0, 0, 0, 1];
    [this.#layers, this.#leastM, this.#isWithin, this.#isHole] = [0, 0, false, false];
    this.#unseen = undefined;
    const isEnd = this.#showSurfaces();
    if (isEnd || this.#left === 0) {
      return this.#left === 0 ? 1 : this.#endInHole();
    }
    this.marched.counts.background_rays += Number(this.#layers === 0);
    const { x, y, z } = this.#rays;
    const colors = this.#colors;
    colors.lookBehind(x, y, z);
    if (colors.isFound) {
      const share = this.#left * colors.alpha;
      this.#add(share);
      return 1 - (this.#left - share);
    }
    return this.#endInHole();
  }

  /** Shows surfaces one behind the other; answers whether the ray ends in a hole. */
  #showSurfaces(): boolean {
    const [rays, colors, marched] = [this.#rays, this.#colors, this.marched];
    const { distancesM, logStep } = this.#steps;
    const { first, thinM } = this.#nearestSurface();
    let hitM = rays.intersectFrom(first);
    if (thinM >= 0 && (hitM < 0 || thinM < hitM / BEHIND)) {
      this.#lookAt(thinM);
      if (colors.isFound && colors.difference <= this.#tolerance) {
        this.#show(thinM);
      }
    }
    for (let exits = 0; exits < MAX_EXITS && hitM >= 0 && this.#left > 0; exits += 1) {
      let atM = hitM;
      let within = this.#tolerance;
      let isInside = false;
      this.#isWithin &&= atM < this.#leastM;
      let next = firstBeyond(distancesM, atM);
      for (;;) {
        if (atM >= this.#leastM && !this.#isWithin) {
          this.#lookAt(atM);
          if (colors.isFound && colors.difference <= within) {
            this.#show(atM);
          } else {
            this.#unseen = colors.isFound ? [colors.red, colors.green, colors.blue] : this.#unseen;
            if (this.#layers === 0 && !isInside) {
              this.#isHole = true;
              if (!this.request.looksBehindHoles) {
                return true;
              }
            }
          }
          if (this.#left === 0) {
            return false;
          }
        }
        within = HOLE_DIFFERENCE + logStep;
        isInside = true;
        if (next >= distancesM.length) {
          hitM = -1;
          break;
        }
        marched.counts.march_steps += 1;
        atM = distancesM[next];
        if (!rays.isSurfaceAt(atM)) {
          hitM = rays.intersectFrom(next);
          break;
        }
        next += 1;
      }
    }
    return false;
  }

  /** The distance of the surface of the nearest view, or -1: it shows though others see past it. No surface begins before step `first`. */
  #nearestSurface(): { first: number; thinM: number } {
    const [rays, marched] = [this.#rays, this.marched];
    const { distancesM } = this.#steps;
    marched.alone = marched.nearest;
    marched.untilUnknown = true;
    const first = rays.firstStep(0);
    marched.untilUnknown = false;
    const isThin = first < distancesM.length && rays.isSurfaceAt(distancesM[first]);
    const thinM = isThin ? rays.refined(first) : -1;
    marched.alone = -1;
    return { first, thinM };
  }

  #lookAt(distanceM: number): void {
    const { x, y, z } = this.#rays;
    this.#colors.lookAt(x * distanceM, y * distanceM, z * distanceM);
  }

  /** Shows the surface that was looked at by its coverage and alpha. */
  #show(distanceM: number): void {
    const { coverage, alpha } = this.#colors;
    const opacity = coverage * alpha;
    this.#isWithin ||= alpha <= 1 - MIN_LAYER && coverage > 1 - MIN_LAYER;
    if (opacity < MIN_LAYER) {
      return;
    }
    let left = this.#left * (1 - opacity);
    if (this.#layers + 1 === MAX_LAYERS || opacity > 1 - MIN_LAYER || left < MIN_LAYER) {
      left = 0;
    }
    this.#add(this.#left - left);
    this.#left = left;
    this.#layers += 1;
    this.#leastM = distanceM * BEHIND;
  }

  /** Adds the light of the color that was looked at. */
  #add(share: number): void {
    this.#red += share * this.#light(this.#colors.red);
    this.#green += share * this.#light(this.#colors.green);
    this.#blue += share * this.#light(this.#colors.blue);
  }

  /** What is left of the ray ends in nothing known. */
  #endInHole(): number {
    if (this.#layers > 0) {
      const part = 1 / (1 - this.#left);
      [this.#red, this.#green, this.#blue] = [this.#red * part, this.#green * part, this.#blue * part];
      return 1;
    }
    this.#isHole = true;
    if (this.#unseen === undefined) {
      return 0;
    }
    [this.#red, this.#green, this.#blue] = this.#unseen.map(this.#light) as [number, number, number];
    return 1;
  }
}

/** The first distance that is greater than one. */
function firstBeyond(distancesM: Float32Array, atM: number): number {
  let [next, end] = [0, distancesM.length];
  while (next < end) {
    const half = (next + end) >> 1;
    [next, end] = distancesM[half] <= atM ? [half + 1, end] : [next, half];
  }
  return next;
}

/** Linear light of colors as they are coded: codes over 255, or light. */
function lightOfCoding(coding: ColorCoding): (code: number) => number {
  if (coding.name === "light") {
    return (light) => light;
  }
  const gain = 2 ** -coding.exposureEv;
  return (code) => gain * lightOf(255 * code, coding.transfer);
}
