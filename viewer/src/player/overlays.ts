// Colors of the inspector in place of those of the film: the marching kernel blends them as it blends colors, and so shows what each pixel
// is made of.

import type { Container } from "../format/container.ts";
import type { Rect, Stream } from "../format/types.ts";
import type { Catalogue, ColorCoding, FaceStreams } from "../views/catalogue.ts";
import { type Color, codingColors } from "./coding_colors.ts";
import type { DrawRequest } from "./renderer.ts";
import type { Overlay, View } from "./types.ts";

const DARK: Color = [18, 20, 26];
const TILE_EDGE: Color = [255, 255, 255];
const CELL_EDGE: Color = [255, 176, 0];
const FRESH: Color = [60, 220, 90];
const KEYFRAME: Color = [255, 120, 40];
const LATER: Color = [40, 90, 200];

/** Overlays that are colors of texels; holes are marked when a picture is shown. */
const TEXEL_OVERLAYS = ["probes", "nodes", "units", "keyframes", "fetched"] as const satisfies Overlay[];
type TexelOverlay = (typeof TEXEL_OVERLAYS)[number];

/** How colors of overlays are coded. */
export const OVERLAY_CODING: ColorCoding = { name: "codes", transfer: "srgb", exposureEv: 0 };
/** How much of an overlay is shown. */
export const OVERLAY_SHARE = 0.55;

/** The overlays of a picture that are colors of texels, those that others are painted over first. */
export function texelOverlays({ overlays }: View): TexelOverlay[] {
  return TEXEL_OVERLAYS.filter((overlay) => overlays.has(overlay));
}

/** Sends texels of a rectangle of a face of a view: codes of red, green and blue behind the curve of sRGB, and alpha, row by row. */
type SendTexels = (place: { view: number; face: number }, rect: Rect, texels: Uint8Array<ArrayBuffer>) => void;

/** Paints overlays for images of a film. */
export class OverlayPainter {
  /** What the image of each face shows, by its depth stream. */
  readonly #painted = new Map<number, ImagePainter>();
  /** Texels of the bytes of coding maps; 0 where there is none. */
  readonly #codingWords = Uint32Array.from(codingColors(), (color) => (color === undefined ? 0 : wordOf(color)));

  constructor(
    private readonly container: Container,
    private readonly catalogue: Catalogue,
    private readonly send: SendTexels,
  ) {}

  /** Takes in that nothing of a view is painted any more. */
  forget(view: number): void {
    this.catalogue.views[view].faces.forEach(({ depth }) => this.#painted.delete(depth.index));
  }

  /** Paints overlays over each other, each image only where it changed. */
  paint(overlays: readonly TexelOverlay[], request: DrawRequest): void {
    for (const view of request.views) {
      for (const streams of this.catalogue.views[view].faces) {
        const painter = new ImagePainter(streams.size);
        overlays.forEach((overlay) => this.#paint(overlay, { view, streams }, request, painter));
        for (const rect of painter.changesTo(this.#painted.get(streams.depth.index))) {
          this.send({ view, face: streams.face }, rect, painter.texels(rect));
        }
        painter.forgetMaps();
        this.#painted.set(streams.depth.index, painter);
      }
    }
  }

  #paint(
    overlay: TexelOverlay,
    { view, streams }: { view: number; streams: FaceStreams },
    { view: { frame }, isFresh, codings }: DrawRequest,
    canvas: ImagePainter,
  ): void {
    const { depth, color } = streams;
    if (overlay === "probes") {
      canvas.fill([0, 0, ...streams.size], hue(view / this.catalogue.views.length));
    } else if (overlay === "nodes") {
      this.#forEachUnit(depth, (rect, unit) => {
        const known = codings(depth.index, unit);
        const key = known === undefined ? "" : `${known.chunk} ${known.frame}`;
        canvas.map(rect, { key, bytes: known?.bytes, words: this.#codingWords });
      });
    } else if (overlay === "units") {
      this.#forEachUnit(color, (rect) => canvas.frame(rect, CELL_EDGE));
      this.#forEachUnit(depth, (rect) => canvas.frame(rect, TILE_EDGE));
    } else {
      this.#forEachUnit(depth, (rect, unit) => {
        const chunk = this.container.chunkIndex(depth.index, unit, frame);
        if (chunk < 0) {
          return;
        }
        if (overlay === "fetched") {
          canvas.fill(rect, isFresh(chunk) ? FRESH : DARK);
        } else {
          const { firstFrame, frameCount } = this.container.chunks[chunk];
          const age = (frame - firstFrame) / Math.max(1, frameCount - 1);
          canvas.fill(rect, KEYFRAME.map((part, at) => Math.round(part + (LATER[at] - part) * age)) as Color);
        }
      });
      if (overlay === "fetched") {
        this.#forEachUnit(color, (rect, unit) => {
          const chunk = this.container.chunkIndex(color.index, unit, frame);
          if (chunk >= 0 && isFresh(chunk)) {
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

/** A hue of even brightness; `turn` from 0 to 1. */
function hue(turn: number): Color {
  const part = (shift: number): number => Math.round(255 * (0.55 + 0.4 * Math.cos(2 * Math.PI * (turn - shift))));
  return [part(0), part(1 / 3), part(2 / 3)];
}

/** Texels of a rectangle by a byte for each. */
interface ByteMap {
  /** Tells maps of a rectangle apart. */
  key: string;
  /** Row by row; without them the rectangle is left as it is. */
  bytes: Uint8Array | undefined;
  /** The texels of all bytes; 0 leaves what is there. */
  words: Uint32Array;
}

/** A step of painting: a rectangle in one color, the texels along its edges, or texels by a map of it. */
interface Step {
  rect: Rect;
  isFrame: boolean;
  color: Color;
  map?: ByteMap;
}

/** Rectangles of an image, painted once their texels are asked for. */
class ImagePainter {
  readonly #steps: Step[] = [];

  constructor(readonly size: [number, number]) {}

  /** Tells whether two images look alike but for their maps. */
  get #key(): string {
    return this.#steps.map(({ rect, color, isFrame }) => [...rect, ...color, isFrame].join()).join(" ");
  }

  /** The rectangles in which this image differs from another one: all of it, or only maps of it. */
  changesTo(other: ImagePainter | undefined): Rect[] {
    if (other === undefined || other.#key !== this.#key) {
      return [[0, 0, ...this.size]];
    }
    return this.#steps.filter(({ map }, at) => map?.key !== other.#steps[at].map?.key).map(({ rect }) => rect);
  }

  fill(rect: Rect, color: Color): void {
    this.#steps.push({ rect, color, isFrame: false });
  }

  /** The texels along the edges of a rectangle. */
  frame(rect: Rect, color: Color): void {
    this.#steps.push({ rect, color, isFrame: true });
  }

  /** The texels of a rectangle by a map. */
  map(rect: Rect, map: ByteMap): void {
    this.#steps.push({ rect, color: DARK, isFrame: false, map });
  }

  /** Lets the bytes of maps go: nothing more is drawn. */
  forgetMaps(): void {
    this.#steps.forEach(({ map }) => map && (map.bytes = undefined));
  }

  /** The texels of a rectangle of the image. */
  texels(area: Rect): Uint8Array<ArrayBuffer> {
    const [x, y, width, height] = area;
    const texels = new Uint8Array(4 * width * height);
    const words = new Uint32Array(texels.buffer);
    words.fill(wordOf(DARK));
    for (const step of this.#steps) {
      const [left, top, columns, rows] = step.rect;
      const [from, to] = [Math.max(left, x), Math.min(left + columns, x + width)];
      for (let row = Math.max(top, y); row < Math.min(top + rows, y + height) && from < to; row += 1) {
        const start = (row - y) * width + from - x;
        drawRow(step, row, [from, to], words.subarray(start, start + to - from));
      }
    }
    return texels;
  }
}

/** Draws the texels of a row of a step, from one column to before another one, which are those of the image. */
function drawRow(step: Step, row: number, [from, to]: [number, number], out: Uint32Array): void {
  const [left, top, columns, rows] = step.rect;
  if (step.map !== undefined) {
    const { bytes, words } = step.map;
    const start = (row - top) * columns + from - left;
    for (let at = 0; bytes !== undefined && at < out.length; at += 1) {
      out[at] = words[bytes[start + at]] || out[at];
    }
  } else if (!step.isFrame || row === top || row === top + rows - 1) {
    out.fill(wordOf(step.color));
  } else {
    if (from === left) {
      out[0] = wordOf(step.color);
    }
    if (to === left + columns) {
      out[out.length - 1] = wordOf(step.color);
    }
  }
}

function wordOf([red, green, blue]: Color): number {
  return (red | (green << 8) | (blue << 16) | (255 << 24)) >>> 0;
}
