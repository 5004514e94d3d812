// Decodes and draws on the graphics device.

import type { Stream } from "../format/types.ts";
import { FamilyDecoder } from "../gpu/decoder.ts";
import { ROW_WORDS } from "../gpu/depth_planes.ts";
import { type Gpu, NoWebGpuError } from "../gpu/device.ts";
import { familyOf } from "../gpu/family.ts";
import { Marcher, Picture } from "../gpu/march.ts";
import { Presenter } from "../gpu/present.ts";
import { MARCH_SETTINGS } from "../gpu/scene.ts";
import { type DevicePictures, LightFieldTexels } from "../gpu/texels.ts";
import { activeViews } from "../views/active.ts";
import type { Camera } from "../views/camera.ts";
import type { FaceStreams } from "../views/catalogue.ts";
import { DeviceFamily } from "./device_units.ts";
import { OVERLAY_CODING, OVERLAY_SHARE, OverlayPainter, texelOverlays } from "./overlays.ts";
import { type DrawRequest, type DrawResult, type Renderer, type Scene, sizeOfEye } from "./renderer.ts";
import { DeviceTimer } from "./timer.ts";

/** Bytes of chunks on the device beside those that a frame needs. */
const KEPT_BYTES = 256 << 20;

/** Whether the device decodes the colors of a face for rendering: 8-bit cells of opaque images. Workers decode others as fast. */
function isOfDevice({ color: { header }, alpha }: FaceStreams): boolean {
  return header.kind === "color" && !header.isHalf && header.coding.name === "cells" && alpha === undefined;
}

export class DeviceRenderer implements Renderer {
  readonly name = "gpu";
  readonly mostPixels = Infinity;
  onFailed: (message: string) => void = () => undefined;
  readonly #marcher: Marcher;
  readonly #timer: DeviceTimer;
  /** Of the left and the right eye, and of overlays. */
  readonly #pictures: [Picture, Picture, Picture];
  #overlay: { painter: OverlayPainter; view: GPUTextureView } | undefined;

  private constructor(
    private readonly gpu: Gpu,
    private readonly scene: Scene,
    readonly texels: LightFieldTexels,
    private readonly presenter: Presenter,
  ) {
    this.#marcher = new Marcher(gpu, texels);
    this.#timer = new DeviceTimer(gpu);
    this.#pictures = [new Picture(gpu), new Picture(gpu), new Picture(gpu)];
    gpu.onError = (message) => this.onFailed(`The graphics device failed: ${message}`);
    void gpu.lost.then((reason) => this.onFailed(`The graphics device was lost: ${reason}`));
  }

  /** Takes over a device, and a canvas that nothing else has drawn to. A NoWebGpuError where the device fails. */
  static async create(gpu: Gpu, scene: Scene): Promise<DeviceRenderer> {
    // Compiled while the first chunks are fetched; the first picture fails where that does.
    gpu.pipeline("render-pyramid").catch(() => undefined);
    const [texels, presenter] = await Promise.all([
      LightFieldTexels.create(gpu, scene.catalogue, scene.mostImages),
      Presenter.create(gpu, scene.canvas),
    ]).catch((error: unknown) => {
      throw new NoWebGpuError(`The graphics device cannot draw the film: ${String(error)}`);
    });
    return new DeviceRenderer(gpu, scene, texels, presenter);
  }

  get hasEffects(): boolean {
    return !this.gpu.isSoftware;
  }

  async load(view: number, faces: readonly FaceStreams[]): Promise<DeviceFamily[]> {
    const { decoding, mostViews } = this.scene;
    const byKernel = new Map<string, Stream[]>();
    for (const stream of faces.flatMap((face) => [face.depth, ...(isOfDevice(face) ? [face.color] : [])])) {
      const { kernel } = familyOf(stream.header);
      byKernel.set(kernel, [...(byKernel.get(kernel) ?? []), stream]);
    }
    // A probe has a family or two of depth and of color.
    const keptWords = Math.floor(KEPT_BYTES / 4 / (2 * mostViews));
    const decoders = [...byKernel.values()].map((streams) => FamilyDecoder.create(this.gpu, streams, ROW_WORDS));
    const timing = () => this.#timer.pass("decode");
    const families = (await Promise.all(decoders)).map(
      (decoder) => new DeviceFamily(decoder, decoding, keptWords, timing),
    );
    const pictures = new Map<number, DevicePictures>();
    for (const { decoder } of families) {
      decoder.streams.forEach(({ index }, position) => pictures.set(index, { decoder, position }));
    }
    this.texels.load(view, pictures);
    // Its tiles of the textures may have had other images.
    this.#overlay?.painter.forget(view);
    return families;
  }

  async draw(request: DrawRequest, onShown: () => void): Promise<DrawResult> {
    const { view, cameras, views } = request;
    const begun = performance.now();
    const { container, catalogue, canvas } = this.scene;
    const size = sizeOfEye(request);
    const marksHoles = view.overlays.has("holes");
    const settings = {
      ...MARCH_SETTINGS,
      steps: view.steps,
      holes: marksHoles ? "nearest" : "behind",
      effects: this.hasEffects,
    } as const;
    const [left, right, marks] = this.#pictures;
    const shot = (camera: Camera) => {
      const probeOf = (probe: number) => container.probeAt(probe, view.frame);
      return { active: activeViews(catalogue, views, camera.eye, probeOf), camera, size, settings };
    };
    const timing = () => this.#timer.pass("march");
    for (const [eye, camera] of cameras.entries()) {
      await this.#marcher.render(this.#pictures[eye], { ...shot(camera), timing });
    }
    const overlays = texelOverlays(view);
    if (overlays.length > 0) {
      this.#overlay ??= this.#makeOverlay();
      this.#overlay.painter.paint(overlays, request);
      const marked = shot(cameras[0]);
      await this.#marcher.render(marks, {
        ...marked,
        active: { ...marked.active, coding: OVERLAY_CODING },
        colors: this.#overlay.view,
      });
    }
    [canvas.width, canvas.height] = view.size;
    const hasMarks = overlays.length > 0;
    this.presenter.show([left, cameras.length > 1 ? right : left, hasMarks ? marks : left], {
      exposureEv: view.exposureEv,
      toneMap: view.toneMap,
      stereo: view.stereo,
      marksHoles,
      overlay: hasMarks ? OVERLAY_SHARE : 0,
    });
    onShown();
    const counters = await left.readCounters();
    const wallMs = performance.now() - begun;
    const times = await this.#timer.read();
    return { counters, decodeMs: times.get("decode") ?? 0, marchMs: times.get("march") ?? wallMs };
  }

  async decodeMs(): Promise<number> {
    return (await this.#timer.read()).get("decode") ?? 0;
  }

  async pixels(): Promise<{ size: [number, number]; rgba: Float32Array }> {
    const [left] = this.#pictures;
    return { size: [...left.size], rgba: await left.readPixels() };
  }

  close(): void {
    this.gpu.destroy();
  }

  #makeOverlay(): { painter: OverlayPainter; view: GPUTextureView } {
    const { container, catalogue } = this.scene;
    const { arrays } = this.texels;
    const texture = arrays.overlayTexture();
    const painter = new OverlayPainter(container, catalogue, ({ view, face }, rect, texels) => {
      arrays.upload(texture, this.texels.tile(view, face), rect, texels);
    });
    return { painter, view: texture.createView({ dimension: "2d-array" }) };
  }
}
