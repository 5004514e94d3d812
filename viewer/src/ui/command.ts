// The current pose as a command line of `lightfold render`.

import type { Pose, StereoLayout } from "../player/types.ts";
import { shortNumber } from "./link.ts";
import { forwardOf } from "./pose.ts";

/** Characters that a terminal may act on when text is pasted into it, and marks that change the order in which text is read. */
const CONTROL = /[\u0000-\u001f\u007f-\u009f\u061c\u200e\u200f\u202a-\u202e\u2066-\u2069]/;

function octal(character: string): string {
  const bytes = new TextEncoder().encode(character);
  return [...bytes].map((byte) => `\\${byte.toString(8).padStart(3, "0")}`).join("");
}

/** A file's name as one word of a POSIX shell, which no program takes for an option. Control characters are written as octal numbers,
 *  within $'...', which bash and zsh read. */
export function shellWord(name: string): string {
  const path = name.startsWith("-") ? `./${name}` : name;
  if (!CONTROL.test(path)) {
    return `'${path.replaceAll("'", "'\\''")}'`;
  }
  const escaped = path.replace(/[\\']/g, "\\$&").replace(new RegExp(CONTROL, "g"), octal);
  return `$'${escaped}'`;
}

/** What a command renders. */
export interface Shot {
  pose: Pose;
  /** Vertical field of view in degrees. */
  fovDeg: number;
  /** Of the whole picture, in pixels. */
  size: [number, number];
  stereo: StereoLayout;
  /** Metres between the eyes. */
  eyeDistance: number;
  /** Absent for still scenes. */
  frame?: number;
}

/** `lightfold render` with the file's name and the shot. Of two eyes, `--size` is that of each. */
export function renderCommand(name: string, shot: Shot): string {
  const words = ["lightfold", "render", shellWord(name)];
  const { pose, stereo } = shot;
  const ahead = forwardOf(pose);
  const place = (values: number[]): string => values.map((value) => shortNumber(value, 5)).join(",");
  words.push("--eye", place(pose.eye));
  words.push("--look-at", place(pose.eye.map((value, axis) => value + ahead[axis])));
  words.push("--fov", shortNumber(shot.fovDeg, 3));
  const eyes = stereo === "side-by-side" ? 2 : 1;
  words.push("--size", `${Math.max(1, Math.round(shot.size[0] / eyes))}x${shot.size[1]}`);
  if (eyes === 2) {
    words.push("--stereo", "side-by-side", "--eye-distance", shortNumber(shot.eyeDistance, 4));
  }
  if (shot.frame !== undefined) {
    words.push("--frames", String(shot.frame));
  }
  words.push("-o", "view.png");
  return words.join(" ");
}
