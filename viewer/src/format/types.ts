// What a container says of itself: formats/container.md 4 to 6, and the codec headers of depth.md and color.md.

/** A file, or an object of a web server, that is read by ranges. */
export interface ByteSource {
  readonly byteCount: number;
  /** Exactly `count` bytes at `offset`, or an error. */
  read(offset: number, count: number, signal?: AbortSignal): Promise<Uint8Array>;
}

export type Vec3 = [number, number, number];
/** x, y, z, w; of length 1. */
export type Quaternion = [number, number, number, number];
/** Left, top, width and height. */
export type Rect = [number, number, number, number];

export type StreamKind = "color" | "depth" | "material" | "alpha";

/** A probe (container.md 4). A moving probe has a pose for each frame in the attributes. */
export interface Probe {
  name: string;
  /** Metres. */
  position: Vec3;
  orientation: Quaternion;
  /** First and last frame in which it is active. */
  frames: [number, number];
  /** fx, fy, cx, cy in pixels of a perspective probe, else zeros. */
  intrinsics: [number, number, number, number];
}

/** A stream (container.md 5): one kind of image of one face of one probe. */
export interface Stream {
  /** Its row in the stream table. */
  index: number;
  kind: StreamKind;
  /** 0 to 5: px nx py ny pz nz; 6: the view of a perspective probe. */
  face: number;
  probe: number;
  /** Four characters. */
  codec: string;
  width: number;
  height: number;
  firstFrame: number;
  frameCount: number;
  /** Width of a tile or cell; those of the last column are cut off at the image's edge. */
  unitWidth: number;
  unitHeight: number;
  header: CodecHeader;
  /** What `header` was read from: workers are sent these. */
  headerBytes: Uint8Array;
}

/** How the stored bytes of a chunk became fewer. */
export type Storage = "raw" | "lzma2" | "zstd";

/** A chunk (container.md 6): some frames of a unit. Chunks are in the order of stream, unit and first frame. */
export interface Chunk {
  stream: number;
  unit: number;
  /** Numbered as in the source. */
  firstFrame: number;
  frameCount: number;
  offset: number;
  storedBytes: number;
  rawBytes: number;
  crc32: number;
  storage: Storage;
}

/** Depth range and what it means (depth.md 2 and 3). */
export interface DepthRange {
  /** Metres of codes 0 and 65534, as single floats. */
  nearM: number;
  farM: number;
}

/** What the player uses of a codec header of depth (`Stream::json` of src/wasm/stream.rs). */
export interface DepthHeader {
  kind: "depth";
  range: DepthRange;
  isDistance: boolean;
  coding:
    | { name: "boxes"; window: number; inBlocks: boolean }
    | { name: "nodes"; window: number; domain: DepthDomain }
    | { name: "blocks" }
    | { name: "predictive" };
}

/** Domain of modelling functions: `Unit.domain`, `base` and `scale` of shaders/shared/layout.wgsl. */
export interface DepthDomain {
  kind: number;
  base: number;
  scale: number;
}

export interface MaterialHeader {
  kind: "material";
  window: number;
  inBlocks: boolean;
}

export interface AlphaHeader {
  kind: "alpha";
}

export interface ColorHeader {
  kind: "color";
  /** Half floats of linear light, else 8-bit codes. */
  isHalf: boolean;
  /** Of 8-bit codes: the curve from linear light, and the exposure before it in stops. */
  transfer: "srgb" | "linear";
  exposureEv: number;
  coding: { name: "cells"; blocks?: "bc1" | "bc7" | "bc6h" } | { name: "transform" };
}

export type CodecHeader = DepthHeader | MaterialHeader | AlphaHeader | ColorHeader;

/** A file that breaks a rule of formats/. The message is one sentence, with the place. */
export class FormatError extends Error {
  override name = "FormatError";
}

/** A file that keeps the rules, and needs more than this player does: a later version, an unknown codec, too much memory. */
export class UnsupportedError extends Error {
  override name = "UnsupportedError";
}
