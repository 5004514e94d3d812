// How the depth of units in sight is coded, for the overlay of nodes. Workers are asked only for what a picture with the overlay shows, a
// few units at a time, and nothing waits for them.

import type { Chunk } from "../format/types.ts";
import type { StoredChunk } from "../decoder/types.ts";
import { type DecodeContext, storedChunk, type UnitFrame } from "./unit_source.ts";

/** Bytes of maps at most. Units of a picture beyond it have none. */
const MAX_BYTES = 64 << 20;
/** Units that workers are asked for at once. */
const MAX_ASKED = 8;

/** How each pixel of a unit is coded in a frame (player/coding_colors.ts), row by row. */
export interface UnitCodings {
  chunk: number;
  frame: number;
  bytes: Uint8Array;
}

/** A unit in sight, and the frame that it is to show. */
export interface SeenUnit extends UnitFrame {
  stream: number;
}

export class CodingMaps {
  /** By streams and units; those that no picture shows, for longest, first. */
  readonly #maps = new Map<string, UnitCodings>();
  /** Units of the last picture. */
  #seen = new Set<string>();
  /** Those of them whose maps are not here, in the order in which workers are to be asked. */
  #waiting: SeenUnit[] = [];
  readonly #asked = new Set<string>();
  /** When units were asked for last, as numbers that count up. */
  readonly #turns = new Map<string, number>();
  #turn = 0;
  readonly #broken = new Set<number>();

  constructor(private readonly decoding: DecodeContext) {}

  /** Takes in the units that a picture shows, and asks for maps of their frames that are not here, those that waited longest first; chunks
   *  to be fetched are added to `fetch`. Answers how many are not here yet. */
  show(units: readonly SeenUnit[], fetch: Chunk[]): number {
    this.#seen = new Set(units.map(keyOf));
    const missing: SeenUnit[] = [];
    let bytes = 0;
    for (const unit of units) {
      bytes += this.#bytesOf(unit);
      if (bytes > MAX_BYTES || this.#broken.has(unit.chunk)) {
        continue;
      }
      const key = keyOf(unit);
      const map = this.#maps.get(key);
      if (map !== undefined) {
        this.#keep(key, map);
      }
      if (map?.chunk !== unit.chunk || map.frame !== unit.frame) {
        missing.push(unit);
      }
    }
    const turn = (unit: SeenUnit): number => this.#turns.get(keyOf(unit)) ?? -1;
    this.#waiting = missing.sort((one, other) => turn(one) - turn(other));
    this.#pump(fetch);
    return missing.length;
  }

  /** The map of a unit: of the frame that it is to show, or of another one until that is here. */
  of(stream: number, unit: number): UnitCodings | undefined {
    return this.#maps.get(keyOf({ stream, unit }));
  }

  /** Forgets all maps, as the overlay is off. */
  clear(): void {
    this.#maps.clear();
    this.#seen.clear();
    this.#waiting = [];
    this.#turns.clear();
  }

  #bytesOf({ stream, unit }: SeenUnit): number {
    const [, , width, height] = this.decoding.container.unitRect(stream, unit);
    return width * height;
  }

  /** Asks for as many of the units that wait as may be asked for at once. */
  #pump(fetch: Chunk[]): void {
    this.#waiting = this.#waiting.filter((unit) => {
      if (this.#asked.has(keyOf(unit)) || this.#asked.size >= MAX_ASKED) {
        return true;
      }
      const stored = storedChunk(this.decoding, unit.chunk, fetch);
      if (stored !== undefined) {
        this.#ask(unit, stored);
      }
      return stored === undefined;
    });
  }

  #ask(unit: SeenUnit, stored: StoredChunk): void {
    const key = keyOf(unit);
    const { chunk, frame } = unit;
    this.#asked.add(key);
    this.#turns.set(key, (this.#turn += 1));
    const isWanted = (): boolean => this.#seen.has(key);
    const arrive = (bytes: Uint8Array | undefined): void => {
      if (bytes !== undefined && isWanted()) {
        this.#keep(key, { chunk, frame, bytes });
        this.#trim();
      }
    };
    // What decodes the chunk tells of its errors.
    const fail = (): void => void this.#broken.add(chunk);
    const job = this.decoding.pool.codings(stored, frame - stored.chunk.firstFrame, isWanted).then(arrive, fail);
    void job.then(() => {
      this.#asked.delete(key);
      this.#pump([]);
      this.decoding.onReady();
    });
  }

  /** Keeps a map, behind all others. */
  #keep(key: string, map: UnitCodings): void {
    this.#maps.delete(key);
    this.#maps.set(key, map);
  }

  #trim(): void {
    let bytes = [...this.#maps.values()].reduce((sum, map) => sum + map.bytes.length, 0);
    for (const [key, map] of this.#maps) {
      if (bytes <= MAX_BYTES) {
        return;
      }
      this.#maps.delete(key);
      bytes -= map.bytes.length;
    }
  }
}

function keyOf({ stream, unit }: Pick<SeenUnit, "stream" | "unit">): string {
  return `${stream} ${unit}`;
}
