// Color chunks in the form of the device (src/gpu/prepare.rs).

import type { ColorHeader } from "../../format/types.ts";
import { CONSTANTS, rowsOf, type RowValues } from "../../gpu/layout.ts";
import type { ChunkArea, Prepared, Timeline } from "../types.ts";
import type { CellChunk } from "./cells.ts";
import { parseChunk } from "./chunk.ts";
import { changedPixels } from "./timeline.ts";
import { regionRect } from "./transform/payload.ts";
import type { TransformChunk } from "./transform/reconstruct.ts";
import { SET_WORDS } from "./transform_tables.ts";

/** Checks a payload and brings it into the form of the device: of the transform codec the kernel of keyframes where the chunk holds such
 *  (src/gpu/prepare.rs). Nothing of the payload is shared. */
export function prepareColor(header: ColorHeader, payload: Uint8Array, area: ChunkArea): Prepared {
  const chunk = parseChunk(header, payload, area);
  if ("cells" in chunk) {
    return prepareCells(chunk.cells, header.coding.name === "transform" ? "keyframes" : "codec");
  }
  return prepareTransform(chunk.transform, payload, area.frames);
}

/** What the state of a substream of fewer than four bytes counts from (formats/entropy.md 3). */
const MIN_STATE = 2 ** 16;

/** A timeline without anything. Its arrays are of one chunk alone, as they may be transferred. */
function emptyTimeline(): Timeline {
  return {
    recordFrames: new Uint32Array(),
    recordPixels: new Uint32Array(),
    keyframes: new Uint32Array(),
    weights: new Uint8Array(),
    frameSets: new Uint32Array(),
    framePixels: new Uint32Array(),
  };
}

/** Bytes as little-endian words, the last filled up with zeros. */
function wordsOf(bytes: Uint8Array): Uint32Array<ArrayBuffer> {
  const words = new Uint32Array(Math.ceil(bytes.length / 4));
  new Uint8Array(words.buffer).set(bytes);
  return words;
}

function prepareCells(chunk: CellChunk, kernel: Prepared["kernel"]): Prepared {
  const { format, payload, keyframes, starts, inBlocks, weightsAt, weights } = chunk;
  const [width, height] = format.size;
  // Kernels of blocks take a block at a time.
  const work = format.blocks === undefined ? width * height : Math.ceil(width / 4) * Math.ceil(height / 4);
  const { KEYFRAME_BLOCKS, KEYFRAME_SAMPLES } = CONSTANTS;
  const rows = Array.from(keyframes, (frame, at): RowValues => {
    return { frame, at: starts[at], coding: inBlocks[at] === 1 ? KEYFRAME_BLOCKS : KEYFRAME_SAMPLES, work };
  });
  return {
    kernel,
    isNodes: false,
    stream: wordsOf(payload),
    records: rowsOf("Record", rows),
    boxes: new Uint32Array(),
    weights: [weightsAt, weights.length],
    passes: 0,
    timeline: { ...emptyTimeline(), keyframes, weights: weights.slice() },
  };
}

/** Header, then the substream of each region in whole words. Each frame that differs from the one before has a record, with all
 *  regions. */
function prepareTransform(chunk: TransformChunk, payload: Uint8Array, frames: number): Prepared {
  const { substreams } = chunk.layout;
  const parts = [headerWords(chunk, frames)];
  let words = parts[0].length;
  const boxes: RowValues[] = [];
  for (let region = 0; region + 1 < substreams.length; region++) {
    const [x, y, width, height] = regionRect(chunk.format.size, region);
    boxes.push({ x, y, width, height, at: 4 * words, end: region + 1 });
    const bytes = payload.subarray(substreams[region], substreams[region + 1]);
    const [short = 0] = bytes.length < 4 ? wordsOf(bytes) : [];
    const part = bytes.length < 4 ? Uint32Array.of(MIN_STATE + short) : wordsOf(bytes);
    const steps = Uint32Array.from(chunk.layout.indices.subarray(3 * region, 3 * region + 3));
    parts.push(steps, part);
    words += steps.length + part.length;
  }
  const stream = new Uint32Array(words);
  let at = 0;
  for (const part of parts) {
    stream.set(part, at);
    at += part.length;
  }
  const timeline = timelineOf(chunk, frames);
  const [count, work] = [boxes.length, boxes.length];
  const records = Array.from(timeline.keyframes, (frame): RowValues => ({ frame, count, work }));
  return {
    kernel: "codec",
    isNodes: false,
    stream,
    records: rowsOf("Record", records),
    boxes: rowsOf("BoxRow", boxes),
    weights: [0, 0],
    passes: chunk.passes,
    timeline,
  };
}

function timelineOf(chunk: TransformChunk, frames: number): Timeline {
  const sets = [...chunk.pixelsOfFrames()].sort(([one], [other]) => (one < other ? -1 : 1));
  const frameSets = Uint32Array.from(
    sets.flatMap(([set]) => [0n, 32n, 64n, 96n].map((shift) => Number((set >> shift) & 0xffff_ffffn))),
  );
  const timeline = { ...emptyTimeline(), frameSets, framePixels: Uint32Array.from(sets, ([, pixels]) => pixels) };
  const differs = (frame: number) => changedPixels(timeline, frame, frame === 0 ? undefined : frame - 1, 1) > 0;
  return { ...timeline, keyframes: Uint32Array.from(Array.from({ length: frames }, (_, at) => at).filter(differs)) };
}

/** Words of a chunk before its regions, as the kernels read them: `shaders/color/transform/chunk.wgsl`. */
function headerWords({ layout }: TransformChunk, frames: number): Uint32Array<ArrayBuffer> {
  const { set, slopes, colors, offsetSet } = layout;
  const words = [set * SET_WORDS, slopes.green, slopes.orange, colors.length / 3, frames, offsetSet];
  for (let at = 0; at < colors.length; at += 3) {
    words.push(colors[at] | (colors[at + 1] << 16), colors[at + 2]);
  }
  return new Uint32Array(Int32Array.from(words).buffer);
}
