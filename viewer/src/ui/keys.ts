// Keys and buttons: what each does.

import type { Vec3 } from "../format/types.ts";

/** What a key or a button of the page does once. */
export type Action =
  | "play"
  | "step-back"
  | "step-forward"
  | "first"
  | "last"
  | "loop"
  | "slower"
  | "faster"
  | "reset"
  | "lock-pointer"
  | "settings"
  | "inspector"
  | "help"
  | "full-screen"
  | "screenshot";

/** The parts of a `KeyboardEvent` that count. */
export interface KeyPress {
  key: string;
  code: string;
  ctrlKey: boolean;
  altKey: boolean;
  metaKey: boolean;
}

/** What has the focus: `text` takes all keys, `widget` those that press, move or scroll it, `slider` and `panel` those that move or
 *  scroll them. */
export type Focus = "picture" | "panel" | "slider" | "widget" | "text";

const ACTIONS: ReadonlyMap<string, Action> = new Map<string, Action>([
  [" ", "play"],
  ["k", "play"],
  [",", "step-back"],
  [".", "step-forward"],
  ["Home", "first"],
  ["End", "last"],
  ["l", "loop"],
  ["[", "slower"],
  ["]", "faster"],
  ["0", "reset"],
  ["r", "reset"],
  ["m", "lock-pointer"],
  ["v", "settings"],
  ["i", "inspector"],
  ["h", "help"],
  ["?", "help"],
  ["f", "full-screen"],
  ["c", "screenshot"],
]);

/** Keys that move a slider or scroll a panel, and those that other widgets use. */
const MOVING_KEYS: ReadonlySet<string> = new Set(["Home", "End", "ArrowLeft", "ArrowRight", "ArrowUp", "ArrowDown"]);
const WIDGET_KEYS: ReadonlySet<string> = new Set([...MOVING_KEYS, " ", "Enter"]);
const KEYS_OF: Readonly<Record<Focus, ReadonlySet<string>>> = {
  picture: new Set(),
  panel: MOVING_KEYS,
  slider: MOVING_KEYS,
  widget: WIDGET_KEYS,
  text: WIDGET_KEYS,
};

/** Whether the page may use a key. */
export function isForPage(press: KeyPress, focus: Focus): boolean {
  const hasModifier = press.ctrlKey || press.altKey || press.metaKey;
  return !hasModifier && focus !== "text" && !KEYS_OF[focus].has(press.key);
}

/** What the key does once. */
export function actionOf(press: KeyPress, focus: Focus): Action | undefined {
  const key = press.key.length === 1 ? press.key.toLowerCase() : press.key;
  return isForPage(press, focus) ? ACTIONS.get(key) : undefined;
}

/** Steps right, up and ahead of keys that are held, by their place on the keyboard. */
const MOVES: ReadonlyMap<string, Vec3> = new Map([
  ["KeyW", [0, 0, 1]],
  ["KeyS", [0, 0, -1]],
  ["KeyA", [-1, 0, 0]],
  ["KeyD", [1, 0, 0]],
  ["KeyE", [0, 1, 0]],
  ["KeyQ", [0, -1, 0]],
]);

/** Turns left and up of keys that are held. */
const TURNS: ReadonlyMap<string, [number, number]> = new Map([
  ["ArrowLeft", [1, 0]],
  ["ArrowRight", [-1, 0]],
  ["ArrowUp", [0, 1]],
  ["ArrowDown", [0, -1]],
]);

/** Whether holding this key moves or turns the eye. */
export function isMotionKey(code: string): boolean {
  return MOVES.has(code) || TURNS.has(code);
}

/** Motion of what is held: right, up and ahead, each -1..1; left and up turns, each -1..1. */
export interface Motion {
  step: Vec3;
  turn: [number, number];
}

/** The sum of all keys that are held. */
export function motionOf(held: Iterable<string>): Motion {
  const motion: Motion = { step: [0, 0, 0], turn: [0, 0] };
  for (const code of held) {
    MOVES.get(code)?.forEach((value, axis) => (motion.step[axis] += value));
    TURNS.get(code)?.forEach((value, axis) => (motion.turn[axis] += value));
  }
  return motion;
}

/** Deflections of a stick below this are noise. */
const DEAD_ZONE = 0.15;

function deflection(value: number | undefined): number {
  const size = Math.abs(value ?? 0);
  return size < DEAD_ZONE ? 0 : Math.sign(value ?? 0) * Math.min((size - DEAD_ZONE) / (1 - DEAD_ZONE), 1);
}

/** The parts of a `Gamepad` of the standard mapping that count. */
export interface Pad {
  axes: readonly number[];
  buttons: readonly { pressed: boolean; value: number }[];
}

/** Left stick moves, right stick turns, triggers move down and up. */
export function motionOfPad({ axes, buttons }: Pad): Motion {
  const lift = (buttons[7]?.value ?? 0) - (buttons[6]?.value ?? 0);
  return {
    step: [deflection(axes[0]), lift, -deflection(axes[1])],
    turn: [-deflection(axes[2]), -deflection(axes[3])],
  };
}

/** Buttons of the standard mapping: A, Y, and those above the triggers. */
export const PAD_ACTIONS: readonly (readonly [number, Action])[] = [
  [0, "play"],
  [3, "reset"],
  [4, "step-back"],
  [5, "step-forward"],
];
