// An instance of lightfold.wasm: input and output of its functions, and their errors (src/wasm/exports.rs).

import { FormatError, UnsupportedError } from "../format/types.ts";
import type { Camera } from "../views/camera.ts";

/** What all functions share. */
interface Memory {
  memory: WebAssembly.Memory;
  input(bytes: number): number;
  output_pointer(): number;
  output_bytes(): number;
}

const INVALID = -1;
const UNSUPPORTED = -2;

/** Thrown where the instance stopped, as after a panic: it can do nothing more. */
export class DecoderStopped extends Error {
  override name = "DecoderStopped";
}

/** An instance with these functions. */
export class Instance<Functions> {
  readonly #exports: Memory & Functions;
  #isStopped = false;

  constructor({ exports }: WebAssembly.Instance) {
    this.#exports = exports as unknown as Memory & Functions;
  }

  /** True if another instance must take its place. */
  get isStopped(): boolean {
    return this.#isStopped;
  }

  /** Bytes of its memory, which never become fewer. */
  get memoryBytes(): number {
    return this.#exports.memory.buffer.byteLength;
  }

  /** Writes the input of the next call, parts one behind the other. */
  write(...parts: readonly ArrayBufferView[]): void {
    const bytes = parts.reduce((sum, { byteLength }) => sum + byteLength, 0);
    let at = this.run(({ input }) => input(bytes)) >>> 0;
    for (const { buffer, byteOffset, byteLength } of parts) {
      new Uint8Array(this.#exports.memory.buffer, at, byteLength).set(new Uint8Array(buffer, byteOffset, byteLength));
      at += byteLength;
    }
  }

  /** The output of the last call: a view that is valid until the next one. */
  output(): Uint8Array {
    const [at, count] = this.run((exports) => [exports.output_pointer() >>> 0, exports.output_bytes() >>> 0]);
    return new Uint8Array(this.#exports.memory.buffer, at, count);
  }

  /** The output as words. */
  words(): Uint32Array {
    const bytes = this.output();
    return new Uint32Array(bytes.buffer, bytes.byteOffset, bytes.length / 4);
  }

  /** The output as text. */
  text(): string {
    return new TextDecoder().decode(this.output());
  }

  /** Runs a function that may answer an error, which is thrown. */
  call(run: (exports: Memory & Functions) => number): number {
    const result = this.run(run);
    if (result >= 0) {
      return result;
    }
    const text = this.text();
    const sentence = `${text.slice(0, 1).toUpperCase()}${text.slice(1)}.`;
    throw result === INVALID
      ? new FormatError(sentence)
      : result === UNSUPPORTED
        ? new UnsupportedError(sentence)
        : new Error(sentence);
  }

  run<T>(run: (exports: Memory & Functions) => T): T {
    if (this.#isStopped) {
      throw new DecoderStopped("The decoder has stopped.");
    }
    try {
      return run(this.#exports);
    } catch (error) {
      // A trap, or a stack that overflowed.
      this.#isStopped = true;
      throw new DecoderStopped(`The decoder has stopped: ${error instanceof Error ? error.message : String(error)}.`);
    }
  }
}

/** A camera as numbers of an input. */
export function cameraNumbers({ eye, axes, half }: Camera): number[] {
  return [...eye, ...axes.flat(), ...half];
}
