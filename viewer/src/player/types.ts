// The interface between page and player. The page knows no container and no device.

import type { Vec3 } from "../format/types.ts";
import type { Pose } from "../views/camera.ts";
import type { StereoLayout, ToneMapName } from "../views/presentation.ts";

export type { Pose, StereoLayout, ToneMapName };

export interface Film {
  name: string;
  fileBytes: number;
  framesPerSecond: number;
  firstFrame: number;
  frameCount: number;
  /** The frame to begin with; else the first. */
  startFrame?: number;
  /** The box of the probes' positions over all frames, in metres. */
  headBox: { least: Vec3; greatest: Vec3 };
  probes: { name: string; position: Vec3 }[];
  /** No surface is nearer to a probe than this, in metres; none where it is unknown. */
  nearM?: number;
  /** Where to begin: the middle probe, looking as it does. */
  start: Pose;
  /** Rows for the inspector: kind, codec, and stored bytes of all such streams. */
  streams: { kind: string; codec: string; count: number; bytes: number }[];
}

/** What draws: the graphics device, or the processor in small pictures. */
export type RendererName = "gpu" | "cpu";
/** With "auto" the graphics device draws, unless that is a program on the processor, which is slower than our own. */
export type RendererChoice = RendererName | "auto";
/** Overlays of the inspector; several at once. */
export type Overlay = "probes" | "nodes" | "holes" | "units" | "keyframes" | "fetched";

export interface View {
  pose: Pose;
  frame: number;
  /** Whether the film plays: then frames that come next are fetched and decoded ahead. */
  playing: boolean;
  /** Of the canvas, in device pixels. The player gives the canvas this size as it shows the picture, so that it is never blank. */
  size: [number, number];
  /** Vertical field of view in degrees. */
  fovDeg: number;
  stereo: StereoLayout;
  /** Metres between the eyes. */
  eyeDistance: number;
  exposureEv: number;
  toneMap: ToneMapName;
  overlays: ReadonlySet<Overlay>;
  /** Marching steps; fewer are faster. */
  steps: number;
}

/** Counters of the last picture and of all so far, by the names of `lightfold render --stats`. */
export interface PlayerStats {
  /** Marching: primary_rays, march_steps, ...; decoding: cells_decoded, cells_skipped, bytes_read, ... */
  counters: Record<string, number>;
  decodeMs: number;
  /** 0 where nothing was drawn: a film that has just been opened waits a moment for its first tiles and cells. */
  marchMs: number;
  /** Bytes per second over the last second. */
  fetchRate: number;
  bytesFetched: number;
  requests: number;
  chunksFetched: number;
  /** Chunks that were fetched a second time, since the cache had dropped them. */
  chunksRefetched: number;
  cacheBytes: number;
  /** Tiles and cells of the picture that show an older frame, or nothing, as they are not fetched or decoded yet. */
  unitsMissing: number;
  /** Tiles and cells whose chunks cannot be decoded. */
  unitsBroken: number;
  /** Tiles whose overlay of nodes is not that of the picture's frame yet. */
  overlayMissing: number;
  /** Frame of the picture that is shown; the wanted one once it is complete. */
  shownFrame: number;
}

/** Something the viewer must know. */
export interface Problem {
  /** Nothing more will be drawn. */
  fatal: boolean;
  /** It may pass: it is told again as long as it lasts. */
  passes?: boolean;
  /** The graphics device fails; the processor may draw. */
  isOfDevice?: boolean;
  /** One sentence. Plain text: it may hold names from a file. */
  message: string;
}

export interface Player {
  readonly film: Film;
  /** What draws a container. */
  readonly renderer?: RendererName;
  /** Pixels of a picture at most. */
  readonly mostPixels?: number;
  /** Draws into the canvas, from what is here; fetches what is missing for this view and for where the eye is heading. Never waits for a
   *  fetch. Resolves when the device has drawn. */
  draw(view: View): Promise<PlayerStats>;
  /** Resolves once all chunks of this view are here and decoded, or rejects. */
  settle(view: View): Promise<void>;
  /** Frames of which everything in sight of the last view is here: [first, last] pairs, ascending. */
  fetched(): [number, number][];
  /** The last picture as red, green, blue, alpha of linear light, row by row. */
  pixels(): Promise<{ size: [number, number]; rgba: Float32Array }>;
  /** Called on problems: a request that fails again and again, a file that changed, a chunk that breaks a rule. */
  onProblem: (problem: Problem) => void;
  /** Called in the task in which a picture went to the canvas: until that ends, and no longer, its pixels can be copied. */
  onShown: () => void;
  close(): void;
}
