// Draws on the processor, in a worker, where the browser has no graphics device: small pictures.

import type { Order, Rendered } from "../cpu/messages.ts";
import { present, type LightPicture } from "../cpu/present.ts";
import { WorkerTexels } from "../cpu/texels.ts";
import type { Container } from "../format/container.ts";
import { activeViews } from "../views/active.ts";
import type { Camera } from "../views/camera.ts";
import type { Catalogue, FaceStreams } from "../views/catalogue.ts";
import type { DeviceFamily } from "./device_units.ts";
import { OVERLAY_SHARE, OverlayPainter, texelOverlays } from "./overlays.ts";
import type { Drawn, Renderer, Shot } from "./renderer.ts";
import type { PixelsOf } from "./unit_source.ts";

/** A picture of so many pixels takes a part of a second. */
const MOST_PIXELS = 320 * 180;
/** Steps of a ray at most, and how often the interval before a hit is halved. */
const MOST_STEPS = 128;
const REFINE = 8;

/** What a film is drawn from. */
interface Scene {
  container: Container;
  catalogue: Catalogue;
  canvas: HTMLCanvasElement;
}

export class CpuRenderer implements Renderer {
  readonly texels: WorkerTexels;
  readonly name = "cpu";
  readonly mostPixels = MOST_PIXELS;
  readonly hasEffects = false;
  onFailed: (message: string) => void = () => undefined;
  readonly #worker: Worker;
  readonly #painter: OverlayPainter;
  #picture: LightPicture = { size: [0, 0], rgba: new Float32Array() };

  constructor(private readonly scene: Scene) {
    this.#worker = new Worker(new URL("./renderer.js", import.meta.url), { type: "module" });
    this.#worker.onerror = ({ message }) =>
      this.onFailed(`The worker that renders failed: ${message ?? "it did not load"}`);
    const send = (order: Order): void => this.#worker.postMessage(order);
    this.texels = new WorkerTexels(scene.catalogue, send);
    this.#painter = new OverlayPainter(scene.container, scene.catalogue, (place, rect, texels) => {
      send({ kind: "overlay", place: { ...place, rect }, texels });
    });
  }

  load(view: number, _faces: readonly FaceStreams[], pixelsOf: PixelsOf): Promise<DeviceFamily[]> {
    // Written tiles have pixels, and those of depth are codes.
    this.#painter.forget(view);
    this.texels.load(view, (stream, tile) => pixelsOf(stream, tile) as Uint16Array);
    return Promise.resolve([]);
  }

  async draw(shot: Shot, onShown: () => void): Promise<Drawn> {
    const { view, cameras } = shot;
    const rendered: Rendered[] = [];
    const [width, height] = view.size;
    const size = [view.stereo === "side-by-side" ? Math.ceil(width / 2) : width, height] as const;
    for (const camera of cameras) {
      rendered.push(await this.#render(shot, camera, size));
    }
    const overlays = texelOverlays(view);
    let overlay: LightPicture | undefined;
    if (overlays.length > 0) {
      this.#painter.paint(overlays, shot);
      overlay = { size, rgba: (await this.#render(shot, cameras[0], size, true)).rgba };
    }
    const eyes = rendered.map(({ rgba }) => ({ size, rgba }));
    [this.#picture] = eyes;
    const look = { ...view, marksHoles: view.overlays.has("holes"), overlayShare: OVERLAY_SHARE };
    present(this.scene.canvas, { eyes, overlay }, look);
    onShown();
    const [{ counts }] = rendered;
    return { counters: { ...counts }, decodeMs: 0, marchMs: rendered.reduce((sum, { ms }) => sum + ms, 0) };
  }

  /** Workers decode. */
  decodeMs(): Promise<number> {
    return Promise.resolve(0);
  }

  pixels(): Promise<{ size: [number, number]; rgba: Float32Array }> {
    const { size, rgba } = this.#picture;
    return Promise.resolve({ size: [...size], rgba });
  }

  close(): void {
    this.#worker.terminate();
  }

  #render(
    { view, views }: Shot,
    camera: Camera,
    size: readonly [number, number],
    showsOverlay = false,
  ): Promise<Rendered> {
    const marksHoles = view.overlays.has("holes");
    const asked = { frame: view.frame, steps: Math.min(view.steps, MOST_STEPS), marksHoles, views, showsOverlay };
    return new Promise((resolve) => {
      this.#worker.onmessage = ({ data }: MessageEvent<Rendered>) => resolve(data);
      this.#worker.postMessage(renderOrder(this.scene, asked, camera, size));
    });
  }
}

/** Orders a picture of views, by their places in the catalogue. */
export function renderOrder(
  { container, catalogue }: Pick<Scene, "container" | "catalogue">,
  asked: { frame: number; steps: number; marksHoles: boolean; views: readonly number[]; showsOverlay: boolean },
  camera: Camera,
  size: readonly [number, number],
): Order {
  const probeOf = (probe: number) => container.probeAt(probe, asked.frame);
  const { views, coding, nearest, nearM, farM } = activeViews(catalogue, asked.views, camera.eye, probeOf);
  return {
    kind: "render",
    shot: {
      camera: { axes: camera.axes, half: camera.half },
      size,
      coding,
      showsOverlay: asked.showsOverlay,
      nearM,
      farM,
      steps: asked.steps,
      refine: REFINE,
      looksBehindHoles: !asked.marksHoles,
    },
    views: views.map(({ view, streams, fromEye, turn, cameraWeight }) => ({
      view,
      fromEye,
      turn,
      cameraWeight,
      nearM: streams.nearM,
    })),
    nearest,
  };
}
