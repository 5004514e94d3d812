// Chunks of depth, material and alpha of any codec, checked.

import { type AlphaHeader, type DepthHeader, FormatError, type MaterialHeader } from "../../format/types.ts";
import type { ChunkArea } from "../types.ts";
import { BoxChunk } from "./boxes.ts";
import { NodeChunk } from "./node_chunk.ts";
import { Grid, MAX_SIDE } from "./nodes.ts";
import { PredictiveChunk } from "./predictive.ts";
import { CODES, MATERIALS } from "./texel.ts";

/** Headers of streams whose chunks are a keyframe and changes. */
export type DepthLikeHeader = DepthHeader | MaterialHeader | AlphaHeader;

/** Checks a payload: all rules of formats/depth.md but for the window rule, and for predictive coding what can be told without decoding.
 *  What breaks a rule is a FormatError. */
export function parseChunk(
  header: DepthLikeHeader,
  payload: Uint8Array,
  area: ChunkArea,
): BoxChunk | NodeChunk | PredictiveChunk {
  const { frames } = area;
  const [, , width, height] = area.area.rect;
  if (header.kind === "material") {
    return new BoxChunk({ texel: MATERIALS, inBlocks: header.inBlocks }, payload, [width, height], frames);
  }
  const { coding } = header;
  if (coding.name === "predictive") {
    return new PredictiveChunk(payload, coding, area);
  }
  if (coding.name === "boxes") {
    return new BoxChunk({ texel: CODES, inBlocks: coding.inBlocks }, payload, [width, height], frames);
  }
  if (width < 1 || height < 1 || width > MAX_SIDE || height > MAX_SIDE) {
    throw new FormatError(`A tile has ${width}x${height} pixels where sides are 1 to ${MAX_SIDE} (depth.md 3).`);
  }
  const grid = new Grid(width, height);
  if (coding.name === "blocks") {
    return NodeChunk.ofBlocks(payload, grid, frames);
  }
  return coding.isTree
    ? NodeChunk.ofTree(payload, grid, frames, coding.domain)
    : NodeChunk.ofNodes(payload, grid, frames, coding.domain);
}
