// Rectangles of texels: what two have in common, what holds both, and many as few. Mirrors src/render/views/rects.rs.

import { unitRectOf } from "../format/index_tables.ts";
import type { Rect, Stream } from "../format/types.ts";

/** What two rectangles share; `undefined` where that is nothing. */
export function overlap(a: Rect, b: Rect): Rect | undefined {
  const [left, top] = [Math.max(a[0], b[0]), Math.max(a[1], b[1])];
  const [right, bottom] = [Math.min(a[0] + a[2], b[0] + b[2]), Math.min(a[1] + a[3], b[1] + b[3])];
  return left < right && top < bottom ? [left, top, right - left, bottom - top] : undefined;
}

/** The least rectangle that holds both. */
export function bounds(a: Rect | undefined, b: Rect): Rect {
  if (a === undefined) {
    return b;
  }
  const [left, top] = [Math.min(a[0], b[0]), Math.min(a[1], b[1])];
  const [right, bottom] = [Math.max(a[0] + a[2], b[0] + b[2]), Math.max(a[1] + a[3], b[1] + b[3])];
  return [left, top, right - left, bottom - top];
}

function joinedAlong(axis: 0 | 1, rects: readonly Rect[]): Rect[] {
  const across = axis === 0 ? 1 : 0;
  const ordered = [...rects].sort((a, b) => a[across] - b[across] || a[axis] - b[axis]);
  const all: Rect[] = [];
  for (const rect of ordered) {
    const last = all.at(-1);
    if (
      last !== undefined &&
      last[across] === rect[across] &&
      last[across + 2] === rect[across + 2] &&
      last[axis] + last[axis + 2] === rect[axis]
    ) {
      last[axis + 2] += rect[axis + 2];
    } else {
      all.push([...rect]);
    }
  }
  return all;
}

/** The same texels in fewer rectangles: neighbors in a row that are as high become one, then neighbors in a column that are as wide. */
export function joined(rects: readonly Rect[]): Rect[] {
  return joinedAlong(1, joinedAlong(0, rects));
}

/** Units of a stream's images that overlap a rectangle, each with what they share. */
export function* unitsUnder(
  stream: Pick<Stream, "width" | "height" | "unitWidth" | "unitHeight">,
  rect: Rect,
): Generator<[number, Rect]> {
  const { width, unitWidth, unitHeight } = stream;
  const [left, top, columns, rows] = rect;
  const inRow = Math.ceil(width / unitWidth);
  for (let row = Math.floor(top / unitHeight); row * unitHeight < top + rows; row += 1) {
    for (let column = Math.floor(left / unitWidth); column * unitWidth < left + columns; column += 1) {
      const shared = overlap(unitRectOf(stream, row * inRow + column), rect);
      if (shared !== undefined) {
        yield [row * inRow + column, shared];
      }
    }
  }
}
