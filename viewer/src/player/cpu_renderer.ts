// Draws on the processor, in a worker, where the browser has no graphics device: small pictures.

import { startWorker } from "../assets.ts";
import type { FieldSettings, Order, Rendered } from "../cpu/messages.ts";
import { present } from "../cpu/present.ts";
import { decoderModule } from "../decoder/module.ts";
import type { Camera } from "../views/camera.ts";
import type { FaceStreams } from "../views/catalogue.ts";
import type { DeviceFamily } from "./device_units.ts";
import { OVERLAY_SHARE, OverlayPainter, texelOverlays } from "./overlays.ts";
import { type DrawRequest, type DrawResult, type Renderer, type Scene, sizeOfEye } from "./renderer.ts";
import type { PixelsOf } from "./unit_source.ts";
import { WorkerTexels } from "./worker_texels.ts";

/** A picture of so many pixels takes a part of a second. */
const MAX_PIXELS = 320 * 180;
/** Steps of a ray at most. */
const MAX_STEPS = 128;

/** A picture that was ordered. */
interface Waiting {
  resolve: (rendered: Rendered) => void;
  reject: (error: Error) => void;
}

export class CpuRenderer implements Renderer {
  readonly texels: WorkerTexels;
  readonly name = "cpu";
  readonly mostPixels = MAX_PIXELS;
  readonly hasEffects = true;
  onFailed: (message: string) => void = () => undefined;
  readonly #worker: Worker;
  readonly #painter: OverlayPainter;
  #waiting: Waiting | undefined;
  #failure: string | undefined;
  #picture: Awaited<ReturnType<Renderer["pixels"]>> = { size: [0, 0], rgba: new Float32Array() };

  constructor(private readonly scene: Scene) {
    this.#worker = startWorker("cpu_worker.js", import.meta.url);
    this.#worker.onmessage = ({ data }: MessageEvent<Rendered>) => {
      this.#waiting?.resolve(data);
      this.#waiting = undefined;
    };
    this.#worker.onerror = ({ message }) => this.#fail(message ?? "it did not load");
    this.#worker.onmessageerror = () => this.#fail("its answer cannot be read");
    const settings: FieldSettings = { module: decoderModule(), coding: scene.catalogue.coding };
    this.#worker.postMessage(settings);
    const send = (order: Order): void => this.#worker.postMessage(order);
    this.texels = new WorkerTexels(scene.catalogue, send);
    this.#painter = new OverlayPainter(scene.container, scene.catalogue, (place, rect, texels) => {
      send({ kind: "overlay", area: { ...place, rect }, texels });
    });
  }

  load(view: number, _faces: readonly FaceStreams[], pixelsOf: PixelsOf): Promise<DeviceFamily[]> {
    this.#painter.forget(view);
    // Written tiles have pixels, and those of depth are codes.
    this.texels.load(view, (stream, tile) => pixelsOf(stream, tile) as Uint16Array);
    return Promise.resolve([]);
  }

  async draw(request: DrawRequest, onShown: () => void): Promise<DrawResult> {
    const { view, cameras } = request;
    const rendered: Rendered[] = [];
    for (const camera of cameras) {
      rendered.push(await this.#render(request, camera, false));
    }
    const size = sizeOfEye(request);
    const overlays = texelOverlays(view);
    let overlay: Float32Array | undefined;
    if (overlays.length > 0) {
      this.#painter.paint(overlays, request);
      overlay = (await this.#render(request, cameras[0], true)).rgba;
    }
    const eyes = rendered.map(({ rgba }) => rgba);
    this.#picture = { size, rgba: eyes[0] };
    const options = { ...view, marksHoles: view.overlays.has("holes"), overlayShare: OVERLAY_SHARE };
    present(this.scene.canvas, size, { eyes, overlay }, options);
    onShown();
    const [{ counts }] = rendered;
    return { counters: { ...counts }, decodeMs: 0, marchMs: rendered.reduce((sum, { ms }) => sum + ms, 0) };
  }

  /** Workers decode. */
  decodeMs(): Promise<number> {
    return Promise.resolve(0);
  }

  pixels(): Promise<{ size: [number, number]; rgba: Float32Array }> {
    return Promise.resolve(this.#picture);
  }

  close(): void {
    this.#worker.terminate();
    this.#end("The film was closed.");
  }

  #fail(why: string): void {
    const message = `The worker that renders failed: ${why}`;
    this.#end(message);
    this.onFailed(message);
  }

  /** Nothing more is rendered. */
  #end(message: string): void {
    this.#failure ??= message;
    this.#waiting?.reject(new Error(message));
    this.#waiting = undefined;
  }

  #render(request: DrawRequest, camera: Camera, showsOverlay: boolean): Promise<Rendered> {
    const { container, catalogue } = this.scene;
    const { view, views } = request;
    const order: Order = {
      kind: "render",
      request: {
        camera,
        size: sizeOfEye(request),
        steps: Math.min(view.steps, MAX_STEPS),
        showsOverlay,
        marksHoles: view.overlays.has("holes"),
      },
      views: views.map((at) => {
        const { position, orientation } = container.probeAt(catalogue.views[at].probe, view.frame);
        return { view: at, position, orientation };
      }),
    };
    return new Promise((resolve, reject) => {
      if (this.#failure !== undefined) {
        throw new Error(this.#failure);
      }
      // The page draws one picture after the other.
      this.#waiting?.reject(new Error("Another picture was ordered."));
      this.#waiting = { resolve, reject };
      this.#worker.postMessage(order);
    });
  }
}
