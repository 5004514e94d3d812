// Payloads of chunks: checked and decompressed (formats/container.md 6).

import { crc32 } from "./crc32.ts";
import { decompressLzma2 } from "./lzma2.ts";
import { type Chunk, FormatError } from "./types.ts";
import { decompressZstd } from "./zstd.ts";

/** The payload of a chunk's stored bytes, which is `rawBytes` bytes; a FormatError where they are damaged. Of a raw chunk it is the stored
 *  bytes themselves. */
export function unpack(chunk: Chunk, stored: Uint8Array): Uint8Array {
  if (stored.length !== chunk.storedBytes || crc32(stored) !== chunk.crc32) {
    const last = chunk.firstFrame + chunk.frameCount - 1;
    throw new FormatError(
      `The CRC-32 of stream ${chunk.stream}, unit ${chunk.unit}, frames ${chunk.firstFrame} to ${last} does not match: the file is ` +
        `damaged at byte ${chunk.offset} (container.md 6).`,
    );
  }
  switch (chunk.storage) {
    case "raw":
      return stored;
    case "lzma2":
      return decompressLzma2(stored, chunk.rawBytes);
    case "zstd":
      return decompressZstd(stored, chunk.rawBytes);
  }
}
