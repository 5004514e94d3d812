// The texels of views on the device: what of the pictures of their units is not in the textures yet. Mirrors
// src/gpu/render/backend.rs (CALF 6.2).

import { unitRectOf } from "../format/index_tables.ts";
import type { Rect } from "../format/types.ts";
import type { Catalogue, FaceStreams } from "../views/catalogue.ts";
import { FaceUnits, LoadedFaces, type UnitFilter } from "../views/known_units.ts";
import { bounds } from "../views/rects.ts";
import type { Texels } from "../views/texels.ts";
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

/** A face with a tile of the textures. */
class LoadedFace extends FaceUnits {
  /** Color cells whose pictures on the device are new. */
  readonly staleCells = new Set<number>();
  /** What is to be copied besides what is written. The tile may have had another image. */
  copied: Rect | undefined;

  constructor(
    streams: FaceStreams,
    readonly tile: number,
    /** Of the streams that the device decodes, by their numbers. */
    readonly pictures: ReadonlyMap<number, DevicePictures>,
  ) {
    super(streams);
    this.copied = [0, 0, ...streams.size];
  }

  get depthPictures(): DevicePictures {
    return this.pictures.get(this.streams.depth.index)!;
  }

  /** Depths to be written. */
  takeDepths(): DepthPart[] {
    const { decoder, position } = this.depthPictures;
    return this.takeParts().map(({ rect, tile, isKnown }) => {
      const [left, top] = unitRectOf(this.streams.depth, tile);
      const picture = isKnown ? decoder.unit(position, tile) : undefined;
      return { face: this.streams.face, rect, picture, corner: [left, top] };
    });
  }
}

/** The texels of the loaded views of a container. Views are numbered as in the catalogue, streams as in the container. */
export class LightFieldTexels implements Texels {
  readonly arrays: TextureArrays;
  readonly #tables = new DepthTables();
  readonly #planes = new Map<number, DepthPlanes>();
  readonly #loaded = new LoadedFaces<LoadedFace>();

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
      return tile === undefined ? [] : [new LoadedFace(face, tile, pictures)];
    });
    if (loaded.length < faces.length) {
      loaded.forEach(({ tile }) => this.arrays.free(tile));
      planes.destroy();
      throw new DeviceError("The textures have no room for another probe.");
    }
    this.#planes.set(view, planes);
    this.#loaded.load(view, loaded);
  }

  unload(view: number): void {
    this.planes(view).destroy();
    this.#planes.delete(view);
    this.#loaded.unload(view).forEach(({ tile }) => this.arrays.free(tile));
  }

  /** Bytes of planes and tables. */
  get bytes(): number {
    return [...this.#planes.values()].reduce((sum, { bytes }) => sum + bytes, 0);
  }

  isKnown(stream: number, unit: number): boolean {
    return this.#loaded.isKnown(stream, unit);
  }

  written(stream: number, unit: number): void {
    const { face } = this.#loaded.ofStream(stream);
    this.#loaded.setKnown(stream, unit, true);
    if (stream !== face.streams.depth.index && face.pictures.has(stream)) {
      face.staleCells.add(unit);
    }
  }

  forget(stream: number, unit: number): void {
    this.#loaded.setKnown(stream, unit, false);
  }

  uploadColor(stream: number, rect: Rect, texels: Uint8Array | Uint16Array): void {
    this.arrays.upload("colors", this.#loaded.ofStream(stream).face.tile, rect, texels);
  }

  uploadMaterial(stream: number, unit: number, pixels: Uint8Array): void {
    const { face, units } = this.#loaded.ofStream(stream);
    const texels = new Uint8Array((pixels.length / 3) * 4);
    for (let from = 0, to = 0; from < pixels.length; from += 3, to += 4) {
      texels.set([pixels[from], pixels[from + 1], pixels[from + 2]], to);
    }
    face.setMaterial(unit, pixels);
    this.arrays.upload("materials", face.tile, unitRectOf(units.stream, unit), texels);
    this.written(stream, unit);
  }

  isSpecular(view: number, passes: UnitFilter): boolean {
    return this.#loaded.isSpecular(view, passes);
  }

  /** Brings the textures to what was written. */
  update(): void {
    const encoder = this.gpu.device.createCommandEncoder({ label: "texels" });
    let isChanged = false;
    for (const [view, faces] of this.#loaded.views()) {
      const planes = this.planes(view);
      const tiles = new Map<GPUBuffer, TileParts>();
      for (const face of faces) {
        const { pictures } = face.depthPictures.decoder;
        const of = tiles.get(pictures) ?? { pictures, parts: [] };
        of.parts.push(...face.takeDepths());
        tiles.set(pictures, of);
      }
      const changed = planes.write([...tiles.values()]);
      for (const face of faces) {
        const isCopied = this.#copy(encoder, { planes, face }, changed.get(face.streams.face));
        isChanged ||= isCopied;
      }
    }
    if (isChanged) {
      this.gpu.queue.submit([encoder.finish()]);
    }
  }

  /** Where the image of a face of a loaded view lies. */
  origin(view: number, face: number): Origin {
    return this.arrays.origin(this.tile(view, face));
  }

  /** The tile of a face of a loaded view. */
  tile(view: number, face: number): number {
    const found = this.#loaded.ofView(view).find(({ streams }) => streams.face === face);
    if (found === undefined) {
      throw new Error(`View ${view} has no face ${face}`);
    }
    return found.tile;
  }

  /** The planes of a loaded view. */
  planes(view: number): DepthPlanes {
    const found = this.#planes.get(view);
    if (found === undefined) {
      throw new Error(`View ${view} is not loaded`);
    }
    return found;
  }

  /** Answers whether anything was copied. */
  #copy(
    encoder: GPUCommandEncoder,
    { planes, face }: { planes: DepthPlanes; face: LoadedFace },
    written?: Rect,
  ): boolean {
    const depth = written === undefined ? face.copied : bounds(face.copied, written);
    face.copied = undefined;
    if (depth !== undefined) {
      this.arrays.copyDepth(encoder, face.tile, depth, { planes, face: face.streams.face });
    }
    const isChanged = depth !== undefined || face.staleCells.size > 0;
    const { color } = face.streams;
    for (const unit of face.staleCells) {
      const { decoder, position } = face.pictures.get(color.index)!;
      const { picture, stride } = decoder.unit(position, unit);
      const rect = unitRectOf(color, unit);
      this.arrays.copyColor(encoder, face.tile, rect, { buffer: decoder.pictures, at: picture, pitch: stride });
    }
    face.staleCells.clear();
    return isChanged;
  }
}
