// The images of views in texture arrays: a tile for each image, in all arrays at the same place. Mirrors the textures of
// src/gpu/render/texels.rs.

import type { Rect } from "../format/types.ts";
import type { Catalogue } from "../views/catalogue.ts";
import { above } from "../views/pyramid.ts";
import type { DepthPlanes } from "./depth_planes.ts";
import type { Gpu } from "./device.ts";
import type { TileGrid } from "./tile_grid.ts";
import { tileGrid, tilePlace } from "./tile_grid.ts";

/** Where an image begins in the texture arrays. */
export interface Origin {
  /** Column and row of its first texel. */
  texels: [number, number];
  /** Column and row at which its pyramid begins, in textures of their own. */
  pyramid: [number, number];
  layer: number;
}

/** Words of a rectangle in a buffer, one for each texel. */
export interface TexelWords {
  buffer: GPUBuffer;
  /** First word, and words from row to row: a multiple of 64. */
  at: number;
  pitch: number;
}

type TextureName = "inverse_depths" | "pyramids" | "colors" | "materials";

/** Width and height of a tile: those of the largest images of a catalogue. */
function tileSize({ views }: Catalogue): [number, number] {
  const sizes = views.flatMap(({ faces }) => faces.map(({ size }) => size));
  return [Math.max(...sizes.map(([width]) => width)), Math.max(...sizes.map(([, height]) => height))];
}

/** Rows of the pyramid of a tile: its larger side rounded up to a power of two, p. Level k, counted from 0, begins at row p - p / 2^k. */
function pyramidRows([width, height]: readonly [number, number]): number {
  return 2 ** Math.ceil(Math.log2(Math.max(width, height)));
}

/** Bytes of an image in the arrays. */
export function imageBytes(catalogue: Catalogue): number {
  const [width, height] = tileSize(catalogue);
  const hasMaterial = catalogue.views.some(({ faces }) => faces.some(({ material }) => material !== undefined));
  const texel = 4 + (catalogue.coding.name === "light" ? 8 : 4) + (hasMaterial ? 4 : 0);
  return width * height * texel + 4 * Math.ceil(width / 2) * pyramidRows([width, height]);
}

/** Texture arrays with a tile for each of so many images. */
export class TextureArrays {
  /** {@link pyramidRows} of a tile: `Scene.pyramid_rows`. */
  readonly pyramidRows: number;
  /** Of the colors: bytes, or halves. */
  readonly #tile: readonly [number, number];
  readonly #grid: TileGrid;
  readonly #textures: Record<TextureName, GPUTexture>;
  readonly #views: Record<TextureName, GPUTextureView>;
  readonly #free: number[];

  constructor(
    private readonly gpu: Gpu,
    catalogue: Catalogue,
    count: number,
  ) {
    const { maxTextureDimension2D, maxTextureArrayLayers } = gpu.device.limits;
    const tile = tileSize(catalogue);
    this.pyramidRows = pyramidRows(tile);
    const pyramid = [Math.ceil(tile[0] / 2), this.pyramidRows] as const;
    // Tiles and pyramids share a grid.
    const larger = [Math.max(tile[0], pyramid[0]), Math.max(tile[1], pyramid[1])] as const;
    this.#grid = tileGrid(larger, count, { side: maxTextureDimension2D, layers: maxTextureArrayLayers });
    this.#tile = tile;
    const hasMaterial = catalogue.views.some(({ faces }) => faces.some(({ material }) => material !== undefined));
    this.#textures = {
      inverse_depths: this.#texture("inverse_depths", tile, "r32uint"),
      pyramids: this.#texture("pyramids", pyramid, "r32uint"),
      colors: this.#texture("colors", tile, catalogue.coding.name === "light" ? "rgba16float" : "rgba8unorm"),
      // Kernels with a binding for materials need a texture, also without materials.
      materials: this.#texture("materials", hasMaterial ? tile : [1, 1], "rgba8unorm"),
    };
    const view = (name: TextureName): GPUTextureView => this.#textures[name].createView({ dimension: "2d-array" });
    this.#views = {
      inverse_depths: view("inverse_depths"),
      pyramids: view("pyramids"),
      colors: view("colors"),
      materials: view("materials"),
    };
    this.#free = Array.from({ length: count }, (_, number) => count - 1 - number);
  }

  /** A tile for an image, until {@link TextureArrays.free}; `undefined` where none is left. */
  take(): number | undefined {
    return this.#free.pop();
  }

  free(tile: number): void {
    this.#free.push(tile);
  }

  /** The texture of a binding of rendering kernels. */
  view(name: string): GPUTextureView | undefined {
    return name in this.#views ? this.#views[name as TextureName] : undefined;
  }

  origin(tile: number): Origin {
    const { column, row, layer } = tilePlace(this.#grid, tile);
    const [width, height] = this.#tile;
    return {
      texels: [column * width, row * height],
      pyramid: [column * Math.ceil(width / 2), row * this.pyramidRows],
      layer,
    };
  }

  /** A further array of 8-bit colors. */
  overlayTexture(): GPUTexture {
    return this.#texture("overlay", this.#tile, "rgba8unorm");
  }

  /** Sends texels of four components to a rectangle of an image, row by row, of this texture or of one's own. */
  upload(
    to: "colors" | "materials" | GPUTexture,
    tile: number,
    [left, top, width, height]: Rect,
    texels: Uint8Array | Uint16Array,
  ): void {
    const {
      texels: [x, y],
      layer,
    } = this.origin(tile);
    const texture = typeof to === "string" ? this.#textures[to] : to;
    this.gpu.queue.writeTexture(
      { texture, origin: [x + left, y + top, layer] },
      texels as Uint8Array<ArrayBuffer> | Uint16Array<ArrayBuffer>,
      { bytesPerRow: width * 4 * texels.BYTES_PER_ELEMENT },
      [width, height, 1],
    );
  }

  /** Copies 8-bit colors of a rectangle of an image. */
  copyColor(encoder: GPUCommandEncoder, tile: number, rect: Rect, words: TexelWords): void {
    const { texels, layer } = this.origin(tile);
    this.#copy(encoder, words, { texture: this.#textures.colors, at: [...texels, layer] }, rect);
  }

  /** Copies a rectangle of the inverse depths of an image, and the levels above it. */
  copyDepth(
    encoder: GPUCommandEncoder,
    tile: number,
    rect: Rect,
    { planes, face }: { planes: DepthPlanes; face: number },
  ): void {
    const { texels, pyramid, layer } = this.origin(tile);
    planes.levels(face).forEach((plane, number) => {
      const part = number === 0 ? rect : above(rect, number - 1);
      const words = { buffer: planes.planes, at: plane.at + part[1] * plane.pitch + part[0], pitch: plane.pitch };
      if (number === 0) {
        this.#copy(encoder, words, { texture: this.#textures.inverse_depths, at: [...texels, layer] }, part);
      } else {
        const row = this.pyramidRows - this.pyramidRows / 2 ** (number - 1);
        this.#copy(
          encoder,
          words,
          { texture: this.#textures.pyramids, at: [pyramid[0], pyramid[1] + row, layer] },
          part,
        );
      }
    });
  }

  #texture(label: string, [width, height]: readonly [number, number], format: GPUTextureFormat): GPUTexture {
    const { columns, rows, layers } = this.#grid;
    return this.gpu.device.createTexture({
      label,
      size: [width * columns, height * rows, layers],
      format,
      usage: GPUTextureUsage.TEXTURE_BINDING | GPUTextureUsage.COPY_DST,
    });
  }

  #copy(
    encoder: GPUCommandEncoder,
    { buffer, at, pitch }: TexelWords,
    { texture, at: [x, y, layer] }: { texture: GPUTexture; at: readonly [number, number, number] },
    [left, top, width, height]: Rect,
  ): void {
    // A single row may be the last of its buffer, with no whole pitch behind it.
    const layout = height > 1 ? { offset: 4 * at, bytesPerRow: 4 * pitch } : { offset: 4 * at };
    encoder.copyBufferToTexture({ buffer, ...layout }, { texture, origin: [x + left, y + top, layer] }, [
      width,
      height,
      1,
    ]);
  }
}
