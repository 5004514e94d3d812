// Units of a stream that workers decode: colors of the transform codec and of half floats, colors with alpha, alpha and materials.

import type { Pixels } from "../decoder/types.ts";
import type { Chunk, Stream } from "../format/types.ts";
import {
  type DecodeContext,
  isWithin,
  storedChunk,
  type UnitFrame,
  type UnitSource,
  type UnitState,
} from "./unit_source.ts";

interface Picture {
  pixels: Pixels;
  chunk: number;
  frame: number;
}

interface Unit {
  shown: Picture | undefined;
  /** Of frames that come next, by frame. */
  ready: Map<number, Picture>;
  /** Frames that workers are at. */
  working: Set<number>;
}

/** One stream. The processor keeps the pictures. */
export class WorkerUnits implements UnitSource {
  #changed = new Set<number>();
  readonly #units = new Map<number, Unit>();
  readonly #broken = new Set<number>();
  /** Chunks whose last frames blend into the one behind. */
  readonly #needsNext = new Set<number>();

  constructor(
    readonly stream: Stream,
    private readonly decoding: DecodeContext,
  ) {}

  hasPicture(unit: number): boolean {
    return this.#units.get(unit)?.shown !== undefined;
  }

  shows({ unit, chunk, frame }: UnitFrame): boolean {
    const shown = this.#units.get(unit)?.shown;
    return shown?.chunk === chunk && shown.frame === frame;
  }

  /** The frame that a unit shows. */
  frame(unit: number): number | undefined {
    return this.#units.get(unit)?.shown?.frame;
  }

  /** The pixels of a unit, row by row. */
  pixels(unit: number): Pixels | undefined {
    return this.#units.get(unit)?.shown?.pixels;
  }

  /** Units with new pictures since the last call. */
  takeChanged(): number[] {
    const changed = [...this.#changed];
    this.#changed = new Set();
    return changed;
  }

  ask(wanted: UnitFrame, fetch: Chunk[]): UnitState {
    const { ready } = this.#unit(wanted.unit);
    const useless = [...ready.keys()].filter((frame) => !isWithin(this.decoding.frames, frame));
    useless.forEach((frame) => ready.delete(frame));
    const state = this.prepare(wanted, fetch);
    if (state === "ready") {
      this.#show(wanted.unit, ready.get(wanted.frame)!);
      ready.delete(wanted.frame);
    }
    return state;
  }

  prepare(wanted: UnitFrame, fetch: Chunk[]): UnitState {
    if (this.shows(wanted)) {
      return "shown";
    }
    const picture = this.#unit(wanted.unit).ready.get(wanted.frame);
    return picture?.chunk === wanted.chunk ? "ready" : this.#start(wanted, fetch);
  }

  #unit(unit: number): Unit {
    const known = this.#units.get(unit) ?? { shown: undefined, ready: new Map(), working: new Set() };
    this.#units.set(unit, known);
    return known;
  }

  #show(unit: number, picture: Picture): void {
    this.#unit(unit).shown = picture;
    this.#changed.add(unit);
  }

  #start(wanted: UnitFrame, fetch: Chunk[]): UnitState {
    if (this.#broken.has(wanted.chunk)) {
      return "broken";
    }
    const unit = this.#unit(wanted.unit);
    const chunk = storedChunk(this.decoding, wanted.chunk, fetch);
    const takesNext = wanted.next >= 0 && this.#needsNext.has(wanted.chunk);
    const next = takesNext ? storedChunk(this.decoding, wanted.next, fetch) : undefined;
    if (chunk === undefined || (takesNext && next === undefined)) {
      return "missing";
    }
    if (!unit.working.has(wanted.frame)) {
      unit.working.add(wanted.frame);
      const frame = wanted.frame - chunk.chunk.firstFrame;
      const job = this.decoding.pool.decode(chunk, frame, () => isWithin(this.decoding.frames, wanted.frame), next);
      void job.then(
        (answer) => this.#arrive(wanted, answer),
        (error: Error) => this.#fail(wanted, error),
      );
    }
    return "working";
  }

  #arrive(wanted: UnitFrame, answer: Pixels | "next" | undefined): void {
    const unit = this.#unit(wanted.unit);
    unit.working.delete(wanted.frame);
    if (answer === "next") {
      this.#needsNext.add(wanted.chunk);
    } else if (answer !== undefined) {
      const picture = { pixels: answer, chunk: wanted.chunk, frame: wanted.frame };
      const { frames } = this.decoding;
      if (wanted.frame === frames.shown || unit.shown === undefined) {
        // A late picture is better than none.
        this.#show(wanted.unit, picture);
      } else if (isWithin(frames, wanted.frame)) {
        unit.ready.set(wanted.frame, picture);
      } else if (unit.shown.frame > frames.shown || (unit.shown.frame < wanted.frame && wanted.frame < frames.shown)) {
        this.#show(wanted.unit, picture);
      }
    }
    this.decoding.onReady();
  }

  #fail(wanted: UnitFrame, error: Error): void {
    this.#unit(wanted.unit).working.delete(wanted.frame);
    this.#broken.add(wanted.chunk);
    this.decoding.onBroken(error.message);
    this.decoding.onReady();
  }
}
