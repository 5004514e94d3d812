// Shows pictures on the canvas of a page.

import type { Gpu } from "../gpu/device.ts";
import type { StereoLayout, ToneMapName } from "../player/types.ts";
import type { Picture } from "./march.ts";
import code from "./present.wgsl";

const TONE_MAPS: Record<ToneMapName, number> = { none: 0, reinhard: 1, filmic: 2 };
const LAYOUTS: Record<StereoLayout, number> = { mono: 0, "side-by-side": 1, anaglyph: 2 };
const LOOK_WORDS = 12;

export interface Look {
  exposureEv: number;
  toneMap: ToneMapName;
  stereo: StereoLayout;
  marksHoles: boolean;
  /** Part of the overlay that is shown, 0 to 1. */
  overlay: number;
}

export class Presenter {
  readonly #gpu: Gpu;
  readonly #canvas: HTMLCanvasElement;
  readonly #context: GPUCanvasContext;
  readonly #pipeline: GPURenderPipeline;
  readonly #look: GPUBuffer;

  constructor(gpu: Gpu, canvas: HTMLCanvasElement) {
    const context = canvas.getContext("webgpu");
    if (context === null) {
      throw new Error("The canvas cannot be drawn to through WebGPU.");
    }
    const { device } = gpu;
    const format = navigator.gpu.getPreferredCanvasFormat();
    context.configure({ device, format, alphaMode: "opaque" });
    this.#gpu = gpu;
    this.#canvas = canvas;
    this.#context = context;
    const module = device.createShaderModule({ label: "present", code });
    this.#pipeline = device.createRenderPipeline({
      label: "present",
      layout: "auto",
      vertex: { module, entryPoint: "cover" },
      fragment: { module, entryPoint: "present", targets: [{ format }] },
    });
    const usage = GPUBufferUsage.UNIFORM | GPUBufferUsage.COPY_DST;
    this.#look = device.createBuffer({ label: "look", size: 4 * LOOK_WORDS, usage });
  }

  /** Draws pictures of one size: of the left eye, or of both; `overlay` is mixed in. */
  show(left: Picture, right: Picture, overlay: Picture, look: Look): void {
    const words = new Uint32Array(LOOK_WORDS);
    const floats = new Float32Array(words.buffer);
    words.set([...left.size, this.#canvas.width, this.#canvas.height]);
    floats[4] = 2 ** look.exposureEv;
    words.set([TONE_MAPS[look.toneMap], LAYOUTS[look.stereo], Number(look.marksHoles)], 5);
    floats[8] = look.overlay;
    this.#gpu.write(this.#look, 0, words);
    const buffers = [left.pixels, right.pixels, overlay.pixels, this.#look];
    const group = this.#gpu.device.createBindGroup({
      layout: this.#pipeline.getBindGroupLayout(0),
      entries: buffers.map((buffer, binding) => ({ binding, resource: { buffer } })),
    });
    this.#gpu.submit((encoder) => {
      const view = this.#context.getCurrentTexture().createView();
      const pass = encoder.beginRenderPass({ colorAttachments: [{ view, loadOp: "clear", storeOp: "store" }] });
      pass.setPipeline(this.#pipeline);
      pass.setBindGroup(0, group);
      pass.draw(3);
      pass.end();
    });
  }
}
