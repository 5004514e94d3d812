// Shows frames of a color chunk by the processor (formats/color.md 4 and 6).

import { type ColorHeader, FormatError } from "../../format/types.ts";
import type { ChunkArea, ChunkDecoder, Pixels } from "../types.ts";
import { type CellChunk, parseCells, readKeyframe } from "./cells.ts";
import { parseChunk } from "./chunk.ts";
import { blendInto, roomFor, type Samples } from "./samples.ts";
import { blendOf } from "./timeline.ts";
import type { TransformChunk } from "./transform/reconstruct.ts";

/** More frames than a chunk can have: what is known of a next chunk is its payload alone. */
const ANY_FRAMES = 2 ** 31;

/** A decoder of a chunk's frames, whose payload is checked here. The pictures are red, green and blue of each pixel: bytes, or bit
 *  patterns of half floats (formats/color.md 1). Where a frame blends into the next chunk, all of that chunk's payload is checked but
 *  that its frames are as many as the chunk table says. */
export function colorDecoder(header: ColorHeader, payload: Uint8Array, area: ChunkArea): ChunkDecoder {
  const chunk = parseChunk(header, payload, area);
  return "cells" in chunk ? new CellDecoder(chunk.cells) : new TransformDecoder(chunk.transform);
}

class CellDecoder implements ChunkDecoder {
  readonly #chunk: CellChunk;
  /** The two keyframes that were read last, by their number; the next chunk's first is behind the last one. */
  readonly #keyframes = new Map<number, Samples>();
  #shown: { picture: Samples; keyframe: number; weight: number } | undefined;

  constructor(chunk: CellChunk) {
    this.#chunk = chunk;
  }

  frame(frame: number, next?: () => Uint8Array): Pixels {
    const { keyframe, weight } = blendOf(this.#chunk, frame);
    if (this.#shown?.keyframe === keyframe && this.#shown.weight === weight) {
      return this.#shown.picture;
    }
    const { size, isHalf } = this.#chunk.format;
    const first = this.#keyframe(keyframe, next);
    const second = weight > 0 ? this.#keyframe(keyframe + 1, next) : first;
    const picture = this.#shown?.picture ?? roomFor(size[0] * size[1], isHalf);
    if (weight > 0) {
      blendInto(picture, first, second, weight);
    } else {
      picture.set(first);
    }
    this.#shown = { picture, keyframe, weight };
    return picture;
  }

  #keyframe(keyframe: number, next?: () => Uint8Array): Samples {
    const held = this.#keyframes.get(keyframe);
    if (held !== undefined) {
      return held;
    }
    const { format, keyframes } = this.#chunk;
    let samples: Samples;
    if (keyframe < keyframes.length) {
      samples = readKeyframe(this.#chunk, keyframe);
    } else if (next !== undefined) {
      samples = readKeyframe(parseCells(next(), format, ANY_FRAMES, "inner"), 0);
    } else {
      throw new FormatError("A frame blends into the next chunk of its cell, which is not there (color.md 4).");
    }
    const [oldest] = this.#keyframes.keys();
    if (this.#keyframes.size > 1) {
      this.#keyframes.delete(oldest);
    }
    this.#keyframes.set(keyframe, samples);
    return samples;
  }
}

class TransformDecoder implements ChunkDecoder {
  readonly #chunk: TransformChunk;
  readonly #picture: Samples;
  #shown: number | undefined;

  constructor(chunk: TransformChunk) {
    this.#chunk = chunk;
    const { size, isHalf } = chunk.format;
    this.#picture = roomFor(size[0] * size[1], isHalf);
  }

  frame(frame: number): Pixels {
    this.#chunk.show(frame, this.#shown, this.#picture);
    this.#shown = frame;
    return this.#picture;
  }
}
