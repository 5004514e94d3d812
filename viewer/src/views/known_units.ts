// Which units of loaded views have pictures that may be seen, and texels that are not up to date. Mirrors src/render/views/face_cache.rs
// (CALF 6.2).
//
// A texel has a depth once all its kinds have pictures: its tile, its color cell, and its units of alpha and material where there are
// any. Before that it is unknown, as if the probe did not see there. A unit keeps its picture until a new one is written.

import { unitCountOf, unitRectOf } from "../format/index_tables.ts";
import type { Rect, Stream } from "../format/types.ts";
import type { FaceStreams } from "./catalogue.ts";
import { joined, unitsUnder } from "./rects.ts";

/** The units of a stream of a loaded view. */
export class StreamUnits {
  readonly #known: Uint8Array;

  constructor(readonly stream: Stream) {
    this.#known = new Uint8Array(unitCountOf(stream));
  }

  isKnown(unit: number): boolean {
    return this.#known[unit] === 1;
  }

  /** Answers whether this was a change. */
  setKnown(unit: number, isKnown: boolean): boolean {
    const before = this.#known[unit];
    this.#known[unit] = Number(isKnown);
    return before !== Number(isKnown);
  }
}

/** Texels of a tile of depth to be written. */
export interface TexelPart {
  /** In texels of the face, within the tile. */
  rect: Rect;
  tile: number;
  /** Whether they have pictures of all kinds; else they become unknown. */
  isKnown: boolean;
}

/** Chooses units of streams. */
export type UnitFilter = (stream: Stream, unit: number) => boolean;

/** The units of a face. */
export class FaceUnits {
  readonly depth: StreamUnits;
  /** Color, and alpha and material where there are any. */
  readonly others: StreamUnits[];
  /** Depth tiles that have new pictures, or became known or unknown. */
  readonly #staleTiles = new Set<number>();
  /** Rectangles in which units of other kinds became known or unknown. */
  #staleRects: Rect[] = [];
  /** Units of material with a weight above 0. */
  readonly #specular = new Set<number>();

  constructor(readonly streams: FaceStreams) {
    this.depth = new StreamUnits(streams.depth);
    this.others = [streams.color, streams.alpha, streams.material]
      .filter((stream) => stream !== undefined)
      .map((stream) => new StreamUnits(stream));
  }

  /** Takes in that a unit has a new picture, or none that may be seen. */
  setKnown(units: StreamUnits, unit: number, isKnown: boolean): void {
    const isChange = units.setKnown(unit, isKnown);
    if (units === this.depth && isKnown) {
      this.#staleTiles.add(unit);
    } else if (isChange) {
      this.#staleRects.push(unitRectOf(units.stream, unit));
    }
  }

  /** Takes in the pixels of a unit of material, three bytes each: weights of reflection and refraction come first. */
  setMaterial(unit: number, pixels: Uint8Array): void {
    this.#specular.delete(unit);
    if (pixels.some((weight, at) => weight > 0 && at % 3 < 2)) {
      this.#specular.add(unit);
    }
  }

  /** Whether a unit of material that passes the filter has a weight above 0. */
  isSpecular(passes: UnitFilter): boolean {
    const { material } = this.streams;
    return material !== undefined && [...this.#specular].some((unit) => passes(material, unit));
  }

  /** The texels to be written since the last call. */
  takeParts(): TexelPart[] {
    const stale = new Map<number, Rect[]>();
    for (const tile of this.#staleTiles) {
      stale.set(tile, [unitRectOf(this.streams.depth, tile)]);
    }
    for (const rect of this.#staleRects) {
      for (const [tile, shared] of unitsUnder(this.depth.stream, rect)) {
        if (!this.#staleTiles.has(tile)) {
          stale.set(tile, [...(stale.get(tile) ?? []), shared]);
        }
      }
    }
    this.#staleTiles.clear();
    this.#staleRects = [];
    return [...stale].flatMap(([tile, rects]) => this.#partsOf(tile, rects));
  }

  #partsOf(tile: number, rects: readonly Rect[]): TexelPart[] {
    let parts = rects.map((rect) => ({ rect, isKnown: this.depth.isKnown(tile) }));
    for (const units of this.others) {
      parts = parts.flatMap(({ rect, isKnown }) =>
        [...unitsUnder(units.stream, rect)].map(([unit, shared]) => ({
          rect: shared,
          isKnown: isKnown && units.isKnown(unit),
        })),
      );
    }
    // Units of two kinds that turn together cover the same texels.
    const unique = [...new Map(parts.map((part) => [part.rect.join(), part])).values()];
    return [true, false].flatMap((isKnown) => {
      const alike = unique.filter((part) => part.isKnown === isKnown).map(({ rect }) => rect);
      return joined(alike).map((rect) => ({ rect, tile, isKnown }));
    });
  }
}

/** A stream's units and their face. */
interface Place<Face> {
  face: Face;
  units: StreamUnits;
}

/** The faces of loaded views, and their units by the numbers of streams. */
export class LoadedFaces<Face extends FaceUnits> {
  readonly #views = new Map<number, Face[]>();
  readonly #places = new Map<number, Place<Face>>();

  load(view: number, faces: Face[]): void {
    this.#views.set(view, faces);
    for (const face of faces) {
      [face.depth, ...face.others].forEach((units) => this.#places.set(units.stream.index, { face, units }));
    }
  }

  /** Answers the faces of a view, which is loaded no more. */
  unload(view: number): Face[] {
    const faces = this.ofView(view);
    for (const { depth, others } of faces) {
      [depth, ...others].forEach(({ stream }) => this.#places.delete(stream.index));
    }
    this.#views.delete(view);
    return faces;
  }

  /** Loaded views with their faces. */
  views(): IterableIterator<[number, Face[]]> {
    return this.#views.entries();
  }

  ofView(view: number): Face[] {
    const found = this.#views.get(view);
    if (found === undefined) {
      throw new Error(`View ${view} is not loaded`);
    }
    return found;
  }

  /** Whether a unit of material of a view that passes the filter has a weight above 0. False for a view that is not loaded. */
  isSpecular(view: number, passes: UnitFilter): boolean {
    return this.#views.get(view)?.some((face) => face.isSpecular(passes)) ?? false;
  }

  /** A stream of a loaded view. */
  ofStream(stream: number): Place<Face> {
    const found = this.#places.get(stream);
    if (found === undefined) {
      throw new Error(`Stream ${stream} is of no loaded view`);
    }
    return found;
  }

  /** Whether a unit has a picture that may be seen. */
  isKnown(stream: number, unit: number): boolean {
    return this.ofStream(stream).units.isKnown(unit);
  }

  /** Takes in whether a unit has a picture that may be seen; a new one is up to date nowhere. */
  setKnown(stream: number, unit: number, isKnown: boolean): void {
    const { face, units } = this.ofStream(stream);
    face.setKnown(units, unit, isKnown);
  }
}
