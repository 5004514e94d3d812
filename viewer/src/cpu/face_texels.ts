// The texels of a face in memory, and the greatest inverse depths of squares of them (CALF 6.2). Mirrors src/render/march/pyramid.rs.

import type { Rect } from "../format/types.ts";
import type { TexelMap } from "../views/face.ts";
import { above, pyramidSizes } from "../views/pyramid.ts";

/** The inverse depth of a texel that is not known. */
export const UNKNOWN = Infinity;
/** The inverse depth of the background. */
export const BACKGROUND = 0;

/** One level of a pyramid: the greatest inverse depth of each square of two by two below. */
export interface Level {
  width: number;
  height: number;
  greatest: Float32Array;
}

/** A face whose texels are unknown at first. */
export class FaceTexels {
  readonly width: number;
  readonly height: number;
  /** 1/m along the axis of the face, row by row. */
  readonly inverseDepths: Float32Array;
  /** Red, green, blue and alpha of each texel: codes over 255, or light. */
  readonly colors: Uint8Array | Float32Array;
  /** Codes of an overlay in the place of colors, once there is one. */
  overlay: Uint8Array | undefined;
  /** From the texels up; the last one has a single square. */
  readonly levels: readonly Level[];

  /** `isLight` where colors are half floats of light, and not 8-bit codes. */
  constructor(
    size: readonly [number, number],
    readonly map: TexelMap,
    isLight: boolean,
  ) {
    [this.width, this.height] = size;
    const texels = this.width * this.height;
    this.inverseDepths = new Float32Array(texels).fill(UNKNOWN);
    this.colors = isLight ? new Float32Array(4 * texels) : new Uint8Array(4 * texels);
    this.levels = pyramidSizes(size).map(([width, height]) => ({
      width,
      height,
      greatest: new Float32Array(width * height).fill(UNKNOWN),
    }));
  }

  /** The greatest inverse depth of all texels; {@link UNKNOWN} where one is. */
  get greatest(): number {
    return this.levels[this.levels.length - 1].greatest[0];
  }

  /** Brings the levels to the inverse depths of a rectangle, which changed. */
  update(rect: Rect): void {
    let below: Level = { width: this.width, height: this.height, greatest: this.inverseDepths };
    this.levels.forEach((level, number) => {
      const [left, top, columns, rows] = above(rect, number);
      const { width, height, greatest } = below;
      for (let row = top; row < top + rows; row += 1) {
        const upper = 2 * row * width;
        const lower = Math.min(2 * row + 1, height - 1) * width;
        for (let column = left; column < left + columns; column += 1) {
          const first = 2 * column;
          const second = Math.min(first + 1, width - 1);
          level.greatest[row * level.width + column] = Math.max(
            greatest[upper + first],
            greatest[upper + second],
            greatest[lower + first],
            greatest[lower + second],
          );
        }
      }
      below = level;
    });
  }

  /** The greatest inverse depth of the texels from (left, top) to (right, bottom), or of somewhat more of them. */
  greatestBetween(left: number, top: number, right: number, bottom: number): number {
    const extent = Math.max(right - left, bottom - top);
    const number = extent === 0 ? 0 : 31 - Math.clz32(extent);
    if (number > this.levels.length) {
      return UNKNOWN;
    }
    const level = number === 0 ? undefined : this.levels[number - 1];
    const [values, width] = level === undefined ? [this.inverseDepths, this.width] : [level.greatest, level.width];
    let greatest = 0;
    for (let row = top >> number; row <= bottom >> number; row += 1) {
      for (let at = row * width + (left >> number); at <= row * width + (right >> number); at += 1) {
        if (values[at] > greatest) {
          greatest = values[at];
        }
      }
    }
    return greatest;
  }
}
