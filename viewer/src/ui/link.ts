// The part of a link behind #: pose, frame and settings, for example #eye=0,1.5,0&look=90,-5&frame=12&fov=70. Eye in metres,
// look in degrees (yaw to the left, pitch up). Settings that are not named keep their defaults.

import type { Vec3 } from "../format/types.ts";
import type { Pose } from "../player/types.ts";
import { MAX_PITCH, wrapAngle } from "./pose.ts";
import { DEFAULTS, inRange, MARKS, RENDERERS, STEREO_LAYOUTS, TONE_MAPS } from "./settings.ts";
import type { OverlayName, NumberName, Settings } from "./settings.ts";

/** What a link says; what it does not say, or says wrongly, is absent. */
export interface Link {
  eye?: Vec3;
  /** Yaw and pitch in radians. */
  look?: [number, number];
  frame?: number;
  settings: Partial<Settings>;
}

/** Longer links are not read. */
const MAX_LENGTH = 2000;
/** No coordinate of an eye is greater, in metres. */
const MAX_METRES = 1e9;
const NUMBER = /^-?(\d+(\.\d*)?|\.\d+)(e[+-]?\d{1,2})?$/i;

/** Keys of settings that are numbers. */
const NUMBER_KEYS: readonly (readonly [string, NumberName])[] = [
  ["ev", "exposureEv"],
  ["fov", "fovDeg"],
  ["eyes", "eyeDistance"],
  ["steps", "steps"],
  ["scale", "scale"],
  ["speed", "speed"],
];

function readNumber(text: string | null): number | undefined {
  return text !== null && text.length <= 40 && NUMBER.test(text) ? Number(text) : undefined;
}

function readNumbers(text: string | null, count: number, limit: number): number[] | undefined {
  const parts = text?.split(",", count + 1) ?? [];
  const numbers = parts.map(readNumber);
  const isSound = (value: number | undefined): value is number => value !== undefined && Math.abs(value) <= limit;
  return numbers.length === count && numbers.every(isSound) ? numbers : undefined;
}

function oneOf<T extends string>(values: readonly T[], text: string | null): T | undefined {
  return values.find((value) => value === text);
}

function readMarks(text: string | null): ReadonlySet<OverlayName> | undefined {
  if (text === null) {
    return undefined;
  }
  const names = new Set(text.split(","));
  return new Set(MARKS.filter((mark) => names.has(mark)));
}

function defined<T extends object>(values: T): Partial<T> {
  return Object.fromEntries(Object.entries(values).filter(([, value]) => value !== undefined)) as Partial<T>;
}

/** True if a link states the position or the direction of the eye. */
export function hasPose({ eye, look }: Link): boolean {
  return eye !== undefined || look !== undefined;
}

/** Reads a hash with or without its #. Never fails: what is wrong is left out. */
export function parseLink(hash: string): Link {
  if (hash.length > MAX_LENGTH) {
    return { settings: {} };
  }
  const values = new URLSearchParams(hash.replace(/^#/, ""));
  const eye = readNumbers(values.get("eye"), 3, MAX_METRES) as Vec3 | undefined;
  const degrees = readNumbers(values.get("look"), 2, 1e6);
  const frame = readNumber(values.get("frame"));
  const settings: Partial<Settings> = defined({
    toneMap: oneOf(TONE_MAPS, values.get("tone")),
    stereo: oneOf(STEREO_LAYOUTS, values.get("stereo")),
    isLooped: values.get("loop") === null ? undefined : values.get("loop") !== "0",
    marks: readMarks(values.get("show")),
    renderer: oneOf(RENDERERS, values.get("renderer")),
  });
  for (const [key, name] of NUMBER_KEYS) {
    const value = readNumber(values.get(key));
    if (value !== undefined) {
      settings[name] = inRange(name, value);
    }
  }
  const link: Link = { settings };
  if (eye !== undefined) {
    link.eye = eye;
  }
  if (degrees !== undefined) {
    const [yaw, pitch] = degrees.map((angle) => (angle * Math.PI) / 180);
    link.look = [wrapAngle(yaw), Math.min(Math.max(pitch, -MAX_PITCH), MAX_PITCH)];
  }
  if (frame !== undefined && Number.isSafeInteger(frame) && frame >= 0) {
    link.frame = frame;
  }
  return link;
}

/** A number without needless digits. */
export function shortNumber(value: number, digits: number): string {
  return String(Number(value.toFixed(digits)) + 0);
}

/** The hash of a view, with its #. */
export function formatLink(pose: Pose, frame: number, settings: Settings): string {
  const degrees = [pose.yaw, pose.pitch].map((angle) => shortNumber((angle * 180) / Math.PI, 3));
  const parts = [`eye=${pose.eye.map((value) => shortNumber(value, 5)).join(",")}`, `look=${degrees.join(",")}`];
  parts.push(`frame=${frame}`);
  const add = (key: string, value: string, usual: string): void => {
    if (value !== usual) {
      parts.push(`${key}=${value}`);
    }
  };
  for (const [key, name] of NUMBER_KEYS) {
    add(key, shortNumber(settings[name], 4), shortNumber(DEFAULTS[name], 4));
  }
  add("tone", settings.toneMap, DEFAULTS.toneMap);
  add("stereo", settings.stereo, DEFAULTS.stereo);
  add("loop", settings.isLooped ? "1" : "0", DEFAULTS.isLooped ? "1" : "0");
  add("renderer", settings.renderer, DEFAULTS.renderer);
  add("show", MARKS.filter((mark) => settings.marks.has(mark)).join(","), "");
  return `#${parts.join("&")}`;
}
