// Times of passes on the device, where it can tell them.

import type { Gpu } from "../gpu/device.ts";

/** Passes of a picture at most; later ones are not timed. */
const PASSES = 256;
const BYTES = 16 * PASSES;

/** Sums up the times of a picture's passes by their names. */
export class DeviceTimer {
  readonly #gpu: Gpu;
  readonly #set: GPUQuerySet | undefined;
  readonly #resolved: GPUBuffer | undefined;
  #names: string[] = [];

  constructor(gpu: Gpu) {
    this.#gpu = gpu;
    if (gpu.hasTimestamps) {
      this.#set = gpu.device.createQuerySet({ type: "timestamp", count: 2 * PASSES });
      const usage = GPUBufferUsage.QUERY_RESOLVE | GPUBufferUsage.COPY_SRC;
      this.#resolved = gpu.device.createBuffer({ label: "timestamps", size: BYTES, usage });
    }
  }

  /** What times the next pass; `undefined` where it cannot be timed. */
  pass(name: string): GPUComputePassTimestampWrites | undefined {
    if (this.#set === undefined || this.#names.length === PASSES) {
      return undefined;
    }
    const at = 2 * this.#names.length;
    this.#names.push(name);
    return { querySet: this.#set, beginningOfPassWriteIndex: at, endOfPassWriteIndex: at + 1 };
  }

  /** Milliseconds of all passes since the last call, by name. Waits for the device. */
  async read(): Promise<Map<string, number>> {
    const sums = new Map<string, number>();
    const [set, resolved, names] = [this.#set, this.#resolved, this.#names];
    this.#names = [];
    if (set === undefined || resolved === undefined || names.length === 0) {
      return sums;
    }
    this.#gpu.submit((encoder) => encoder.resolveQuerySet(set, 0, 2 * names.length, resolved, 0));
    const words = await this.#gpu.read(resolved, 0, 4 * names.length);
    const times = new BigUint64Array(words.buffer);
    names.forEach((name, at) => {
      // A pass that was not run, or whose clock was set back, has no time.
      const [begin, end] = [times[2 * at], times[2 * at + 1]];
      const ms = begin > 0n && end > begin ? Number(end - begin) / 1e6 : 0;
      sums.set(name, (sums.get(name) ?? 0) + ms);
    });
    return sums;
  }
}
