// What codecs give: pictures of the CPU decoders, and chunks in the form of the kernels of shaders/.

import type { Rect } from "../format/types.ts";

/** A decoded picture of a unit, row by row: codes of depth or alpha; red, green, blue of material and 8-bit colour; bit patterns of
 *  three halves of colour. */
export type Pixels = Uint16Array | Uint8Array;

/** The area of a unit in its image, which prediction and projections count from. */
export interface UnitArea {
  /** Of the image. */
  imageSize: [number, number];
  face: number;
  rect: Rect;
}

/** Whether a colour chunk may blend into the keyframe of a next one: formats/color.md 4. */
export type ChunkPlace = "inner" | "last";

/** What a decoder needs to know of a chunk besides its payload. */
export interface ChunkArea {
  area: UnitArea;
  frames: number;
  place: ChunkPlace;
}

/** Decodes frames of one unit. Frames are counted from the start of the unit's chunk. */
export interface ChunkDecoder {
  /** The picture of a frame; the same array may be given again. `next` is the payload of the unit's next chunk, where the frame blends
   *  into it. */
  frame(frame: number, next?: () => Uint8Array): Pixels;
}

/** Rows of shaders/kernels.json with their members in words, one row behind the other. */
export type Words = Uint32Array;

/** A checked chunk in the form of the device (src/gpu/prepare.rs): offsets count from the chunk's own first byte, word or row. All arrays
 *  are transferable between workers. */
export interface Prepared {
  /** The kernel of keyframes of `CTR8` and `CTRH` chunks that have cells, else that of the codec. */
  kernel: "codec" | "keyframes";
  /** Records are nodes, which are found by words; all else is found by bytes. */
  isNodes: boolean;
  stream: Words;
  /** Rows `Record`. */
  records: Words;
  /** Rows `BoxRow`. */
  boxes: Words;
  /** Byte at which the weights start, and their number. */
  weights: [number, number];
  /** Upper bound of the passes of the kernel's reader; 0 without one. */
  passes: number;
  timeline: Timeline;
}

/** What the host keeps of a chunk on the device (`Timeline` of src/gpu/prepare.rs). */
export interface Timeline {
  /** Frames that have a record, and the pixels that each writes; none of colour. */
  recordFrames: Uint32Array;
  recordPixels: Uint32Array;
  /** Frames of keyframes of colour; of the transform codec, frames that have a record. */
  keyframes: Uint32Array;
  /** Weights of the first frames; those of later ones are 0. */
  weights: Uint8Array;
  /** Of the transform codec: sets of frames, each four words of 128 bits, the lowest first, and the pixels that look the same in each. */
  frameSets: Uint32Array;
  framePixels: Uint32Array;
}
