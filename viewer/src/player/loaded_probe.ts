// A probe on the device: its decoders, its planes of depths, and its images in the textures.

import type { Chunk, Rect, Stream } from "../format/types.ts";
import { FamilyDecoder } from "../gpu/decoder.ts";
import type { Gpu } from "../gpu/device.ts";
import { familyOf } from "../gpu/family.ts";
import { texelMap } from "../render/camera.ts";
import { ProbePlanes, ROW_WORDS, type TilePart } from "../render/planes.ts";
import type { SceneFace } from "../render/scene.ts";
import type { ImageTextures } from "../render/textures.ts";
import type { Seen } from "../render/visible.ts";
import type { FaceStreams, ProbeStreams } from "./catalogue.ts";
import { DeviceFamily, DeviceUnits } from "./device_units.ts";
import type { DeviceTimer } from "./timer.ts";
import { alphaTexels, opaqueTexels, type Straight, straightHalf, type UnitPixels } from "./texel_colors.ts";
import { type Desk, unitFrame, type UnitSource, unitsUnder, type UnitState } from "./unit_source.ts";
import { WorkerUnits } from "./worker_units.ts";

/** A face, where its units are decoded, and its tile of the textures. */
interface LoadedFace {
  streams: FaceStreams;
  tile: number;
  depth: DeviceUnits;
  color: DeviceUnits | WorkerUnits;
  alpha: WorkerUnits | undefined;
  material: WorkerUnits | undefined;
  scene: SceneFace;
}

/** What a probe needs of the device. */
export interface Stage {
  gpu: Gpu;
  desk: Desk;
  textures: ImageTextures;
  /** Of 8-bit codes. */
  straight: Straight;
}

/** Units of a frame by their states. */
export type UnitCounts = Record<UnitState, number>;

/** A unit whose picture is new. */
interface Changed {
  face: LoadedFace;
  unit: number;
}

/** Whether the device decodes a color stream for rendering: 8-bit cells of opaque images. Workers decode the others as fast. */
function isOfDevice({ color, alpha }: FaceStreams): boolean {
  const { header } = color;
  return header.kind === "color" && !header.isHalf && header.coding.name === "cells" && alpha === undefined;
}

export class LoadedProbe {
  readonly planes: ProbePlanes;
  readonly #stage: Stage;
  readonly #families: DeviceFamily[];
  readonly #faces: LoadedFace[];
  /** Units of color, alpha and material that had a picture when depths were written, by their streams. */
  readonly #had = new Map<UnitSource, Set<number>>();
  lastUsed = 0;

  private constructor(stage: Stage, planes: ProbePlanes, families: DeviceFamily[], faces: LoadedFace[]) {
    this.#stage = stage;
    this.planes = planes;
    this.#families = families;
    this.#faces = faces;
  }

  /** Takes tiles of the textures for its faces: there must be as many free ones. */
  static async load(
    stage: Stage,
    { faces }: ProbeStreams,
    intrinsics: [number, number, number, number],
  ): Promise<LoadedProbe> {
    const { gpu, desk, textures } = stage;
    const onDevice = faces.flatMap((face) => [face.depth, ...(isOfDevice(face) ? [face.color] : [])]);
    const byKernel = new Map<string, Stream[]>();
    for (const stream of onDevice) {
      const { kernel } = familyOf(stream.header);
      byKernel.set(kernel, [...(byKernel.get(kernel) ?? []), stream]);
    }
    const maps = faces.map((one) => texelMap(one.face, one.size, intrinsics));
    const planeFaces = faces.map(({ face, size, header }, at) => ({ face, size, header, map: maps[at] }));
    const [planes, ...decoders] = await Promise.all([
      ProbePlanes.create(gpu, planeFaces),
      ...[...byKernel.values()].map((streams) => FamilyDecoder.create(gpu, streams, ROW_WORDS)),
    ]);
    const families = decoders.map((decoder) => new DeviceFamily(decoder, desk));
    const units = new Map<Stream, DeviceUnits>();
    for (const family of families) {
      family.decoder.streams.forEach((stream, position) => units.set(stream, family.units(position)));
    }
    const workers = (stream: Stream | undefined) => stream && new WorkerUnits(stream, desk);
    const loaded = faces.map((streams, at): LoadedFace => {
      const tile = textures.take();
      const { face, size, alpha, material } = streams;
      return {
        streams,
        tile,
        depth: units.get(streams.depth)!,
        color: units.get(streams.color) ?? new WorkerUnits(streams.color, desk),
        alpha: workers(alpha),
        material: workers(material),
        scene: {
          face,
          size,
          map: maps[at],
          origin: textures.origin(tile),
          levels: planes.levels(face).length - 1,
          hasAlpha: alpha !== undefined,
          hasMaterial: material !== undefined,
        },
      };
    });
    return new LoadedProbe(stage, planes, families, loaded);
  }

  /** Rows of its images. */
  get faces(): SceneFace[] {
    return this.#faces.map(({ scene }) => scene);
  }

  /** The tile of the textures of each face, and its streams. */
  get tiles(): { tile: number; streams: FaceStreams }[] {
    return this.#faces.map(({ tile, streams }) => ({ tile, streams }));
  }

  /** Asks for a frame of the units that are seen; chunks to be fetched are added to `fetch`, and states counted. */
  ask(frame: number, seen: (stream: Stream) => Seen, fetch: Chunk[], counts: UnitCounts): void {
    const { container } = this.#stage.desk;
    for (const { streams, depth, color, alpha, material } of this.#faces) {
      const sources: [Stream | undefined, UnitSource | undefined][] = [
        [streams.depth, depth],
        [streams.color, color],
        [streams.alpha, alpha],
        [streams.material, material],
      ];
      for (const [stream, source] of sources) {
        if (stream === undefined || source === undefined) {
          continue;
        }
        seen(stream).forEach((isSeen, unit) => {
          const wanted = isSeen ? unitFrame(container, stream.index, unit, frame) : undefined;
          if (wanted !== undefined) {
            counts[source.ask(wanted, fetch)] += 1;
          }
        });
      }
    }
  }

  /** Decodes what was asked for and is here, and brings the textures to it. Answers the units and pixels that were decoded. */
  update(timer: DeviceTimer): { units: number; pixels: number } {
    const depths: Changed[] = [];
    const copies: Changed[] = [];
    let [units, pixels] = [0, 0];
    for (const family of this.#families) {
      const decoded = family.decode(timer.pass("decode"));
      pixels += decoded.pixels;
      for (const { stream, unit } of decoded.changed) {
        const index = family.decoder.streams[stream].index;
        const face = this.#faces.find(({ streams }) => streams.depth.index === index || streams.color.index === index)!;
        (face.streams.depth.index === index ? depths : copies).push({ face, unit });
      }
    }
    units += depths.length + copies.length;
    this.#copyColors(copies);
    for (const face of this.#faces) {
      units += this.#writeColors(face);
    }
    this.#writeDepths([...depths, ...this.#turned()]);
    return { units, pixels };
  }

  /** Frees what it holds on the device. */
  unload(): void {
    this.#families.forEach((family) => family.close());
    this.planes.destroy();
    this.#faces.forEach(({ tile }) => this.#stage.textures.giveBack(tile));
  }

  #rect(stream: Stream, unit: number): Rect {
    return this.#stage.desk.container.unitRect(stream.index, unit);
  }

  /** Copies cells that the device decoded into the textures. */
  #copyColors(cells: readonly Changed[]): void {
    if (cells.length === 0) {
      return;
    }
    this.#stage.gpu.submit((encoder) => {
      for (const { face, unit } of cells) {
        const { family, position } = face.color as DeviceUnits;
        const { picture, stride } = family.decoder.unit(position, unit);
        const words = { buffer: family.decoder.pictures, at: picture, pitch: stride };
        this.#stage.textures.copyColors(encoder, words, face.tile, this.#rect(face.streams.color, unit));
      }
    });
  }

  /** Writes colors and materials that workers decoded into the textures; answers the units. */
  #writeColors({ streams, tile, color, alpha, material }: LoadedFace): number {
    const { textures } = this.#stage;
    const of = (source: WorkerUnits, unit: number): UnitPixels => ({
      pixels: source.pixels(unit)!,
      rect: this.#rect(source.stream, unit),
    });
    let units = 0;
    for (const unit of material?.changed ?? []) {
      const one = of(material!, unit);
      textures.write("materials", tile, one.rect, opaqueTexels(one, one.rect));
      units += 1;
    }
    material?.changed.clear();
    if (!(color instanceof WorkerUnits)) {
      return units;
    }
    if (alpha === undefined) {
      for (const unit of color.changed) {
        const one = of(color, unit);
        textures.write("colors", tile, one.rect, opaqueTexels(one, one.rect));
      }
    } else {
      for (const [unit, part] of this.#sharedParts(streams, color, alpha)) {
        const [under] = unitsUnder(alpha.stream, part).next().value!;
        const straight =
          streams.color.header.kind === "color" && streams.color.header.isHalf ? straightHalf : this.#stage.straight;
        textures.write("colors", tile, part, alphaTexels(of(color, unit), of(alpha, under), part, straight));
      }
    }
    units += color.changed.size + (alpha?.changed.size ?? 0);
    color.changed.clear();
    alpha?.changed.clear();
    return units;
  }

  /** Parts of color cells, each under one unit of alpha, of which either is new and both have pictures. */
  *#sharedParts({ color: stream }: FaceStreams, color: WorkerUnits, alpha: WorkerUnits): Generator<[number, Rect]> {
    const done = new Set<string>();
    const under = [...color.changed].flatMap((unit) => [...unitsUnder(alpha.stream, this.#rect(stream, unit))]);
    const rects = [
      ...under.map(([, rect]) => rect),
      ...[...alpha.changed].map((unit) => this.#rect(alpha.stream, unit)),
    ];
    for (const rect of rects) {
      for (const [unit, part] of unitsUnder(stream, rect)) {
        const [[at]] = unitsUnder(alpha.stream, part);
        if (color.hasPicture(unit) && alpha.hasPicture(at) && !done.has(part.join())) {
          done.add(part.join());
          yield [unit, part];
        }
      }
    }
  }

  /** Tiles over which a unit of another kind has its first picture. */
  #turned(): Changed[] {
    const turned: Changed[] = [];
    for (const face of this.#faces) {
      for (const source of [face.color, face.alpha, face.material]) {
        if (source === undefined) {
          continue;
        }
        const had = this.#had.get(source) ?? new Set();
        this.#had.set(source, had);
        const { stream } = source;
        const count = this.#stage.desk.container.unitCount(stream.index);
        for (let unit = 0; unit < count && had.size < count; unit += 1) {
          if (!had.has(unit) && source.hasPicture(unit)) {
            had.add(unit);
            const tiles = unitsUnder(face.streams.depth, this.#rect(stream, unit));
            turned.push(...[...tiles].map(([tile]) => ({ face, unit: tile })));
          }
        }
      }
    }
    return turned;
  }

  /** Writes the depths of tiles where all kinds have pictures, and their pyramids. */
  #writeDepths(tiles: readonly Changed[]): void {
    const parts = new Map<GPUBuffer, TilePart[]>();
    const done = new Set<string>();
    for (const { face, unit } of tiles) {
      const key = `${face.tile} ${unit}`;
      if (done.has(key) || !face.depth.hasPicture(unit)) {
        continue;
      }
      done.add(key);
      const { family, position } = face.depth;
      const { pictures } = family.decoder;
      const list = parts.get(pictures) ?? [];
      parts.set(pictures, list);
      const rect = this.#rect(face.streams.depth, unit);
      const { picture, stride } = family.decoder.unit(position, unit);
      for (const [known, isKnown] of this.#parts(face, rect)) {
        list.push({ face: face.streams.face, rect: known, isKnown, corner: [rect[0], rect[1]], picture, stride });
      }
    }
    if (parts.size === 0) {
      return;
    }
    const changed = this.planes.write(parts);
    this.#stage.gpu.submit((encoder) => {
      for (const { streams, tile } of this.#faces) {
        const rect = changed.get(streams.face);
        if (rect !== undefined) {
          this.#stage.textures.copyDepths(encoder, this.planes.buffer, this.planes.levels(streams.face), tile, rect);
        }
      }
    });
  }

  /** A rectangle in parts over which all kinds but depth have pictures, or do not. */
  #parts({ color, alpha, material }: LoadedFace, rect: Rect): [Rect, boolean][] {
    let parts: [Rect, boolean][] = [[rect, true]];
    for (const source of [color, alpha, material]) {
      if (source !== undefined) {
        parts = parts.flatMap(([part, isKnown]) =>
          [...unitsUnder(source.stream, part)].map(([unit, under]): [Rect, boolean] => [
            under,
            isKnown && source.hasPicture(unit),
          ]),
        );
      }
    }
    return parts;
  }
}
