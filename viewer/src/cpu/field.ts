// The light field of the worker that renders: the texels of loaded views, as the page sends them.

import { inverseDepths } from "../views/inverse_depth.ts";
import { MIN_M } from "../views/active.ts";
import { rayLength, VIEW_FACE } from "../views/face.ts";
import { halfValue } from "../views/straight.ts";
import { FaceTexels, UNKNOWN } from "./face_texels.ts";
import { MarchedViews } from "./marched_views.ts";
import type { FaceArea, FaceOutline, Order, PlacedView, Rendered } from "./messages.ts";
import { Marcher, type MarchRequest } from "./marcher.ts";

interface Face {
  outline: FaceOutline;
  texels: FaceTexels;
  /** By code, in 1/m. */
  inverseDepths: Float32Array;
}

/** Numbers of halves, by their bits. */
let halves: Float32Array | undefined;

export class Field {
  readonly #views = new Map<number, Map<number, Face>>();
  /** By near and far. */
  readonly #tables = new Map<string, Float32Array>();

  /** Does what the page orders; answers a picture where that was ordered. */
  run(order: Order): Rendered | undefined {
    switch (order.kind) {
      case "load":
        this.#views.set(order.view, new Map(order.faces.map((face) => [face.face, this.#faceOf(face, order.isLight)])));
        return undefined;
      case "unload":
        this.#views.delete(order.view);
        this.#dropTables();
        return undefined;
      case "depth":
        this.#writeDepths(order.area, order.codes);
        return undefined;
      case "color":
        writeColors(this.#face(order.area).texels.colors, this.#face(order.area).texels.width, order);
        return undefined;
      case "overlay": {
        const { texels } = this.#face(order.area);
        texels.overlay ??= new Uint8Array(4 * texels.width * texels.height);
        writeColors(texels.overlay, texels.width, order);
        return undefined;
      }
      case "render":
        return this.#render(order.request, order.views, order.nearest);
    }
  }

  #faceOf(outline: FaceOutline, isLight: boolean): Face {
    const { range, size, map } = outline;
    const key = `${range.nearM} ${range.farM}`;
    const table = this.#tables.get(key) ?? new Float32Array(inverseDepths(range).buffer);
    this.#tables.set(key, table);
    return { outline, texels: new FaceTexels(size, map, isLight), inverseDepths: table };
  }

  /** Forgets tables that no face has. */
  #dropTables(): void {
    const faces = [...this.#views.values()].flatMap((view) => [...view.values()]);
    const used = new Set(faces.map(({ inverseDepths: table }) => table));
    [...this.#tables].filter(([, table]) => !used.has(table)).forEach(([key]) => this.#tables.delete(key));
  }

  #face({ view, face }: FaceArea): Face {
    const found = this.#views.get(view)?.get(face);
    if (found === undefined) {
      throw new Error(`View ${view} has no face ${face}`);
    }
    return found;
  }

  #writeDepths(area: FaceArea, codes: Uint16Array | undefined): void {
    const { outline, texels, inverseDepths: table } = this.#face(area);
    const [left, top, width, height] = area.rect;
    for (let row = 0; row < height; row += 1) {
      const to = (top + row) * texels.width + left;
      for (let column = 0; column < width; column += 1) {
        let inverse = codes === undefined ? UNKNOWN : table[codes[row * width + column]];
        if (outline.isDistance && codes !== undefined) {
          inverse *= rayLength(outline.map, left + column, top + row);
        }
        texels.inverseDepths[to + column] = inverse;
      }
    }
    texels.update(area.rect);
  }

  #render(request: MarchRequest, places: readonly PlacedView[], nearest: number): Rendered {
    const begun = performance.now();
    const views = places.map(({ view, ...place }) => {
      const faces = this.#views.get(view);
      if (faces === undefined) {
        throw new Error(`View ${view} is not loaded`);
      }
      const texels = Array.from({ length: VIEW_FACE + 1 }, (_, face) => faces.get(face)?.texels);
      const cube = texels.slice(0, VIEW_FACE).filter((face) => face !== undefined);
      // Only a cube has a texel in every direction.
      const isBounded = cube.length === VIEW_FACE && texels[VIEW_FACE] === undefined && place.nearM >= MIN_M;
      const greatest = isBounded ? Math.max(...cube.map((face) => face.greatest)) : UNKNOWN;
      return { ...place, faces: texels, greatest };
    });
    const marched = new MarchedViews(views, nearest, request.coding.name === "light" && !request.showsOverlay);
    const rgba = new Float32Array(4 * request.size[0] * request.size[1]);
    new Marcher(marched, request).render(0, request.size[1], rgba);
    return { rgba, counts: marched.counts, ms: performance.now() - begun };
  }
}

/** Writes colors of a rectangle of an image of so many columns. */
function writeColors(
  to: Uint8Array | Float32Array,
  columns: number,
  { area, texels }: { area: FaceArea; texels: Uint8Array | Uint16Array },
): void {
  const [left, top, width, height] = area.rect;
  for (let row = 0; row < height; row += 1) {
    const begin = 4 * ((top + row) * columns + left);
    const from = 4 * row * width;
    if (texels instanceof Uint8Array) {
      to.set(texels.subarray(from, from + 4 * width), begin);
    } else {
      halves ??= Float32Array.from({ length: 1 << 16 }, (_, bits) => halfValue(bits));
      for (let at = 0; at < 4 * width; at += 1) {
        to[begin + at] = halves[texels[from + at]];
      }
    }
  }
}
