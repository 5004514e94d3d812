// Input: keys, mouse, touch and gamepad become motion of the eye, and actions.

import type { Vec3 } from "../format/types.ts";
import { actionOf, isForPage, isMotionKey, motionOf, motionOfPad, PAD_ACTIONS } from "./keys.ts";
import type { Action, Focus, Motion } from "./keys.ts";
import { PointerInput } from "./pointer.ts";
import type { PointerHost } from "./pointer.ts";

export interface ControlsHost extends PointerHost {
  act(action: Action): void;
  /** Metres per second of held keys. */
  moveSpeed(): number;
}

/** Degrees per second of arrow keys and sticks, at a field of view of 60 degrees. */
const TURN_RATE_DEG = 70;
/** Shift, and the left stick pressed, multiply the speed. */
const FAST = 4;
/** After a pause the eye does not jump: longest time of a step in seconds. */
const LONGEST_STEP_S = 0.5;

/** Whether the choices of a list are shown. Browsers that do not tell let no keys through meanwhile. */
function isOpen(list: HTMLSelectElement): boolean {
  return CSS.supports("selector(:open)") && list.matches(":open");
}

function focusOf(target: EventTarget | null): Focus {
  if (!(target instanceof HTMLElement)) {
    return "picture";
  }
  if (target instanceof HTMLSelectElement) {
    return isOpen(target) ? "text" : "widget";
  }
  if (target instanceof HTMLInputElement) {
    const isPressed = ["checkbox", "radio", "button"].includes(target.type);
    return target.type === "range" ? "slider" : isPressed ? "widget" : "text";
  }
  if (target.matches("aside, aside section")) {
    return "panel";
  }
  return target.closest("button, a, summary, pre, aside") === null ? "picture" : "widget";
}

export class Controls {
  readonly #host: ControlsHost;
  readonly #pointer: PointerInput;
  /** Keys that are down, and since when, in milliseconds. */
  readonly #held = new Map<string, number>();
  #advancedMs = 0;
  readonly #pressedPads = new Set<string>();
  #isFast = false;

  /** Listens to the window, and to pointers on the stage, until the page ends. */
  constructor(stage: HTMLElement, host: ControlsHost) {
    this.#host = host;
    this.#pointer = new PointerInput(stage, host);
    window.addEventListener("keydown", (event) => this.#down(event));
    window.addEventListener("keyup", (event) => this.#up(event));
    window.addEventListener("blur", () => {
      this.#held.clear();
      this.#isFast = false;
    });
    // What was pressed with a pointer does not keep the keyboard from the picture.
    let isPointer = false;
    window.addEventListener("pointerdown", () => (isPointer = true), { capture: true });
    window.addEventListener("keydown", () => (isPointer = false), { capture: true });
    const returnFocus = ({ target }: Event, selector: string): void => {
      if (isPointer && target instanceof Element && target.closest(selector) !== null) {
        stage.focus({ preventScroll: true });
      }
    };
    window.addEventListener("click", (event) =>
      returnFocus(event, "#tools button:not([aria-expanded='true']), #transport button"),
    );
    window.addEventListener("change", (event) => returnFocus(event, "select"));
  }

  /** Moves the eye by what is held down, for the seconds since the last call. */
  advance(seconds: number): void {
    const time = Math.min(Math.max(seconds, 0), LONGEST_STEP_S);
    this.#advancedMs = performance.now();
    this.#apply(motionOf(this.#held.keys()), this.#isFast, time);
    // Gamepads are listed once one of their buttons was pressed.
    for (const pad of navigator.getGamepads?.() ?? []) {
      if (pad?.mapping === "standard") {
        this.#apply(motionOfPad(pad), pad.buttons[10]?.pressed === true, time);
        this.#press(pad);
      }
    }
  }

  /** Locks the pointer to the picture, or lets it go. */
  toggleLock(): void {
    this.#pointer.toggleLock();
  }

  #down(event: KeyboardEvent): void {
    this.#isFast = event.shiftKey;
    const focus = focusOf(event.target);
    const action = actionOf(event, focus);
    if (action !== undefined) {
      event.preventDefault();
      if (!event.repeat || action.startsWith("step")) {
        this.#host.act(action);
      }
    } else if (isMotionKey(event.code) && isForPage(event, focus)) {
      event.preventDefault();
      this.#held.set(event.code, this.#held.get(event.code) ?? performance.now());
    }
  }

  #up(event: KeyboardEvent): void {
    const pressedMs = this.#held.get(event.code);
    if (pressedMs !== undefined) {
      // What it did since the last step, which may be all where pictures are slow.
      const seconds = (performance.now() - Math.max(pressedMs, this.#advancedMs)) / 1000;
      this.#apply(motionOf([event.code]), this.#isFast, Math.min(Math.max(seconds, 0), LONGEST_STEP_S));
      this.#held.delete(event.code);
    }
    this.#isFast = event.shiftKey;
  }

  #apply({ step, turn }: Motion, isFast: boolean, seconds: number): void {
    if (step.some((value) => value !== 0)) {
      const length = Math.max(1, Math.hypot(...step));
      const metres = ((isFast ? FAST : 1) * this.#host.moveSpeed() * seconds) / length;
      this.#host.move(step.map((value) => value * metres) as Vec3);
    }
    if (turn.some((value) => value !== 0)) {
      const radians = (((TURN_RATE_DEG * Math.PI) / 180) * seconds * this.#host.fovDeg()) / 60;
      this.#host.turn(turn[0] * radians, turn[1] * radians);
    }
  }

  #press(pad: Gamepad): void {
    for (const [button, action] of PAD_ACTIONS) {
      const name = `${pad.index} ${button}`;
      const isPressed = pad.buttons[button]?.pressed === true;
      if (isPressed && !this.#pressedPads.has(name)) {
        this.#pressedPads.add(name);
        this.#host.act(action);
      } else if (!isPressed) {
        this.#pressedPads.delete(name);
      }
    }
  }
}
