// Tiles of one size in the layers of texture arrays. Mirrors `TileGrid` of src/render/atlas/mod.rs.

import { UnsupportedError } from "../format/types.ts";

export interface TileGrid {
  columns: number;
  rows: number;
  layers: number;
}

/** Where a tile is: its column and row in the grid, and its layer. */
export interface TilePlace {
  column: number;
  row: number;
  layer: number;
}

/** A grid for `count` tiles with as few tiles per layer as the limits allow: texels of a side, and layers. */
export function tileGrid(
  [width, height]: readonly [number, number],
  count: number,
  limits: { side: number; layers: number },
): TileGrid {
  const [mostColumns, mostRows] = [Math.floor(limits.side / width), Math.floor(limits.side / height)];
  const perLayer = Math.ceil(count / limits.layers);
  const columns = Math.max(Math.min(perLayer, mostColumns), 1);
  const rows = Math.ceil(perLayer / columns);
  if (mostColumns === 0 || rows > mostRows) {
    const most = mostColumns * mostRows * limits.layers;
    throw new UnsupportedError(
      `${count} images of ${width}x${height} texels are needed at once, and the graphics device holds ${most} of this size.`,
    );
  }
  return { columns, rows, layers: Math.ceil(count / (columns * rows)) };
}

/** The place of a tile by its number. */
export function tilePlace({ columns, rows }: TileGrid, tile: number): TilePlace {
  const ofLayer = tile % (columns * rows);
  return {
    column: ofLayer % columns,
    row: Math.floor(ofLayer / columns),
    layer: Math.floor(tile / (columns * rows)),
  };
}
