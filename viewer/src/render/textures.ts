// Texture arrays with the images of loaded probes: inverse depths, their pyramids, colors and materials. Every image has a tile; all tiles
// have the size of the largest image. Mirrors src/gpu/render/texels.rs.

import type { Rect } from "../format/types.ts";
import { DeviceError, type Gpu } from "../gpu/device.ts";
import { above, type Plane, planeSizes } from "./planes.ts";

/** Where an image begins in the arrays. */
export interface Origin {
  column: number;
  row: number;
  layer: number;
  pyramidColumn: number;
  pyramidRow: number;
}

export type TextureName = "inverse_depths" | "pyramids" | "colors" | "materials";

export interface TextureShape {
  /** Width and height of the largest image. */
  tile: [number, number];
  /** Images at once. */
  count: number;
  /** Colors are half floats, else 8-bit codes. */
  isHalf: boolean;
  hasMaterial: boolean;
}

/** Bytes of an image in all arrays. */
export function imageBytes({ tile: [width, height], isHalf, hasMaterial }: Omit<TextureShape, "count">): number {
  const pyramid = 4 * Math.ceil(width / 2) * pyramidRowsOf([width, height]);
  return width * height * (4 + (isHalf ? 8 : 4) + (hasMaterial ? 4 : 0)) + pyramid;
}

/** Rows of the pyramid of a tile: its larger side rounded up to a power of two, p. Level k, counted from 0, begins at row p - p / 2^k. */
function pyramidRowsOf([width, height]: [number, number]): number {
  return 2 ** Math.ceil(Math.log2(Math.max(width, height, 1)));
}

export class ImageTextures {
  readonly pyramidRows: number;
  readonly #gpu: Gpu;
  readonly #shape: TextureShape;
  /** Tiles of a layer along its sides. */
  readonly #columns: number;
  readonly #rows: number;
  readonly #textures: Record<TextureName, GPUTexture>;
  readonly #free: number[];

  constructor(gpu: Gpu, shape: TextureShape) {
    const { tile, count, isHalf, hasMaterial } = shape;
    const { maxTextureDimension2D: side, maxTextureArrayLayers } = gpu.device.limits;
    this.#gpu = gpu;
    this.#shape = shape;
    this.pyramidRows = pyramidRowsOf(tile);
    const pyramid: [number, number] = [Math.ceil(tile[0] / 2), this.pyramidRows];
    const layers = Math.min(count, maxTextureArrayLayers);
    const most = [0, 1].map((axis) => Math.floor(side / Math.max(tile[axis], pyramid[axis])));
    this.#columns = Math.min(Math.ceil(count / layers), most[0]);
    this.#rows = Math.ceil(count / layers / Math.max(this.#columns, 1));
    if (this.#columns < 1 || this.#rows > most[1]) {
      throw new DeviceError(
        `${count} images of ${tile[0]}x${tile[1]} texels do not fit into the textures of the graphics device.`,
      );
    }
    const texture = (label: string, [width, height]: [number, number], format: GPUTextureFormat): GPUTexture =>
      gpu.device.createTexture({
        label,
        size: [width * this.#columns, height * this.#rows, layers],
        format,
        usage: GPUTextureUsage.TEXTURE_BINDING | GPUTextureUsage.COPY_DST,
      });
    this.#textures = {
      inverse_depths: texture("inverse_depths", tile, "r32uint"),
      pyramids: texture("pyramids", pyramid, "r32uint"),
      colors: texture("colors", tile, isHalf ? "rgba16float" : "rgba8unorm"),
      // Kernels that take materials need a texture, also without materials.
      materials: texture("materials", hasMaterial ? tile : [1, 1], "rgba8unorm"),
    };
    this.#free = Array.from({ length: count }, (_, at) => count - 1 - at);
  }

  /** Tiles that are free. */
  get room(): number {
    return this.#free.length;
  }

  /** Takes a free tile. */
  take(): number {
    const tile = this.#free.pop();
    if (tile === undefined) {
      throw new DeviceError("No tile of the textures is free.");
    }
    return tile;
  }

  giveBack(tile: number): void {
    this.#free.push(tile);
  }

  origin(tile: number): Origin {
    const layers = this.#textures.colors.depthOrArrayLayers;
    const [layer, place] = [tile % layers, Math.floor(tile / layers)];
    const [column, row] = [place % this.#columns, Math.floor(place / this.#columns)];
    const [width, height] = this.#shape.tile;
    return {
      column: column * width,
      row: row * height,
      layer,
      pyramidColumn: column * Math.ceil(width / 2),
      pyramidRow: row * this.pyramidRows,
    };
  }

  view(name: TextureName): GPUTextureView {
    return this.#textures[name].createView({ dimension: "2d-array" });
  }

  /** Copies a rectangle of an image's depths, and the part of its pyramid above it. */
  copyDepths(encoder: GPUCommandEncoder, buffer: GPUBuffer, levels: readonly Plane[], tile: number, rect: Rect): void {
    const origin = this.origin(tile);
    const place = (level: number): [number, number] => {
      const start = this.pyramidRows - (this.pyramidRows >>> (level - 1));
      return level === 0 ? [origin.column, origin.row] : [origin.pyramidColumn, origin.pyramidRow + start];
    };
    levels.forEach(({ at, pitch }, level) => {
      const part = level === 0 ? rect : above(rect, level - 1);
      const [left, top] = part;
      const texture = level === 0 ? this.#textures.inverse_depths : this.#textures.pyramids;
      const source = { buffer, at: at + top * pitch + left, pitch };
      copy(encoder, source, texture, { corner: place(level), layer: origin.layer, rect: part });
    });
  }

  /** Copies a rectangle of colors from a buffer with a word for each texel. */
  copyColors(encoder: GPUCommandEncoder, source: Words, tile: number, rect: Rect): void {
    const { column, row, layer } = this.origin(tile);
    copy(encoder, source, this.#textures.colors, { corner: [column, row], layer, rect });
  }

  /** Writes a rectangle of colors or materials: 4 components of each texel, row by row. */
  write(
    name: "colors" | "materials",
    tile: number,
    [left, top, width, height]: Rect,
    texels: Uint8Array | Uint16Array,
  ): void {
    const { column, row, layer } = this.origin(tile);
    this.#gpu.queue.writeTexture(
      { texture: this.#textures[name], origin: [column + left, row + top, layer] },
      texels as Uint8Array<ArrayBuffer>,
      { bytesPerRow: 4 * texels.BYTES_PER_ELEMENT * width, rowsPerImage: height },
      [width, height],
    );
  }

  /** A texture for other colors of the same images, of 8-bit codes. */
  colorsBeside(): GPUTexture {
    const { width, height, depthOrArrayLayers } = this.#textures.colors;
    const usage = GPUTextureUsage.TEXTURE_BINDING | GPUTextureUsage.COPY_DST;
    return this.#gpu.device.createTexture({ size: [width, height, depthOrArrayLayers], format: "rgba8unorm", usage });
  }

  destroy(): void {
    Object.values(this.#textures).forEach((texture) => texture.destroy());
  }
}

/** A rectangle of words in a buffer: its first word, and words from row to row. */
export interface Words {
  buffer: GPUBuffer;
  at: number;
  pitch: number;
}

interface Target {
  /** Column and row of the image. */
  corner: [number, number];
  layer: number;
  /** In the image. */
  rect: Rect;
}

function copy(
  encoder: GPUCommandEncoder,
  { buffer, at, pitch }: Words,
  texture: GPUTexture,
  { corner, layer, rect }: Target,
): void {
  const [left, top, width, height] = rect;
  encoder.copyBufferToTexture(
    // A single row may be the last of its buffer, with no whole pitch behind it.
    { buffer, offset: 4 * at, ...(height > 1 && { bytesPerRow: 4 * pitch }) },
    { texture, origin: [corner[0] + left, corner[1] + top, layer] },
    [width, height],
  );
}

/** Levels of the pyramid of an image. */
export function pyramidLevels(size: [number, number]): number {
  return planeSizes(size).length - 1;
}
