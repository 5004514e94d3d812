// Decoders of chunks of any codec.

import { type CodecHeader, UnsupportedError } from "../format/types.ts";
import { colorDecoder, prepareColor } from "./color/index.ts";
import { depthCodings, depthDecoder, prepareDepth } from "./depth/index.ts";
import type { ChunkArea, ChunkDecoder, Prepared } from "./types.ts";

/** A decoder of one chunk, whose payload is checked: a FormatError where it breaks a rule. Errors that show only when a frame is decoded are
 *  FormatErrors of `frame`. */
export function chunkDecoder(header: CodecHeader, payload: Uint8Array, area: ChunkArea): ChunkDecoder {
  return header.kind === "color" ? colorDecoder(header, payload, area) : depthDecoder(header, payload, area);
}

/** How each pixel of a chunk's frames is coded, as of depth/coding_map.ts, in place of their pictures; errors are as of
 *  {@link chunkDecoder}. An UnsupportedError for colors, of which there are no such maps. */
export function chunkCodings(header: CodecHeader, payload: Uint8Array, area: ChunkArea): ChunkDecoder {
  if (header.kind === "color") {
    throw new UnsupportedError("There are no maps of how the pixels of colors are coded.");
  }
  return depthCodings(header, payload, area);
}

/** A checked chunk in the form of the device: a FormatError where it breaks a rule, an UnsupportedError for codecs without a kernel. */
export function prepare(header: CodecHeader, payload: Uint8Array, area: ChunkArea): Prepared {
  return header.kind === "color" ? prepareColor(header, payload, area) : prepareDepth(header, payload, area);
}
