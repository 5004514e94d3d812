// A container that is decoded and rendered on the processor, without workers and a page.

import { decoder, decoderModule } from "../src/decoder/module.ts";
import type { Pixels, StoredChunk, UnitPixels } from "../src/decoder/types.ts";
import { Field } from "../src/cpu/field.ts";
import type { PictureRequest, Rendered } from "../src/cpu/messages.ts";
import { Container } from "../src/format/container.ts";
import type { Stream } from "../src/format/types.ts";
import { WorkerTexels } from "../src/player/worker_texels.ts";
import { cameraOf } from "../src/views/camera.ts";
import { type Catalogue, catalogueOf, type FaceStreams, hasFrame, streamsOf } from "../src/views/catalogue.ts";
import { selectViews } from "../src/views/selection.ts";
import { unitsUnder } from "../src/views/rects.ts";
import { colorTexels } from "../src/views/straight.ts";
import type { Shot } from "./films.ts";
import { MemorySource } from "../src/format/memory.ts";
import "./use_decoder.ts";

/** One frame of a film in memory. */
export class MemoryFilm {
  readonly texels: WorkerTexels;
  readonly #field: Field;
  readonly #pixels = new Map<string, Pixels>();

  private constructor(
    readonly container: Container,
    readonly catalogue: Catalogue,
    private readonly source: MemorySource,
    readonly frame: number,
  ) {
    this.#field = new Field(new WebAssembly.Instance(decoderModule()), catalogue.coding);
    this.texels = new WorkerTexels(catalogue, (order) => this.#field.run(structuredClone(order)));
  }

  /** Decodes all of a frame. */
  static async open(bytes: Uint8Array, frame: number): Promise<MemoryFilm> {
    const source = new MemorySource(bytes);
    const container = await Container.open(source);
    const film = new MemoryFilm(container, catalogueOf(container), source, frame);
    for (const view of film.views) {
      film.texels.load(view, (stream, tile) => film.#pixels.get(`${stream} ${tile}`) as Uint16Array);
      for (const face of film.catalogue.views[view].faces) {
        await film.#load(face);
      }
    }
    film.texels.update();
    return film;
  }

  /** Views that have the frame. */
  get views(): number[] {
    const { views } = this.catalogue;
    return views.flatMap((streams, view) => (hasFrame(streams, this.frame) ? [view] : []));
  }

  /** The units of all streams of a face. */
  *unitsOf(face: FaceStreams): Generator<[Stream, number]> {
    for (const stream of streamsOf(face)) {
      for (let unit = 0; unit < this.container.unitCount(stream.index); unit += 1) {
        yield [stream, unit];
      }
    }
  }

  render(
    { pose, size, fovDeg, steps }: Omit<Shot, "frame">,
    options: Partial<PictureRequest> = {},
    views = this.views,
  ): Rendered {
    const camera = cameraOf(pose, fovDeg, size[0] / size[1]);
    const placed = views.map((view) => {
      const { position, orientation } = this.container.probeAt(this.catalogue.views[view].probe, this.frame);
      return { view, position, orientation };
    });
    // Sums of colors depend on the order of views.
    const order = selectViews(placed, pose.eye, views.length);
    placed.sort((one, other) => order.indexOf(one.view) - order.indexOf(other.view));
    const request = { camera, size, steps, showsOverlay: false, marksHoles: false, ...options };
    return this.#field.run({ kind: "render", request, views: placed })!;
  }

  async #load(face: FaceStreams): Promise<void> {
    const { color, alpha } = face;
    for (const [stream, unit] of this.unitsOf(face)) {
      this.#pixels.set(`${stream.index} ${unit}`, await this.#decode(stream, unit));
    }
    const { material } = face;
    for (let unit = 0; material !== undefined && unit < this.container.unitCount(material.index); unit += 1) {
      this.texels.uploadMaterial(material.index, unit, this.#unitPixels(material, unit).pixels as Uint8Array);
    }
    for (let cell = 0; cell < this.container.unitCount(color.index); cell += 1) {
      const of = this.#unitPixels(color, cell);
      for (const [matte, part] of alpha === undefined ? [[-1, of.rect] as const] : unitsUnder(alpha, of.rect)) {
        const under = alpha === undefined ? undefined : this.#unitPixels(alpha, matte);
        this.texels.uploadColor(color.index, part, colorTexels(this.catalogue.coding, of, part, under));
      }
    }
    for (const [stream, unit] of this.unitsOf(face)) {
      this.texels.written(stream.index, unit);
    }
  }

  #unitPixels(stream: Stream, unit: number): UnitPixels {
    const pixels = this.#pixels.get(`${stream.index} ${unit}`)!;
    return { pixels, rect: this.container.unitRect(stream.index, unit) };
  }

  async #decode(stream: Stream, unit: number): Promise<Pixels> {
    const at = this.container.chunkIndex(stream.index, unit, this.frame);
    const stored = async (number: number): Promise<StoredChunk> => {
      const chunk = this.container.chunks[number];
      const bytes = await this.source.read(chunk.offset, chunk.storedBytes);
      return { chunk, stored: bytes, area: this.container.areaOf(number) };
    };
    const chunk = await stored(at);
    const next = chunk.area.place === "last" ? undefined : await stored(at + 1);
    const opened = decoder().openStream(stream, stream.headerBytes);
    const frames = decoder().openChunk(opened, chunk);
    const pixels = frames.frame(this.frame - chunk.chunk.firstFrame, () => next).slice();
    frames.close();
    decoder().closeStream(opened);
    return pixels;
  }
}
