// The eye circles slowly around the place where the film opens, so that its depth shows, until the viewer touches anything.

import type { Vec3 } from "../format/types.ts";
import { add, scale } from "../math.ts";
import type { Film, Pose } from "../player/types.ts";
import { rightOf } from "./pose.ts";

/** Radius as parts of the nearest depth and of the longest side of the head box; the lesser of them counts. */
const DEPTH_SHARE = 0.05;
const BOX_SHARE = 0.25;
/** Height of the ellipse over its width. */
const HEIGHT_SHARE = 0.5;
const PERIOD_S = 12;
/** Seconds in which the circle grows. */
const GROWTH_S = 4;
const LONGEST_STEP_S = 0.1;

/** Parts of a film that the orbit depends on. */
type Region = Pick<Film, "headBox" | "nearM">;

/** Radius in metres of a circle in the region that the probes cover: 0 for a single probe, of which other eyes see holes. */
export function orbitRadius({ headBox: { least, greatest }, nearM = Infinity }: Region): number {
  const longest = Math.max(...least.map((value, axis) => greatest[axis] - value));
  return Math.min(DEPTH_SHARE * nearM, BOX_SHARE * longest);
}

/** The eye so many seconds after it began to circle around the one of `pose`; it leaves that one smoothly. */
export function orbitEye(pose: Pose, radius: number, seconds: number): Vec3 {
  const angle = (2 * Math.PI * seconds) / PERIOD_S;
  const part = Math.min(seconds / GROWTH_S, 1);
  const grown = radius * part * part * (3 - 2 * part);
  const across = scale(rightOf(pose), grown * Math.sin(angle));
  return add(add(pose.eye, across), [0, HEIGHT_SHARE * grown * Math.cos(angle), 0]);
}

/** State of the orbit: waiting for the first picture, requested by the user, running, or ended for good. */
type State = "waits" | "asked" | "runs" | "ended";

/** Input of {@link Orbit.advance}, once per displayed frame. */
interface Now {
  film: Region;
  /** Seconds since the last frame. */
  seconds: number;
  /** The present view is shown in full. */
  isShown: boolean;
  /** Full pictures are fast enough to move in. */
  isFluent: boolean;
}

export class Orbit {
  #state: State = "waits";
  #middle: Pose | undefined;
  #seconds = 0;

  /** Ends at the first input, except to the field of the orbit itself, or on the first call of {@link Orbit.stop}. */
  constructor() {
    const end = ({ target }: Event): void => {
      if (!(target instanceof Element && target.closest("#orbit-field") !== null)) {
        this.stop();
      }
    };
    ["pointerdown", "wheel", "keydown"].forEach((type) =>
      window.addEventListener(type, end, { capture: true, passive: true }),
    );
  }

  get isOn(): boolean {
    return this.#state !== "ended";
  }

  stop(): void {
    this.#state = "ended";
  }

  /** The viewer asks for it: it begins as soon as it can. */
  ask(): void {
    this.#state = "asked";
  }

  /** The eye that goes on; none where the orbit does not run. It begins at `pose` once that is shown, by itself only where pictures are
   *  fast. */
  advance(pose: Pose, { film, seconds, isShown, isFluent }: Now): Vec3 | undefined {
    if ((this.#state === "asked" || (this.#state === "waits" && isFluent)) && isShown && orbitRadius(film) > 0) {
      [this.#state, this.#middle, this.#seconds] = ["runs", pose, 0];
    }
    if (this.#state !== "runs" || this.#middle === undefined) {
      return undefined;
    }
    // After a pause the eye does not jump.
    this.#seconds += Math.min(Math.max(seconds, 0), LONGEST_STEP_S);
    return orbitEye(this.#middle, orbitRadius(film), this.#seconds);
  }
}
