// Shows pictures on a canvas: exposure, tone map, the curve of sRGB, and two eyes.

import { STEREO_NUMBERS, type StereoLayout, TONE_MAP_NUMBERS, type ToneMapName } from "../views/presentation.ts";
import { DeviceError } from "./device.ts";
import type { Gpu } from "./device.ts";
import type { Picture } from "./march.ts";
import source from "./present.wgsl";

/** Overrides of present.wgsl. */
const CONSTANTS = {
  TONE_REINHARD: TONE_MAP_NUMBERS.reinhard,
  TONE_FILMIC: TONE_MAP_NUMBERS.filmic,
  EYES_SIDE_BY_SIDE: STEREO_NUMBERS["side-by-side"],
  EYES_ANAGLYPH: STEREO_NUMBERS.anaglyph,
};
/** Words of `PresentOptions` of present.wgsl. */
const OPTION_WORDS = 10;

/** How pictures are shown. */
export interface PresentOptions {
  exposureEv: number;
  toneMap: ToneMapName;
  stereo: StereoLayout;
  /** What no probe saw is marked: pixels with an alpha below 1, as settings with holes "nearest" or "blank" make them. */
  marksHoles: boolean;
  /** Part of the overlay that is shown, 0 to 1. */
  overlay: number;
}

/** A canvas that the device draws to. */
export class Presenter {
  readonly #context: GPUCanvasContext;
  readonly #pipeline: GPURenderPipeline;
  readonly #options: GPUBuffer;

  private constructor(
    private readonly gpu: Gpu,
    private readonly canvas: HTMLCanvasElement | OffscreenCanvas,
    made: { context: GPUCanvasContext; pipeline: GPURenderPipeline },
  ) {
    this.#context = made.context;
    this.#pipeline = made.pipeline;
    const usage = GPUBufferUsage.UNIFORM | GPUBufferUsage.COPY_DST;
    this.#options = gpu.device.createBuffer({ label: "options", size: 4 * OPTION_WORDS, usage });
  }

  /** Takes over a canvas, which nothing else has drawn to. */
  static async create(gpu: Gpu, canvas: HTMLCanvasElement | OffscreenCanvas): Promise<Presenter> {
    const context = canvas.getContext("webgpu") as GPUCanvasContext | null;
    if (context === null) {
      throw new DeviceError("The canvas cannot be drawn to by the graphics device.");
    }
    const format = navigator.gpu.getPreferredCanvasFormat();
    context.configure({ device: gpu.device, format, alphaMode: "opaque" });
    const module = gpu.device.createShaderModule({ label: "present", code: source });
    const pipeline = await gpu.device.createRenderPipelineAsync({
      label: "present",
      layout: "auto",
      vertex: { module, entryPoint: "corner" },
      fragment: { module, entryPoint: "show", constants: CONSTANTS, targets: [{ format }] },
    });
    return new Presenter(gpu, canvas, { context, pipeline });
  }

  /** Draws the picture of the left or only eye, that of the right one, and an overlay, which have one size. */
  show([left, right, overlay]: readonly [Picture, Picture, Picture], options: PresentOptions): void {
    const words = new Uint32Array(OPTION_WORDS);
    const floats = new Float32Array(words.buffer);
    floats.set([...left.size, this.canvas.width, this.canvas.height, 2 ** options.exposureEv]);
    words.set([TONE_MAP_NUMBERS[options.toneMap], STEREO_NUMBERS[options.stereo], Number(options.marksHoles)], 5);
    floats[8] = options.overlay;
    this.gpu.write(this.#options, 0, words);
    const buffers = [this.#options, left.pixels, right.pixels, overlay.pixels];
    const group = this.gpu.device.createBindGroup({
      layout: this.#pipeline.getBindGroupLayout(0),
      entries: buffers.map((buffer, binding) => ({ binding, resource: { buffer } })),
    });
    this.gpu.submit((encoder) => {
      const view = this.#context.getCurrentTexture().createView();
      const pass = encoder.beginRenderPass({ colorAttachments: [{ view, loadOp: "clear", storeOp: "store" }] });
      pass.setPipeline(this.#pipeline);
      pass.setBindGroup(0, group);
      pass.draw(3);
      pass.end();
    });
  }
}
