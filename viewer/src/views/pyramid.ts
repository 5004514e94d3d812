// Pyramids above the texels of an image: each level has a square for two by two squares below. Mirrors src/render/march/pyramid.rs.

import type { Rect } from "../format/types.ts";

/** Columns and rows of squares of each level above an image, up to a single square. */
export function pyramidSizes([width, height]: readonly [number, number]): [number, number][] {
  const sizes: [number, number][] = [];
  let [columns, rows] = [width, height];
  while (columns > 1 || rows > 1 || sizes.length === 0) {
    [columns, rows] = [Math.ceil(columns / 2), Math.ceil(rows / 2)];
    sizes.push([columns, rows]);
  }
  return sizes;
}

/** The part of a level of a pyramid, counted from 0, that covers a rectangle of texels. */
export function above([left, top, width, height]: Rect, level: number): Rect {
  const span = (begin: number, count: number): [number, number] => {
    const first = begin >> (level + 1);
    return [first, ((begin + count - 1) >> (level + 1)) - first + 1];
  };
  const [[x, columns], [y, rows]] = [span(left, width), span(top, height)];
  return [x, y, columns, rows];
}
