// Messages between the page and its workers.

import type { ChunkArea, Prepared, Pixels } from "../codec/types.ts";
import type { Chunk, StreamKind } from "../format/types.ts";

/** What a worker needs of a stream to read its chunks. */
export interface StreamOutline {
  kind: StreamKind;
  codec: string;
  headerBytes: Uint8Array;
  face: number;
  width: number;
  height: number;
  unitWidth: number;
  unitHeight: number;
}

/** A chunk to check, decompress, and bring into the form of the device. */
export interface Job {
  id: number;
  stream: number;
  /** Sent with the first job of a stream to each worker. */
  outline?: StreamOutline;
  chunk: Chunk;
  stored: Uint8Array;
  area: ChunkArea;
  /** Of a stream that the processor decodes: the frame, counted from the chunk's first; then pixels are answered. */
  frame?: number;
  /** The unit's next chunk, into which the frame may blend. */
  next?: { chunk: Chunk; stored: Uint8Array };
}

export type Answer =
  | { id: number; prepared: Prepared }
  | { id: number; pixels: Pixels }
  /** One sentence; `isFormat`: the file breaks a rule. */
  | { id: number; error: string; isFormat: boolean };
