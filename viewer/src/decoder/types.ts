// Input and output of the decoder: chunks, pictures, and chunks in the form of the kernels of shaders/.

import type { Chunk, Rect, StreamKind } from "../format/types.ts";
import type { ToneMapName } from "../views/presentation.ts";

/** A decoded picture of a unit, row by row: codes of depth or alpha; red, green, blue of material and 8-bit colour; bit patterns of
 *  three halves of colour. */
export type Pixels = Uint16Array | Uint8Array;

/** Decoded pixels of a unit, row by row, and its rectangle in the image. */
export interface UnitPixels {
  pixels: Pixels;
  rect: Rect;
}

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

/** Whether a colour chunk may blend into the keyframe of a next one: formats/color.md 4. */
export type ChunkPlace = "inner" | "last";

/** Where a chunk lies: the rectangle of its unit, and its place among the unit's chunks. */
export interface ChunkArea {
  rect: Rect;
  place: ChunkPlace;
}

/** A chunk, its stored bytes, and where it lies in its stream. */
export interface StoredChunk {
  chunk: Chunk;
  stored: Uint8Array;
  area: ChunkArea;
}

/** Rows of shaders/kernels.json with their members in words, one row behind the other. */
export type Words = Uint32Array;

/** A checked chunk in the form of the device (src/kernels/prepare.rs): offsets count from the chunk's own first byte, word or row. All arrays
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

/** What the host keeps of a chunk on the device (`Timeline` of src/kernels/prepare.rs). */
export interface Timeline {
  /** Frames that have a record, and the pixels that each writes; none of colour. */
  recordFrames: Uint32Array;
  recordPixels: Uint32Array;
  /** Frames of keyframes of colour; of the transform codec, frames that have a record. */
  keyframes: Uint32Array;
  /** Weights of the first frames; those of later ones are 0. */
  weights: Uint32Array;
  /** Of the transform codec: sets of frames, each four words of 128 bits, the lowest first, and the pixels that look the same in each. */
  frameSets: Uint32Array;
  framePixels: Uint32Array;
}

/** Distances at which a ray is sampled. */
export interface Steps {
  /** Metres, never falling; at least one. */
  distancesM: Float32Array<ArrayBuffer>;
  /** Logarithm of the ratio of adjacent distances; 0 where there is one distance. */
  logStep: number;
  /** Greatest distance of hits behind the surface, in the logarithm: the rest of an interval that was halved `refine` times. */
  uncertainty: number;
}

/** How pictures become codes. */
export interface Presentation {
  exposureEv: number;
  toneMap: ToneMapName;
  /** What no probe saw is marked: pixels with an alpha below 1. */
  marksHoles: boolean;
  /** Part of the overlay that is shown, 0 to 1. */
  overlayShare: number;
  /** Red of the left eye, green and blue of the right one. */
  isAnaglyph: boolean;
}
