// A probe whose texels are loaded: where its units are decoded, and how their pictures come into the texels.

import type { UnitPixels } from "../decoder/types.ts";
import type { Chunk, Stream } from "../format/types.ts";
import { type ColorCoding, type FaceStreams, type ProbeStreams, streamsOf } from "../views/catalogue.ts";
import { unitsUnder } from "../views/rects.ts";
import { colorTexels } from "../views/straight.ts";
import type { DeviceFamily } from "./device_units.ts";
import type { Renderer } from "./renderer.ts";
import { type DecodeContext, unitFrame, type UnitFrame, type UnitSource, type UnitState } from "./unit_source.ts";
import { WorkerUnits } from "./worker_units.ts";

/** What loaded views share. */
export interface ViewContext {
  renderer: Renderer;
  decoding: DecodeContext;
  /** Of the film's colors. */
  coding: ColorCoding;
}

/** Units of a frame by their states. */
export type UnitCounts = Record<UnitState, number>;

/** Units that are asked for. */
export interface Asking {
  sees: (stream: Stream, unit: number) => boolean;
  /** Takes chunks that must be fetched. */
  fetch: Chunk[];
  counts: UnitCounts;
}

export class LoadedView {
  readonly #families: readonly DeviceFamily[];
  readonly #sources: ReadonlyMap<Stream, UnitSource>;
  readonly #moves: boolean;
  /** Of a probe that moves: its units, and what was asked of them. */
  #asked: { stream: Stream; source: UnitSource; unit: number; wanted: UnitFrame | undefined }[] = [];
  /** Number of the last picture that it took part in. */
  lastUsed = 0;

  private constructor(
    private readonly context: ViewContext,
    private readonly view: number,
    private readonly streams: ProbeStreams,
    decoders: { families: readonly DeviceFamily[]; sources: ReadonlyMap<Stream, UnitSource> },
  ) {
    this.#families = decoders.families;
    this.#sources = decoders.sources;
    const { container } = context.decoding;
    this.#moves = container.footage.poses.has(container.probes[streams.probe].name);
  }

  /** Loads a view of the catalogue, of which nothing is known. */
  static async load(context: ViewContext, view: number, streams: ProbeStreams): Promise<LoadedView> {
    const { renderer, decoding } = context;
    const workers = new Map<number, WorkerUnits>();
    const families = await renderer.load(view, streams.faces, (stream, unit) => workers.get(stream)?.pixels(unit));
    const sources = new Map<Stream, UnitSource>();
    for (const family of families) {
      family.decoder.streams.forEach((stream, position) => sources.set(stream, family.units(position)));
    }
    for (const stream of streams.faces.flatMap(streamsOf).filter((one) => !sources.has(one))) {
      const units = new WorkerUnits(stream, decoding);
      workers.set(stream.index, units);
      sources.set(stream, units);
    }
    return new LoadedView(context, view, streams, { families, sources });
  }

  /** Asks for a frame of the units that are seen; chunks to be fetched are added to `fetch`, and states counted. */
  ask(frame: number, { sees, fetch, counts }: Asking): void {
    this.#asked = [];
    this.#forEachUnit(frame, sees, (stream, source, unit, wanted) => {
      if (wanted !== undefined) {
        counts[source.ask(wanted, fetch)] += 1;
      }
      if (this.#moves) {
        this.#asked.push({ stream, source, unit, wanted });
      }
    });
  }

  /** The same of a frame that comes later: units go on to show what they do. */
  prepare(frame: number, { sees, fetch, counts }: Asking): void {
    this.#forEachUnit(frame, sees, (_stream, source, _unit, wanted) => {
      if (wanted !== undefined) {
        counts[source.prepare(wanted, fetch)] += 1;
      }
    });
  }

  /** Visits all units; `wanted` is the frame of those that are seen and have it. */
  #forEachUnit(
    frame: number,
    sees: Asking["sees"],
    visit: (stream: Stream, source: UnitSource, unit: number, wanted: UnitFrame | undefined) => void,
  ): void {
    const { container } = this.context.decoding;
    for (const [stream, source] of this.#sources) {
      for (let unit = 0; unit < container.unitCount(stream.index); unit += 1) {
        visit(stream, source, unit, sees(stream, unit) ? unitFrame(container, stream.index, unit, frame) : undefined);
      }
    }
  }

  /** Decodes what was asked for and is here, and sends what workers decoded. Answers the units and pixels that are new, and the
   *  units that another call brings nearer to their frame. */
  update(): { units: number; pixels: number; behind: number } {
    const { texels } = this.context.renderer;
    let [units, pixels, behind] = [0, 0, 0];
    for (const family of this.#families) {
      const decoded = family.decode();
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
        const [, , width, height] = this.context.decoding.container.unitRect(stream.index, unit);
        return sum + width * height;
      }, 0);
    }
    this.#place();
    return { units, pixels, behind };
  }

  /** Of a probe that moves only pictures of the present frame may be seen: older ones are seen from elsewhere. */
  #place(): void {
    const { texels } = this.context.renderer;
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

  /** Frees its texels and what it holds on the device. */
  unload(): void {
    this.context.renderer.texels.unload(this.view);
    this.#families.forEach((family) => family.close());
  }

  #workers(stream: Stream | undefined): WorkerUnits | undefined {
    const source = stream && this.#sources.get(stream);
    return source instanceof WorkerUnits ? source : undefined;
  }

  /** Sends what workers decoded of a face; answers the units. */
  #send({ depth, color: stream, alpha: alphaStream, material: materialStream }: FaceStreams): [Stream, number][] {
    const { texels } = this.context.renderer;
    const [color, alpha, material] = [stream, alphaStream, materialStream].map((one) => this.#workers(one));
    const tiles = this.#workers(depth)?.takeChanged() ?? [];
    const sent = tiles.map((tile): [Stream, number] => [depth, tile]);
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
    const { renderer, coding } = this.context;
    const { texels } = renderer;
    const unit = this.#pixelsOf(color, cell);
    if (alpha === undefined) {
      texels.uploadColor(color.stream.index, unit.rect, colorTexels(coding, unit, unit.rect));
      return true;
    }
    let isWhole = true;
    for (const [matte, part] of unitsUnder(alpha.stream, unit.rect)) {
      if (alpha.frame(matte) === color.frame(cell)) {
        texels.uploadColor(color.stream.index, part, colorTexels(coding, unit, part, this.#pixelsOf(alpha, matte)));
      } else {
        isWhole = false;
      }
    }
    return isWhole;
  }

  #pixelsOf(source: WorkerUnits, unit: number): UnitPixels {
    return { pixels: source.pixels(unit)!, rect: this.context.decoding.container.unitRect(source.stream.index, unit) };
  }
}
