// The first 16 and the last 40 bytes of a container (formats/container.md 3 and 7).

import { FileFields } from "./bytes.ts";
import { decoder } from "../decoder/module.ts";
import { HEAD_BYTES } from "./index_tables.ts";
import { FormatError, UnsupportedError } from "./types.ts";

/** Bytes of the foot. */
export const FOOT_BYTES = 40;
/** The major version, and the minor one that adds all that this player knows. */
export const VERSION: readonly [number, number] = [1, 0];
const MAGIC = [0x89, 0x4c, 0x46, 0x4c, 0x44, 0x0d, 0x0a, 0x1a];
const FOOT_MAGIC = [0x4c, 0x46, 0x4e, 0x44];
const SECTION = "container.md 7";

/** Where the index lies (container.md 7). */
export interface Foot {
  indexOffset: number;
  indexBytes: number;
  indexCrc32: number;
}

/** Checks the head; answers the minor version. */
export function readHead(bytes: Uint8Array): number {
  const fields = new FileFields(bytes, "container.md 3", 0);
  const magic = fields.take(Math.min(MAGIC.length, bytes.length));
  if (magic.length < MAGIC.length || MAGIC.some((byte, at) => magic[at] !== byte)) {
    throw new FormatError("This is not a lightfold container: its first 8 bytes are other (container.md 3).");
  }
  const [major, minor] = [fields.u16(), fields.u16()];
  if (major !== VERSION[0]) {
    throw new UnsupportedError(`The container has format version ${major}; this player reads version ${VERSION[0]}.`);
  }
  fields.zeros(4);
  return minor;
}

/** Reads the foot of a file of `fileBytes` bytes. */
export function readFoot(bytes: Uint8Array, fileBytes: number): Foot {
  const start = fileBytes - FOOT_BYTES;
  if (!isFoot(bytes)) {
    throw new FormatError("The container has no foot: it was cut short, so copy or encode it again (container.md 7).");
  }
  const fields = new FileFields(bytes, SECTION, start);
  if (decoder().crc32(bytes.subarray(0, 32)) !== new DataView(bytes.buffer, bytes.byteOffset).getUint32(32, true)) {
    throw fields.error("The foot's CRC-32 does not match: the file is damaged");
  }
  const [indexOffset, indexBytes] = [fields.u64("The index's offset"), fields.u64("The index")];
  const indexCrc32 = fields.u32();
  fields.zeros(4);
  const said = fields.u64("The file's size");
  if (said !== fileBytes) {
    throw fields.error(`The foot speaks of a file of ${said} bytes, this one has ${fileBytes}`, 24);
  }
  if (indexOffset < HEAD_BYTES || indexOffset + indexBytes !== start) {
    throw fields.error("The index does not lie between the chunks and the foot", 0);
  }
  return { indexOffset, indexBytes, indexCrc32 };
}

/** Where in the last bytes of a file of `fileBytes` a foot ends that others follow: an offset in the file, or none. */
export function findFoot(tail: Uint8Array, fileBytes: number): number | undefined {
  const first = fileBytes - tail.length;
  for (let end = tail.length - 1; end >= FOOT_BYTES; end -= 1) {
    const bytes = tail.subarray(end - FOOT_BYTES, end);
    if (isFoot(bytes) && isWhole(bytes, first + end)) {
      return first + end;
    }
  }
  return undefined;
}

function isFoot(bytes: Uint8Array): boolean {
  return bytes.length === FOOT_BYTES && FOOT_MAGIC.every((byte, at) => bytes[FOOT_BYTES - 4 + at] === byte);
}

function isWhole(bytes: Uint8Array, fileBytes: number): boolean {
  try {
    readFoot(bytes, fileBytes);
    return true;
  } catch {
    return false;
  }
}
