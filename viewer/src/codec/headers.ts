// Codec headers of streams: which codec goes with which kind (formats/container.md 5).

import { type CodecHeader, type StreamKind, UnsupportedError } from "../format/types.ts";
import { FormatError } from "../format/types.ts";
import { parseColorHeader } from "./color/header.ts";
import { parseAlphaHeader, parseDepthHeader, parseMaterialHeader } from "./depth/header.ts";

/** What the reading of a codec header needs to know of its stream. Sizes are in pixels. */
export interface HeaderStream {
  kind: StreamKind;
  /** Four characters. */
  codec: string;
  /** 0 to 6. */
  face: number;
  width: number;
  height: number;
  unitWidth: number;
  unitHeight: number;
}

const CODECS: Readonly<Record<StreamKind, readonly string[]>> = {
  color: ["CTR8", "CTRH", "CCL8", "CCB1", "CCB7", "CCLH", "CCB6"],
  depth: ["DQPN", "DQTR", "DAAB", "DPRD", "DB4W", "DAB5"],
  material: ["MAAB", "MAB1"],
  alpha: ["APRD"],
};
/** Codecs whose units are made of blocks of 4x4 pixels. */
const IN_BLOCKS: readonly string[] = ["DAB5", "MAB1", "CCB1", "CCB7", "CCB6"];
const BLOCK_SIDE = 4;

/** Reads a codec header: a FormatError where it breaks a rule, an UnsupportedError where the codec is unknown, or of another kind of
 *  stream. */
export function parseCodecHeader(stream: HeaderStream, bytes: Uint8Array): CodecHeader {
  const { kind, codec, unitWidth, unitHeight } = stream;
  if (!CODECS[kind].includes(codec)) {
    throw new UnsupportedError(`A stream of ${kind} has codec ${shown(codec)}, which this player does not know.`);
  }
  if (IN_BLOCKS.includes(codec) && (unitWidth % BLOCK_SIDE !== 0 || unitHeight % BLOCK_SIDE !== 0)) {
    throw new FormatError(
      `A stream of codec ${codec} has units of ${unitWidth}x${unitHeight} pixels, whose sides are no multiples of ${BLOCK_SIDE}.`,
    );
  }
  switch (kind) {
    case "depth":
      return parseDepthHeader(codec, bytes, stream);
    case "material":
      return parseMaterialHeader(codec, bytes, stream);
    case "alpha":
      return parseAlphaHeader(codec, bytes, stream);
    case "color":
      return parseColorHeader(codec, bytes, stream);
  }
}

/** The characters of a codec for a message, those that are not plain by their numbers. */
function shown(codec: string): string {
  return `"${codec.replace(/[^A-Za-z0-9]/gu, (letter) => `\\x${letter.charCodeAt(0).toString(16).padStart(2, "0")}`)}"`;
}
