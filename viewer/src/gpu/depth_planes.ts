// Inverse depths of a probe and their pyramids in device buffers: planes of words, one for the texels of each face and one for each level of
// its pyramid (CALF 6.2). Kernels write them from decoded tiles; textures are copied from them. Mirrors src/gpu/render/depth_planes.rs.

import type { DepthRange, Rect } from "../format/types.ts";
import type { FaceStreams } from "../views/catalogue.ts";
import { rayLength } from "../views/face.ts";
import { decoder } from "../decoder/module.ts";
import { above, pyramidSizes } from "../views/pyramid.ts";
import { bounds } from "../views/rects.ts";
import type { UnitPicture } from "./decoder.ts";
import type { Gpu, Pipeline } from "./device.ts";
import { kernel } from "./kernels.ts";
import { CONSTANTS, listOf, rowsOf } from "./layout.ts";
import type { RowValues } from "./layout.ts";

/** Alignment of rows in words: copies into textures require it. So do offsets of bindings. */
export const ROW_WORDS = 64;
/** Bits of the inverse depth of a texel that is not known, +inf. */
const UNKNOWN = 0x7f800000;
/** Bits of 1e30, which stands for an infinite inverse depth: shaders have no infinity. */
const NO_BOUND = 0x7149f2ca;
/** Words before the first plane: the topmost level of each face, one word at the number of the face, then reductions of those of a cube. */
const HEAD_WORDS = 64;
/** Words of the six tops of a cube, then of their reductions: the first of each, and how many. */
const REDUCTIONS = [
  [0, 6],
  [8, 3],
  [11, 2],
  [13, 1],
] as const;
/** The word of the greatest inverse depth of a cube, and at most 1e30. */
export const GREATEST_WORD = 13;
const CUBE_FACES = [0, 1, 2, 3, 4, 5];

/** One level of a face: its texels, or squares of them. */
export interface Plane {
  /** Its first word. */
  at: number;
  /** Words from row to row. */
  pitch: number;
  size: readonly [number, number];
}

/** Texels of a face whose inverse depths are written: those of a tile, or unknown ones. */
export interface DepthPart {
  face: number;
  /** Left, top, width and height in texels of the face, within the tile. */
  rect: Rect;
  /** Where the tile's picture lies; `undefined`: the texels become unknown. */
  picture: UnitPicture | undefined;
  /** Left and top of the tile in the face. */
  corner: readonly [number, number];
}

/** Parts of tiles of one buffer of pictures. */
export interface TileParts {
  pictures: GPUBuffer;
  parts: DepthPart[];
}

/** Kernels that write planes. */
export interface PlaneKernels {
  texels: Pipeline;
  squares: Pipeline;
}

interface FacePlanes {
  /** Texels, and the levels above them. */
  levels: Plane[];
  /** First of the inverse depths by code among the tables. */
  table: number;
  /** First of the ray lengths, row by row; `NONE` for planar depth. */
  rayLengths: number;
}

/** A dispatch with its list among the jobs. */
interface Step {
  kernel: keyof PlaneKernels;
  pictures: GPUBuffer | undefined;
  /** First word of the list, and words. */
  at: number;
  words: number;
  invocations: number;
}

/** Inverse depths by code, kept by their range. */
export class DepthTables {
  readonly #known = new Map<string, Uint32Array>();

  of(range: DepthRange): Uint32Array {
    const key = `${range.nearM} ${range.farM}`;
    const table = this.#known.get(key) ?? decoder().inverseDepths(range);
    this.#known.set(key, table);
    return table;
  }
}

/** Planes of a face and the words up to their end, where tables are added to `tables`. */
function planesOf(streams: FaceStreams, start: number, tables: TableWords): { planes: FacePlanes; end: number } {
  let at = start;
  const levels = [streams.size, ...pyramidSizes(streams.size)].map((size): Plane => {
    const plane = { at, pitch: Math.ceil(size[0] / ROW_WORDS) * ROW_WORDS, size };
    at += plane.pitch * size[1];
    return plane;
  });
  levels[levels.length - 1].at = streams.face;
  const { header, size, map } = streams;
  const table = tables.add(`${header.range.nearM} ${header.range.farM}`, () => tables.depths.of(header.range));
  const rayLengths = header.isDistance
    ? tables.add([...size, ...map.scale, ...map.center].join(), () => rayLengthsOf(streams))
    : CONSTANTS.NONE;
  return { planes: { levels, table, rayLengths }, end: at };
}

/** Distance over planar depth of all texels, as bits of floats. */
function rayLengthsOf({ size: [width, height], map }: FaceStreams): Uint32Array {
  const lengths = new Float32Array(width * height);
  for (let row = 0; row < height; row += 1) {
    for (let column = 0; column < width; column += 1) {
      lengths[row * width + column] = rayLength(map, column, row);
    }
  }
  return new Uint32Array(lengths.buffer);
}

/** Tables one behind the other, each once. */
class TableWords {
  readonly parts: Uint32Array[] = [];
  words = 0;
  readonly #firsts = new Map<string, number>();

  constructor(readonly depths: DepthTables) {}

  /** First word of the table of this name. */
  add(name: string, make: () => Uint32Array): number {
    const known = this.#firsts.get(name);
    if (known !== undefined) {
      return known;
    }
    const at = this.words;
    const made = make();
    this.parts.push(made);
    this.words += made.length;
    this.#firsts.set(name, at);
    return at;
  }

  all(): Uint32Array {
    const words = new Uint32Array(this.words);
    let at = 0;
    for (const part of this.parts) {
      words.set(part, at);
      at += part.length;
    }
    return words;
  }
}

/** The job that writes a rectangle of a level from the level below. */
function pyramidJob(
  below: Plane,
  plane: Plane,
  [left, top, width, height]: Rect,
  end: number,
): RowValues & { end: number } {
  return {
    below: below.at,
    below_pitch: below.pitch,
    below_width: below.size[0],
    below_height: below.size[1],
    left,
    top,
    width,
    output: plane.at,
    pitch: plane.pitch,
    limit: CONSTANTS.NONE,
    end: end + width * height,
  };
}

/** Lists of jobs where bindings may begin. */
class JobLists {
  readonly steps: Step[] = [];
  readonly #lists: Uint32Array[] = [];
  #words = 0;

  add(kernel: keyof PlaneKernels, struct: string, jobs: (RowValues & { end: number })[], pictures?: GPUBuffer): void {
    const invocations = jobs.at(-1)?.end ?? 0;
    if (invocations > 0) {
      const list = listOf([invocations, jobs.length], rowsOf(struct, jobs));
      this.steps.push({ kernel, pictures, at: this.#words, words: list.length, invocations });
      this.#lists.push(list);
      this.#words += Math.ceil(list.length / ROW_WORDS) * ROW_WORDS;
    }
  }

  all(): Uint32Array {
    const words = new Uint32Array(this.#words);
    this.steps.forEach(({ at }, number) => words.set(this.#lists[number], at));
    return words;
  }
}

/** The planes of a probe. */
export class DepthPlanes {
  /** All planes, behind the head. */
  readonly planes: GPUBuffer;
  /** Whether there is {@link GREATEST_WORD}: a face in every direction. */
  readonly hasGreatest: boolean;
  readonly #tables: GPUBuffer;
  readonly #faces = new Map<number, FacePlanes>();
  #jobs: GPUBuffer;

  /** Planes of faces without known texels. */
  constructor(
    private readonly gpu: Gpu,
    private readonly kernels: PlaneKernels,
    faces: readonly FaceStreams[],
    depths: DepthTables,
  ) {
    const tables = new TableWords(depths);
    let words = HEAD_WORDS;
    for (const streams of faces) {
      const { planes, end } = planesOf(streams, words, tables);
      this.#faces.set(streams.face, planes);
      words = end;
    }
    gpu.check("planes", words);
    gpu.check("tables", tables.words);
    const start = new Uint32Array(words).fill(UNKNOWN);
    start[GREATEST_WORD] = NO_BOUND;
    this.planes = gpu.filled("planes", start);
    this.#tables = gpu.filled("tables", tables.all());
    this.#jobs = gpu.buffer("jobs", 0);
    this.hasGreatest = this.#faces.size === CUBE_FACES.length && CUBE_FACES.every((face) => this.#faces.has(face));
  }

  get bytes(): number {
    return this.planes.size + this.#tables.size + this.#jobs.size;
  }

  /** The texels of a face, and the levels of its pyramid. */
  levels(face: number): readonly Plane[] {
    return this.#faces.get(face)?.levels ?? [];
  }

  /** Writes inverse depths, and the pyramids above them; answers the rectangle that changed of each face. */
  write(tiles: readonly TileParts[]): ReadonlyMap<number, Rect> {
    const lists = new JobLists();
    const changed = new Map<number, Rect>();
    for (const { pictures, parts } of tiles) {
      let end = 0;
      const jobs = parts.map((part) => {
        end += part.rect[2] * part.rect[3];
        changed.set(part.face, bounds(changed.get(part.face), part.rect));
        return { ...this.#depthJob(part), end };
      });
      lists.add("texels", "DepthJob", jobs, pictures);
    }
    this.#listSquares(changed, lists);
    if (lists.steps.length > 0) {
      this.#run(lists);
    }
    return changed;
  }

  /** Frees its buffers. */
  destroy(): void {
    [this.planes, this.#tables, this.#jobs].forEach((buffer) => this.gpu.release(buffer));
  }

  #depthJob({ face, rect: [left, top, width], picture, corner }: DepthPart): RowValues {
    const { levels, table, rayLengths } = this.#faces.get(face)!;
    const [{ at, pitch, size }] = levels;
    const place = { width, output: at + top * pitch + left, pitch };
    if (picture === undefined) {
      return { ...place, picture: CONSTANTS.NONE, table: UNKNOWN, ray_length: CONSTANTS.NONE };
    }
    return {
      ...place,
      picture: picture.picture,
      stride: picture.stride,
      left: left - corner[0],
      top: top - corner[1],
      table,
      ray_length: rayLengths === CONSTANTS.NONE ? rayLengths : rayLengths + top * size[0] + left,
      ray_length_pitch: size[0],
    };
  }

  /** Lists the jobs of each level, from the texels up, and of the reductions. */
  #listSquares(changed: ReadonlyMap<number, Rect>, lists: JobLists): void {
    const mostLevels = Math.max(0, ...[...changed.keys()].map((face) => this.levels(face).length));
    for (let level = 1; level < mostLevels; level += 1) {
      const jobs: (RowValues & { end: number })[] = [];
      for (const [face, rect] of changed) {
        const [below, plane] = this.levels(face).slice(level - 1, level + 1);
        if (plane !== undefined) {
          jobs.push(pyramidJob(below, plane, above(rect, level - 1), jobs.at(-1)?.end ?? 0));
        }
      }
      lists.add("squares", "PyramidJob", jobs);
    }
    if (this.hasGreatest && changed.size > 0) {
      const rows = REDUCTIONS.map(([at, count]): Plane => ({ at, pitch: count, size: [count, 1] }));
      for (let number = 1; number < rows.length; number += 1) {
        const job = pyramidJob(rows[number - 1], rows[number], [0, 0, rows[number].size[0], 1], 0);
        lists.add("squares", "PyramidJob", [{ ...job, limit: NO_BOUND }]);
      }
    }
  }

  #run(lists: JobLists): void {
    const words = lists.all();
    if (this.#jobs.size < 4 * words.length) {
      this.gpu.release(this.#jobs);
      this.#jobs = this.gpu.buffer("jobs", words.length);
    }
    this.gpu.write(this.#jobs, 0, words);
    this.gpu.submit((encoder) => {
      const pass = encoder.beginComputePass({ label: "planes" });
      for (const step of lists.steps) {
        const pipeline = this.kernels[step.kernel];
        const list = { buffer: this.#jobs, offset: 4 * step.at, size: 4 * step.words };
        const named: Record<string, GPUBufferBinding> = {
          jobs: list,
          tables: { buffer: this.#tables },
          planes: { buffer: this.planes },
          ...(step.pictures && { pictures: { buffer: step.pictures } }),
        };
        pass.setPipeline(pipeline.pipeline);
        pass.setBindGroup(
          0,
          this.gpu.bind(pipeline, (name) => named[name]),
        );
        const groups = Math.ceil(step.invocations / kernel(step.kernel).workgroup);
        const columns = Math.min(groups, CONSTANTS.MAX_GROUPS);
        pass.dispatchWorkgroups(columns, Math.ceil(groups / columns));
      }
      pass.end();
    });
  }
}
