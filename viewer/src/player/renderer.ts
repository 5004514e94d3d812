// Draws pictures of loaded views, on the graphics device or on the processor.

import type { Container } from "../format/container.ts";
import type { Catalogue, FaceStreams } from "../views/catalogue.ts";
import type { Camera } from "../views/camera.ts";
import type { Texels } from "../views/texels.ts";
import type { UnitCodings } from "./coding_maps.ts";
import type { DeviceFamily } from "./device_units.ts";
import type { RendererName, View } from "./types.ts";
import type { DecodeContext, PixelsOf } from "./unit_source.ts";

/** What a renderer draws from, and the canvas, which nothing else has drawn to. */
export interface Scene {
  container: Container;
  catalogue: Catalogue;
  canvas: HTMLCanvasElement;
  decoding: DecodeContext;
  /** Views that are loaded at once, and their images, at most. */
  mostViews: number;
  mostImages: number;
}

/** A picture to be drawn. */
export interface DrawRequest {
  /** With a frame that there is. */
  view: View;
  /** Of one eye, or of the left and the right one. */
  cameras: readonly Camera[];
  /** Loaded views that take part, by their places in the catalogue. */
  views: readonly number[];
  /** Whether a chunk, by its place in the container, was fetched within the last second. */
  isFresh: (chunk: number) => boolean;
  /** How a unit of depth is coded, where that is known. */
  codings: (stream: number, unit: number) => UnitCodings | undefined;
}

/** Width and height of the picture of an eye. */
export function sizeOfEye({ view: { size, stereo } }: DrawRequest): [number, number] {
  return [stereo === "side-by-side" ? Math.ceil(size[0] / 2) : size[0], size[1]];
}

/** What drawing took. */
export interface DrawResult {
  /** Of the first eye, by the names of `lightfold render --stats`. */
  counters: Record<string, number>;
  /** Milliseconds of decoding on the device, and of marching. */
  decodeMs: number;
  marchMs: number;
}

export interface Renderer {
  readonly name: RendererName;
  /** Pixels of a picture at most, so that it takes a part of a second. */
  readonly mostPixels: number;
  readonly texels: Texels;
  /** Whether secondary rays are followed where a material is specular. */
  readonly hasEffects: boolean;
  /** Called where nothing more can be drawn, with a sentence. */
  onFailed: (message: string) => void;
  /** Loads a view of the catalogue, of which nothing is known. Answers the families of its streams that the device decodes; workers
   *  decode the others, whose pixels are those of `pixelsOf`. */
  load(view: number, faces: readonly FaceStreams[], pixelsOf: PixelsOf): Promise<DeviceFamily[]>;
  /** Draws on the canvas. `onShown` is called in the task in which the picture goes there. */
  draw(request: DrawRequest, onShown: () => void): Promise<DrawResult>;
  /** Milliseconds of decoding since the last picture. */
  decodeMs(): Promise<number>;
  /** The last picture as red, green, blue, alpha of linear light, row by row. */
  pixels(): Promise<{ size: [number, number]; rgba: Float32Array }>;
  close(): void;
}
