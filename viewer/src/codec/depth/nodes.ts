// Nodes of the quadtree of a unit: where they lie, and the eight words that say what they hold (formats/depth.md 7).

import type { Rect } from "../../format/types.ts";

/** Words of a node's coefficients: bytes 0 to 3 are the first, the lowest byte first. */
export const NODE_WORDS = 8;
/** Levels of nodes: 0 to 8. */
export const LEVELS = 9;
/** Most pixels of a side of a unit. */
export const MAX_SIDE = 1024;
/** The last two words of a biquadratic function, and the last word of a platelet. */
export const MARKER = 0xffffffff;

/** Functions of nodes: what they are made of. */
export type NodeFunction = "raw" | "biquadratic" | "platelet" | "bc4w";

/** A place of the quadtree as one number: its level, column and row, counted in nodes of that level. */
export type Place = number;

/** The number of a place; column and row are 0 to 255. */
export function placeOf(level: number, column: number, row: number): Place {
  return (level << 16) | (row << 8) | column;
}

/** Level of a place, 0 to 8: the side is 4 · 2^level pixels. */
export function levelOf(place: Place): number {
  return place >> 16;
}

/** Pixels of a side of the nodes of a level. */
export function sideOf(level: number): number {
  return 4 << level;
}

/** Left and top of a place in pixels of the unit. */
function cornerOf(place: Place): [number, number] {
  const side = sideOf(levelOf(place));
  return [(place & 0xff) * side, ((place >> 8) & 0xff) * side];
}

/** The pixels of a unit, at most 1024x1024, that nodes cover. */
export class Grid {
  readonly width: number;
  readonly height: number;

  constructor(width: number, height: number) {
    this.width = width;
    this.height = height;
  }

  /** The least level whose one node covers the unit. */
  get rootLevel(): number {
    let level = 0;
    while (sideOf(level) < Math.max(this.width, this.height)) {
      level += 1;
    }
    return level;
  }

  /** Leaves of the unit. */
  get leaves(): number {
    return Math.ceil(this.width / 4) * Math.ceil(this.height / 4);
  }

  /** Whether a place has pixels in the unit. */
  has(place: Place): boolean {
    const [x, y] = cornerOf(place);
    return x < this.width && y < this.height;
  }

  /** The rectangle of a place as far as it lies in the unit. */
  rectOf(place: Place): Rect {
    const [x, y] = cornerOf(place);
    const side = sideOf(levelOf(place));
    return [x, y, Math.min(side, this.width - x), Math.min(side, this.height - y)];
  }

  /** Pixels of a place that lie in the unit. */
  pixelsOf(place: Place): number {
    const [, , width, height] = this.rectOf(place);
    return width * height;
  }
}

/** Calls `visit` with the four places of the next finer level that lie in a place, in the order of the walk: along rows, from the top. */
export function forChildren(place: Place, visit: (child: Place) => void): void {
  const level = levelOf(place) - 1;
  const column = 2 * (place & 0xff);
  const row = 2 * ((place >> 8) & 0xff);
  visit(placeOf(level, column, row));
  visit(placeOf(level, column + 1, row));
  visit(placeOf(level, column, row + 1));
  visit(placeOf(level, column + 1, row + 1));
}

/** The function of a node of `level` whose coefficients start at word `at`. */
export function functionOf(level: number, words: Uint32Array, at: number): NodeFunction {
  if (level === 0) {
    return "raw";
  }
  if (words[at + 7] !== MARKER) {
    return "bc4w";
  }
  return words[at + 6] === MARKER ? "biquadratic" : "platelet";
}
