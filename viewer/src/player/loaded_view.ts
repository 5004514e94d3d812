// A probe on the device: where its units are decoded, and how their pictures come into the textures.

import type { Chunk, Stream } from "../format/types.ts";
import { FamilyDecoder } from "../gpu/decoder.ts";
import { ROW_WORDS } from "../gpu/depth_planes.ts";
import type { Gpu } from "../gpu/device.ts";
import { familyOf } from "../gpu/family.ts";
import type { DevicePictures, LightFieldTexels } from "../gpu/texels.ts";
import { type FaceStreams, type ProbeStreams, streamsOf } from "../views/catalogue.ts";
import { unitsUnder } from "../views/rects.ts";
import type { ColorTexels, UnitPixels } from "../views/straight.ts";
import { DeviceFamily } from "./device_units.ts";
import type { DeviceTimer } from "./timer.ts";
import { type Desk, unitFrame, type UnitFrame, type UnitSource, type UnitState } from "./unit_source.ts";
import { WorkerUnits } from "./worker_units.ts";

/** What a probe needs of the device. */
export interface Stage {
  gpu: Gpu;
  desk: Desk;
  texels: LightFieldTexels;
  colors: ColorTexels;
  /** Words of chunks that each family of streams keeps on the device. */
  keptWords: number;
}

/** Units of a frame by their states. */
export type UnitCounts = Record<UnitState, number>;

/** Whether the device decodes the colors of a face for rendering: 8-bit cells of opaque images. Workers decode others as fast. */
function isOfDevice({ color: { header }, alpha }: FaceStreams): boolean {
  return header.kind === "color" && !header.isHalf && header.coding.name === "cells" && alpha === undefined;
}

/** A probe whose texels are on the device. */
export class LoadedView {
  readonly #families: DeviceFamily[];
  readonly #sources = new Map<Stream, UnitSource>();
  readonly #moves: boolean;
  /** Of a probe that moves: its units, and what was asked of them. */
  #asked: { stream: Stream; source: UnitSource; unit: number; wanted: UnitFrame | undefined }[] = [];
  /** Number of the last picture that it took part in. */
  lastUsed = 0;

  private constructor(
    private readonly stage: Stage,
    private readonly view: number,
    private readonly streams: ProbeStreams,
    families: DeviceFamily[],
  ) {
    this.#families = families;
    const { container } = stage.desk;
    this.#moves = container.footage.poses.has(container.probes[streams.probe].name);
    const pictures = new Map<number, DevicePictures>();
    for (const family of families) {
      family.decoder.streams.forEach((stream, position) => {
        pictures.set(stream.index, { decoder: family.decoder, position });
        this.#sources.set(stream, family.units(position));
      });
    }
    for (const stream of streams.faces.flatMap(streamsOf)) {
      if (!this.#sources.has(stream)) {
        this.#sources.set(stream, new WorkerUnits(stream, stage.desk));
      }
    }
    stage.texels.load(view, pictures);
  }

  /** Loads a view of the catalogue, of which nothing is known. */
  static async load(stage: Stage, view: number): Promise<LoadedView> {
    const streams = stage.texels.catalogue.views[view];
    const onDevice = streams.faces.flatMap((face) => [face.depth, ...(isOfDevice(face) ? [face.color] : [])]);
    const families = new Map<string, Stream[]>();
    for (const stream of onDevice) {
      const { kernel } = familyOf(stream.header);
      families.set(kernel, [...(families.get(kernel) ?? []), stream]);
    }
    const made = [...families.values()].map((family) => FamilyDecoder.create(stage.gpu, family, ROW_WORDS));
    const decoders = await Promise.all(made);
    return new LoadedView(
      stage,
      view,
      streams,
      decoders.map((decoder) => new DeviceFamily(decoder, stage.desk, stage.keptWords)),
    );
  }

  /** Asks for a frame of the units that are seen; chunks to be fetched are added to `fetch`, and states counted. */
  ask(frame: number, sees: (stream: Stream, unit: number) => boolean, fetch: Chunk[], counts: UnitCounts): void {
    const { container } = this.stage.desk;
    this.#asked = [];
    for (const [stream, source] of this.#sources) {
      for (let unit = 0; unit < container.unitCount(stream.index); unit += 1) {
        const wanted = sees(stream, unit) ? unitFrame(container, stream.index, unit, frame) : undefined;
        if (wanted !== undefined) {
          counts[source.ask(wanted, fetch)] += 1;
        }
        if (this.#moves) {
          this.#asked.push({ stream, source, unit, wanted });
        }
      }
    }
  }

  /** Decodes the next frames of a film that plays, as far as workers do it and their chunks are here. */
  askAhead(frame: number, sees: (stream: Stream, unit: number) => boolean): void {
    const { container } = this.stage.desk;
    for (const [stream, source] of this.#sources) {
      for (let unit = 0; source instanceof WorkerUnits && unit < container.unitCount(stream.index); unit += 1) {
        const wanted = sees(stream, unit) ? unitFrame(container, stream.index, unit, frame) : undefined;
        if (wanted !== undefined) {
          source.askAhead(wanted);
        }
      }
    }
  }

  /** Decodes what was asked for and is here, and sends what workers decoded. Answers the units and pixels that are new, and the
   *  units that another call brings nearer to their frame. */
  update(timer: DeviceTimer): { units: number; pixels: number; behind: number } {
    const { texels } = this.stage;
    let [units, pixels, behind] = [0, 0, 0];
    for (const family of this.#families) {
      const decoded = family.decode(() => timer.pass("decode"));
      pixels += decoded.pixels;
      behind += decoded.behind;
      units += decoded.changed.length;
      for (const { stream, unit } of decoded.changed) {
        texels.written(family.decoder.streams[stream].index, unit);
      }
    }
    for (const face of this.streams.faces) {
      const sent = this.#send(face);
      units += sent.length;
      pixels += sent.reduce((sum, [stream, unit]) => {
        const [, , width, height] = this.stage.desk.container.unitRect(stream.index, unit);
        return sum + width * height;
      }, 0);
    }
    this.#place();
    return { units, pixels, behind };
  }

  /** Of a probe that moves only pictures of the present frame may be seen: older ones are seen from elsewhere. */
  #place(): void {
    const { texels } = this.stage;
    for (const { stream, source, unit, wanted } of this.#asked) {
      const isRight = wanted !== undefined && source.shows(wanted);
      if (isRight && !texels.isKnown(stream.index, unit)) {
        texels.written(stream.index, unit);
      } else if (!isRight && source.hasPicture(unit)) {
        texels.forget(stream.index, unit);
      }
    }
    this.#asked = [];
  }

  /** Frees what it holds on the device. */
  unload(): void {
    this.stage.texels.unload(this.view);
    this.#families.forEach((family) => family.close());
  }

  #workers(stream: Stream | undefined): WorkerUnits | undefined {
    const source = stream && this.#sources.get(stream);
    return source instanceof WorkerUnits ? source : undefined;
  }

  /** Sends what workers decoded of a face; answers the units. */
  #send({ color: stream, alpha: alphaStream, material: materialStream }: FaceStreams): [Stream, number][] {
    const { texels } = this.stage;
    const [color, alpha, material] = [stream, alphaStream, materialStream].map((one) => this.#workers(one));
    const sent: [Stream, number][] = [];
    for (const unit of material?.takeChanged() ?? []) {
      texels.uploadMaterial(material!.stream.index, unit, material!.pixels(unit) as Uint8Array);
      sent.push([material!.stream, unit]);
    }
    const cells = color?.takeChanged() ?? [];
    const mattes = alpha?.takeChanged() ?? [];
    const under = mattes.flatMap((matte) => [...unitsUnder(stream, this.#pixelsOf(alpha!, matte).rect)]);
    for (const cell of new Set([...cells, ...under.map(([unit]) => unit)])) {
      if (color !== undefined && color.hasPicture(cell) && this.#sendColor(color, cell, alpha)) {
        sent.push([stream, cell]);
      }
    }
    sent.push(...mattes.map((matte): [Stream, number] => [alpha!.stream, matte]));
    // Only once the colors below them were sent.
    sent.forEach(([one, unit]) => texels.written(one.index, unit));
    return sent;
  }

  /** Sends a cell, or those parts of it over which alpha shows the same frame; answers whether that was all. */
  #sendColor(color: WorkerUnits, cell: number, alpha: WorkerUnits | undefined): boolean {
    const { texels, colors } = this.stage;
    const unit = this.#pixelsOf(color, cell);
    if (alpha === undefined) {
      texels.uploadColor(color.stream.index, unit.rect, colors.of(unit, unit.rect));
      return true;
    }
    let isWhole = true;
    for (const [matte, part] of unitsUnder(alpha.stream, unit.rect)) {
      if (alpha.frame(matte) === color.frame(cell)) {
        texels.uploadColor(color.stream.index, part, colors.of(unit, part, this.#pixelsOf(alpha, matte)));
      } else {
        isWhole = false;
      }
    }
    return isWhole;
  }

  #pixelsOf(source: WorkerUnits, unit: number): UnitPixels {
    return { pixels: source.pixels(unit)!, rect: this.stage.desk.container.unitRect(source.stream.index, unit) };
  }
}
