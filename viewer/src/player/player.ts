// Plays a container on a canvas: what is in sight is fetched, decoded and drawn.
//
// A picture takes what is here: a unit whose chunks are not here yet shows an older frame, or nothing, and other probes show what is
// there. Nothing waits for a fetch.

import { Container } from "../format/container.ts";
import type { ByteSource, Chunk, Stream, Vec3 } from "../format/types.ts";
import { Gpu } from "../gpu/device.ts";
import { besideOf, type Camera, cameraOf } from "../render/camera.ts";
import { Marcher, marchKernel, Picture } from "../render/march.ts";
import { GREATEST_WORD, planeBytes } from "../render/planes.ts";
import { Presenter } from "../render/present.ts";
import { type SceneRows, sceneRows, type SceneView } from "../render/scene.ts";
import { imageBytes, ImageTextures } from "../render/textures.ts";
import { length, subtract } from "../render/vectors.ts";
import { VisibleUnits } from "../render/visible.ts";
import { type Catalogue, catalogueOf, type ProbeStreams } from "./catalogue.ts";
import { filmOf } from "./film.ts";
import { LoadedProbe, type Stage, type UnitCounts } from "./loaded_probe.ts";
import { OverlayTexture, TEXEL_OVERLAYS, type TexelOverlay } from "./overlays.ts";
import { WorkerPool } from "./pool.ts";
import { ChunkStore } from "./store.ts";
import { straightCodes } from "./texel_colors.ts";
import { DeviceTimer } from "./timer.ts";
import type { Film, Player, PlayerStats, Problem, View } from "./types.ts";
import type { Desk } from "./unit_source.ts";

/** Bytes of the textures and planes of probes at most, unless one probe alone has more. */
const TEXEL_BYTES = 1 << 30;
const MOST_WORKERS = 4;
const REFINE = 8;
const MAX_BOUNCES = 4;
/** Seconds that chunks are fetched ahead of the film, and of the eye. */
const FRAMES_AHEAD_S = 2;
const EYE_AHEAD_S = 0.5;
/** An eye that moved longer ago stands. Milliseconds. */
const STILL_MS = 300;
const FRESH_MS = 1000;
/** How much of an overlay is shown. */
const OVERLAY_SHARE = 0.55;

/** Opens a container to be drawn on a canvas: a NoWebGpuError without a device, an error of formats/ or of the source. */
export async function openPlayer(source: ByteSource, canvas: HTMLCanvasElement): Promise<Player> {
  const [gpu, container] = await Promise.all([Gpu.open(), Container.open(source)]);
  try {
    return new FilmPlayer(gpu, container, canvas);
  } catch (error) {
    gpu.destroy();
    throw error;
  }
}

/** Where the eye was and when. */
interface Motion {
  eye: Vec3;
  ms: number;
  /** Metres per second. */
  velocity: Vec3;
}

/** What a view takes: probes, the nearest first, cameras of the eyes, and how far its units are. */
interface Sight {
  active: ProbeStreams[];
  cameras: Camera[];
  counts: UnitCounts;
}

class FilmPlayer implements Player {
  readonly film: Film;
  onProblem: (problem: Problem) => void = () => undefined;
  onShown: () => void = () => undefined;
  readonly #gpu: Gpu;
  readonly #container: Container;
  readonly #canvas: HTMLCanvasElement;
  readonly #catalogue: Catalogue;
  readonly #desk: Desk;
  readonly #stage: Stage;
  readonly #visible: VisibleUnits;
  readonly #marcher: Marcher;
  readonly #presenter: Presenter;
  readonly #timer: DeviceTimer;
  readonly #left: Picture;
  readonly #right: Picture;
  readonly #overlayPicture: Picture;
  /** By their places in the container. */
  readonly #loaded = new Map<number, LoadedProbe>();
  readonly #mostProbes: number;
  /** When chunks arrived, by their offsets. */
  readonly #arrived = new Map<number, number>();
  #overlay: OverlayTexture | undefined;
  #motion: Motion | undefined;
  #lastFrame: number | undefined;
  #shownFrame: number;
  #draws = 0;
  #totals = { cells_decoded: 0, pixels_decoded: 0 };
  #lastView: View | undefined;
  #wake: () => void = () => undefined;
  #isClosed = false;

  constructor(gpu: Gpu, container: Container, canvas: HTMLCanvasElement) {
    this.#gpu = gpu;
    this.#container = container;
    this.#canvas = canvas;
    this.#catalogue = catalogueOf(container);
    const { probes, largest, isHalf, hasMaterial, coding } = this.#catalogue;
    this.film = filmOf(
      container,
      probes.map(({ probe }) => probe),
    );
    this.#shownFrame = this.film.firstFrame;
    const mostFaces = Math.max(...probes.map(({ faces }) => faces.length));
    const ofProbe = mostFaces * (imageBytes({ tile: largest, isHalf, hasMaterial }) + planeBytes(largest));
    this.#mostProbes = Math.min(probes.length, Math.max(1, Math.floor(TEXEL_BYTES / ofProbe)));
    const textures = new ImageTextures(gpu, {
      tile: largest,
      count: this.#mostProbes * mostFaces,
      isHalf,
      hasMaterial,
    });
    const store = new ChunkStore(container.source);
    store.onChunk = (offset) => {
      this.#arrived.set(offset, performance.now());
      this.#wake();
    };
    store.onProblem = (problem) => this.#tell(problem);
    const workers = Math.max(1, Math.min(MOST_WORKERS, (navigator.hardwareConcurrency || 2) - 1));
    const start = (): Worker => new Worker(new URL("./worker.js", import.meta.url), { type: "module" });
    const pool = new WorkerPool(workers, start, (stream) => {
      const { headerBytes, ...rest } = container.streams[stream];
      return { stream: rest, headerBytes };
    });
    this.#desk = {
      container,
      store,
      pool,
      onReady: () => this.#wake(),
      onBroken: (message) => this.#tell({ fatal: false, message }),
    };
    this.#stage = { gpu, desk: this.#desk, textures, straight: straightCodes(coding.transfer === "linear") };
    this.#visible = new VisibleUnits(container);
    this.#marcher = new Marcher(gpu);
    this.#presenter = new Presenter(gpu, canvas);
    this.#timer = new DeviceTimer(gpu);
    [this.#left, this.#right, this.#overlayPicture] = [new Picture(gpu), new Picture(gpu), new Picture(gpu)];
    // Compiled while the first chunks are fetched.
    void gpu.pipeline(marchKernel(false));
    gpu.onError = (message) => this.#tell({ fatal: true, message: `The graphics device failed: ${message}` });
    void gpu.lost.then((reason) => this.#tell({ fatal: true, message: `The graphics device was lost: ${reason}` }));
  }

  async draw(view: View): Promise<PlayerStats> {
    const scene = await this.#bring(view);
    const begun = performance.now();
    const counters = await this.#march(view, scene);
    const wallMs = performance.now() - begun;
    const times = await this.#timer.read();
    const { counts, active } = scene;
    const unitsMissing = counts.missing + counts.working;
    this.#shownFrame = unitsMissing === 0 ? view.frame : this.#shownFrame;
    const fetched = this.#desk.store.stats;
    return {
      ...fetched,
      counters: {
        ...counters,
        ...this.#totals,
        cells_unchanged: counts.shown,
        bytes_read: fetched.bytesFetched,
        active_probes: active.length,
      },
      decodeMs: times.get("decode") ?? 0,
      marchMs: times.get("march") ?? wallMs,
      unitsMissing,
      shownFrame: this.#shownFrame,
    };
  }

  async settle(view: View): Promise<void> {
    for (;;) {
      const ready = new Promise<void>((resolve) => (this.#wake = resolve));
      const { counts } = await this.#bring(view);
      if (counts.missing + counts.working === 0 || this.#isClosed) {
        return;
      }
      await ready;
    }
  }

  fetched(): [number, number][] {
    const { firstFrame, frameCount } = this.film;
    const isMissing = new Uint8Array(frameCount);
    const view = this.#lastView;
    if (view === undefined) {
      return [];
    }
    const cameras = this.#cameras(view, false);
    for (const chunk of this.#chunksInSight(this.#active(view.pose.eye, view.frame), cameras)) {
      if (this.#desk.store.get(chunk) === undefined) {
        const first = chunk.firstFrame - firstFrame;
        isMissing.fill(1, first, first + chunk.frameCount);
      }
    }
    const spans: [number, number][] = [];
    isMissing.forEach((missing, at) => {
      const last = spans.at(-1);
      if (missing === 0 && last?.[1] === firstFrame + at - 1) {
        last[1] += 1;
      } else if (missing === 0) {
        spans.push([firstFrame + at, firstFrame + at]);
      }
    });
    return spans;
  }

  async pixels(): Promise<{ size: [number, number]; rgba: Float32Array }> {
    return { size: [...this.#left.size], rgba: await this.#left.read() };
  }

  close(): void {
    this.#isClosed = true;
    this.#wake();
    this.#desk.store.close();
    this.#desk.pool.close();
    this.#gpu.destroy();
  }

  #tell(problem: Problem): void {
    if (!this.#isClosed) {
      this.onProblem(problem);
    }
  }

  /** Brings the device to a view as far as chunks are here, and asks for the others. */
  async #bring(view: View): Promise<Sight> {
    this.#draws += 1;
    this.#lastView = view;
    const cameras = this.#cameras(view);
    const active = this.#active(view.pose.eye, view.frame);
    await this.#load(active);
    const counts: UnitCounts = { shown: 0, working: 0, missing: 0, broken: 0 };
    const fetch: Chunk[] = [];
    const seen = (stream: Stream) => this.#visible.units(stream, cameras);
    const probes = active.map(({ probe }) => this.#loaded.get(probe)!);
    probes.forEach((probe) => probe.ask(view.frame, seen, fetch, counts));
    this.#desk.store.want([...fetch, ...this.#ahead(view, active, cameras)]);
    for (const probe of probes) {
      const { units, pixels } = probe.update(this.#timer);
      this.#totals.cells_decoded += units;
      this.#totals.pixels_decoded += pixels;
    }
    return { active, cameras, counts };
  }

  /** The cameras of the eyes; with `predicts`, the motion of the eye is taken in. */
  #cameras(view: View, predicts = true): Camera[] {
    if (predicts) {
      this.#notice(view);
    }
    const [width, height] = view.size;
    const isSplit = view.stereo === "side-by-side";
    const camera = cameraOf(view.pose, view.fovDeg, (isSplit ? width / 2 : width) / height);
    if (view.stereo === "mono") {
      return [camera];
    }
    return [-0.5, 0.5].map((side) => besideOf(camera, side * view.eyeDistance));
  }

  #notice({ pose: { eye } }: View): void {
    const now = performance.now();
    const before = this.#motion;
    const seconds = before === undefined ? 0 : (now - before.ms) / 1000;
    if (before === undefined) {
      this.#motion = { eye: [...eye], ms: now, velocity: [0, 0, 0] };
    } else if (before.eye.join() !== eye.join()) {
      const velocity = subtract(eye, before.eye).map((part) => part / Math.max(seconds, 0.01)) as Vec3;
      this.#motion = { eye: [...eye], ms: now, velocity };
    } else if (now - before.ms > STILL_MS) {
      before.velocity = [0, 0, 0];
    }
  }

  /** The probes that have a frame, the nearest to the eye first, as many as the device has room for. */
  #active(eye: Vec3, frame: number): ProbeStreams[] {
    const has = ({ firstFrame, frameCount }: Stream): boolean => frame >= firstFrame && frame < firstFrame + frameCount;
    const able = this.#catalogue.probes.filter(({ faces }) =>
      faces.some(({ depth, color }) => has(depth) && has(color)),
    );
    const distance = ({ probe }: ProbeStreams): number =>
      length(subtract(this.#container.probeAt(probe, frame).position, eye));
    const byDistance = able.map((probe) => ({ probe, metres: distance(probe) })).sort((a, b) => a.metres - b.metres);
    return byDistance.slice(0, this.#mostProbes).map(({ probe }) => probe);
  }

  /** Brings probes to the device, in the place of those that were used longest ago. */
  async #load(active: readonly ProbeStreams[]): Promise<void> {
    const missing = active.filter(({ probe }) => !this.#loaded.has(probe));
    const isActive = new Set(active.map(({ probe }) => probe));
    for (const streams of missing) {
      while (this.#stage.textures.room < streams.faces.length) {
        const idle = [...this.#loaded].filter(([probe]) => !isActive.has(probe));
        const [probe, loaded] = idle.reduce((oldest, one) => (one[1].lastUsed < oldest[1].lastUsed ? one : oldest));
        loaded.unload();
        this.#loaded.delete(probe);
      }
      const { intrinsics } = this.#container.probes[streams.probe];
      this.#loaded.set(streams.probe, await LoadedProbe.load(this.#stage, streams, intrinsics));
    }
    active.forEach(({ probe }) => (this.#loaded.get(probe)!.lastUsed = this.#draws));
  }

  /** Chunks that will be needed: those around where the eye is heading, and while the film plays those of its next frames. */
  #ahead(view: View, active: readonly ProbeStreams[], cameras: readonly Camera[]): Chunk[] {
    const { frame } = view;
    const isPlaying = this.#lastFrame !== undefined && this.#lastFrame !== frame;
    this.#lastFrame = frame;
    const chunks: Chunk[] = [];
    const velocity = this.#motion?.velocity ?? [0, 0, 0];
    if (length(velocity) > 0) {
      const eye = view.pose.eye.map((part, axis) => part + velocity[axis] * EYE_AHEAD_S) as Vec3;
      const heading = cameras.map((camera) => ({ ...camera, eye }));
      const there = new VisibleUnits(this.#container);
      chunks.push(...this.#chunksOf(active, (stream) => there.units(stream, heading), frame, frame));
    }
    if (isPlaying) {
      const last = frame + Math.ceil(FRAMES_AHEAD_S * this.film.framesPerSecond);
      const seen = (stream: Stream) => this.#visible.units(stream, cameras);
      const next = this.#chunksOf(active, seen, frame + 1, last);
      chunks.push(...next.sort((a, b) => a.firstFrame - b.firstFrame));
    }
    return chunks.filter((chunk) => this.#desk.store.get(chunk) === undefined);
  }

  /** Chunks with any of some frames of the units that are seen. */
  #chunksOf(
    active: readonly ProbeStreams[],
    seen: (stream: Stream) => readonly boolean[],
    first: number,
    last: number,
  ): Chunk[] {
    const chunks: Chunk[] = [];
    for (const { depth, color, alpha, material } of active.flatMap(({ faces }) => faces)) {
      for (const stream of [depth, color, alpha, material]) {
        const units = stream === undefined ? [] : seen(stream);
        units.forEach((isSeen, unit) => {
          const [start, end] = isSeen ? this.#container.chunksOf(stream!.index, unit) : [0, 0];
          for (let at = start; at < end; at += 1) {
            const chunk = this.#container.chunks[at];
            if (chunk.firstFrame <= last && chunk.firstFrame + chunk.frameCount > first) {
              chunks.push(chunk);
            }
          }
        });
      }
    }
    return chunks;
  }

  /** All chunks of the units that cameras see. */
  #chunksInSight(active: readonly ProbeStreams[], cameras: readonly Camera[]): Chunk[] {
    return this.#chunksOf(active, (stream) => this.#visible.units(stream, cameras), 0, Infinity);
  }

  /** Renders the eyes and what overlays show, and presents them; answers the counters of the first eye. */
  async #march(view: View, { active, cameras }: Sight): Promise<Record<string, number>> {
    const { textures } = this.#stage;
    const pipeline = await this.#gpu.pipeline(marchKernel(false));
    const views = active.map(({ probe, nearM, farM }): SceneView => {
      return { probe: this.#container.probeAt(probe, view.frame), nearM, farM, faces: this.#loaded.get(probe)!.faces };
    });
    const greatest = active.flatMap(({ probe }, at) => {
      const { planes } = this.#loaded.get(probe)!;
      return planes.hasGreatest ? [{ view: at, buffer: planes.buffer, word: GREATEST_WORD }] : [];
    });
    const marksHoles = view.overlays.has("holes");
    const size: [number, number] = [
      view.stereo === "side-by-side" ? Math.ceil(view.size[0] / 2) : view.size[0],
      view.size[1],
    ];
    const rows = (camera: Camera): SceneRows => {
      const settings = {
        size,
        steps: view.steps,
        refine: REFINE,
        holes: marksHoles ? "nearest" : "behind",
        maxBounces: MAX_BOUNCES,
      } as const;
      return sceneRows(views, camera, this.#catalogue.coding, settings, textures.pyramidRows);
    };
    const timing = () => this.#timer.pass("march");
    const pictures = [this.#left, this.#right];
    cameras.forEach((camera, eye) =>
      this.#marcher.render(pipeline, { rows: rows(camera), greatest, textures, timing }, pictures[eye]),
    );
    const overlays = TEXEL_OVERLAYS.filter((overlay) => view.overlays.has(overlay));
    if (overlays.length > 0) {
      const colors = this.#paint(overlays, view.frame, active);
      this.#marcher.render(pipeline, { rows: rows(cameras[0]), greatest, textures, colors }, this.#overlayPicture);
    }
    [this.#canvas.width, this.#canvas.height] = view.size;
    const right = cameras.length > 1 ? this.#right : this.#left;
    this.#presenter.show(this.#left, right, overlays.length > 0 ? this.#overlayPicture : this.#left, {
      ...view,
      marksHoles,
      overlay: overlays.length > 0 ? OVERLAY_SHARE : 0,
    });
    this.onShown();
    return this.#left.counters();
  }

  #paint(overlays: readonly TexelOverlay[], frame: number, active: readonly ProbeStreams[]): GPUTextureView {
    this.#overlay ??= new OverlayTexture(this.#gpu, this.#container, this.#stage.textures);
    const { probes } = this.#catalogue;
    const images = active.flatMap((streams) => {
      const number = probes.indexOf(streams);
      const { tiles } = this.#loaded.get(streams.probe)!;
      return tiles.map((tile) => ({ ...tile, probe: number, probes: probes.length }));
    });
    const now = performance.now();
    const isFresh = (chunk: number): boolean =>
      now - (this.#arrived.get(this.#container.chunks[chunk].offset) ?? -Infinity) < FRESH_MS;
    this.#overlay.paint(overlays, { frame, isFresh, images });
    return this.#overlay.view;
  }
}
