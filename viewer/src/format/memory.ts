// A file in memory.

import { type ByteSource, FormatError } from "./types.ts";

/** Bytes that are all here. */
export class MemorySource implements ByteSource {
  constructor(private readonly bytes: Uint8Array) {}

  get byteCount(): number {
    return this.bytes.length;
  }

  /** A part of the bytes, which is not copied. A range beyond them is a FormatError. */
  read(offset: number, count: number): Promise<Uint8Array> {
    if (offset < 0 || count < 0 || offset + count > this.bytes.length) {
      return Promise.reject(new FormatError(`The file ends before byte ${offset + count}.`));
    }
    return Promise.resolve(this.bytes.subarray(offset, offset + count));
  }
}
