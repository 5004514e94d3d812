// A chunk of a color cell as keyframes and weights (formats/color.md 4).

import { FormatError } from "../../format/types.ts";
import { blockImageBytes, type ColorBlocks, decodeBlockImage } from "../block/image.ts";
import { Fields } from "../fields.ts";
import type { ChunkPlace } from "../types.ts";
import { roomFor, type Samples } from "./samples.ts";

const SECTION = "color.md 4";
const CLOSED_BY_NEXT = 1;
const MAX_WEIGHTS = 2 ** 20;
/** Bit of a row, in codecs of blocks: the keyframe is stored as samples. */
const AS_SAMPLES = 0x80000000;

/** How the keyframes of a cell are stored. */
export interface CellFormat {
  /** Pixels. */
  size: [number, number];
  isHalf: boolean;
  /** The format of keyframes in blocks; none where all are samples. */
  blocks?: ColorBlocks;
}

/** A checked chunk. */
export interface CellChunk {
  format: CellFormat;
  payload: Uint8Array;
  /** Frames of the keyframes, ascending from 0. */
  keyframes: Uint32Array;
  /** Byte of the payload at which each keyframe starts. */
  starts: Uint32Array;
  /** 1 for each keyframe in blocks. */
  inBlocks: Uint8Array;
  /** Byte of the payload at which the weights start. */
  weightsAt: number;
  /** Weights of the first frames; those of later ones are 0. */
  weights: Uint8Array;
  /** The last keyframe's successor is the first one of the next chunk. */
  closedByNext: boolean;
}

/** Checks the payload of a chunk of `frames` frames (formats/color.md 4). One that is the last of its cell must not lead to a next one. */
export function parseCells(payload: Uint8Array, format: CellFormat, frames: number, place: ChunkPlace): CellChunk {
  const fields = new Fields(payload, SECTION);
  const count = fields.u16();
  const flags = fields.u8();
  fields.zeros(1);
  const weightCount = fields.u32();
  if (count === 0 || count > frames || flags > CLOSED_BY_NEXT || weightCount > Math.min(frames, MAX_WEIGHTS)) {
    throw fields.error(
      `${count} keyframes, ${weightCount} weights and flags ${flags} are impossible in ${frames} frames`,
    );
  }
  const { keyframes, inBlocks } = readRows(fields, format, count, frames);
  const weightsAt = fields.skip(weightCount);
  const weights = payload.subarray(weightsAt, weightsAt + weightCount);
  const last = keyframes[count - 1];
  const leadsOn = weights.subarray(last + 1).some((weight) => weight > 0);
  if (keyframes.some((frame) => weights[frame] > 0) || (leadsOn && flags === 0)) {
    throw fields.error("A weight stands where no two keyframes enclose it");
  }
  const starts = new Uint32Array(count);
  let end = fields.at;
  for (let keyframe = 0; keyframe < count; keyframe++) {
    starts[keyframe] = end;
    end += keyframeBytes(format, inBlocks[keyframe] === 1);
  }
  if (end !== payload.length) {
    throw fields.error(`${end - fields.at} bytes of keyframes were expected where ${fields.remaining} are left`);
  }
  if (place === "last" && leadsOn) {
    throw new FormatError(`The last chunk of a cell leads to a next one, and there is none (${SECTION}).`);
  }
  return { format, payload, keyframes, starts, inBlocks, weightsAt, weights, closedByNext: flags === CLOSED_BY_NEXT };
}

function readRows(
  fields: Fields,
  format: CellFormat,
  count: number,
  frames: number,
): Pick<CellChunk, "keyframes" | "inBlocks"> {
  const hasBlocks = format.blocks !== undefined;
  const keyframes = new Uint32Array(count);
  const inBlocks = new Uint8Array(count);
  for (let at = 0; at < count; at++) {
    const row = fields.u32();
    // Without blocks the bit belongs to the frame, and puts it out of range.
    const asSamples = !hasBlocks || row >= AS_SAMPLES;
    const frame = hasBlocks && row >= AS_SAMPLES ? row - AS_SAMPLES : row;
    if ((at === 0 ? frame !== 0 : frame <= keyframes[at - 1]) || frame >= frames) {
      throw fields.error(`Keyframe ${at} at frame ${frame} is out of order or out of range`);
    }
    keyframes[at] = frame;
    inBlocks[at] = asSamples ? 0 : 1;
  }
  return { keyframes, inBlocks };
}

function keyframeBytes({ size: [width, height], isHalf, blocks }: CellFormat, inBlocks: boolean): number {
  return inBlocks && blocks !== undefined
    ? blockImageBytes(blocks, width, height)
    : 3 * width * height * (isHalf ? 2 : 1);
}

/** The samples of a keyframe, where they must not be changed: they may lie in the payload. */
export function readKeyframe(chunk: CellChunk, keyframe: number): Samples {
  const { size, isHalf, blocks } = chunk.format;
  const inBlocks = chunk.inBlocks[keyframe] === 1;
  const start = chunk.starts[keyframe];
  const bytes = chunk.payload.subarray(start, start + keyframeBytes(chunk.format, inBlocks));
  if (inBlocks && blocks !== undefined) {
    const samples = roomFor(size[0] * size[1], isHalf);
    decodeBlockImage(blocks, bytes, size, samples);
    return samples;
  }
  if (!isHalf) {
    return bytes;
  }
  const samples = roomFor(size[0] * size[1], true);
  for (let at = 0; at < samples.length; at++) {
    samples[at] = bytes[2 * at] | (bytes[2 * at + 1] << 8);
  }
  return samples;
}
