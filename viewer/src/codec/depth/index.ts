// Decoders of depth, material and alpha, and their chunks in the form of the device (formats/depth.md).

import { FormatError } from "../../format/types.ts";
import type { ChunkArea, ChunkDecoder, Pixels, Prepared } from "../types.ts";
import { BoxChunk } from "./boxes.ts";
import { type DepthLikeHeader, parseChunk } from "./chunk.ts";
import { CodingMap, paintBoxes, paintNodes, paintPredictive } from "./coding_map.ts";
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
  const [, , width, height] = area.area.rect;
  if (chunk instanceof PredictiveChunk) {
    const bytes = header.kind === "alpha" ? new Uint8Array(width * height) : undefined;
    return new PredictiveDecoder(chunk, () => (bytes === undefined ? chunk.picture : asBytes(chunk.picture, bytes)));
  }
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

/** Checks a chunk like {@link depthDecoder}, and answers how each pixel of its frames is coded in place of their codes: maps as of
 *  coding_map.ts, which do not depend on the order in which they are asked for. */
export function depthCodings(header: DepthLikeHeader, payload: Uint8Array, area: ChunkArea): ChunkDecoder {
  const chunk = parseChunk(header, payload, area);
  const [, , width, height] = area.area.rect;
  const map = new CodingMap(width, height);
  if (chunk instanceof PredictiveChunk) {
    const show = (): Uint8Array => map.at(chunk.next - 1);
    return new PredictiveDecoder(chunk, show, () => paintPredictive(map, chunk));
  }
  // Each record on the way counts, also where a decoder may leave some out.
  const window = Math.min(windowOf(header), 1);
  const [records, paint] =
    chunk instanceof BoxChunk
      ? [chunk.records, (record: number) => paintBoxes(map, chunk, chunk.records[record])]
      : [chunk.frames, (record: number) => paintNodes(map, chunk, chunk.frames[record], window === 0)];
  const steps = new SteppingDecoder(map.bytes, records, area.frames, window, paint);
  return {
    frame: (frame) => {
      steps.frame(frame);
      return map.at(frame);
    },
  };
}

/** Checks a chunk, and brings it into the form of the kernels of shaders/ (src/gpu/prepare.rs): predictive coding is decoded to boxes of
 *  the codes that each frame changes. An UnsupportedError where these take more than 128 MiB. */
export function prepareDepth(header: DepthLikeHeader, payload: Uint8Array, area: ChunkArea): Prepared {
  const chunk = parseChunk(header, payload, area);
  if (chunk instanceof PredictiveChunk) {
    return preparedPredictive(chunk, area.area.rect[2]);
  }
  return chunk instanceof NodeChunk ? preparedNodes(chunk) : preparedBoxes(chunk);
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
  readonly #show: () => Pixels;
  readonly #onFrame: () => void;
  #failed: FormatError | undefined;

  /** `show` answers the picture of the frame decoded last; `onFrame` is called for each one on the way. */
  constructor(chunk: PredictiveChunk, show: () => Pixels, onFrame: () => void = () => undefined) {
    this.#chunk = chunk;
    this.#show = show;
    this.#onFrame = onFrame;
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
        this.#onFrame();
      }
    } catch (error) {
      if (error instanceof FormatError) {
        this.#failed = error;
      }
      throw error;
    }
    return this.#show();
  }
}

/** Codes above 255 are taken for 255 (depth.md 16). */
function asBytes(codes: Uint16Array, bytes: Uint8Array): Uint8Array {
  for (let pixel = 0; pixel < codes.length; pixel += 1) {
    bytes[pixel] = Math.min(codes[pixel], 255);
  }
  return bytes;
}
