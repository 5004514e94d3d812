// Mouse and touch on the picture: dragging turns, two fingers move, a locked pointer turns without dragging.

import type { Vec3 } from "../format/types.ts";

export interface PointerHost {
  /** Radians to the left and up. */
  turn(left: number, up: number): void;
  /** Metres to the right, up, and ahead. */
  move(step: Vec3): void;
  /** Changes the field of view by this factor. */
  zoom(factor: number): void;
  /** The pointer is at this part of the width, 0..1. */
  hover(part: number): void;
  /** Vertical field of view in degrees. */
  fovDeg(): number;
  /** Metres that a finger moves the eye over the height of the picture. */
  reach(): number;
}

/** Radians per pixel of a locked pointer, at a field of view of 60 degrees. */
const LOCKED_RATE = 0.0022;
/** Change of the field of view for each pixel of the wheel. */
const WHEEL_RATE = 0.001;
/** Pixels of a line of the wheel. */
const LINE_PX = 32;

interface Finger {
  x: number;
  y: number;
}

/** Middle of the fingers, and their mean distance from it. */
function spanOf(fingers: Iterable<Finger>): { x: number; y: number; spread: number } {
  const all = [...fingers];
  const x = all.reduce((sum, finger) => sum + finger.x, 0) / all.length;
  const y = all.reduce((sum, finger) => sum + finger.y, 0) / all.length;
  const spread = all.reduce((sum, finger) => sum + Math.hypot(finger.x - x, finger.y - y), 0) / all.length;
  return { x, y, spread };
}

export class PointerInput {
  readonly #stage: HTMLElement;
  readonly #host: PointerHost;
  readonly #fingers = new Map<number, Finger>();

  constructor(stage: HTMLElement, host: PointerHost) {
    this.#stage = stage;
    this.#host = host;
    stage.addEventListener("pointerdown", (event) => this.#down(event));
    stage.addEventListener("pointermove", (event) => this.#moved(event));
    const release = (event: PointerEvent): void => this.#up(event);
    stage.addEventListener("pointerup", release);
    stage.addEventListener("pointercancel", release);
    stage.addEventListener("dblclick", () => this.toggleLock());
    stage.addEventListener("wheel", (event) => this.#wheel(event), { passive: false });
  }

  toggleLock(): void {
    if (document.pointerLockElement === this.#stage) {
      document.exitPointerLock();
      return;
    }
    // Older browsers answer nothing; a refusal (too soon after Escape) needs no word.
    const asked: Promise<void> | undefined = this.#stage.requestPointerLock();
    asked?.catch(() => undefined);
  }

  #down(event: PointerEvent): void {
    if (event.button !== 0 || document.pointerLockElement === this.#stage) {
      return;
    }
    this.#stage.setPointerCapture(event.pointerId);
    this.#fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    this.#stage.classList.add("dragged");
  }

  #up(event: PointerEvent): void {
    this.#fingers.delete(event.pointerId);
    this.#stage.classList.toggle("dragged", this.#fingers.size > 0);
  }

  #moved(event: PointerEvent): void {
    if (document.pointerLockElement === this.#stage) {
      const rate = (LOCKED_RATE * this.#host.fovDeg()) / 60;
      this.#host.turn(-event.movementX * rate, -event.movementY * rate);
      return;
    }
    const area = this.#stage.getBoundingClientRect();
    this.#host.hover(Math.min(Math.max((event.clientX - area.left) / Math.max(area.width, 1), 0), 1));
    if (!this.#fingers.has(event.pointerId)) {
      return;
    }
    const before = spanOf(this.#fingers.values());
    this.#fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    const after = spanOf(this.#fingers.values());
    const [right, down] = [after.x - before.x, after.y - before.y];
    const height = Math.max(area.height, 1);
    if (this.#fingers.size === 1) {
      // The picture follows the hand.
      const perPixel = (this.#host.fovDeg() * Math.PI) / 180 / height;
      this.#host.turn(right * perPixel, down * perPixel);
    } else {
      const perPixel = this.#host.reach() / height;
      this.#host.move([-right * perPixel, down * perPixel, 2 * (after.spread - before.spread) * perPixel]);
    }
  }

  #wheel(event: WheelEvent): void {
    if (event.ctrlKey) {
      return;
    }
    event.preventDefault();
    const pixels = event.deltaMode === WheelEvent.DOM_DELTA_PIXEL ? event.deltaY : event.deltaY * LINE_PX;
    this.#host.zoom(Math.exp(Math.min(Math.max(pixels, -300), 300) * WHEEL_RATE));
  }
}
