// A checked chunk of a color cell in either coding: keyframes and weights, or a transform in space and time (formats/color.md 4 and 6.4).

import { type ColorHeader, FormatError } from "../../format/types.ts";
import type { ChunkArea } from "../types.ts";
import { type CellChunk, type CellFormat, parseCells } from "./cells.ts";
import { checkFrames, holdsCells } from "./transform/payload.ts";
import { TransformChunk } from "./transform/reconstruct.ts";

/** A chunk in one of the two codings. */
export type ColorChunk = { cells: CellChunk } | { transform: TransformChunk };

/** Checks a payload of a cell (formats/color.md 4 and 6.4). */
export function parseChunk(
  { coding, isHalf }: ColorHeader,
  payload: Uint8Array,
  { area, frames, place }: ChunkArea,
): ColorChunk {
  const [, , width, height] = area.rect;
  const format: CellFormat = { size: [width, height], isHalf };
  if (coding.name === "cells") {
    return { cells: parseCells(payload, { ...format, blocks: coding.blocks }, frames, place) };
  }
  checkFrames(frames);
  if (!holdsCells(payload)) {
    return { transform: new TransformChunk(payload, format, frames, coding.tables) };
  }
  const cells = parseCells(payload.subarray(1), format, frames, place);
  if (cells.closedByNext) {
    throw new FormatError("Keyframes in a chunk of the transform codec are closed by the next chunk (color.md 6.4).");
  }
  return { cells };
}
