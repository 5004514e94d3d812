// What the viewer can set, with the ranges that hold for controls and links.

import type { Overlay, RendererChoice, StereoLayout, ToneMapName } from "../player/types.ts";

/** Overlays of containers, and that of scenes. */
export type OverlayName = Overlay | "overdraw";

export interface Settings {
  exposureEv: number;
  toneMap: ToneMapName;
  /** Vertical field of view in degrees. */
  fovDeg: number;
  stereo: StereoLayout;
  /** Metres between the eyes. */
  eyeDistance: number;
  /** Marching steps. */
  steps: number;
  /** Pixels of the picture for each of the screen, along a side. */
  scale: number;
  /** Seconds of the film in a second. */
  speed: number;
  isLooped: boolean;
  marks: ReadonlySet<OverlayName>;
  renderer: RendererChoice;
}

export const DEFAULTS: Readonly<Settings> = {
  exposureEv: 0,
  toneMap: "none",
  fovDeg: 60,
  stereo: "mono",
  eyeDistance: 0.063,
  steps: 1024,
  scale: 1,
  speed: 1,
  isLooped: true,
  marks: new Set(),
  renderer: "auto",
};

/** Settings that are numbers. */
export type NumberName = "exposureEv" | "fovDeg" | "eyeDistance" | "steps" | "scale" | "speed";

/** Least and greatest value. */
const RANGES: Readonly<Record<NumberName, readonly [number, number]>> = {
  exposureEv: [-10, 10],
  fovDeg: [20, 120],
  eyeDistance: [0, 0.5],
  steps: [32, 4096],
  scale: [0.125, 1],
  speed: [0.25, 2],
};

export const TONE_MAPS: readonly ToneMapName[] = ["none", "reinhard", "filmic"];
export const STEREO_LAYOUTS: readonly StereoLayout[] = ["mono", "side-by-side", "anaglyph"];
export const RENDERERS: readonly RendererChoice[] = ["auto", "gpu", "cpu"];
export const MARKS: readonly OverlayName[] = ["probes", "nodes", "holes", "units", "keyframes", "fetched", "overdraw"];

/** The value within the range of its setting; steps are whole. */
export function inRange(name: NumberName, value: number): number {
  const [least, greatest] = RANGES[name];
  const near = Math.min(Math.max(value, least), greatest);
  return name === "steps" ? Math.round(near) : near;
}
