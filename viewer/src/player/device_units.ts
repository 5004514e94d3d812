// Units of the streams of one family of a probe, decoded on the device: depth, and 8-bit colors of cells.

import type { Chunk, Stream } from "../format/types.ts";
import type { FamilyDecoder, Wanted } from "../gpu/decoder.ts";
import { type DecodeContext, storedChunk, type UnitFrame, type UnitSource, type UnitState } from "./unit_source.ts";

/** What a call decoded. */
export interface DecodedUnits {
  changed: Wanted[];
  pixels: number;
  behind: number;
}

/** The decoder of a family, and the chunks that are on their way to it. */
export class DeviceFamily {
  /** Units to be decoded by the next call of {@link DeviceFamily.decode}. */
  #wanted: Wanted[] = [];
  /** Chunks that the last frame needed, and that this one needs, by their keys. */
  #before = new Set<number>();
  #needed = new Set<number>();
  readonly #preparing = new Set<number>();
  readonly #broken = new Set<number>();
  #isClosed = false;

  constructor(
    readonly decoder: FamilyDecoder,
    private readonly decoding: DecodeContext,
    /** Words of chunks that stay on the device beside those that a frame needs. */
    private readonly keptWords: number,
    /** Is asked for what times a pass, where there is work. */
    private readonly timing: () => GPUComputePassTimestampWrites | undefined,
  ) {}

  /** A stream's units. */
  units(position: number): DeviceUnits {
    return new DeviceUnits(this, position);
  }

  shows(position: number, frame: UnitFrame): boolean {
    return this.decoder.shows(this.#wantedOf(position, frame));
  }

  #wantedOf(position: number, { unit, frame, chunk, next }: UnitFrame): Wanted {
    const { firstFrame } = this.decoding.container.chunks[chunk];
    return { stream: position, unit, frame, key: chunk + 1, firstFrame, nextKey: next + 1 };
  }

  ask(position: number, one: UnitFrame, fetch: Chunk[]): UnitState {
    const state = this.prepare(position, one, fetch);
    if (state === "ready") {
      this.#wanted.push(this.#wantedOf(position, one));
    }
    return state;
  }

  prepare(position: number, one: UnitFrame, fetch: Chunk[]): UnitState {
    const { chunk, next } = one;
    const wanted = this.#wantedOf(position, one);
    if (this.decoder.shows(wanted)) {
      return "shown";
    }
    const states = [this.#bring(chunk, fetch)];
    if (states[0] === "shown" && next >= 0 && this.decoder.needsNext(wanted)) {
      states.push(this.#bring(next, fetch));
    }
    if (states.every((state) => state === "shown")) {
      return "ready";
    }
    return (["broken", "missing", "working"] as const).find((state) => states.includes(state)) ?? "working";
  }

  /** Decodes what was asked for and is here; answers the units whose pictures changed, by the positions of their streams, and the pixels
   *  written, and how many are not at their frame yet. */
  decode(): DecodedUnits {
    const [wanted, needed] = [this.#wanted, this.#needed];
    this.#wanted = [];
    this.#before = needed;
    this.#needed = new Set();
    const done = this.decoder.decode(wanted, wanted.length > 0 ? this.timing() : undefined);
    done.refused.forEach(({ key }) => this.#broken.add(key));
    this.decoder.drop(needed, this.keptWords);
    return { changed: done.written.map(({ wanted: one }) => one), pixels: done.pixels, behind: done.behind.length };
  }

  /** Frees the decoder. */
  close(): void {
    this.#isClosed = true;
    this.decoder.destroy();
  }

  /** Whether a chunk is on the device ("shown"), or what keeps it from there. */
  #bring(at: number, fetch: Chunk[]): UnitState {
    const key = at + 1;
    this.#needed.add(key);
    if (this.decoder.has(key)) {
      return "shown";
    }
    if (this.#broken.has(key)) {
      return "broken";
    }
    if (this.#preparing.has(key)) {
      return "working";
    }
    const chunk = storedChunk(this.decoding, at, fetch);
    if (chunk === undefined) {
      return "missing";
    }
    this.#preparing.add(key);
    void this.decoding.pool
      .prepare(chunk, () => true)
      .then(
        (prepared) => {
          this.#preparing.delete(key);
          if (this.#isClosed) {
            return;
          }
          if (prepared !== undefined && !this.decoder.add(key, prepared)) {
            // No room: chunks that the last frame did not need go.
            this.decoder.drop(this.#before, 0);
            if (!this.decoder.add(key, prepared)) {
              this.#broken.add(key);
              this.decoding.onBroken("The graphics device has no room for the chunks of a frame.");
            }
          }
          this.decoding.onReady();
        },
        (error: Error) => {
          this.#preparing.delete(key);
          this.#broken.add(key);
          this.decoding.onBroken(error.message);
          this.decoding.onReady();
        },
      );
    return "working";
  }
}

/** The units of a stream of a family. */
export class DeviceUnits implements UnitSource {
  constructor(
    readonly family: DeviceFamily,
    readonly position: number,
  ) {}

  get stream(): Stream {
    return this.family.decoder.streams[this.position];
  }

  hasPicture(unit: number): boolean {
    return this.family.decoder.showsAny(this.position, unit);
  }

  shows(wanted: UnitFrame): boolean {
    return this.family.shows(this.position, wanted);
  }

  ask(wanted: UnitFrame, fetch: Chunk[]): UnitState {
    return this.family.ask(this.position, wanted, fetch);
  }

  prepare(wanted: UnitFrame, fetch: Chunk[]): UnitState {
    return this.family.prepare(this.position, wanted, fetch);
  }
}
