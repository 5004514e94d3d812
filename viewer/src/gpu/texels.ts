// The texels of views on the device: which units have pictures, and what of them is not in the textures yet. Mirrors
// src/views/face_cache.rs and src/gpu/render/backend.rs (CALF 6.2).
//
// A texel has a depth once all its kinds have pictures: its tile, its color cell, and its units of alpha and material where there are
// any. Before that it is unknown, as if the probe did not see there. A unit keeps its picture until a new one is written.

import type { Rect, Stream } from "../format/types.ts";
import { unitCountOf, unitRectOf } from "../format/index_tables.ts";
import type { Catalogue, FaceStreams } from "../views/catalogue.ts";
import { bounds, joined, unitsUnder } from "../views/rects.ts";
import type { FamilyDecoder } from "./decoder.ts";
import type { DepthPart, PlaneKernels, TileParts } from "./depth_planes.ts";
import { DepthPlanes, DepthTables } from "./depth_planes.ts";
import { DeviceError } from "./device.ts";
import type { Gpu } from "./device.ts";
import type { Origin } from "./texture_arrays.ts";
import { TextureArrays } from "./texture_arrays.ts";

/** Where the device decodes a stream: its decoder, and its position among the decoder's streams. */
export interface DevicePictures {
  decoder: FamilyDecoder;
  position: number;
}

/** The units of a stream of a loaded view. */
class StreamUnits {
  readonly #known: Uint8Array;

  constructor(
    readonly stream: Stream,
    readonly face: LoadedFace,
    readonly pictures: DevicePictures | undefined,
  ) {
    this.#known = new Uint8Array(unitCountOf(stream));
  }

  isKnown(unit: number): boolean {
    return this.#known[unit] === 1;
  }

  /** Whether this was a change. */
  setKnown(unit: number, isKnown: boolean): boolean {
    const before = this.#known[unit];
    this.#known[unit] = Number(isKnown);
    return before !== Number(isKnown);
  }
}

class LoadedFace {
  readonly depth: StreamUnits;
  /** Color, and alpha and material where there are any. */
  readonly others: StreamUnits[];
  /** Depth tiles that have new pictures, or became known or unknown. */
  readonly staleTiles = new Set<number>();
  /** Rectangles in which units of other kinds became known or unknown. */
  staleRects: Rect[] = [];
  /** Color cells whose pictures on the device are new. */
  readonly staleCells = new Set<number>();
  /** Units of material with a weight above 0. */
  readonly specular = new Set<number>();
  /** What is to be copied besides what is written. */
  copied: Rect | undefined;

  constructor(
    readonly streams: FaceStreams,
    readonly tile: number,
    picturesOf: (stream: Stream) => DevicePictures | undefined,
  ) {
    const units = (stream: Stream): StreamUnits => new StreamUnits(stream, this, picturesOf(stream));
    this.depth = units(streams.depth);
    this.others = [streams.color, streams.alpha, streams.material]
      .filter((stream) => stream !== undefined)
      .map((stream) => units(stream));
    // The tile may have had another image.
    this.copied = [0, 0, ...streams.size];
  }

  /** Depths to be written: stale ones, in parts that have pictures of all kinds, and parts that do not. */
  takeParts(): DepthPart[] {
    const stale = new Map<number, Rect[]>();
    for (const tile of this.staleTiles) {
      stale.set(tile, [unitRectOf(this.streams.depth, tile)]);
    }
    for (const rect of this.staleRects) {
      for (const [tile, shared] of unitsUnder(this.depth.stream, rect)) {
        if (!this.staleTiles.has(tile)) {
          stale.set(tile, [...(stale.get(tile) ?? []), shared]);
        }
      }
    }
    this.staleTiles.clear();
    this.staleRects = [];
    return [...stale].flatMap(([tile, rects]) => this.#partsOf(tile, rects));
  }

  #partsOf(tile: number, rects: readonly Rect[]): DepthPart[] {
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
    const { decoder, position } = this.depth.pictures!;
    const [left, top] = unitRectOf(this.streams.depth, tile);
    return [true, false].flatMap((wanted) => {
      const alike = unique.filter(({ isKnown }) => isKnown === wanted).map(({ rect }) => rect);
      const picture = wanted ? decoder.unit(position, tile) : undefined;
      return joined(alike).map((rect) => ({ face: this.streams.face, rect, picture, corner: [left, top] as const }));
    });
  }
}

interface LoadedView {
  planes: DepthPlanes;
  faces: LoadedFace[];
}

/** The texels of the loaded views of a container. Views are numbered as in the catalogue, streams as in the container. */
export class LightFieldTexels {
  readonly arrays: TextureArrays;
  readonly #tables = new DepthTables();
  readonly #views = new Map<number, LoadedView>();
  readonly #units = new Map<number, StreamUnits>();

  private constructor(
    private readonly gpu: Gpu,
    private readonly kernels: PlaneKernels,
    readonly catalogue: Catalogue,
    images: number,
  ) {
    this.arrays = new TextureArrays(gpu, catalogue, images);
  }

  /** Room for so many images at once; no view is loaded. */
  static async create(gpu: Gpu, catalogue: Catalogue, images: number): Promise<LightFieldTexels> {
    const [texels, squares] = await Promise.all([gpu.pipeline("texels"), gpu.pipeline("squares")]);
    return new LightFieldTexels(gpu, { texels, squares }, catalogue, images);
  }

  /** Loads a view of which nothing is known. `pictures`, by the numbers of streams, has all its depth and those of its colors that the
   *  device decodes, with rows of a multiple of 64 words; pixels of other streams are uploaded. */
  load(view: number, pictures: ReadonlyMap<number, DevicePictures>): void {
    const { faces } = this.catalogue.views[view];
    const planes = new DepthPlanes(this.gpu, this.kernels, faces, this.#tables);
    const tiles = faces.map(() => this.arrays.take());
    const loaded = faces.flatMap((face, at) => {
      const tile = tiles[at];
      return tile === undefined ? [] : [new LoadedFace(face, tile, ({ index }) => pictures.get(index))];
    });
    if (loaded.length < faces.length) {
      loaded.forEach(({ tile }) => this.arrays.free(tile));
      planes.destroy();
      throw new DeviceError("The textures have no room for another probe.");
    }
    this.#views.set(view, { planes, faces: loaded });
    for (const { depth, others } of loaded) {
      [depth, ...others].forEach((units) => this.#units.set(units.stream.index, units));
    }
  }

  /** Frees the tiles of a view. */
  unload(view: number): void {
    const { planes, faces } = this.#loaded(view);
    planes.destroy();
    for (const { depth, others, tile } of faces) {
      [depth, ...others].forEach(({ stream }) => this.#units.delete(stream.index));
      this.arrays.free(tile);
    }
    this.#views.delete(view);
  }

  /** Bytes of planes and tables. */
  get bytes(): number {
    return [...this.#views.values()].reduce((sum, { planes }) => sum + planes.bytes, 0);
  }

  /** Whether a unit has a picture that may be seen. */
  isKnown(stream: number, unit: number): boolean {
    return this.#unitsOf(stream).isKnown(unit);
  }

  /** Takes in that a unit has a new picture: on the device, or all of its texels were uploaded. */
  written(stream: number, unit: number): void {
    const units = this.#unitsOf(stream);
    const { face, pictures } = units;
    const isNew = units.setKnown(unit, true);
    if (units === face.depth) {
      face.staleTiles.add(unit);
      return;
    }
    if (pictures !== undefined) {
      face.staleCells.add(unit);
    }
    if (isNew) {
      face.staleRects.push(unitRectOf(units.stream, unit));
    }
  }

  /** Takes in that a unit shows nothing that may be seen: its texels become unknown until it is written again. */
  forget(stream: number, unit: number): void {
    const units = this.#unitsOf(stream);
    if (units.setKnown(unit, false)) {
      units.face.staleRects.push(unitRectOf(units.stream, unit));
    }
  }

  /** Sends texels of a rectangle of a color stream, row by row: those of `ColorTexels`. */
  uploadColor(stream: number, rect: Rect, texels: Uint8Array | Uint16Array): void {
    this.arrays.upload("colors", this.#unitsOf(stream).face.tile, rect, texels);
  }

  /** Sends the pixels of a unit of material, three bytes each, and takes in that it is written. */
  uploadMaterial(stream: number, unit: number, pixels: Uint8Array): void {
    const { face, stream: info } = this.#unitsOf(stream);
    const texels = new Uint8Array((pixels.length / 3) * 4);
    let isSpecular = false;
    for (let from = 0, to = 0; from < pixels.length; from += 3, to += 4) {
      texels.set([pixels[from], pixels[from + 1], pixels[from + 2]], to);
      isSpecular ||= pixels[from] > 0 || pixels[from + 1] > 0;
    }
    face.specular.delete(unit);
    if (isSpecular) {
      face.specular.add(unit);
    }
    this.arrays.upload("materials", face.tile, unitRectOf(info, unit), texels);
    this.written(stream, unit);
  }

  /** Whether a weight of a material of a view is above 0: then rays may go anywhere, and all units are needed. */
  isSpecular(view: number): boolean {
    return this.#views.get(view)?.faces.some(({ specular }) => specular.size > 0) ?? false;
  }

  /** Brings the textures to what was written. Returns the texels copied. */
  update(): number {
    let texels = 0;
    const encoder = this.gpu.device.createCommandEncoder({ label: "texels" });
    for (const { planes, faces } of this.#views.values()) {
      const tiles = new Map<GPUBuffer, TileParts>();
      for (const face of faces) {
        const { pictures } = face.depth.pictures!.decoder;
        const of = tiles.get(pictures) ?? { pictures, parts: [] };
        of.parts.push(...face.takeParts());
        tiles.set(pictures, of);
      }
      const changed = planes.write([...tiles.values()]);
      for (const face of faces) {
        texels += this.#copy(encoder, { planes, face }, changed.get(face.streams.face));
      }
    }
    if (texels > 0) {
      this.gpu.queue.submit([encoder.finish()]);
    }
    return texels;
  }

  /** Where the image of a face of a loaded view lies. */
  origin(view: number, face: number): Origin {
    return this.arrays.origin(this.tile(view, face));
  }

  /** The tile of a face of a loaded view. */
  tile(view: number, face: number): number {
    const found = this.#loaded(view).faces.find(({ streams }) => streams.face === face);
    if (found === undefined) {
      throw new Error(`View ${view} has no face ${face}`);
    }
    return found.tile;
  }

  /** The planes of a loaded view. */
  planes(view: number): DepthPlanes {
    return this.#loaded(view).planes;
  }

  #copy(
    encoder: GPUCommandEncoder,
    { planes, face }: { planes: DepthPlanes; face: LoadedFace },
    written?: Rect,
  ): number {
    let texels = 0;
    const depth = written === undefined ? face.copied : bounds(face.copied, written);
    face.copied = undefined;
    if (depth !== undefined) {
      this.arrays.copyDepth(encoder, face.tile, depth, { planes, face: face.streams.face });
      texels += depth[2] * depth[3];
    }
    const [color] = face.others;
    for (const unit of face.staleCells) {
      const { decoder, position } = color.pictures!;
      const { picture, stride } = decoder.unit(position, unit);
      const rect = unitRectOf(color.stream, unit);
      this.arrays.copyColor(encoder, face.tile, rect, { buffer: decoder.pictures, at: picture, pitch: stride });
      texels += rect[2] * rect[3];
    }
    face.staleCells.clear();
    return texels;
  }

  #loaded(view: number): LoadedView {
    const found = this.#views.get(view);
    if (found === undefined) {
      throw new Error(`View ${view} is not loaded`);
    }
    return found;
  }

  #unitsOf(stream: number): StreamUnits {
    const found = this.#units.get(stream);
    if (found === undefined) {
      throw new Error(`Stream ${stream} is of no loaded view`);
    }
    return found;
  }
}
