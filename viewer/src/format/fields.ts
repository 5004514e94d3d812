// Little-endian fields of codec headers and payloads.

import { FormatError } from "./types.ts";

/** Reads fields one after the other, never beyond the end; a field that is missing or wrong is a FormatError. */
export class Fields {
  readonly bytes: Uint8Array;
  readonly #view: DataView;
  readonly #section: string;
  /** Offset of the next field. */
  at = 0;

  /** `section` of formats/ describes the bytes. */
  constructor(bytes: Uint8Array, section: string) {
    this.bytes = bytes;
    this.#view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
    this.#section = section;
  }

  get remaining(): number {
    return this.bytes.length - this.at;
  }

  /** An error at the next field; `problem` is a sentence without its full stop. */
  error(problem: string): FormatError {
    return new FormatError(`${problem}, at offset ${this.at} (${this.#section}).`);
  }

  /** Skips `count` bytes and answers where they start. */
  skip(count: number): number {
    const start = this.at;
    if (!(count <= this.remaining)) {
      throw this.error(`${count} more bytes were expected where ${this.remaining} are left`);
    }
    this.at += count;
    return start;
  }

  u8(): number {
    return this.bytes[this.skip(1)];
  }

  u16(): number {
    return this.#view.getUint16(this.skip(2), true);
  }

  u32(): number {
    return this.#view.getUint32(this.skip(4), true);
  }

  f32(): number {
    return this.#view.getFloat32(this.skip(4), true);
  }

  f64(): number {
    return this.#view.getFloat64(this.skip(8), true);
  }

  /** Reserved bytes, which are 0. */
  zeros(count: number): void {
    const start = this.skip(count);
    if (this.bytes.subarray(start, start + count).some((byte) => byte !== 0)) {
      throw this.error("A reserved byte is not 0");
    }
  }

  /** A number of 7 bits a byte, at most five bytes, in its shortest form (container.md 1). */
  varint(): number {
    let value = 0;
    for (let place = 0; place < 5; place += 1) {
      const byte = this.u8();
      value += (byte & 0x7f) * 2 ** (7 * place);
      if (byte === 0 && place > 0) {
        throw this.error("A number is not in its shortest form");
      }
      if (byte < 0x80) {
        return value;
      }
    }
    throw this.error("A number has more than five bytes");
  }

  /** All bytes must have been read. */
  finish(): void {
    if (this.remaining > 0) {
      throw this.error(`${this.remaining} bytes are left behind the last field`);
    }
  }
}
