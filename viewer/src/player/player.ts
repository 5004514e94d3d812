// Plays a container on a canvas: what is in sight is fetched, decoded and drawn.
//
// A picture takes what is here: a unit whose chunks are not here yet shows an older frame, or nothing, and other probes show what is
// there. Nothing waits for a fetch.

import { Container } from "../format/container.ts";
import type { ByteSource, Chunk, Stream, Vec3 } from "../format/types.ts";
import { Gpu } from "../gpu/device.ts";
import { Marcher, Picture } from "../gpu/march.ts";
import { Presenter } from "../gpu/present.ts";
import { MARCH_SETTINGS } from "../gpu/scene.ts";
import { LightFieldTexels } from "../gpu/texels.ts";
import { imageBytes } from "../gpu/texture_arrays.ts";
import { add, length, scale, subtract } from "../math.ts";
import { activeViews } from "../views/active.ts";
import { type Camera, cameraOf, stereoEyes } from "../views/camera.ts";
import { type Catalogue, catalogueOf, frameRanges, hasFrame, streamsOf } from "../views/catalogue.ts";
import { selectViews } from "../views/selection.ts";
import { ColorTexels } from "../views/straight.ts";
import { VisibleUnits } from "../views/visible.ts";
import { CodingMaps, type SeenUnit, type UnitCodings } from "./coding_maps.ts";
import { filmOf } from "./film.ts";
import { LoadedView, type Stage, type UnitCounts } from "./loaded_view.ts";
import { OverlayTexture, TEXEL_OVERLAYS, type TexelOverlay } from "./overlays.ts";
import { WorkerPool } from "./pool.ts";
import { withRetries } from "./retries.ts";
import { ChunkStore, rangeKey } from "./store.ts";
import { FRAMES_AHEAD } from "./worker_units.ts";
import { DeviceTimer } from "./timer.ts";
import type { Film, Player, PlayerStats, Problem, View } from "./types.ts";
import { type Desk, unitFrame } from "./unit_source.ts";

/** Bytes of the textures and planes of probes at most, unless one probe alone has more. */
const TEXEL_BYTES = 1 << 30;
const MOST_WORKERS = 4;
/** An image takes about as much again as its textures for planes and pyramids, and again for pictures of its units. */
const IMAGE_SHARE = 3;
/** Bytes of chunks on the device beside those that a frame needs. */
const KEPT_BYTES = 256 << 20;
/** Seconds that chunks are fetched ahead of the film, and of the eye. */
const FRAMES_AHEAD_S = 2;
const EYE_AHEAD_S = 0.5;
/** An eye that goes faster was put elsewhere. Metres per second. */
const FASTEST = 6;
/** An eye that moved longer ago stands. Milliseconds. */
const STILL_MS = 300;
const FRESH_MS = 1000;
/** After so long the first picture is drawn of what is here. */
const FIRST_MS = 1500;
/** How much of an overlay is shown. */
const OVERLAY_SHARE = 0.55;

/** Opens a container to be drawn on a canvas: a NoWebGpuError without a device, an error of formats/ or of the source. */
export async function openPlayer(source: ByteSource, canvas: HTMLCanvasElement): Promise<Player> {
  const [opened, read] = await Promise.allSettled([Gpu.open(), withRetries(() => Container.open(source))]);
  if (opened.status === "rejected") {
    throw opened.reason;
  }
  try {
    if (read.status === "rejected") {
      throw read.reason;
    }
    return await FilmPlayer.create(opened.value, read.value, canvas);
  } catch (error) {
    opened.value.destroy();
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

/** What a view takes: views of the catalogue, the nearest first, cameras of the eyes, and how far its units are. */
interface Sight {
  /** With a frame that there is. */
  view: View;
  active: number[];
  cameras: Camera[];
  counts: UnitCounts;
}

/** What a player is made of. */
interface Parts {
  gpu: Gpu;
  container: Container;
  canvas: HTMLCanvasElement;
  catalogue: Catalogue;
  /** Views that are on the device at once. */
  mostViews: number;
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
  /** For where the eye is heading. */
  readonly #heading: VisibleUnits;
  readonly #marcher: Marcher;
  readonly #presenter: Presenter;
  readonly #timer: DeviceTimer;
  /** Of the left and the right eye, and of overlays. */
  readonly #pictures: [Picture, Picture, Picture];
  /** By their places in the catalogue. */
  readonly #loaded = new Map<number, LoadedView>();
  readonly #mostViews: number;
  /** When chunks arrived, by the keys of their ranges. */
  readonly #arrived = new Map<string, number>();
  #overlay: OverlayTexture | undefined;
  /** For the overlay of nodes. */
  readonly #codings: CodingMaps;
  #overlayMissing = 0;
  #motion: Motion | undefined;
  #shownFrame: number;
  readonly #openedMs = performance.now();
  /** A picture was drawn. */
  #isShown = false;
  #draws = 0;
  #totals = { cells_decoded: 0, pixels_decoded: 0 };
  #lastView: View | undefined;
  #wake: () => void = () => undefined;
  #isClosed = false;

  private constructor(parts: Parts, texels: LightFieldTexels, presenter: Presenter) {
    const { gpu, container, canvas, catalogue, mostViews } = parts;
    this.#gpu = gpu;
    this.#container = container;
    this.#canvas = canvas;
    this.#catalogue = catalogue;
    this.#mostViews = mostViews;
    this.film = filmOf(
      container,
      catalogue.views.map(({ probe }) => probe),
    );
    this.#shownFrame = this.film.firstFrame;
    const store = new ChunkStore(container.source);
    store.onChunk = (key) => {
      this.#arrived.set(key, performance.now());
      this.#wake();
    };
    store.onProblem = (problem) => this.#tell(problem);
    const workers = Math.max(1, Math.min(MOST_WORKERS, (navigator.hardwareConcurrency || 2) - 1));
    const start = (): Worker => new Worker(new URL("./worker.js", import.meta.url), { type: "module" });
    const pool = new WorkerPool(workers, start, (stream) => {
      const { kind, codec, face, width, height, unitWidth, unitHeight, headerBytes } = container.streams[stream];
      return { stream: { kind, codec, face, width, height, unitWidth, unitHeight }, headerBytes };
    });
    this.#desk = {
      container,
      store,
      pool,
      onReady: () => this.#wake(),
      onBroken: (message) => this.#tell({ fatal: false, message }),
    };
    this.#codings = new CodingMaps(this.#desk);
    const hasAlpha = catalogue.views.some(({ faces }) => faces.some(({ alpha }) => alpha !== undefined));
    const colors = new ColorTexels(catalogue.coding, hasAlpha);
    // A probe has a family or two of depth and of color.
    const keptWords = Math.floor(KEPT_BYTES / 4 / (2 * mostViews));
    this.#stage = { gpu, desk: this.#desk, texels, colors, keptWords };
    pool.onFailed = (message) => this.#tell({ fatal: true, message });
    this.#visible = new VisibleUnits(container);
    this.#heading = new VisibleUnits(container);
    this.#marcher = new Marcher(gpu, texels);
    this.#presenter = presenter;
    this.#timer = new DeviceTimer(gpu);
    this.#pictures = [new Picture(gpu), new Picture(gpu), new Picture(gpu)];
    gpu.onError = (message) => this.#tell({ fatal: true, message: `The graphics device failed: ${message}` });
    void gpu.lost.then((reason) => this.#tell({ fatal: true, message: `The graphics device was lost: ${reason}` }));
  }

  static async create(gpu: Gpu, container: Container, canvas: HTMLCanvasElement): Promise<FilmPlayer> {
    const catalogue = catalogueOf(container);
    const { views } = catalogue;
    const mostFaces = Math.max(...views.map(({ faces }) => faces.length));
    const ofView = mostFaces * IMAGE_SHARE * imageBytes(catalogue);
    const mostViews = Math.min(views.length, Math.max(1, Math.floor(TEXEL_BYTES / ofView)));
    // Compiled while the first chunks are fetched.
    void gpu.pipeline("render-pyramid");
    const images = mostViews * mostFaces;
    const [texels, presenter] = await Promise.all([
      LightFieldTexels.create(gpu, catalogue, images),
      Presenter.create(gpu, canvas),
    ]);
    return new FilmPlayer({ gpu, container, canvas, catalogue, mostViews }, texels, presenter);
  }

  async draw(view: View): Promise<PlayerStats> {
    const scene = await this.#bring(view);
    const begun = performance.now();
    const { counts, active } = scene;
    const unitsMissing = counts.missing + counts.working;
    // Rays through nothing known take longest: the first picture waits for what comes soon.
    this.#isShown ||= unitsMissing === 0 || begun - this.#openedMs > FIRST_MS;
    const counters = this.#isShown ? await this.#march(scene) : {};
    const wallMs = this.#isShown ? performance.now() - begun : 0;
    const times = await this.#timer.read();
    this.#shownFrame = unitsMissing === 0 ? scene.view.frame : this.#shownFrame;
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
      unitsBroken: counts.broken,
      overlayMissing: this.#overlayMissing,
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
      // Times are those of the next picture alone.
      await Promise.all([ready, this.#timer.read()]);
    }
  }

  fetched(): [number, number][] {
    const { firstFrame, frameCount } = this.film;
    const view = this.#lastView;
    if (view === undefined) {
      return [];
    }
    const active = this.#active(view.pose.eye, view.frame);
    const sees = (stream: Stream, unit: number): boolean => this.#visible.sees(stream, unit);
    const missing = this.#chunksOf(active, sees, [0, Infinity])
      .filter((chunk) => this.#desk.store.get(chunk) === undefined)
      .map((chunk): [number, number] => [chunk.firstFrame, chunk.firstFrame + chunk.frameCount - 1])
      .sort((one, other) => one[0] - other[0]);
    const spans: [number, number][] = [];
    let next = firstFrame;
    for (const [first, last] of missing) {
      if (first > next) {
        spans.push([next, first - 1]);
      }
      next = Math.max(next, last + 1);
    }
    const end = firstFrame + frameCount - 1;
    return next <= end ? [...spans, [next, end]] : spans;
  }

  async pixels(): Promise<{ size: [number, number]; rgba: Float32Array }> {
    const [left] = this.#pictures;
    return { size: [...left.size], rgba: await left.readPixels() };
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
  async #bring(asked: View): Promise<Sight> {
    const view = { ...asked, frame: this.#frameOf(asked.frame) };
    this.#draws += 1;
    this.#lastView = view;
    this.#notice(view);
    const cameras = this.#cameras(view);
    const active = this.#active(view.pose.eye, view.frame);
    await this.#load(active);
    this.#visible.look(cameras);
    const { texels, desk } = this.#stage;
    // Secondary rays go anywhere.
    const isSpecular = (): boolean => this.#hasEffects && active.some((at) => texels.isSpecular(at));
    const needsAll = isSpecular();
    const sees = (stream: Stream, unit: number): boolean => needsAll || this.#visible.sees(stream, unit);
    const counts: UnitCounts = { shown: 0, ready: 0, working: 0, missing: 0, broken: 0 };
    const fetch: Chunk[] = [];
    const views = active.map((at) => this.#loaded.get(at)!);
    views.forEach((one) => one.ask(view.frame, sees, fetch, counts));
    this.#overlayMissing = this.#mark(view, active, fetch);
    const inUse = this.#chunksOf(active, sees, [view.frame, view.frame]);
    desk.store.want([...fetch, ...this.#ahead(view, active, cameras)], inUse);
    for (let ahead = 1; view.playing && ahead <= FRAMES_AHEAD; ahead += 1) {
      views.forEach((one) => one.askAhead(view.frame + ahead, sees));
    }
    for (const one of views) {
      const { units, pixels, behind } = one.update(this.#timer);
      counts.working += behind;
      this.#totals.cells_decoded += units;
      this.#totals.pixels_decoded += pixels;
    }
    texels.update();
    // A material that has just been decoded needs all units, which the next call asks for.
    counts.working += Number(isSpecular() && !needsAll);
    if (counts.working > 0 && desk.pool.pending === 0) {
      // Nothing else would.
      this.#wake();
    }
    return { view, active, cameras, counts };
  }

  /** Asks for what the overlay of nodes shows, while it is on; answers how many tiles it is missing of. */
  #mark({ overlays, frame }: View, active: readonly number[], fetch: Chunk[]): number {
    if (!overlays.has("nodes")) {
      this.#codings.clear();
      return 0;
    }
    const units: SeenUnit[] = [];
    for (const { depth } of active.flatMap((at) => this.#catalogue.views[at].faces)) {
      for (let unit = 0; unit < this.#container.unitCount(depth.index); unit += 1) {
        const seen = this.#visible.sees(depth, unit) && unitFrame(this.#container, depth.index, unit, frame);
        if (seen) {
          units.push({ ...seen, stream: depth.index });
        }
      }
    }
    return this.#codings.show(units, fetch);
  }

  get #hasEffects(): boolean {
    return !this.#gpu.isSoftware;
  }

  /** The cameras of the eyes. */
  #cameras(view: View): Camera[] {
    const [width, height] = view.size;
    const isSplit = view.stereo === "side-by-side";
    const camera = cameraOf(view.pose, view.fovDeg, (isSplit ? width / 2 : width) / height);
    return view.stereo === "mono" ? [camera] : stereoEyes(camera, view.eyeDistance);
  }

  /** Takes in where the eye is, and how it moves. */
  #notice({ pose: { eye } }: View): void {
    const now = performance.now();
    const before = this.#motion;
    if (before === undefined) {
      this.#motion = { eye: [...eye], ms: now, velocity: [0, 0, 0] };
    } else if (before.eye.join() !== eye.join()) {
      const seconds = Math.max((now - before.ms) / 1000, 0.01);
      const velocity = scale(subtract(eye, before.eye), 1 / seconds);
      this.#motion = { eye: [...eye], ms: now, velocity: length(velocity) <= FASTEST ? velocity : [0, 0, 0] };
    } else if (now - before.ms > STILL_MS) {
      before.velocity = [0, 0, 0];
    }
  }

  /** The frame itself, or the nearest before it that a view has, or else the first of any. */
  #frameOf(frame: number): number {
    const ranges = this.#catalogue.views.flatMap(frameRanges);
    if (ranges.some(([first, last]) => first <= frame && frame <= last)) {
      return frame;
    }
    const before = ranges.map(([, last]) => last).filter((last) => last < frame);
    return before.length > 0 ? Math.max(...before) : Math.min(...ranges.map(([first]) => first));
  }

  /** The views that have a frame, the nearest to the eye first, as many as the device has room for. */
  #active(eye: Vec3, frame: number): number[] {
    const candidates = this.#catalogue.views.flatMap((streams, view) => {
      const { position } = this.#container.probeAt(streams.probe, frame);
      return hasFrame(streams, frame) ? [{ view, position }] : [];
    });
    return selectViews(candidates, eye, this.#mostViews);
  }

  /** Brings views to the device, in the place of those that were used longest ago. */
  async #load(active: readonly number[]): Promise<void> {
    for (const view of active.filter((at) => !this.#loaded.has(at))) {
      while (this.#loaded.size >= this.#mostViews) {
        const idle = [...this.#loaded].filter(([other]) => !active.includes(other));
        const [oldest, loaded] = idle.reduce((one, other) => (other[1].lastUsed < one[1].lastUsed ? other : one));
        loaded.unload();
        this.#loaded.delete(oldest);
      }
      this.#loaded.set(view, await LoadedView.load(this.#stage, view));
    }
    active.forEach((at) => (this.#loaded.get(at)!.lastUsed = this.#draws));
  }

  /** Chunks that will be needed: those around where the eye is heading, and while the film plays those of its next frames. */
  #ahead(view: View, active: readonly number[], cameras: readonly Camera[]): Chunk[] {
    const { frame } = view;
    const chunks: Chunk[] = [];
    const velocity = this.#motion?.velocity ?? [0, 0, 0];
    if (length(velocity) > 0) {
      const eye = add(view.pose.eye, scale(velocity, EYE_AHEAD_S));
      this.#heading.look(cameras.map((camera) => ({ ...camera, eye })));
      chunks.push(...this.#chunksOf(active, (stream, unit) => this.#heading.sees(stream, unit), [frame, frame]));
    }
    if (view.playing) {
      const last = frame + Math.ceil(FRAMES_AHEAD_S * this.film.framesPerSecond);
      const next = this.#chunksOf(active, (stream, unit) => this.#visible.sees(stream, unit), [frame + 1, last]);
      chunks.push(...next.sort((a, b) => a.firstFrame - b.firstFrame));
    }
    return chunks;
  }

  /** Chunks with any of some frames, first and last, of the units that are seen. */
  #chunksOf(
    active: readonly number[],
    sees: (stream: Stream, unit: number) => boolean,
    [first, last]: readonly [number, number],
  ): Chunk[] {
    const chunks: Chunk[] = [];
    for (const stream of active.flatMap((at) => this.#catalogue.views[at].faces).flatMap(streamsOf)) {
      for (let unit = 0; unit < this.#container.unitCount(stream.index); unit += 1) {
        const [start, end] = sees(stream, unit) ? this.#container.chunksOf(stream.index, unit) : [0, 0];
        for (let at = start; at < end; at += 1) {
          const chunk = this.#container.chunks[at];
          if (chunk.firstFrame <= last && chunk.firstFrame + chunk.frameCount > first) {
            chunks.push(chunk);
          }
        }
      }
    }
    return chunks;
  }

  /** Renders the eyes and what overlays show, and presents them; answers the counters of the first eye. */
  async #march({ view, active, cameras }: Sight): Promise<Record<string, number>> {
    const [width, height] = view.size;
    const size: [number, number] = [view.stereo === "side-by-side" ? Math.ceil(width / 2) : width, height];
    const marksHoles = view.overlays.has("holes");
    const settings = {
      ...MARCH_SETTINGS,
      steps: view.steps,
      holes: marksHoles ? "nearest" : "behind",
      effects: this.#hasEffects,
    } as const;
    const [left, right, marks] = this.#pictures;
    const shot = (camera: Camera) => {
      const probeOf = (probe: number) => this.#container.probeAt(probe, view.frame);
      return { active: activeViews(this.#catalogue, active, camera.eye, probeOf), camera, size, settings };
    };
    const timing = () => this.#timer.pass("march");
    for (const [eye, camera] of cameras.entries()) {
      await this.#marcher.render(this.#pictures[eye], { ...shot(camera), timing });
    }
    const overlays = TEXEL_OVERLAYS.filter((overlay) => view.overlays.has(overlay));
    if (overlays.length > 0) {
      await this.#marcher.render(marks, { ...shot(cameras[0]), colors: this.#paint(overlays, view.frame, active) });
    }
    [this.#canvas.width, this.#canvas.height] = view.size;
    const hasMarks = overlays.length > 0;
    this.#presenter.show([left, cameras.length > 1 ? right : left, hasMarks ? marks : left], {
      exposureEv: view.exposureEv,
      toneMap: view.toneMap,
      stereo: view.stereo,
      marksHoles,
      overlay: hasMarks ? OVERLAY_SHARE : 0,
    });
    this.onShown();
    return left.readCounters();
  }

  #paint(overlays: readonly TexelOverlay[], frame: number, views: readonly number[]): GPUTextureView {
    this.#overlay ??= new OverlayTexture(this.#container, this.#stage.texels);
    const now = performance.now();
    const isFresh = (chunk: number): boolean => {
      const arrived = this.#arrived.get(rangeKey(this.#container.chunks[chunk]));
      return arrived !== undefined && now - arrived < FRESH_MS;
    };
    const codings = (stream: number, unit: number): UnitCodings | undefined => this.#codings.of(stream, unit);
    this.#overlay.paint(overlays, { frame, isFresh, codings, views });
    return this.#overlay.view;
  }
}
