// Renders pictures on the device: the kernels of shaders/march. Mirrors src/gpu/render.rs.

import type { Gpu, Pipeline } from "../gpu/device.ts";
import type { KernelName } from "../gpu/kernels.ts";
import { memberOffset, rowWords } from "../gpu/layout.ts";
import type { SceneRows } from "./scene.ts";
import type { ImageTextures, TextureName } from "./textures.ts";

/** Counters in the order of shaders/march/counters.wgsl. */
const COUNTERS = [
  "primary_rays",
  "march_steps",
  "refine_steps",
  "secondary_rays",
  "normal_evals",
  "material_samples",
  "hole_rays",
  "background_rays",
] as const;

/** Rows and columns of pixels of a workgroup. */
const TILE = 8;
/** Most samples that a dispatch of several rows of workgroups compares with views: a device that is busy for long is reset. */
const WORK = 2 ** 28;
const TEXTURES: readonly string[] = ["inverse_depths", "pyramids", "colors", "materials"] satisfies TextureName[];

/** A view whose greatest inverse depth the device knows: the buffer and the word. */
export interface Greatest {
  view: number;
  buffer: GPUBuffer;
  word: number;
}

/** A picture on the device: red, green, blue and alpha of linear light, row by row. */
export class Picture {
  readonly #gpu: Gpu;
  #pixels: GPUBuffer | undefined;
  #counts: GPUBuffer | undefined;
  size: [number, number] = [0, 0];

  constructor(gpu: Gpu) {
    this.#gpu = gpu;
  }

  /** Its buffers, made anew for another size. */
  resize(size: [number, number]): { pixels: GPUBuffer; counts: GPUBuffer } {
    if (this.#pixels === undefined || this.#counts === undefined || size.join() !== this.size.join()) {
      this.destroy();
      this.size = [...size];
      this.#pixels = this.#gpu.buffer("pixels", 4 * size[0] * size[1]);
      this.#counts = this.#gpu.buffer("counts", countWords(size));
    }
    return { pixels: this.#pixels, counts: this.#counts };
  }

  /** What a picture is drawn from. */
  get pixels(): GPUBuffer {
    return this.resize(this.size).pixels;
  }

  async read(): Promise<Float32Array> {
    const words = await this.#gpu.read(this.pixels, 0, 4 * this.size[0] * this.size[1]);
    return new Float32Array(words.buffer);
  }

  /** Counters of the picture by the names of `lightfold render --stats`. */
  async counters(): Promise<Record<string, number>> {
    const counts = await this.#gpu.read(this.resize(this.size).counts, 0, countWords(this.size));
    const sums = new Array<number>(COUNTERS.length).fill(0);
    counts.forEach((count, at) => (sums[at % COUNTERS.length] += count));
    return Object.fromEntries(COUNTERS.map((name, at) => [name, sums[at]]));
  }

  destroy(): void {
    for (const buffer of [this.#pixels, this.#counts]) {
      if (buffer !== undefined) {
        this.#gpu.release(buffer);
      }
    }
    [this.#pixels, this.#counts] = [undefined, undefined];
  }
}

function countWords([width, height]: [number, number]): number {
  return Math.ceil(width / TILE) * Math.ceil(height / TILE) * COUNTERS.length;
}

type RowsName = "views" | "faces" | "distances_m";

/** What a picture shows. */
export interface MarchedScene {
  rows: SceneRows;
  greatest: readonly Greatest[];
  textures: ImageTextures;
  /** Stands in for the colors of the textures. */
  colors?: GPUTextureView;
  /** Written around each dispatch. */
  timing?: () => GPUComputePassTimestampWrites | undefined;
}

/** Renders one picture after the other. */
export class Marcher {
  readonly #gpu: Gpu;
  readonly #scene: GPUBuffer;
  #rows: Record<RowsName, GPUBuffer>;

  constructor(gpu: Gpu) {
    this.#gpu = gpu;
    this.#scene = gpu.buffer("scene", rowWords("Scene"));
    this.#rows = {
      views: gpu.buffer("views", 1),
      faces: gpu.buffer("faces", 1),
      distances_m: gpu.buffer("distances_m", 1),
    };
  }

  /** Submits a picture. */
  render(pipeline: Pipeline, { rows, greatest, textures, colors, timing }: MarchedScene, into: Picture): void {
    const gpu = this.#gpu;
    const { width, height } = sizeOf(rows);
    const { pixels, counts } = into.resize([width, height]);
    gpu.write(this.#scene, 0, rows.scene);
    const filled = (name: RowsName, words: Uint32Array): GPUBuffer => {
      if (this.#rows[name].size < words.byteLength) {
        gpu.release(this.#rows[name]);
        this.#rows[name] = gpu.buffer(name, words.length);
      }
      gpu.write(this.#rows[name], 0, words);
      return this.#rows[name];
    };
    const buffers: Record<string, GPUBuffer> = {
      scene: this.#scene,
      views: filled("views", rows.views),
      faces: filled("faces", rows.faces),
      distances_m: filled("distances_m", rows.distances),
      pixels,
      counts,
    };
    gpu.submit((encoder) => {
      const at = memberOffset("View", "greatest_inverse_depth");
      for (const { view, buffer, word } of greatest) {
        encoder.copyBufferToBuffer(buffer, 4 * word, buffers.views, 4 * (view * rowWords("View") + at), 4);
      }
    });
    const group = gpu.bind(pipeline, (name) => {
      if (name === "colors" && colors !== undefined) {
        return colors;
      }
      return TEXTURES.includes(name) ? textures.view(name as TextureName) : { buffer: buffers[name] };
    });
    const perRow = (width * rows.distances.length * rows.views.length) / rowWords("View");
    const step = Math.max(1, Math.floor(WORK / perRow / TILE)) * TILE;
    for (let first = 0; first < height; first += step) {
      const count = Math.min(step, height - first);
      gpu.write(this.#scene, 4 * memberOffset("Scene", "first_row"), Uint32Array.of(first));
      gpu.write(this.#scene, 4 * memberOffset("Scene", "rows"), Uint32Array.of(count));
      const timestampWrites = timing?.();
      gpu.submit((encoder) => {
        const pass = encoder.beginComputePass(timestampWrites && { timestampWrites });
        pass.setPipeline(pipeline.pipeline);
        pass.setBindGroup(0, group);
        pass.dispatchWorkgroups(Math.ceil(width / TILE), Math.ceil(count / TILE));
        pass.end();
      });
    }
  }

  destroy(): void {
    [this.#scene, ...Object.values(this.#rows)].forEach((buffer) => this.#gpu.release(buffer));
  }
}

function sizeOf({ scene }: SceneRows): { width: number; height: number } {
  return { width: scene[memberOffset("Scene", "width")], height: scene[memberOffset("Scene", "height")] };
}

/** The kernel of a picture: secondary rays only where a material is specular, as other pictures need no code for them. */
export function marchKernel(isSpecular: boolean): KernelName {
  return isSpecular ? "render-effects" : "render-pyramid";
}
