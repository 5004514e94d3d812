// Codec headers of depth, material and alpha (formats/depth.md 3 and 16).

import {
  type AlphaHeader,
  type DepthDomain,
  type DepthHeader,
  type MaterialHeader,
  type PredictiveCoding,
  UnsupportedError,
} from "../../format/types.ts";
import { builtInTables, readTables } from "../entropy.ts";
import { Fields } from "../fields.ts";
import { DOMAIN_INVERSE, DOMAIN_LOG, FAR_CODE, MAX_LOG } from "./domain.ts";
import type { Projection } from "./projection.ts";

/** What the stream table says of a stream besides its codec and header: pixels of its images and of its units. */
export interface StreamShape {
  face: number;
  width: number;
  height: number;
  unitWidth: number;
  unitHeight: number;
}

const DEPTH = "depth.md 3";
const MAX_SIDE = 1024;
const MAX_WINDOW = 255;
const MAX_BOXES = 256;
const MAX_LEVELS = 4096;
const MIN_OCTAVE = 512;
const MAX_OCTAVE = 131071;

/** Reads the header of a stream of depth (depth.md 3); `codec` is DAAB, DAB5, DQPN, DQTR, DB4W or DPRD, others are unsupported. */
export function parseDepthHeader(codec: string, bytes: Uint8Array, stream: StreamShape): DepthHeader {
  if (!["DAAB", "DAB5", "DQPN", "DQTR", "DB4W", "DPRD"].includes(codec)) {
    throw unknown("depth", codec);
  }
  const fields = new Fields(bytes, DEPTH);
  const [nearM, farM, background, measure] = [fields.f32(), fields.f32(), fields.f32(), fields.u32()];
  if (!(nearM > 0 && nearM <= farM && Number.isFinite(farM))) {
    throw fields.error(`Depths from ${nearM} m to ${farM} m are no range`);
  }
  if (Number.isNaN(background)) {
    throw fields.error("The background value is not a number");
  }
  if (measure > 1) {
    throw fields.error(`Depth has measure ${measure}, which is unknown`);
  }
  const coding = readCoding(codec, fields, stream);
  fields.finish();
  return { kind: "depth", range: { nearM, farM }, background, isDistance: measure === 0, coding };
}

function readCoding(codec: string, fields: Fields, stream: StreamShape): DepthHeader["coding"] {
  if (codec === "DAAB" || codec === "DAB5") {
    const inBlocks = codec === "DAB5";
    checkBlocks(inBlocks, fields, stream);
    return { name: "boxes", inBlocks, ...readTemporal(fields) };
  }
  checkTiles(fields, stream);
  switch (codec) {
    case "DB4W":
      return { name: "blocks" };
    case "DPRD": {
      const coding = readPredictive(fields);
      if (coding.projection.shape === 2 && stream.width !== stream.height) {
        throw fields.error(`A cube face has ${stream.width}x${stream.height} pixels, which is no square`);
      }
      return coding;
    }
    default:
      return readNodes(fields, codec === "DQTR");
  }
}

/** Reads the header of a stream of material (depth.md 3); `codec` is MAAB or MAB1, others are unsupported. */
export function parseMaterialHeader(codec: string, bytes: Uint8Array, stream: StreamShape): MaterialHeader {
  if (codec !== "MAAB" && codec !== "MAB1") {
    throw unknown("material", codec);
  }
  const fields = new Fields(bytes, DEPTH);
  const inBlocks = codec === "MAB1";
  checkBlocks(inBlocks, fields, stream);
  const { window } = readTemporal(fields);
  fields.finish();
  return { kind: "material", window, inBlocks };
}

/** Reads the header of a stream of alpha (depth.md 16); `codec` is APRD, others are unsupported. */
export function parseAlphaHeader(codec: string, bytes: Uint8Array, stream: StreamShape): AlphaHeader {
  if (codec !== "APRD") {
    throw unknown("alpha", codec);
  }
  const fields = new Fields(bytes, "depth.md 16");
  checkTiles(fields, stream);
  const keyframeInterval = readKeyframeInterval(fields);
  fields.finish();
  const coding: PredictiveCoding = {
    name: "predictive",
    keyframeInterval,
    bound: 0,
    epsilon: 0,
    projection: { shape: 0, octave: 0 },
    levels: new Uint16Array(),
    tables: builtInTables("depth"),
  };
  return { kind: "alpha", coding };
}

function unknown(kind: string, codec: string): UnsupportedError {
  const letters = Array.from(codec, (letter) => (/[ -~]/u.test(letter) ? letter : "?")).join("");
  return new UnsupportedError(`A stream of ${kind} has codec '${letters}', which this player does not know.`);
}

function checkTiles(fields: Fields, { unitWidth, unitHeight }: StreamShape): void {
  if (unitWidth > MAX_SIDE || unitHeight > MAX_SIDE) {
    throw fields.error(`Tiles have ${unitWidth}x${unitHeight} pixels, at most ${MAX_SIDE} a side are legal`);
  }
}

function checkBlocks(inBlocks: boolean, fields: Fields, { unitWidth, unitHeight }: StreamShape): void {
  if (inBlocks && (unitWidth % 4 !== 0 || unitHeight % 4 !== 0)) {
    throw fields.error(`Tiles have ${unitWidth}x${unitHeight} pixels, where multiples of 4 were expected`);
  }
}

function readKeyframeInterval(fields: Fields): number {
  const frames = fields.u32();
  if (frames === 0) {
    throw fields.error("A keyframe interval has 0 frames");
  }
  return frames;
}

function checkWindow(fields: Fields, window: number): void {
  if (window < 1 || window > MAX_WINDOW) {
    throw fields.error(`A window has ${window} frames where 1 to ${MAX_WINDOW} are legal`);
  }
}

function readTemporal(fields: Fields): { window: number; keyframeInterval: number } {
  const window = fields.u16();
  checkWindow(fields, window);
  const boxes = fields.u16();
  if (boxes < 1 || boxes > MAX_BOXES) {
    throw fields.error(`Records have at most ${boxes} boxes where 1 to ${MAX_BOXES} are legal`);
  }
  // Epsilon is a promise of the encoder.
  fields.skip(2);
  fields.zeros(2);
  return { window, keyframeInterval: readKeyframeInterval(fields) };
}

function readNodes(fields: Fields, isTree: boolean): DepthHeader["coding"] {
  const window = fields.u16();
  checkWindow(fields, window);
  if (isTree && window !== 1) {
    throw fields.error(`A window has ${window} frames, which an intermediate form cannot have`);
  }
  fields.skip(2);
  const keyframeInterval = readKeyframeInterval(fields);
  // Bound and epsilon are promises of the encoder.
  fields.skip(2);
  const domain: DepthDomain = { kind: fields.u16(), base: fields.u32(), scale: fields.u32() };
  if (domain.kind > DOMAIN_INVERSE) {
    throw fields.error(`Domain ${domain.kind} is unknown`);
  }
  const isLegal =
    domain.kind === DOMAIN_LOG ? domain.base === 0 && domain.scale === 0 : domain.base < MAX_LOG && domain.scale > 0;
  if (!isLegal) {
    throw fields.error(`Domain ${domain.kind} has base ${domain.base} and scale ${domain.scale}, which is illegal`);
  }
  return { name: "nodes", window, isTree, domain, keyframeInterval };
}

function readPredictive(fields: Fields): PredictiveCoding {
  const bound = fields.u16();
  if (bound > FAR_CODE) {
    throw fields.error(`A bound has ${bound} codes, at most ${FAR_CODE} are legal`);
  }
  const epsilon = fields.u16();
  const keyframeInterval = readKeyframeInterval(fields);
  const [shape, hasLevels, ownSets, octave] = [fields.u16(), fields.u8(), fields.u8(), fields.u32()];
  const projection = projectionOf(fields, shape, octave);
  const tables = readTables("depth", ownSets, () => fields.varint());
  if (hasLevels > 1) {
    throw fields.error(`Levels are of kind ${hasLevels}, which is unknown`);
  }
  if (hasLevels === 1 && (bound !== 0 || epsilon !== 0 || shape !== 0)) {
    throw fields.error("A stream with a bound, a threshold or a projection has levels");
  }
  const levels = hasLevels === 1 ? readLevels(fields) : new Uint16Array();
  return { name: "predictive", keyframeInterval, bound, epsilon, projection, levels, tables };
}

function projectionOf(fields: Fields, shape: number, octave: number): Projection {
  if (shape !== 0 && shape !== 1 && shape !== 2) {
    throw fields.error(`Projection ${shape} is unknown`);
  }
  if (shape === 0 ? octave !== 0 : octave < MIN_OCTAVE || octave > MAX_OCTAVE) {
    throw fields.error(`Projection ${shape} has ${octave} codes for a factor of two, which is illegal`);
  }
  return { shape, octave };
}

function readLevels(fields: Fields): Uint16Array {
  const count = fields.u16();
  if (count < 1 || count > MAX_LEVELS) {
    throw fields.error(`A stream has ${count} levels where 1 to ${MAX_LEVELS} are legal`);
  }
  const levels = new Uint16Array(count);
  let before = -1;
  for (let at = 0; at < count; at += 1) {
    levels[at] = fields.u16();
    if (levels[at] <= before || levels[at] > FAR_CODE) {
      throw fields.error(`Level ${levels[at]} behind ${before} is illegal: levels ascend, up to ${FAR_CODE}`);
    }
    before = levels[at];
  }
  return levels;
}
