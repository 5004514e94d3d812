// Limits on files that claim more than their size justifies (formats/container.md 2, "What a reader spends").

import { type IndexTables, type StreamRow, unitCountOf, unitRectOf } from "./index_tables.ts";
import { type Chunk, type CodecHeader, UnsupportedError } from "./types.ts";

/** Decoding one stream may take so much, or so many times the file's size, whichever is more. */
const STREAM_BYTES = 2 ** 30;
const STREAM_RATIO = 1024;
/** All streams together may take so many times what one may. */
const ALL_STREAMS = 4;
/** Units in frames, and so many more for each byte of the file. */
const UNIT_FRAMES = 2 ** 26;
const UNIT_FRAMES_RATIO = 1024;
/** Pixels of all images, and so many more for each byte of the file. */
const PIXELS = 2 ** 38;
const PIXELS_RATIO = 2 ** 20;
/** Largest index. */
export const MAX_INDEX_BYTES = 2 ** 26;
/** All different codec headers together, whose tables take up to some ten times their bytes. */
export const MAX_HEADER_BYTES = 2 ** 24;

// What decoding holds, in bytes.
const UNIT_BYTES = 4096;
const REGION_SIDE = 32;
const MIN_SIDE = 4;
const MAX_KEYFRAME_TABLE = 4 * 2 ** 20;

/** Refuses streams that take more memory or time to decode than a file of `fileBytes` justifies: an UnsupportedError. `headers` are those
 *  of the streams, in their order. */
export function checkLimits(index: IndexTables, headers: readonly CodecHeader[], fileBytes: number): void {
  const mostOfStream = Math.max(STREAM_BYTES, STREAM_RATIO * fileBytes);
  let [total, unitFrames, pixels] = [0, 0, 0];
  index.streams.forEach((stream, at) => {
    const bytes = streamBytes(index, at, headers[at]);
    if (bytes > mostOfStream) {
      throw new UnsupportedError(
        `Stream ${at} of ${stream.width}x${stream.height} pixels would take ${bytes} bytes to decode, more than a file of ` +
          `${fileBytes} bytes justifies (container.md 2).`,
      );
    }
    total += bytes;
    unitFrames += unitCountOf(stream) * stream.frameCount;
    pixels += stream.width * stream.height * stream.frameCount;
  });
  if (total > ALL_STREAMS * mostOfStream) {
    throw new UnsupportedError(
      `The streams would take ${total} bytes to decode, more than a file of ${fileBytes} bytes justifies (container.md 2).`,
    );
  }
  if (unitFrames > UNIT_FRAMES + UNIT_FRAMES_RATIO * fileBytes || pixels > PIXELS + PIXELS_RATIO * fileBytes) {
    throw new UnsupportedError(
      `The streams have ${unitFrames} units and ${pixels} pixels in all their frames, more than a file of ${fileBytes} bytes ` +
        "justifies (container.md 2).",
    );
  }
}

/** Bytes for decoding the images of a stream one after the other. */
function streamBytes({ streams, chunks, units }: IndexTables, at: number, header: CodecHeader): number {
  const stream = streams[at];
  let bytes = stream.width * stream.height * pixelBytes(header) + unitCountOf(stream) * UNIT_BYTES;
  for (let unit = units.firstUnits[at]; unit < units.firstUnits[at + 1]; unit += 1) {
    let most = 0;
    for (let row = units.firstChunks[unit]; row < units.firstChunks[unit + 1]; row += 1) {
      most = Math.max(most, chunkBytes(stream, chunks[row], header));
    }
    bytes += most;
  }
  return bytes;
}

/** For each pixel: the pictures of units, keyframes, and the image that is made of them. */
function pixelBytes(header: CodecHeader): number {
  switch (header.kind) {
    case "depth":
      return header.coding.name === "predictive" ? 32 : 4;
    case "material":
      return 6;
    case "alpha":
      return 32;
    case "color":
      return header.isHalf ? 30 : 12;
  }
}

/** For a payload and what it is parsed to. */
function chunkBytes(stream: StreamRow, { unit, frameCount, rawBytes }: Chunk, header: CodecHeader): number {
  if (header.kind === "depth" && header.coding.name === "nodes") {
    return 64 * rawBytes;
  }
  if (header.kind !== "color") {
    return 10 * rawBytes;
  }
  const keyframes = 4 * rawBytes + Math.min(8 * rawBytes, MAX_KEYFRAME_TABLE);
  if (header.coding.name === "cells") {
    return keyframes;
  }
  const [, , width, height] = unitRectOf(stream, unit);
  const [regions, rootPixels] = regionsOf(width, height);
  const pixels = rootPixels * frameCount;
  const parsed = Math.min(832 * rawBytes + 5632 * regions, 72 * pixels);
  return Math.max(keyframes, parsed + rawBytes + 640 * regions + pixels);
}

/** Regions of a cell, and pixels of their roots (color.md 6.4). */
function regionsOf(width: number, height: number): [number, number] {
  const parts = (side: number): [number, number][] => [
    [Math.floor(side / REGION_SIDE), REGION_SIDE],
    [side % REGION_SIDE > 0 ? 1 : 0, side % REGION_SIDE],
  ];
  let [regions, pixels] = [0, 0];
  for (const [columns, right] of parts(width)) {
    for (const [rows, bottom] of parts(height)) {
      let side = MIN_SIDE;
      while (side < Math.max(right, bottom)) {
        side *= 2;
      }
      regions += columns * rows;
      pixels += columns * rows * side * side;
    }
  }
  return [regions, pixels];
}
