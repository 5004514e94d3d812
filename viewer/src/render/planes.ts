// Inverse depths of a probe and their pyramids in buffers of the device (CALF 6.2): planes of words, one for the texels of each face and
// one for each level of its pyramid. Kernels write them from decoded tiles; textures are copied from them. Mirrors
// src/gpu/render/depth_planes.rs.

import type { DepthHeader, Rect } from "../format/types.ts";
import type { Gpu, Pipeline } from "../gpu/device.ts";
import { CONSTANTS, listOf, type RowValues, rowsOf } from "../gpu/layout.ts";
import { VIEW_FACE, rayLengthFactor, type TexelMap } from "./camera.ts";

/** Alignment of rows in words: copies into textures want it. */
export const ROW_WORDS = 64;
/** Words before the first plane: the topmost level of each face, then the reductions of those of a cube. */
const HEAD_WORDS = 64;
/** Words of the six tops of a cube, then of their reductions: the first of each, and how many. */
const REDUCTIONS: readonly [number, number][] = [
  [0, 6],
  [8, 3],
  [11, 2],
  [13, 1],
];
/** The word of the greatest inverse depth of a cube. */
export const GREATEST_WORD = 13;
/** Bits of +inf: a texel that is not known. */
export const UNKNOWN_BITS = 0x7f800000;
/** Bits of 1e30, which stands for an infinite inverse depth in shaders. */
export const NO_BOUND_BITS = new Uint32Array(Float32Array.of(1e30).buffer)[0];
const CODES = 1 << 16;
const FAR_CODE = 65534;
const FACES_OF_CUBE = 6;

/** Words of an image in the buffer: from its first one, row by row. */
export interface Plane {
  at: number;
  pitch: number;
  width: number;
  height: number;
}

/** A face whose depths are kept. */
export interface PlaneFace {
  face: number;
  size: [number, number];
  map: TexelMap;
  header: DepthHeader;
}

/** A part of a decoded tile that is to be written, or made unknown. */
export interface TilePart {
  face: number;
  rect: Rect;
  isKnown: boolean;
  /** Left and top of the tile in the face. */
  corner: [number, number];
  /** Where the tile lies in its buffer of pictures: first word, and words of a row. */
  picture: number;
  stride: number;
}

interface FacePlanes {
  /** Texels, then the levels above them. */
  levels: Plane[];
  /** First word of the inverse depths by code. */
  table: number;
  /** First word of the ray lengths, row by row, or NONE. */
  rayLengths: number;
}

/** One dispatch, and its list of jobs. */
interface Step {
  pictures: GPUBuffer | undefined;
  list: Uint32Array;
  invocations: number;
}

const tablesOfRanges = new Map<string, Uint32Array>();

/** Inverse depths by code, in 1/m, as the bits of single floats. */
function inverseDepths({ range: { nearM, farM } }: DepthHeader): Uint32Array {
  const key = `${nearM} ${farM}`;
  const known = tablesOfRanges.get(key);
  if (known !== undefined) {
    return known;
  }
  const inverse = new Float32Array(CODES);
  const logSpan = Math.log(farM / nearM);
  for (let code = 0; code <= FAR_CODE; code += 1) {
    inverse[code] = 1 / Math.fround(nearM * Math.exp((logSpan * code) / FAR_CODE));
  }
  inverse[0] = 1 / nearM;
  inverse[FAR_CODE] = 1 / farM;
  const bits = new Uint32Array(inverse.buffer);
  tablesOfRanges.set(key, bits);
  return bits;
}

function rayLengths({ size: [width, height], map }: PlaneFace): Uint32Array {
  const lengths = new Float32Array(width * height);
  for (let row = 0; row < height; row += 1) {
    for (let column = 0; column < width; column += 1) {
      lengths[row * width + column] = rayLengthFactor(map, column, row);
    }
  }
  return new Uint32Array(lengths.buffer);
}

function roundUp(value: number, multiple: number): number {
  return Math.ceil(value / multiple) * multiple;
}

/** Columns and rows of the texels of an image, and of each level above them. */
export function planeSizes(size: [number, number]): [number, number][] {
  const sizes: [number, number][] = [size];
  let [width, height] = size;
  do {
    [width, height] = [Math.ceil(width / 2), Math.ceil(height / 2)];
    sizes.push([width, height]);
  } while (width > 1 || height > 1);
  return sizes;
}

/** Bytes of the planes of an image. */
export function planeBytes(size: [number, number]): number {
  return planeSizes(size).reduce((sum, [width, height]) => sum + 4 * roundUp(width, ROW_WORDS) * height, 0);
}

/** The part of a level of a pyramid, counted from 0, that covers a rectangle of texels. */
export function above([left, top, width, height]: Rect, level: number): Rect {
  const span = (begin: number, count: number): [number, number] => {
    const first = begin >>> (level + 1);
    return [first, ((begin + count - 1) >>> (level + 1)) - first + 1];
  };
  const [[x, columns], [y, rows]] = [span(left, width), span(top, height)];
  return [x, y, columns, rows];
}

/** The smallest rectangle around two. */
export function bounds(one: Rect | undefined, other: Rect): Rect {
  if (one === undefined) {
    return other;
  }
  const [left, top] = [Math.min(one[0], other[0]), Math.min(one[1], other[1])];
  const right = Math.max(one[0] + one[2], other[0] + other[2]);
  const bottom = Math.max(one[1] + one[3], other[1] + other[3]);
  return [left, top, right - left, bottom - top];
}

/** The depths of a probe. */
export class ProbePlanes {
  readonly buffer: GPUBuffer;
  readonly #gpu: Gpu;
  readonly #tables: GPUBuffer;
  readonly #faces = new Map<number, FacePlanes>();
  readonly #pipelines: { texels: Pipeline; squares: Pipeline };

  private constructor(gpu: Gpu, faces: readonly PlaneFace[], pipelines: { texels: Pipeline; squares: Pipeline }) {
    this.#gpu = gpu;
    this.#pipelines = pipelines;
    const tables: Uint32Array[] = [];
    let tableWords = 0;
    const put = (words: Uint32Array): number => {
      tables.push(words);
      tableWords += words.length;
      return tableWords - words.length;
    };
    const starts = new Map<Uint32Array, number>();
    let at = HEAD_WORDS;
    for (const one of faces) {
      const levels = planeSizes(one.size).map(([width, height]): Plane => {
        const pitch = roundUp(width, ROW_WORDS);
        at += pitch * height;
        return { at: at - pitch * height, pitch, width, height };
      });
      levels[levels.length - 1].at = one.face;
      const inverse = inverseDepths(one.header);
      const table = starts.get(inverse) ?? put(inverse);
      starts.set(inverse, table);
      const lengths = one.header.isDistance ? put(rayLengths(one)) : CONSTANTS.NONE;
      this.#faces.set(one.face, { levels, table, rayLengths: lengths });
    }
    this.buffer = gpu.buffer("planes", at);
    const start = new Uint32Array(at).fill(UNKNOWN_BITS);
    start[GREATEST_WORD] = NO_BOUND_BITS;
    gpu.write(this.buffer, 0, start);
    const all = new Uint32Array(tableWords);
    let end = 0;
    for (const words of tables) {
      all.set(words, end);
      end += words.length;
    }
    this.#tables = gpu.filled("tables", all);
  }

  /** Planes of faces without known texels. */
  static async create(gpu: Gpu, faces: readonly PlaneFace[]): Promise<ProbePlanes> {
    const [texels, squares] = await Promise.all([gpu.pipeline("texels"), gpu.pipeline("squares")]);
    return new ProbePlanes(gpu, faces, { texels, squares });
  }

  /** The texels of a face, and the levels of its pyramid. */
  levels(face: number): readonly Plane[] {
    return this.#faces.get(face)?.levels ?? [];
  }

  /** Whether there is {@link GREATEST_WORD}: a face in every direction. */
  get hasGreatest(): boolean {
    return this.#faces.size === FACES_OF_CUBE && !this.#faces.has(VIEW_FACE);
  }

  destroy(): void {
    this.#gpu.release(this.buffer);
    this.#gpu.release(this.#tables);
  }

  /** Writes parts of tiles, by the buffers of their pictures, and then the pyramids; answers what changed in each face. */
  write(tiles: ReadonlyMap<GPUBuffer, readonly TilePart[]>): Map<number, Rect> {
    const changed = new Map<number, Rect>();
    const texels: Step[] = [];
    for (const [pictures, parts] of tiles) {
      let end = 0;
      const jobs = parts.map((part) => {
        end += part.rect[2] * part.rect[3];
        changed.set(part.face, bounds(changed.get(part.face), part.rect));
        return { ...this.#depthJob(part), end };
      });
      texels.push({ pictures, list: listOf([end, jobs.length], rowsOf("DepthJob", jobs)), invocations: end });
    }
    this.#run(this.#pipelines.texels, texels);
    this.#run(this.#pipelines.squares, this.#pyramidSteps(changed));
    return changed;
  }

  #depthJob({ face, rect: [left, top, width], isKnown, corner, picture, stride }: TilePart): RowValues {
    const { levels, table, rayLengths: lengths } = this.#faces.get(face)!;
    const [plane] = levels;
    const output = plane.at + top * plane.pitch + left;
    if (!isKnown) {
      return {
        picture: CONSTANTS.NONE,
        table: UNKNOWN_BITS,
        ray_length: CONSTANTS.NONE,
        width,
        output,
        pitch: plane.pitch,
      };
    }
    const rayLength = lengths === CONSTANTS.NONE ? lengths : lengths + top * plane.width + left;
    return {
      picture,
      stride,
      left: left - corner[0],
      top: top - corner[1],
      width,
      table,
      ray_length: rayLength,
      ray_length_pitch: plane.width,
      output,
      pitch: plane.pitch,
    };
  }

  /** A dispatch for each level, from the texels up, and for the reductions. */
  #pyramidSteps(changed: ReadonlyMap<number, Rect>): Step[] {
    const steps: Step[] = [];
    const most = Math.max(0, ...[...changed.keys()].map((face) => this.levels(face).length));
    for (let level = 1; level < most; level += 1) {
      let end = 0;
      const jobs: RowValues[] = [];
      for (const [face, rect] of changed) {
        const levels = this.levels(face);
        if (level < levels.length) {
          const part = above(rect, level - 1);
          end += part[2] * part[3];
          jobs.push({ ...pyramidJob(levels[level - 1], levels[level], part), limit: CONSTANTS.NONE, end });
        }
      }
      steps.push({
        pictures: undefined,
        list: listOf([end, jobs.length], rowsOf("PyramidJob", jobs)),
        invocations: end,
      });
    }
    if (this.hasGreatest && changed.size > 0) {
      for (let at = 1; at < REDUCTIONS.length; at += 1) {
        const [below, plane] = [REDUCTIONS[at - 1], REDUCTIONS[at]].map(([first, count]): Plane => ({
          at: first,
          pitch: count,
          width: count,
          height: 1,
        }));
        const job = { ...pyramidJob(below, plane, [0, 0, plane.width, 1]), limit: NO_BOUND_BITS, end: plane.width };
        const list = listOf([plane.width, 1], rowsOf("PyramidJob", [job]));
        steps.push({ pictures: undefined, list, invocations: plane.width });
      }
    }
    return steps;
  }

  #run({ pipeline, ...kernel }: Pipeline, steps: readonly Step[]): void {
    if (steps.length === 0) {
      return;
    }
    const lists = steps.map(({ list }) => this.#gpu.filled("jobs", list));
    this.#gpu.submit((encoder) => {
      const pass = encoder.beginComputePass();
      pass.setPipeline(pipeline);
      steps.forEach(({ pictures, invocations }, at) => {
        const named: Readonly<Record<string, GPUBuffer>> = {
          tables: this.#tables,
          jobs: lists[at],
          planes: this.buffer,
        };
        const group = this.#gpu.bind({ pipeline, ...kernel }, (name) => ({ buffer: named[name] ?? pictures }));
        pass.setBindGroup(0, group);
        const groups = Math.max(1, Math.ceil(invocations / CONSTANTS.WORKGROUP));
        const x = Math.min(groups, CONSTANTS.MAX_GROUPS);
        pass.dispatchWorkgroups(x, Math.ceil(groups / x));
      });
      pass.end();
    });
    lists.forEach((list) => this.#gpu.release(list));
  }
}

function pyramidJob(below: Plane, plane: Plane, [left, top, width]: Rect): RowValues {
  return {
    below: below.at,
    below_pitch: below.pitch,
    below_width: below.width,
    below_height: below.height,
    left,
    top,
    width,
    output: plane.at,
    pitch: plane.pitch,
  };
}
