// Decoders of depth, material and alpha, and their chunks in the form of the device (formats/depth.md).

import { FormatError } from "../../format/types.ts";
import type { ChunkArea, ChunkDecoder, Pixels, Prepared } from "../types.ts";
import { BoxChunk } from "./boxes.ts";
import { type DepthLikeHeader, parseChunk } from "./chunk.ts";
import { NodeChunk } from "./node_chunk.ts";
import { PredictiveChunk } from "./predictive.ts";
import { preparedBoxes, preparedNodes, preparedPredictive } from "./prepare.ts";
import { stepsOver } from "./record_table.ts";

export type { DepthLikeHeader } from "./chunk.ts";

/** Checks a chunk of a unit of `area`, and decodes its frames: one code of 16 bits a pixel of depth, three bytes of material, one byte of
 *  alpha (arithmetic.md 1). The picture is one array that is changed in place. A FormatError where the payload breaks a rule; of
 *  predictive coding also from `frame`, since only decoding tells whether a substream is whole. */
export function depthDecoder(header: DepthLikeHeader, payload: Uint8Array, area: ChunkArea): ChunkDecoder {
  const chunk = parseChunk(header, payload, area);
  if (chunk instanceof PredictiveChunk) {
    return new PredictiveDecoder(chunk, header.kind === "alpha");
  }
  const [, , width, height] = area.area.rect;
  if (chunk instanceof BoxChunk) {
    const picture = chunk.layout.texel.picture(width * height);
    const apply = (record: number): void => {
      chunk.apply(chunk.records[record], picture);
    };
    return new SteppingDecoder(picture, chunk.records, area.frames, windowOf(header), apply);
  }
  const picture = new Uint16Array(width * height);
  const apply = (record: number): void => {
    chunk.apply(chunk.frames[record], picture);
  };
  return new SteppingDecoder(picture, chunk.frames, area.frames, windowOf(header), apply);
}

/** Checks a chunk, and brings it into the form of the kernels of shaders/ (src/gpu/prepare.rs): predictive coding is decoded to boxes of
 *  the codes that each frame changes. An UnsupportedError where these take more than 128 MiB. */
export function prepareDepth(header: DepthLikeHeader, payload: Uint8Array, area: ChunkArea): Prepared {
  const chunk = parseChunk(header, payload, area);
  if (chunk instanceof PredictiveChunk) {
    return preparedPredictive(chunk, area.area.rect[2]);
  }
  return chunk instanceof NodeChunk ? preparedNodes(chunk) : preparedBoxes(chunk, area.area.rect);
}

/** Longest step in frames; 0 where any frame is complete in itself. */
function windowOf(header: DepthLikeHeader): number {
  if (header.kind === "material") {
    return header.window;
  }
  return header.coding.name === "boxes" || header.coding.name === "nodes" ? header.coding.window : 0;
}

function checkFrame(frame: number, frames: number): void {
  if (!Number.isInteger(frame) || frame < 0 || frame >= frames) {
    throw new RangeError(`frame ${frame} of a chunk of ${frames}`);
  }
}

/** Goes from frame to frame by applying records in steps of the window (depth.md 4). */
class SteppingDecoder implements ChunkDecoder {
  readonly #picture: Pixels;
  readonly #recordFrames: Uint32Array;
  readonly #frames: number;
  readonly #window: number;
  readonly #apply: (record: number) => void;
  #at: number | undefined;

  constructor(
    picture: Pixels,
    records: readonly { frame: number }[],
    frames: number,
    window: number,
    apply: (record: number) => void,
  ) {
    this.#picture = picture;
    this.#recordFrames = Uint32Array.from(records, (record) => record.frame);
    this.#frames = frames;
    this.#window = window;
    this.#apply = apply;
  }

  frame(frame: number): Pixels {
    checkFrame(frame, this.#frames);
    stepsOver(this.#recordFrames, this.#at, frame, this.#window).forEach(this.#apply);
    this.#at = frame;
    return this.#picture;
  }
}

/** Decodes all frames on the way (depth.md 15.1). */
class PredictiveDecoder implements ChunkDecoder {
  readonly #chunk: PredictiveChunk;
  /** Of alpha: the codes as bytes. */
  readonly #alpha: boolean;
  #bytes = new Uint8Array();
  #failed: FormatError | undefined;

  constructor(chunk: PredictiveChunk, isAlpha: boolean) {
    this.#chunk = chunk;
    this.#alpha = isAlpha;
  }

  frame(frame: number): Pixels {
    const chunk = this.#chunk;
    checkFrame(frame, chunk.frames);
    if (this.#failed !== undefined && frame >= chunk.next - 1) {
      throw this.#failed;
    }
    if (frame < chunk.next - 1) {
      chunk.restart();
      this.#failed = undefined;
    }
    try {
      while (chunk.next <= frame) {
        chunk.decodeNext();
      }
    } catch (error) {
      if (error instanceof FormatError) {
        this.#failed = error;
      }
      throw error;
    }
    return this.#alpha ? this.#asBytes(chunk.picture) : chunk.picture;
  }

  /** Codes above 255 are taken for 255 (depth.md 16). */
  #asBytes(codes: Uint16Array): Uint8Array {
    if (this.#bytes.length !== codes.length) {
      this.#bytes = new Uint8Array(codes.length);
    }
    for (let pixel = 0; pixel < codes.length; pixel += 1) {
      this.#bytes[pixel] = Math.min(codes[pixel], 255);
    }
    return this.#bytes;
  }
}
