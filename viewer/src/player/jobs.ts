// Messages between the page and its workers.

import type { HeaderStream, Pixels, Prepared, StoredChunk } from "../decoder/types.ts";

/** What a worker needs of a stream to read its chunks. */
export interface StreamOutline {
  stream: HeaderStream;
  headerBytes: Uint8Array;
}

/** The first message to a worker. */
export interface WorkerSettings {
  /** The decoder. */
  module: WebAssembly.Module;
  /** Bytes of the decoders that it keeps, at most. */
  keptBytes: number;
}

/** Work on a chunk: to bring it into the form of the device, or, with `frame`, to decode a frame of it or to tell how that is coded. */
export interface Job extends StoredChunk {
  id: number;
  /** Sent with the first job of a stream to each worker. */
  outline?: StreamOutline;
  /** The frame, counted from the chunk's first. */
  frame?: number;
  /** The answer is how each pixel of the frame is coded (player/coding_colors.ts), and not the pixels. */
  asksCodings?: true;
  /** The unit's next chunk, into which the frame may blend. */
  next?: StoredChunk;
}

export type Answer =
  | { id: number; prepared: Prepared }
  | { id: number; pixels: Pixels }
  /** The frame blends into the unit's next chunk, which the job did not have. */
  | { id: number; needsNext: true }
  /** One sentence. */
  | { id: number; error: string };
