// Colors of an overlay in place of those of the texels: rendering blends them as it does those, and so shows which probes a pixel is of.

import type { Rect } from "../format/types.ts";
import type { LightFieldTexels } from "./texels.ts";
import { halfBits } from "../views/straight.ts";

/** Red, green and blue, 0 to 1, as they are coded: behind the curve of 8-bit colors, or linear light. */
export type Tint = readonly [number, number, number];

/** A hue of the color circle, 0 to 1, bright. */
export function hue(turn: number): Tint {
  const channel = (third: number): number =>
    Math.min(Math.max(Math.abs(((((turn + third) % 1) + 1) % 1) * 6 - 3) - 1, 0), 1);
  return [channel(0), channel(2 / 3), channel(1 / 3)];
}

/** An array of colors with the images of all loaded views, for `Shot.colors`. */
export class Tints {
  readonly view: GPUTextureView;
  readonly #texture: GPUTexture;

  /** Nothing is filled yet. */
  constructor(private readonly texels: LightFieldTexels) {
    this.#texture = texels.arrays.colorTexture("tints");
    this.view = this.#texture.createView({ dimension: "2d-array" });
  }

  /** Fills a rectangle of a face of a loaded view. */
  fill(view: number, face: number, rect: Rect, tint: Tint): void {
    const isHalf = this.texels.arrays.colorFormat === "rgba16float";
    const texel = [...tint, 1].map((value) => (isHalf ? halfBits(value) : Math.round(value * 255)));
    const texels = new (isHalf ? Uint16Array : Uint8Array)(4 * rect[2] * rect[3]);
    for (let at = 0; at < texels.length; at += 4) {
      texels.set(texel, at);
    }
    this.texels.arrays.upload(this.#texture, this.texels.tile(view, face), rect, texels);
  }

  /** Fills all images of some views, each view with a hue of its own among `count` of the catalogue. */
  fillViews(views: readonly number[]): void {
    const all = this.texels.catalogue.views;
    for (const view of views) {
      for (const { face, size } of all[view].faces) {
        this.fill(view, face, [0, 0, ...size], hue(view / all.length));
      }
    }
  }

  destroy(): void {
    this.#texture.destroy();
  }
}
