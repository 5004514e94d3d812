// The decoder of the program as WebAssembly: what its functions take and give (src/wasm/exports.rs).

import type { CodecHeader, DepthRange, Probe, Rect, Storage } from "../format/types.ts";
import { FormatError } from "../format/types.ts";
import type { Camera } from "../views/camera.ts";
import { TONE_MAP_NUMBERS } from "../views/presentation.ts";
import { cameraNumbers, Instance } from "./instance.ts";
import type { HeaderStream, Pixels, Prepared, Presentation, Steps, StoredChunk, UnitPixels } from "./types.ts";

/** Functions of src/wasm/exports.rs. */
interface Functions {
  crc32(): number;
  decompress(method: number, rawBytes: number): number;
  open_stream(...numbers: HeaderNumbers): number;
  close_stream(stream: number): void;
  open_chunk(stream: number, ...numbers: ChunkNumbers): number;
  open_codings(stream: number, ...numbers: ChunkNumbers): number;
  set_next(chunk: number, frames: number, isLast: number, method: number, rawBytes: number): number;
  show_frame(chunk: number, frame: number): number;
  close_chunk(chunk: number): void;
  prepare(stream: number, ...numbers: ChunkNumbers): number;
  transform_tables(): number;
  log2_table(): void;
  inverse_depths(nearM: number, farM: number): number;
  visible_units(face: number, width: number, height: number, unitWidth: number, unitHeight: number): number;
  straight_texels(): number;
  ray_steps(count: number, nearM: number, farM: number, refine: number): void;
  present_pictures(tone: number, marksHoles: number, isAnaglyph: number): number;
}

type HeaderNumbers = [kind: number, face: number, width: number, height: number, unitWidth: number, unitHeight: number];
type ChunkNumbers = [unit: number, frames: number, isLast: number, method: number, rawBytes: number];

/** In the order of their numbers (container.md 5 and 6). */
const KINDS = ["color", "depth", "material", "alpha"] as const;
const STORAGES: readonly Storage[] = ["raw", "lzma2", "zstd"];

/** Result of `show_frame`. */
const NEEDS_NEXT = 1;
/** Numbers before the arrays of a prepared chunk, and arrays. */
const PREPARED_NUMBERS = 5;
const PREPARED_ARRAYS = 9;

/** Thrown where a frame blends into the unit's next chunk, which is not there. */
export class NextIsMissing extends Error {
  override name = "NextIsMissing";
}

/** A stream whose codec header is legal. */
export interface DecoderStream {
  number: number;
  header: CodecHeader;
}

/** The frames of a chunk; {@link ChunkDecoder.close} frees its memory. */
export interface ChunkDecoder {
  /** The picture of a frame, counted from the chunk's first: a view that is valid until the next call of any decoder. `next` is the unit's
   *  next chunk, for a frame that blends into it. */
  frame(frame: number, next?: () => StoredChunk | undefined): Pixels;
  close(): void;
}

/** An instance. */
export class Decoder {
  readonly #wasm: Instance<Functions>;

  constructor(instance: WebAssembly.Instance) {
    this.#wasm = new Instance(instance);
  }

  /** True if another instance must take its place. */
  get isStopped(): boolean {
    return this.#wasm.isStopped;
  }

  /** Bytes of its memory, which never become fewer. */
  get memoryBytes(): number {
    return this.#wasm.memoryBytes;
  }

  /** The CRC-32 of bytes, 0 to 2^32 - 1. */
  crc32(bytes: Uint8Array): number {
    this.#wasm.write(bytes);
    return this.#wasm.run((wasm) => wasm.crc32()) >>> 0;
  }

  /** The bytes that stored ones mean, `rawBytes` of them; a FormatError where they are damaged. */
  decompress(storage: Storage, stored: Uint8Array, rawBytes: number): Uint8Array {
    this.#wasm.write(stored);
    this.#wasm.call((wasm) => wasm.decompress(STORAGES.indexOf(storage), rawBytes));
    return this.#wasm.output().slice();
  }

  /** Reads a codec header: a FormatError where it breaks a rule, an UnsupportedError where the codec is unknown, or of another kind of
   *  stream. */
  openStream(stream: HeaderStream, headerBytes: Uint8Array): DecoderStream {
    const { kind, codec, face, width, height, unitWidth, unitHeight } = stream;
    const bytes = new Uint8Array(codec.length + headerBytes.length);
    bytes.set(Array.from(codec, (letter) => letter.charCodeAt(0)));
    bytes.set(headerBytes, codec.length);
    this.#wasm.write(bytes);
    const numbers: HeaderNumbers = [KINDS.indexOf(kind), face, width, height, unitWidth, unitHeight];
    const number = this.#wasm.call((wasm) => wasm.open_stream(...numbers));
    return { number, header: JSON.parse(this.#wasm.text()) as CodecHeader };
  }

  closeStream({ number }: DecoderStream): void {
    this.#wasm.run((wasm) => wasm.close_stream(number));
  }

  /** A decoder of a chunk, whose payload is checked: a FormatError where it breaks a rule. Errors that show only when a frame is decoded
   *  are FormatErrors of `frame`. */
  openChunk({ number, header }: DecoderStream, chunk: StoredChunk): ChunkDecoder {
    const numbers = this.#writeChunk(chunk);
    const opened = this.#wasm.call((wasm) => wasm.open_chunk(number, ...numbers));
    return this.#decoderOf(opened, header.kind === "depth" || (header.kind === "color" && header.isHalf));
  }

  /** How each pixel of a chunk's frames is coded (player/coding_colors.ts), in place of their pictures; errors are as of
   *  {@link Decoder.openChunk}. An UnsupportedError for colors, of which there are no such maps. */
  openCodings({ number }: DecoderStream, chunk: StoredChunk): ChunkDecoder {
    const numbers = this.#writeChunk(chunk);
    return this.#decoderOf(
      this.#wasm.call((wasm) => wasm.open_codings(number, ...numbers)),
      false,
    );
  }

  /** A checked chunk in the form of the device: a FormatError where it breaks a rule, an UnsupportedError where it would take more than
   *  128 MiB. */
  prepare({ number }: DecoderStream, chunk: StoredChunk): Prepared {
    const numbers = this.#writeChunk(chunk);
    this.#wasm.call((wasm) => wasm.prepare(number, ...numbers));
    const words = this.#wasm.words();
    const [isKeyframes, isNodes, weightsAt, weightCount, passes] = words;
    let at = PREPARED_NUMBERS + PREPARED_ARRAYS;
    const arrays = Array.from(words.subarray(PREPARED_NUMBERS, at), (length) => words.slice(at, (at += length)));
    const [stream, records, boxes, recordFrames, recordPixels, keyframes, weights, frameSets, framePixels] = arrays;
    return {
      kernel: isKeyframes === 1 ? "keyframes" : "codec",
      isNodes: isNodes === 1,
      stream,
      records,
      boxes,
      weights: [weightsAt, weightCount],
      passes,
      timeline: { recordFrames, recordPixels, keyframes, weights, frameSets, framePixels },
    };
  }

  /** The tables of streams of the transform codec in one buffer, and the first word of the table sets of each stream. */
  transformTables(streams: readonly DecoderStream[]): { words: Uint32Array; firstSets: number[] } {
    const numbers = Uint32Array.from(streams, ({ number }) => number);
    this.#wasm.write(numbers);
    this.#wasm.call((wasm) => wasm.transform_tables());
    const words = this.#wasm.words();
    return { words: words.slice(streams.length), firstSets: [...words.subarray(0, streams.length)] };
  }

  /** log2(1 + i/256) with 24 fraction bits, i = 0 to 256 (arithmetic.md 7). */
  log2Table(): Uint32Array {
    this.#wasm.run((wasm) => wasm.log2_table());
    return this.#wasm.words().slice();
  }

  /** The inverse depths of all codes in 1/m, as bits of floats; that of the background is 0. */
  inverseDepths({ nearM, farM }: DepthRange): Uint32Array {
    this.#wasm.call((wasm) => wasm.inverse_depths(nearM, farM));
    return this.#wasm.words().slice();
  }

  /** 1 for each unit of an image that a camera may see, by its number: of an image without known directions all. `nearM` is the least
   *  distance of a surface of the probe. */
  visibleUnits(image: HeaderStream, probe: Probe, nearM: number, cameras: readonly Camera[]): Uint8Array {
    const { face, width, height, unitWidth, unitHeight } = image;
    const { position, orientation, intrinsics } = probe;
    this.#wasm.write(
      Float64Array.of(...position, ...orientation, ...intrinsics, nearM, ...cameras.flatMap(cameraNumbers)),
    );
    this.#wasm.call((wasm) => wasm.visible_units(face, width, height, unitWidth, unitHeight));
    return this.#wasm.output().slice();
  }

  /** Straight colors and alpha of a rectangle, four components of each texel: bytes, or those of halves of light. `coding` is its number
   *  of `open_field` (src/wasm/exports.rs). */
  straightTexels(coding: number, color: UnitPixels, rect: Rect, alpha?: UnitPixels): Uint8Array<ArrayBuffer> {
    const numbers = Float64Array.of(coding, ...rect, ...color.rect, ...(alpha?.rect ?? [0, 0, 0, 0]));
    this.#wasm.write(numbers, color.pixels, ...(alpha === undefined ? [] : [alpha.pixels]));
    this.#wasm.call((wasm) => wasm.straight_texels());
    return this.#wasm.output().slice();
  }

  /** `count` steps, at least 1, between `nearM` and `farM`, both above 0; where far is not beyond near, near alone. */
  raySteps(count: number, nearM: number, farM: number, refine: number): Steps {
    this.#wasm.run((wasm) => wasm.ray_steps(count, nearM, farM, refine));
    const numbers = new Float32Array(this.#wasm.words().slice().buffer);
    return { logStep: numbers[0], uncertainty: numbers[1], distancesM: numbers.slice(2) };
  }

  /** Red, green, blue and alpha of pictures for a canvas, one behind the other: of one eye, or the left and the right one, and an overlay
   *  over each unless its share is 0. All have as many pixels. */
  presentPictures(pictures: readonly Float32Array[], how: Presentation): Uint8ClampedArray<ArrayBuffer> {
    const { exposureEv, overlayShare, toneMap, marksHoles, isAnaglyph } = how;
    this.#wasm.write(Float64Array.of(exposureEv, overlayShare, pictures[0].length / 4), ...pictures);
    const tone = TONE_MAP_NUMBERS[toneMap];
    this.#wasm.call((wasm) => wasm.present_pictures(tone, Number(marksHoles), Number(isAnaglyph)));
    return new Uint8ClampedArray(this.#wasm.output());
  }

  #decoderOf(chunk: number, isWide: boolean): ChunkDecoder {
    return {
      frame: (frame, next) => {
        if (this.#wasm.call((wasm) => wasm.show_frame(chunk, frame)) === NEEDS_NEXT) {
          this.#setNext(chunk, next?.());
          this.#wasm.call((wasm) => wasm.show_frame(chunk, frame));
        }
        const bytes = this.#wasm.output();
        return isWide ? new Uint16Array(bytes.buffer, bytes.byteOffset, bytes.length / 2) : bytes;
      },
      close: () => this.#wasm.run((wasm) => wasm.close_chunk(chunk)),
    };
  }

  #setNext(chunk: number, next: StoredChunk | undefined): void {
    if (next === undefined) {
      throw new NextIsMissing("A frame blends into the next chunk of its cell, which is not there (color.md 4).");
    }
    const [, ...numbers] = this.#writeChunk(next);
    this.#wasm.call((wasm) => wasm.set_next(chunk, ...numbers));
  }

  /** Checks stored bytes (container.md 6), and makes them the input. */
  #writeChunk({ chunk, stored, area }: StoredChunk): ChunkNumbers {
    if (stored.length !== chunk.storedBytes || this.crc32(stored) !== chunk.crc32) {
      const last = chunk.firstFrame + chunk.frameCount - 1;
      throw new FormatError(
        `The CRC-32 of stream ${chunk.stream}, unit ${chunk.unit}, frames ${chunk.firstFrame} to ${last} does not match: the file is ` +
          `damaged at byte ${chunk.offset} (container.md 6).`,
      );
    }
    const isLast = area.place === "last" ? 1 : 0;
    return [chunk.unit, chunk.frameCount, isLast, STORAGES.indexOf(chunk.storage), chunk.rawBytes];
  }
}
