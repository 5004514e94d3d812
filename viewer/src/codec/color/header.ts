// Codec headers of color streams (formats/color.md 2).

import type { ColorHeader } from "../../format/types.ts";
import { UnsupportedError } from "../../format/types.ts";
import { readTables } from "../entropy.ts";
import { Fields } from "../fields.ts";

const SECTION = "color.md 2";
/** Color planes of the transform codec: red, green and blue. */
const PLANES = 3;
/** Pixels of a side of a block. */
const BLOCK = 4;

/** What a codec stores. */
const CODECS: ReadonlyMap<string, { isHalf: boolean; blocks?: "bc1" | "bc7" | "bc6h"; isTransform?: true }> = new Map([
  ["CCL8", { isHalf: false }],
  ["CCB1", { isHalf: false, blocks: "bc1" }],
  ["CCB7", { isHalf: false, blocks: "bc7" }],
  ["CCLH", { isHalf: true }],
  ["CCB6", { isHalf: true, blocks: "bc6h" }],
  ["CTR8", { isHalf: false, isTransform: true }],
  ["CTRH", { isHalf: true, isTransform: true }],
]);

/** What a stream says of itself (container.md 5); pixels. */
export interface StreamShape {
  face: number;
  width: number;
  height: number;
  unitWidth: number;
  unitHeight: number;
}

/** Reads and checks the header of a color codec of four characters (formats/color.md 2); a codec that is none is an UnsupportedError. */
export function parseColorHeader(codec: string, bytes: Uint8Array, stream: StreamShape): ColorHeader {
  const known = CODECS.get(codec);
  if (known === undefined) {
    throw new UnsupportedError(`The codec ${JSON.stringify(codec)} of a color stream is not known (${SECTION}).`);
  }
  const fields = new Fields(bytes, SECTION);
  const minPsnrDb = fields.f64();
  if (!Number.isFinite(minPsnrDb)) {
    throw fields.error("The PSNR is no finite number");
  }
  const tone = known.isHalf ? readWhite(fields) : readTone(fields);
  let coding: ColorHeader["coding"] = { name: "cells", blocks: known.blocks };
  if (known.isTransform) {
    const minQuality = fields.f64();
    if (!(minQuality >= 0 && minQuality <= 100)) {
      throw fields.error("The quality is not within 0 to 100");
    }
    const planes = fields.u8();
    if (planes !== PLANES) {
      throw fields.error(`A stream has ${planes} planes of color, ${PLANES} were expected`);
    }
    fields.zeros(3);
    coding = { name: "transform", tables: readTables("color", fields.u8(), () => fields.varint()) };
  }
  if (known.blocks !== undefined && (stream.unitWidth % BLOCK !== 0 || stream.unitHeight % BLOCK !== 0)) {
    throw fields.error(`The sides of units are no multiples of ${BLOCK} pixels`);
  }
  fields.finish();
  return { kind: "color", isHalf: known.isHalf, ...tone, minPsnrDb, coding };
}

function readTone(fields: Fields): Pick<ColorHeader, "transfer" | "exposureEv"> {
  const exposureEv = fields.f32();
  if (!(exposureEv >= -32 && exposureEv <= 32)) {
    throw fields.error(`An exposure of ${exposureEv} stops is not within -32 to 32`);
  }
  const transfer = fields.u32();
  if (transfer > 1) {
    throw fields.error(`The transfer function ${transfer} is not known`);
  }
  return { transfer: transfer === 0 ? "srgb" : "linear", exposureEv };
}

/** Reads the luminance of white, which only an encoder needs. */
function readWhite(fields: Fields): Pick<ColorHeader, "transfer" | "exposureEv"> {
  const white = fields.f64();
  if (!(Number.isFinite(white) && white > 0)) {
    throw fields.error(`A white of ${white} candelas per square meter is not finite and above 0`);
  }
  return { transfer: "linear", exposureEv: 0 };
}
