// Where the units of a stream are decoded: on the device, or by workers.

import type { Pixels, StoredChunk } from "../decoder/types.ts";
import type { Container } from "../format/container.ts";
import type { Chunk } from "../format/types.ts";
import type { WorkerPool } from "./pool.ts";
import type { ChunkStore } from "./store.ts";

/** Frames whose pictures are of use: the one that is shown, and those that are shown next. */
export interface FrameWindow {
  shown: number;
  /** First and last. */
  next: [number, number];
}

/** Whether pictures of a frame are of use. */
export function isWithin({ shown, next: [first, last] }: FrameWindow, frame: number): boolean {
  return frame === shown || (frame >= first && frame <= last);
}

/** What units of all streams share. */
export interface DecodeContext {
  frames: FrameWindow;
  container: Container;
  store: ChunkStore;
  pool: WorkerPool;
  /** A job is done: what it made may be drawn. */
  onReady: () => void;
  /** A chunk cannot be decoded; the sentence of a worker. */
  onBroken: (message: string) => void;
}

/** What a unit shows, by the numbers of its stream and its own; `undefined` where nothing is known, or the device has it. */
export type PixelsOf = (stream: number, unit: number) => Pixels | undefined;

/** A frame that a unit is to show. `next` is the place of the chunk behind, or -1. */
export interface UnitFrame {
  unit: number;
  frame: number;
  /** Place of its chunk in the container's table. */
  chunk: number;
  next: number;
}

/** How far a unit is. */
export type UnitState =
  /** It shows the frame. */
  | "shown"
  /** It will after the next call of `DeviceFamily.decode`. */
  | "ready"
  /** Its chunks are here, and jobs on their way. */
  | "working"
  /** Chunks must be fetched. */
  | "missing"
  /** Its chunk breaks a rule, or cannot be decoded here. */
  | "broken";

/** The units of one stream. */
export interface UnitSource {
  /** Whether a unit has any picture. */
  hasPicture(unit: number): boolean;
  /** Whether what a unit shows is right for a frame. */
  shows(wanted: UnitFrame): boolean;
  /** What keeps a unit from a frame that it is to show. Chunks to be fetched are added to `fetch`; jobs begin where their chunks are here. */
  ask(wanted: UnitFrame, fetch: Chunk[]): UnitState;
  /** The same of a frame that comes later: the unit goes on to show what it does. */
  prepare(wanted: UnitFrame, fetch: Chunk[]): UnitState;
}

/** The frame of a unit and where its chunks are; `undefined` where its stream does not have the frame. */
export function unitFrame(container: Container, stream: number, unit: number, frame: number): UnitFrame | undefined {
  const chunk = container.chunkIndex(stream, unit, frame);
  if (chunk < 0) {
    return undefined;
  }
  const next = container.placeOf(chunk) === "last" ? -1 : chunk + 1;
  return { unit, frame, chunk, next };
}

/** A chunk with its bytes; `undefined` where they are not here, and then it is added to `fetch`. */
export function storedChunk({ container, store }: DecodeContext, at: number, fetch: Chunk[]): StoredChunk | undefined {
  const chunk = container.chunks[at];
  const stored = store.get(chunk);
  if (stored === undefined) {
    fetch.push(chunk);
    return undefined;
  }
  return { chunk, stored, area: container.areaOf(at) };
}
