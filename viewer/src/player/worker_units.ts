// Units of a stream that workers decode: colors of the transform codec and of half floats, colors with alpha, alpha and materials.

import type { Pixels } from "../codec/types.ts";
import type { Chunk, Stream } from "../format/types.ts";
import { type Desk, storedChunk, type UnitFrame, type UnitSource, type UnitState } from "./unit_source.ts";

interface Shown {
  pixels: Pixels;
  chunk: number;
  frame: number;
}

/** One stream. The processor keeps the pictures. */
export class WorkerUnits implements UnitSource {
  #changed = new Set<number>();
  readonly #shown = new Map<number, Shown>();
  /** A job at a time for each unit. */
  readonly #working = new Set<number>();
  readonly #broken = new Set<number>();
  /** Chunks whose last frames blend into the one behind. */
  readonly #needsNext = new Set<number>();

  constructor(
    readonly stream: Stream,
    private readonly desk: Desk,
  ) {}

  hasPicture(unit: number): boolean {
    return this.#shown.has(unit);
  }

  /** The pixels of a unit, row by row. */
  pixels(unit: number): Pixels | undefined {
    return this.#shown.get(unit)?.pixels;
  }

  /** Units with new pictures since the last call. */
  takeChanged(): number[] {
    const changed = [...this.#changed];
    this.#changed = new Set();
    return changed;
  }

  ask(wanted: UnitFrame, fetch: Chunk[]): UnitState {
    const shown = this.#shown.get(wanted.unit);
    if (shown?.chunk === wanted.chunk && shown.frame === wanted.frame) {
      return "shown";
    }
    if (this.#broken.has(wanted.chunk)) {
      return "broken";
    }
    const chunk = storedChunk(this.desk, wanted.chunk, fetch);
    const takesNext = wanted.next >= 0 && this.#needsNext.has(wanted.chunk);
    const next = takesNext ? storedChunk(this.desk, wanted.next, fetch) : undefined;
    if (chunk === undefined || (takesNext && next === undefined)) {
      return "missing";
    }
    if (!this.#working.has(wanted.unit)) {
      this.#working.add(wanted.unit);
      const frame = wanted.frame - chunk.chunk.firstFrame;
      const job = this.desk.pool.decode(chunk, frame, () => true, next);
      void job.then(
        (answer) => this.#arrive(wanted, answer),
        (error: Error) => this.#fail(wanted, error),
      );
    }
    return "working";
  }

  #arrive(wanted: UnitFrame, answer: Pixels | "next" | undefined): void {
    this.#working.delete(wanted.unit);
    if (answer === "next") {
      this.#needsNext.add(wanted.chunk);
    } else if (answer !== undefined) {
      this.#shown.set(wanted.unit, { pixels: answer, chunk: wanted.chunk, frame: wanted.frame });
      this.#changed.add(wanted.unit);
    }
    this.desk.onReady();
  }

  #fail(wanted: UnitFrame, error: Error): void {
    this.#working.delete(wanted.unit);
    this.#broken.add(wanted.chunk);
    this.desk.onBroken(error.message);
    this.desk.onReady();
  }
}
