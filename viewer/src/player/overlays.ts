// Colors of the inspector in place of those of the film: the marching kernel blends them as it blends colors, and so shows what each pixel
// is made of.

import type { Container } from "../format/container.ts";
import type { Rect, Stream } from "../format/types.ts";
import type { LightFieldTexels } from "../gpu/texels.ts";
import type { FaceStreams } from "../views/catalogue.ts";
import { halfBits, lightOf as lightOfCode } from "../views/straight.ts";
import type { Overlay } from "./types.ts";

type Color = [number, number, number];

const DARK: Color = [18, 20, 26];
const TILE_EDGE: Color = [255, 255, 255];
const CELL_EDGE: Color = [255, 176, 0];
const FRESH: Color = [60, 220, 90];
const KEYFRAME: Color = [255, 120, 40];
const LATER: Color = [40, 90, 200];

/** What an overlay is painted from. */
export interface OverlayPicture {
  frame: number;
  /** Whether a chunk was fetched within the last second. */
  isFresh: (chunk: number) => boolean;
  /** Loaded views, by their places in the catalogue. */
  views: readonly number[];
}

/** Overlays that are colors of texels; holes are marked when a picture is shown. */
export const TEXEL_OVERLAYS = ["probes", "units", "keyframes", "fetched"] as const satisfies Overlay[];
export type TexelOverlay = (typeof TEXEL_OVERLAYS)[number];

export class OverlayTexture {
  readonly view: GPUTextureView;
  readonly #texture: GPUTexture;
  /** What each tile shows. */
  readonly #painted = new Map<number, string>();

  constructor(
    private readonly container: Container,
    private readonly texels: LightFieldTexels,
  ) {
    this.#texture = texels.arrays.colorTexture("overlay");
    this.view = this.#texture.createView({ dimension: "2d-array" });
  }

  /** Paints overlays over each other, each image only where it changed. */
  paint(overlays: readonly TexelOverlay[], picture: OverlayPicture): void {
    const { arrays, catalogue } = this.texels;
    for (const view of picture.views) {
      for (const streams of catalogue.views[view].faces) {
        const tile = this.texels.tile(view, streams.face);
        const painter = new ImagePainter(streams.size);
        overlays.forEach((overlay) => this.#paint(overlay, { view, streams }, picture, painter));
        if (this.#painted.get(tile) !== painter.key) {
          this.#painted.set(tile, painter.key);
          const texels = painter.texels();
          arrays.upload(
            this.#texture,
            tile,
            [0, 0, ...streams.size],
            arrays.colorFormat === "rgba8unorm" ? texels : halvesOf(texels),
          );
        }
      }
    }
  }

  #paint(
    overlay: TexelOverlay,
    { view, streams }: { view: number; streams: FaceStreams },
    picture: OverlayPicture,
    canvas: ImagePainter,
  ): void {
    const { depth, color } = streams;
    if (overlay === "probes") {
      canvas.fill([0, 0, ...streams.size], hue(view / this.texels.catalogue.views.length));
    } else if (overlay === "units") {
      this.#forEachUnit(color, (rect) => canvas.frame(rect, CELL_EDGE));
      this.#forEachUnit(depth, (rect) => canvas.frame(rect, TILE_EDGE));
    } else {
      this.#forEachUnit(depth, (rect, unit) => {
        const chunk = this.container.chunkIndex(depth.index, unit, picture.frame);
        if (chunk < 0) {
          return;
        }
        if (overlay === "fetched") {
          canvas.fill(rect, picture.isFresh(chunk) ? FRESH : DARK);
        } else {
          const { firstFrame, frameCount } = this.container.chunks[chunk];
          const age = (picture.frame - firstFrame) / Math.max(1, frameCount - 1);
          canvas.fill(rect, KEYFRAME.map((part, at) => Math.round(part + (LATER[at] - part) * age)) as Color);
        }
      });
      if (overlay === "fetched") {
        this.#forEachUnit(color, (rect, unit) => {
          const chunk = this.container.chunkIndex(color.index, unit, picture.frame);
          if (chunk >= 0 && picture.isFresh(chunk)) {
            canvas.frame(rect, FRESH);
          }
        });
      }
    }
  }

  #forEachUnit({ index }: Stream, visit: (rect: Rect, unit: number) => void): void {
    for (let unit = 0; unit < this.container.unitCount(index); unit += 1) {
      visit(this.container.unitRect(index, unit), unit);
    }
  }
}

/** 8-bit codes as half floats of light. */
function halvesOf(codes: Uint8Array): Uint16Array {
  const halves = Array.from({ length: 256 }, (_, code) => halfBits(lightOfCode(code, "srgb")));
  return Uint16Array.from(codes, (code) => halves[code]);
}

/** A hue of even brightness; `turn` from 0 to 1. */
function hue(turn: number): Color {
  const part = (shift: number): number => Math.round(255 * (0.55 + 0.4 * Math.cos(2 * Math.PI * (turn - shift))));
  return [part(0), part(1 / 3), part(2 / 3)];
}

/** Rectangles of an image, painted once their texels are asked for. */
class ImagePainter {
  readonly #steps: { rect: Rect; color: Color; isFrame: boolean }[] = [];

  constructor(readonly size: [number, number]) {}

  /** Tells whether two images look alike. */
  get key(): string {
    return this.#steps.map(({ rect, color, isFrame }) => [...rect, ...color, isFrame].join()).join(" ");
  }

  fill(rect: Rect, color: Color): void {
    this.#steps.push({ rect, color, isFrame: false });
  }

  /** The texels along the edges of a rectangle. */
  frame(rect: Rect, color: Color): void {
    this.#steps.push({ rect, color, isFrame: true });
  }

  texels(): Uint8Array<ArrayBuffer> {
    const [width, height] = this.size;
    const texels = new Uint8Array(4 * width * height);
    const words = new Uint32Array(texels.buffer);
    words.fill(wordOf(DARK));
    for (const { rect, color, isFrame } of this.#steps) {
      const [left, top, columns, rows] = rect;
      for (let row = top; row < top + rows; row += 1) {
        const start = row * width + left;
        if (!isFrame || row === top || row === top + rows - 1) {
          words.fill(wordOf(color), start, start + columns);
        } else {
          [words[start], words[start + columns - 1]] = [wordOf(color), wordOf(color)];
        }
      }
    }
    return texels;
  }
}

function wordOf([red, green, blue]: Color): number {
  return (red | (green << 8) | (blue << 16) | (255 << 24)) >>> 0;
}
