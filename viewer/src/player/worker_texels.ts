// Texels that lie in the worker that renders: what of the pictures of units was not sent there yet.

import type { Catalogue, FaceStreams } from "../views/catalogue.ts";
import type { Rect } from "../format/types.ts";
import { unitRectOf } from "../format/index_tables.ts";
import { FaceUnits, LoadedFaces, type UnitFilter } from "../views/known_units.ts";
import type { Texels } from "../views/texels.ts";
import type { Order } from "../cpu/messages.ts";

/** The codes of a tile, row by row. */
type TileCodes = (stream: number, tile: number) => Uint16Array;

class SentFace extends FaceUnits {
  constructor(
    streams: FaceStreams,
    readonly view: number,
    readonly codes: TileCodes,
  ) {
    super(streams);
  }
}

export class WorkerTexels implements Texels {
  readonly #loaded = new LoadedFaces<SentFace>();

  constructor(
    private readonly catalogue: Catalogue,
    private readonly send: (order: Order) => void,
  ) {}

  /** Loads a view of which nothing is known; its tiles have codes once they are written. */
  load(view: number, codes: TileCodes): void {
    const { faces, nearM, farM } = this.catalogue.views[view];
    this.#loaded.load(
      view,
      faces.map((face) => new SentFace(face, view, codes)),
    );
    const rows = faces.flatMap(({ face, size, map, header: { range, isDistance }, alpha, material }) => {
      const flags = [isDistance, alpha !== undefined, material !== undefined].map(Number);
      return [face, ...size, ...map.scale, ...map.center, range.nearM, range.farM, ...flags];
    });
    this.send({ kind: "load", view, numbers: Float64Array.of(nearM, farM, ...rows) });
  }

  unload(view: number): void {
    this.#loaded.unload(view);
    this.send({ kind: "unload", view });
  }

  isKnown(stream: number, unit: number): boolean {
    return this.#loaded.isKnown(stream, unit);
  }

  written(stream: number, unit: number): void {
    this.#loaded.setKnown(stream, unit, true);
  }

  forget(stream: number, unit: number): void {
    this.#loaded.setKnown(stream, unit, false);
  }

  uploadColor(stream: number, rect: Rect, texels: Uint8Array | Uint16Array): void {
    const { view, streams } = this.#loaded.ofStream(stream).face;
    this.send({ kind: "color", area: { view, face: streams.face, rect }, texels });
  }

  uploadMaterial(stream: number, unit: number, pixels: Uint8Array): void {
    const { face, units } = this.#loaded.ofStream(stream);
    face.setMaterial(unit, pixels);
    const area = { view: face.view, face: face.streams.face, rect: unitRectOf(units.stream, unit) };
    this.send({ kind: "material", area, texels: pixels });
    this.written(stream, unit);
  }

  isSpecular(view: number, passes: UnitFilter): boolean {
    return this.#loaded.isSpecular(view, passes);
  }

  update(): void {
    for (const [view, faces] of this.#loaded.views()) {
      for (const face of faces) {
        const { depth, face: number } = face.streams;
        for (const { rect, tile, isKnown } of face.takeParts()) {
          const codes = isKnown ? partOf(face.codes(depth.index, tile), unitRectOf(depth, tile), rect) : undefined;
          this.send({ kind: "depth", area: { view, face: number, rect }, codes });
        }
      }
    }
  }
}

/** Pixels of a rectangle within the one that some lie in. */
function partOf(codes: Uint16Array, [left, top, width]: Rect, rect: Rect): Uint16Array {
  const part = new Uint16Array(rect[2] * rect[3]);
  for (let row = 0; row < rect[3]; row += 1) {
    const from = (rect[1] - top + row) * width + rect[0] - left;
    part.set(codes.subarray(from, from + rect[2]), row * rect[2]);
  }
  return part;
}
