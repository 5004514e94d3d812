// Plays a container on a canvas: what is in sight is fetched, decoded and drawn.
//
// A picture takes what is here: a unit whose chunks are not here yet shows an older frame, or nothing, and other probes show what is
// there. Nothing waits for a fetch.

import { startWorker } from "../assets.ts";
import { decoderModule } from "../decoder/module.ts";
import { Container } from "../format/container.ts";
import { type ByteSource, type Chunk, type Stream, UnsupportedError, type Vec3 } from "../format/types.ts";
import { findAdapter, Gpu, isSoftware } from "../gpu/device.ts";
import { imageBytes } from "../gpu/texture_arrays.ts";
import { add, length, scale, subtract } from "../math.ts";
import { type Camera, cameraOf, stereoEyes } from "../views/camera.ts";
import { type Catalogue, catalogueOf, frameRanges, hasFrame, streamsOf } from "../views/catalogue.ts";
import { selectViews } from "../views/selection.ts";
import { VisibleUnits } from "../views/visible.ts";
import { CodingMaps, type SeenUnit } from "./coding_maps.ts";
import { CpuRenderer } from "./cpu_renderer.ts";
import { DeviceRenderer } from "./device_renderer.ts";
import { filmOf } from "./film.ts";
import { FramePacing } from "./frame_pacing.ts";
import type { WorkerSettings } from "./jobs.ts";
import { LoadedView, type ViewContext, type UnitCounts } from "./loaded_view.ts";
import { WorkerPool } from "./pool.ts";
import type { DrawResult, Renderer } from "./renderer.ts";
import { withRetries } from "./retries.ts";
import { ChunkStore, rangeKey } from "./store.ts";
import type { Film, Player, PlayerStats, Problem, RendererChoice, RendererName, View } from "./types.ts";
import { type DecodeContext, unitFrame } from "./unit_source.ts";

/** Bytes of the textures and planes of probes at most, unless one probe alone has more. */
const TEXEL_BYTES = 1 << 30;
const MAX_WORKERS = 4;
/** Bytes of the decoders that workers keep, of all together. */
const DECODER_BYTES = 512 << 20;
/** Views that the processor draws from at most: each adds to the time of a picture. */
const MAX_CPU_VIEWS = 4;
/** An image takes about as much again as its textures for planes and pyramids, and again for pictures of its units. */
const IMAGE_SHARE = 3;
/** Frames that are decoded ahead of a film that plays. */
const FRAMES_AHEAD = 3;
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

/** Opens a container to be drawn on a canvas: a NoWebGpuError without a device unless the processor shall draw, an error of formats/ or of
 *  the source. */
export async function openPlayer(
  source: ByteSource,
  canvas: HTMLCanvasElement,
  choice: RendererChoice,
): Promise<Player> {
  const [opened, read] = await Promise.allSettled([openGpu(choice), withRetries(() => Container.open(source))]);
  if (opened.status === "rejected") {
    throw opened.reason;
  }
  const gpu = opened.value;
  let decoding: DecodeContext | undefined;
  let renderer: Renderer | undefined;
  try {
    if (read.status === "rejected") {
      throw read.reason;
    }
    const container = read.value;
    const catalogue = catalogueOf(container);
    const mostFaces = Math.max(...catalogue.views.map(({ faces }) => faces.length));
    const mostViews = mostViewsOf(catalogue, mostFaces, gpu === undefined);
    decoding = decodeContextOf(container);
    const scene = { container, catalogue, canvas, decoding, mostViews, mostImages: mostViews * mostFaces };
    renderer = gpu === undefined ? new CpuRenderer(scene) : await DeviceRenderer.create(gpu, scene);
    return new FilmPlayer({ renderer, decoding, catalogue, mostViews });
  } catch (error) {
    decoding?.store.close();
    decoding?.pool.close();
    renderer?.close();
    gpu?.destroy();
    throw error;
  }
}

/** Views that are loaded at once. Textures of a device have limits of their own. */
function mostViewsOf(catalogue: Catalogue, mostFaces: number, isCpu: boolean): number {
  const { views } = catalogue;
  const ofView = mostFaces * IMAGE_SHARE * imageBytes(catalogue);
  if (isCpu && ofView > TEXEL_BYTES) {
    throw new UnsupportedError("The images of a probe are larger than the processor draws; a graphics device may.");
  }
  const room = Math.max(1, Math.floor(TEXEL_BYTES / ofView));
  return Math.min(views.length, room, isCpu ? MAX_CPU_VIEWS : Infinity);
}

/** The device that shall draw, if any. */
async function openGpu(choice: RendererChoice): Promise<Gpu | undefined> {
  if (choice === "cpu") {
    return undefined;
  }
  const adapter = await findAdapter();
  return choice === "auto" && isSoftware(adapter) ? undefined : Gpu.open(adapter);
}

/** The chunks of a container, and workers for them. */
function decodeContextOf(container: Container): DecodeContext {
  const workers = Math.max(1, Math.min(MAX_WORKERS, (navigator.hardwareConcurrency || 2) - 1));
  const settings: WorkerSettings = { module: decoderModule(), keptBytes: DECODER_BYTES / workers };
  const start = (): Worker => {
    const worker = startWorker("worker.js", import.meta.url);
    worker.postMessage(settings);
    return worker;
  };
  const pool = new WorkerPool(workers, start, (stream) => {
    const { kind, codec, face, width, height, unitWidth, unitHeight, headerBytes } = container.streams[stream];
    return { stream: { kind, codec, face, width, height, unitWidth, unitHeight }, headerBytes };
  });
  const store = new ChunkStore(container.source);
  return {
    container,
    frames: { shown: 0, next: [0, 0] },
    store,
    pool,
    onReady: () => undefined,
    onBroken: () => undefined,
  };
}

/** Where the eye was and when. */
interface Motion {
  eye: Vec3;
  ms: number;
  /** Metres per second. */
  velocity: Vec3;
}

/** What a view takes: views of the catalogue, the nearest first, cameras of the eyes, and how far its units are. */
interface PreparedView {
  /** With a frame that there is. */
  view: View;
  active: number[];
  cameras: Camera[];
  counts: UnitCounts;
}

/** What a player is made of. */
interface Parts {
  renderer: Renderer;
  decoding: DecodeContext;
  catalogue: Catalogue;
  /** Views that are loaded at once. */
  mostViews: number;
}

class FilmPlayer implements Player {
  readonly film: Film;
  onProblem: (problem: Problem) => void = () => undefined;
  onShown: () => void = () => undefined;
  readonly #renderer: Renderer;
  readonly #container: Container;
  readonly #catalogue: Catalogue;
  readonly #decoding: DecodeContext;
  readonly #context: ViewContext;
  readonly #visible: VisibleUnits;
  /** For where the eye is heading. */
  readonly #heading: VisibleUnits;
  /** By their places in the catalogue. */
  readonly #loaded = new Map<number, LoadedView>();
  readonly #mostViews: number;
  /** When chunks arrived, by the keys of their ranges. */
  readonly #arrived = new Map<string, number>();
  /** For the overlay of nodes. */
  readonly #codings: CodingMaps;
  #overlayMissing = 0;
  readonly #pacing = new FramePacing();
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

  constructor({ renderer, decoding, catalogue, mostViews }: Parts) {
    const { container, store, pool } = decoding;
    this.#renderer = renderer;
    this.#container = container;
    this.#catalogue = catalogue;
    this.#decoding = decoding;
    this.#mostViews = mostViews;
    this.film = filmOf(
      container,
      catalogue.views.map(({ probe }) => probe),
    );
    this.#shownFrame = this.film.firstFrame;
    store.onChunk = (key) => {
      this.#arrived.set(key, performance.now());
      this.#wake();
    };
    store.onProblem = (problem) => this.#tell(problem);
    this.#codings = new CodingMaps(decoding);
    pool.onFailed = (message) => this.#tell({ fatal: true, message });
    renderer.onFailed = (message) => this.#tell({ fatal: true, isOfDevice: renderer.name === "gpu", message });
    decoding.onReady = () => this.#wake();
    decoding.onBroken = (message) => this.#tell({ fatal: false, message });
    this.#context = { renderer, decoding, coding: catalogue.coding };
    this.#visible = new VisibleUnits(container);
    this.#heading = new VisibleUnits(container);
  }

  get renderer(): RendererName {
    return this.#renderer.name;
  }

  get mostPixels(): number {
    return this.#renderer.mostPixels;
  }

  async draw(view: View): Promise<PlayerStats> {
    const scene = await this.#bring(view);
    const { counts, active } = scene;
    const unitsMissing = counts.missing + counts.working;
    // Rays through nothing known take longest: the first picture waits for what comes soon.
    this.#isShown ||= unitsMissing === 0 || performance.now() - this.#openedMs > FIRST_MS;
    const drawn = this.#isShown ? await this.#draw(scene) : undefined;
    this.#shownFrame = unitsMissing === 0 ? scene.view.frame : this.#shownFrame;
    const fetched = this.#decoding.store.stats;
    return {
      ...fetched,
      counters: {
        ...drawn?.counters,
        ...this.#totals,
        cells_unchanged: counts.shown,
        bytes_read: fetched.bytesFetched,
        active_probes: active.length,
      },
      decodeMs: drawn?.decodeMs ?? (await this.#renderer.decodeMs()),
      marchMs: drawn?.marchMs ?? 0,
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
      await Promise.all([ready, this.#renderer.decodeMs()]);
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
      .filter((chunk) => this.#decoding.store.get(chunk) === undefined)
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

  pixels(): Promise<{ size: [number, number]; rgba: Float32Array }> {
    return this.#renderer.pixels();
  }

  close(): void {
    this.#isClosed = true;
    this.#wake();
    this.#decoding.store.close();
    this.#decoding.pool.close();
    this.#renderer.close();
  }

  #tell(problem: Problem): void {
    if (!this.#isClosed) {
      this.onProblem(problem);
    }
  }

  /** Brings the texels to a view as far as chunks are here, and asks for the others. */
  async #bring(asked: View): Promise<PreparedView> {
    const { playing } = asked;
    const frame = this.#pacing.next(this.#frameOf(asked.frame), playing, performance.now());
    this.#draws += 1;
    this.#lastView = asked;
    this.#notice(asked);
    const cameras = this.#cameras(asked);
    const active = this.#active(asked.pose.eye, frame);
    await this.#load(active);
    this.#visible.look(cameras);
    const { renderer, decoding } = this.#context;
    const { texels } = renderer;
    const isVisible = (stream: Stream, unit: number): boolean => this.#visible.sees(stream, unit);
    // Secondary rays go anywhere.
    const isSpecular = (): boolean => renderer.hasEffects && active.some((at) => texels.isSpecular(at, isVisible));
    const needsAll = isSpecular();
    const sees = needsAll ? (): boolean => true : isVisible;
    const views = active.map((at) => this.#loaded.get(at)!);
    const fetch: Chunk[] = [];
    const bring = (how: "ask" | "prepare", of: number, missing: Chunk[]): UnitCounts => {
      const counts: UnitCounts = { shown: 0, ready: 0, working: 0, missing: 0, broken: 0 };
      views.forEach((one) => one[how](of, { sees, fetch: missing, counts }));
      return counts;
    };
    const next: [number, number] = [frame, frame + (playing ? FRAMES_AHEAD : 0)];
    decoding.frames = { shown: this.#pacing.shown ?? frame, next };
    const prepared = bring("prepare", frame, fetch);
    const shown = this.#pacing.show(prepared.missing + prepared.working === 0, playing, performance.now());
    decoding.frames = { shown, next };
    const counts = bring("ask", shown, fetch);
    for (let ahead = frame + 1; ahead <= next[1]; ahead += 1) {
      bring("prepare", ahead, []);
    }
    const view = { ...asked, frame: shown };
    this.#overlayMissing = this.#mark(view, active, fetch);
    const inUse = [...new Set([frame, shown])].flatMap((one) => this.#chunksOf(active, sees, [one, one]));
    decoding.store.want([...fetch, ...this.#ahead({ ...asked, frame }, active, cameras)], inUse);
    for (const one of views) {
      const { units, pixels, behind } = one.update();
      counts.working += behind;
      this.#totals.cells_decoded += units;
      this.#totals.pixels_decoded += pixels;
    }
    texels.update();
    // A material that has just been decoded needs all units, which the next call asks for.
    counts.working += Number(isSpecular() && !needsAll);
    if (counts.working > 0 && decoding.pool.pending === 0) {
      // Nothing else would.
      this.#wake();
    }
    return { view, active, cameras, counts: shown === frame ? counts : prepared };
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
      this.#loaded.set(view, await LoadedView.load(this.#context, view, this.#catalogue.views[view]));
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
    frames: readonly [number, number],
  ): Chunk[] {
    const chunks: Chunk[] = [];
    for (const stream of active.flatMap((at) => this.#catalogue.views[at].faces).flatMap(streamsOf)) {
      for (let unit = 0; unit < this.#container.unitCount(stream.index); unit += 1) {
        if (sees(stream, unit)) {
          const [start, end] = this.#container.chunksAmong(stream.index, unit, frames);
          chunks.push(...this.#container.chunks.slice(start, end));
        }
      }
    }
    return chunks;
  }

  #draw({ view, active, cameras }: PreparedView): Promise<DrawResult> {
    const now = performance.now();
    const isFresh = (chunk: number): boolean => {
      const arrived = this.#arrived.get(rangeKey(this.#container.chunks[chunk]));
      return arrived !== undefined && now - arrived < FRESH_MS;
    };
    const codings = (stream: number, unit: number) => this.#codings.of(stream, unit);
    return this.#renderer.draw({ view, cameras, views: active, isFresh, codings }, () => this.onShown());
  }
}
