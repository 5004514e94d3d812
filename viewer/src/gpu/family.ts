// Families of streams that are decoded together: those of one kernel. Mirrors src/gpu/family.rs.

import type { CodecHeader, Stream } from "../format/types.ts";
import { UnsupportedError } from "../format/types.ts";
import type { KernelName } from "./kernels.ts";

/** What a word of a picture holds: two codes, three bytes, or with the next word three halves. */
export type PixelWords = "codes" | "bytes" | "halves";

export interface Family {
  /** The kernel that writes pixels. */
  kernel: KernelName;
  /** The one of chunks of keyframes, where the codec has others. */
  keyframes: KernelName | undefined;
  plan: KernelName;
  words: PixelWords;
  /** Whether a chunk decodes any of its frames at once; else frames are reached by changing a picture. */
  isColor: boolean;
}

const COLOR_CELLS = { bc1: "cells-bc1", bc7: "cells-bc7", bc6h: "cells-bc6h" } as const;

function kernelOf(header: CodecHeader): KernelName {
  switch (header.kind) {
    case "alpha":
      throw new UnsupportedError("Alpha is not decoded on the graphics device.");
    case "material":
      return header.inBlocks ? "boxes-bc1" : "boxes-material";
    case "depth":
      switch (header.coding.name) {
        case "boxes":
          return header.coding.inBlocks ? "boxes-bc5" : "boxes-codes";
        case "predictive":
          // Its chunks become boxes when they are prepared.
          return "boxes-codes";
        default:
          return "nodes";
      }
    case "color":
      if (header.coding.name === "transform") {
        return header.isHalf ? "transform-half" : "transform-8bit";
      }
      if (header.coding.blocks !== undefined) {
        return COLOR_CELLS[header.coding.blocks];
      }
      return header.isHalf ? "cells-half" : "cells-8bit";
  }
}

/** The family of a stream: of all kinds but alpha. */
export function familyOf(header: CodecHeader): Family {
  const kernel = kernelOf(header);
  if (header.kind !== "color") {
    return {
      kernel,
      keyframes: undefined,
      plan: "plan-records",
      words: header.kind === "material" ? "bytes" : "codes",
      isColor: false,
    };
  }
  const cells = header.isHalf ? "cells-half" : "cells-8bit";
  return {
    kernel,
    keyframes: header.coding.name === "transform" ? cells : undefined,
    plan: "plan-cells",
    words: header.isHalf ? "halves" : "bytes",
    isColor: true,
  };
}

/** Words of a row of a picture. Rows of 8-bit colors take a multiple of `multiple` words: copies into textures want it. */
export function rowStride(family: Family, width: number, multiple: number): number {
  switch (family.words) {
    case "codes":
      return Math.ceil(width / 2);
    case "halves":
      return 2 * width;
    case "bytes":
      return family.isColor ? Math.ceil(width / multiple) * multiple : width;
  }
}

/** Words of the pictures of a stream. */
export function pictureWords(stream: Stream, multiple: number): number {
  const family = familyOf(stream.header);
  const unit = Math.min(stream.unitWidth, stream.width);
  const whole = Math.floor(stream.width / unit) * rowStride(family, unit, multiple);
  // Units of a column are as wide, and their heights add up to that of the image.
  return (whole + rowStride(family, stream.width % unit, multiple)) * stream.height;
}

/** What a kernel needs to know of the units of a stream besides their pictures: members of `Unit`. */
export function unitMembers(header: CodecHeader): { window: number; domain: number; base: number; scale: number } {
  const plain = { window: 0, domain: 0, base: 0, scale: 0 };
  if (header.kind === "material") {
    return { ...plain, window: header.window };
  }
  if (header.kind !== "depth") {
    return plain;
  }
  const { coding } = header;
  switch (coding.name) {
    case "boxes":
      return { ...plain, window: coding.window };
    case "predictive":
      return { ...plain, window: 1 };
    case "nodes":
      return {
        window: coding.window,
        domain: coding.domain.kind,
        base: coding.domain.base,
        scale: coding.domain.scale,
      };
    case "blocks":
      // Each frame is whole: none is needed before another.
      return plain;
  }
}
