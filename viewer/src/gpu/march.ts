// Renders a light field on the device: the kernels of shaders/march (CALF 6). Mirrors src/gpu/render.rs.

import { type ActiveViews, MIN_M } from "../views/active.ts";
import type { Camera } from "../views/camera.ts";
import { COUNTS } from "../views/counts.ts";
import type { Counts } from "../views/counts.ts";
import { GREATEST_WORD } from "./depth_planes.ts";
import { DeviceError } from "./device.ts";
import type { Gpu, Pipeline } from "./device.ts";
import { memberOffset, rowWords } from "./layout.ts";
import type { MarchSettings, SceneRows } from "./scene.ts";
import { sceneRows } from "./scene.ts";
import type { LightFieldTexels } from "./texels.ts";

/** Rows and columns of pixels of a workgroup. */
const TILE = 8;
/** The alpha of a pixel whose loops a device ended. */
const GIVEN_UP = -1;
/** Most samples that a dispatch of several rows of workgroups compares with views: systems reset a device that is busy for seconds. */
const WORK = 2 ** 28;
/** A surface emits four secondary rays, and searches for the far side of a solid along three; at most so many rays of a bounce matter. */
const MAX_SURFACES = 256;
/** After a dispatch that took less, in milliseconds, the next one may have twice the rows. */
const SHORT_MS = 50;

/** Words of the counts of a picture: some for each workgroup. */
function countWords([width, height]: readonly [number, number]): number {
  return Math.ceil(width / TILE) * Math.ceil(height / TILE) * COUNTS.length;
}

/** Most secondary rays per camera ray. */
function mostSecondaryRays(maxBounces: number): number {
  const surfaces = (bounce: number): number => Math.min(MAX_SURFACES, 4 ** bounce);
  let rays = 0;
  for (let bounce = 0; bounce < maxBounces; bounce += 1) {
    rays += 3 * surfaces(bounce) + surfaces(bounce + 1);
  }
  return rays;
}

/** Rows of a dispatch in which a ray has so many secondary rays: whole workgroups of them. */
function rowsOfDispatch(width: number, views: number, settings: MarchSettings, secondary: number): number {
  const points = settings.steps + 1 + settings.refine;
  const row = settings.samples ** 2 * width * points * views * (1 + secondary);
  return Math.max(Math.floor(WORK / (row * TILE)), 1) * TILE;
}

/** A picture on the device: red, green and blue of linear light, not multiplied by alpha, and alpha; row by row. */
export class Picture {
  /** Width and height. */
  size: [number, number] = [0, 0];
  #pixels: GPUBuffer;
  #counts: GPUBuffer;

  constructor(private readonly gpu: Gpu) {
    this.#pixels = gpu.buffer("pixels", 0);
    this.#counts = gpu.buffer("counts", 0);
  }

  /** Four floats for each pixel. */
  get pixels(): GPUBuffer {
    return this.#pixels;
  }

  get counts(): GPUBuffer {
    return this.#counts;
  }

  /** Makes room for pixels of a size. */
  resize([width, height]: readonly [number, number]): void {
    if (width === this.size[0] && height === this.size[1]) {
      return;
    }
    this.gpu.check("pixels", 4 * width * height);
    this.destroy();
    this.#pixels = this.gpu.buffer("pixels", 4 * width * height);
    this.#counts = this.gpu.buffer("counts", countWords([width, height]));
    this.size = [width, height];
  }

  /** The pixels, once they are rendered. */
  async readPixels(): Promise<Float32Array> {
    const words = await this.gpu.read(this.#pixels, 0, 4 * this.size[0] * this.size[1]);
    const rgba = new Float32Array(words.buffer);
    for (let at = 3; at < rgba.length; at += 4) {
      if (rgba[at] === GIVEN_UP) {
        throw new DeviceError("The graphics device ended loops before they were done; take fewer steps.");
      }
    }
    return rgba;
  }

  /** The counts, once it is rendered. */
  async readCounters(): Promise<Counts> {
    const counts = await this.gpu.read(this.#counts, 0, countWords(this.size));
    const sums = new Array<number>(COUNTS.length).fill(0);
    counts.forEach((count, at) => (sums[at % COUNTS.length] += count));
    return Object.fromEntries(COUNTS.map((name, at) => [name, sums[at]])) as Counts;
  }

  destroy(): void {
    this.gpu.release(this.#pixels);
    this.gpu.release(this.#counts);
  }
}

/** What a picture is rendered from. */
export interface Shot {
  active: ActiveViews;
  camera: Camera;
  /** Width and height in pixels, above 0. */
  size: [number, number];
  settings: MarchSettings;
  /** Colors in place of those of the texels: of an overlay. */
  colors?: GPUTextureView;
  /** Is written around each dispatch. */
  timing?: () => GPUComputePassTimestampWrites | undefined;
}

/** Renders pictures of loaded views. */
export class Marcher {
  /** By the names of bindings. */
  readonly #buffers = new Map<string, GPUBuffer>();

  constructor(
    private readonly gpu: Gpu,
    private readonly texels: LightFieldTexels,
  ) {}

  /** Renders into a picture. Resolves once all dispatches are submitted; with secondary rays these wait for each other. */
  async render(picture: Picture, shot: Shot): Promise<void> {
    const { active, camera, size, settings } = shot;
    const isSpecular = settings.effects && active.views.some(({ view }) => this.texels.isSpecular(view, () => true));
    const pipeline = await this.gpu.pipeline(isSpecular ? "render-effects" : "render-pyramid");
    picture.resize(size);
    this.#send(sceneRows(active, camera, size, settings, this.texels));
    this.#copyGreatest(active);
    const group = this.#bind(pipeline, picture, shot.colors);
    const [width, height] = size;
    const most = rowsOfDispatch(width, active.views.length, settings, 0);
    const secondary = isSpecular ? mostSecondaryRays(settings.maxBounces) : 0;
    const least = rowsOfDispatch(width, active.views.length, settings, secondary);
    let rows = least;
    for (let first = 0; first < height;) {
      const count = Math.min(rows, height - first);
      const begun = performance.now();
      this.#dispatch({ pipeline, group, width, rows: [first, count] }, shot.timing?.());
      first += count;
      if (isSpecular && first < height) {
        await this.gpu.queue.onSubmittedWorkDone();
        rows = performance.now() - begun < SHORT_MS ? Math.min(2 * rows, most) : least;
      }
    }
  }

  #send({ scene, views, faces, distancesM }: SceneRows): void {
    for (const [name, words] of Object.entries({ scene, views, faces, distances_m: distancesM })) {
      let buffer = this.#buffers.get(name);
      if (buffer === undefined || buffer.size < words.byteLength) {
        if (buffer !== undefined) {
          this.gpu.release(buffer);
        }
        buffer = this.gpu.buffer(name, words.length);
        this.#buffers.set(name, buffer);
      }
      this.gpu.write(buffer, 0, words);
    }
  }

  /** Copies the greatest inverse depths of views into their rows: the processor does not know them. */
  #copyGreatest({ views }: ActiveViews): void {
    const rows = this.#buffers.get("views")!;
    const member = memberOffset("View", "greatest_inverse_depth");
    this.gpu.submit((encoder) => {
      views.forEach(({ view, streams }, at) => {
        const planes = this.texels.planes(view);
        if (planes.hasGreatest && streams.nearM >= MIN_M) {
          const to = 4 * (at * rowWords("View") + member);
          encoder.copyBufferToBuffer(planes.planes, 4 * GREATEST_WORD, rows, to, 4);
        }
      });
    });
  }

  #bind(pipeline: Pipeline, picture: Picture, colors: GPUTextureView | undefined): GPUBindGroup {
    const own = new Map([...this.#buffers, ["pixels", picture.pixels], ["counts", picture.counts]]);
    return this.gpu.bind(pipeline, (name) => {
      const buffer = own.get(name);
      if (buffer !== undefined) {
        return { buffer };
      }
      const view = name === "colors" && colors !== undefined ? colors : this.texels.arrays.view(name);
      if (view === undefined) {
        throw new DeviceError(`No input of rendering is named ${name}.`);
      }
      return view;
    });
  }

  #dispatch(
    work: { pipeline: Pipeline; group: GPUBindGroup; width: number; rows: [number, number] },
    timing: GPUComputePassTimestampWrites | undefined,
  ): void {
    const { pipeline, group, width, rows } = work;
    const scene = this.#buffers.get("scene")!;
    ["first_row", "rows"].forEach((name, at) => {
      this.gpu.write(scene, 4 * memberOffset("Scene", name), Uint32Array.of(rows[at]));
    });
    this.gpu.submit((encoder) => {
      const pass = encoder.beginComputePass({ label: "render", ...(timing && { timestampWrites: timing }) });
      pass.setPipeline(pipeline.pipeline);
      pass.setBindGroup(0, group);
      pass.dispatchWorkgroups(Math.ceil(width / TILE), Math.ceil(rows[1] / TILE));
      pass.end();
    });
  }
}
