// Fields of a container and its index (formats/container.md 1), with errors that name their place in the file.

import { Fields } from "./fields.ts";
import { FormatError } from "./types.ts";

const CONTROL = /[\u0000-\u001f\u007f-\u009f]/u;

/** Reads fields of a file one after the other, never beyond the end; a field that is missing or wrong is a FormatError. */
export class FileFields extends Fields {
  /** The section of formats/ that describes the next fields. */
  section: string;
  readonly #base: number;
  readonly #numbers: DataView;

  /** `base` is the offset of `bytes` in the file. */
  constructor(bytes: Uint8Array, section: string, base: number) {
    super(bytes, section);
    this.section = section;
    this.#base = base;
    this.#numbers = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  }

  /** An error at the next field, or at that of another offset in the bytes; `problem` is a sentence without its full stop. */
  override error(problem: string, at = this.at): FormatError {
    return new FormatError(`${problem}, at byte ${this.#base + at} (${this.section}).`);
  }

  /** The next `count` bytes, which are not copied. */
  take(count: number): Uint8Array {
    const start = this.skip(count);
    return this.bytes.subarray(start, start + count);
  }

  /** A 64-bit number; one of 2^53 or more, which no size or offset of a file can be, is an error that calls it `what`. */
  u64(what: string): number {
    const start = this.skip(8);
    const value = this.#numbers.getUint32(start, true) + this.#numbers.getUint32(start + 4, true) * 2 ** 32;
    if (!Number.isSafeInteger(value)) {
      throw this.error(`${what} is larger than any file`, start);
    }
    return value;
  }

  /** So many finite 64-bit floats, which errors call `what`. */
  finites(count: number, what: string): number[] {
    return Array.from({ length: count }, () => {
      const start = this.at;
      const value = this.f64();
      if (!Number.isFinite(value)) {
        throw this.error(`${what} is ${value}, where a finite number was expected`, start);
      }
      return value;
    });
  }

  /** A number of at most 32 bits (container.md 1). */
  varint32(): number {
    const start = this.at;
    const value = this.varint();
    if (value >= 2 ** 32) {
      throw this.error(`${value} is more than 32 bits hold`, start);
    }
    return value;
  }

  /** Text with its length before it, in UTF-8, which errors call `what`. */
  string(what: string): string {
    const bytes = this.take(this.u16());
    try {
      return new TextDecoder("utf-8", { fatal: true, ignoreBOM: true }).decode(bytes);
    } catch {
      throw this.error(`${what} is not UTF-8`, this.at - bytes.length);
    }
  }

  /** Refuses a table of `count` rows of at least `least` bytes that does not fit what is left, before memory is reserved for it. */
  fits(count: number, what: string, least: number): void {
    if (count * least > this.remaining) {
      throw this.error(`${count} ${what} do not fit into the rest of the index`);
    }
  }
}

/** Whether a text holds a control character: Unicode category Cc. */
export function hasControls(text: string): boolean {
  return CONTROL.test(text);
}

/** A text of a file for a message: in quotes, cut, with all but visible ASCII characters as numbers. */
export function quoted(text: string): string {
  const most = 40;
  const letters = Array.from(text.slice(0, 2 * most)).slice(0, most);
  const plain = letters.map((letter) =>
    /^[ -~]$/u.test(letter) ? letter : `\\u{${(letter.codePointAt(0) ?? 0).toString(16)}}`,
  );
  return `"${plain.join("")}${letters.join("").length < text.length ? "..." : ""}"`;
}
