// Chunks of nodes: packed nodes, the intermediate form, and plain blocks (formats/depth.md 9, 11 and 12), checked and brought into the
// runtime form (depth.md 10), which is decoded here and on devices.

import type { DepthDomain, Rect } from "../../format/types.ts";
import { Fields } from "../fields.ts";
import { codeIn, DOMAIN_LOG } from "./domain.ts";
import { decodeNode } from "./functions.ts";
import { type Grid, levelOf, LEVELS, MARKER, NODE_WORDS, type Place, placeOf } from "./nodes.ts";
import { checkStart, readRecordTable } from "./record_table.ts";
import { type Nodes, readNodes, readTreeRecord } from "./storage.ts";

/** Words of the header of a frame in the runtime form: `NODE_HEADER_WORDS` of shaders/kernels.json. */
const HEADER_WORDS = 12;
/** Frames start, and coefficients, at multiples of so many words. */
const ALIGN = 4;

/** A frame in the runtime form. */
export interface NodeFrame {
  frame: number;
  /** Its first word. */
  at: number;
  /** Pixels of the unit that its nodes cover. */
  pixels: number;
  /** Leaves that its nodes are worth: 4^level each. */
  leaves: number;
  /** Of the intermediate form: functions of coarser places, which are not decoded. */
  coarse?: Nodes;
}

/** A checked chunk. Nodes lie in the unit, those of a record do not overlap, and the first record covers the unit. */
export class NodeChunk {
  readonly frames: readonly NodeFrame[];
  /** The runtime form (depth.md 10). */
  readonly words: Uint32Array;
  readonly #grid: Grid;
  readonly #code: (value: number) => number;

  private constructor(grid: Grid, domain: DepthDomain, runtime: Runtime) {
    this.#grid = grid;
    this.#code = codeIn(domain);
    this.frames = runtime.frames;
    this.words = runtime.finish();
  }

  /** Packed nodes (depth.md 9) of `frames` frames. */
  static ofNodes(payload: Uint8Array, grid: Grid, frames: number, domain: DepthDomain): NodeChunk {
    const fields = new Fields(payload, "depth.md 9");
    return NodeChunk.#ofRecords(fields, grid, frames, domain, (frame) => {
      const coverage = fields.u8();
      if (coverage > 1 || (coverage === 1 && frame === 0)) {
        throw fields.error(`The record of frame ${frame} has coverage ${coverage}, which it cannot have`);
      }
      return readNodes(grid, coverage === 1, fields);
    });
  }

  /** The intermediate form (depth.md 11) of `frames` frames. */
  static ofTree(payload: Uint8Array, grid: Grid, frames: number, domain: DepthDomain): NodeChunk {
    const fields = new Fields(payload, "depth.md 11");
    return NodeChunk.#ofRecords(fields, grid, frames, domain, (frame) => {
      const { leaves, coarse } = readTreeRecord(grid, fields);
      if (frame === 0 && leaves.places.length !== grid.leaves) {
        throw fields.error("The first record of a chunk does not hold all leaves");
      }
      return { ...leaves, coarse };
    });
  }

  static #ofRecords(
    fields: Fields,
    grid: Grid,
    frames: number,
    domain: DepthDomain,
    read: (frame: number) => Nodes & { coarse?: Nodes },
  ): NodeChunk {
    const runtime = new Runtime(grid);
    for (const row of readRecordTable(fields, frames)) {
      checkStart(fields, row);
      runtime.push(row.frame, read(row.frame));
    }
    fields.finish();
    return new NodeChunk(grid, domain, runtime);
  }

  /** Plain blocks (depth.md 12) of `frames` frames. */
  static ofBlocks(payload: Uint8Array, grid: Grid, frames: number): NodeChunk {
    const fields = new Fields(payload, "depth.md 12");
    const columns = Math.ceil(grid.width / 8);
    const blocks = columns * Math.ceil(grid.height / 8);
    if (payload.length !== blocks * 4 * NODE_WORDS * frames) {
      throw fields.error(`A payload of ${payload.length} bytes is no ${frames} frames of ${blocks} blocks`);
    }
    const places = Array.from({ length: blocks }, (_, at) => placeOf(1, at % columns, Math.floor(at / columns)));
    const words = new Uint32Array(NODE_WORDS * blocks);
    const runtime = new Runtime(grid);
    for (let frame = 0; frame < frames; frame += 1) {
      for (let word = 0; word < words.length; word += 1) {
        words[word] = fields.u32();
        if (word % NODE_WORDS === NODE_WORDS - 1 && words[word] === MARKER) {
          throw fields.error("A BC4w block ends like another function");
        }
      }
      runtime.push(frame, { places, words });
    }
    return new NodeChunk(grid, { kind: DOMAIN_LOG, base: 0, scale: 0 }, runtime);
  }

  /** Decodes the nodes of a frame into a picture of the unit. */
  apply(frame: NodeFrame, picture: Uint16Array): void {
    const stride = this.#grid.width;
    const target = { picture, start: 0, stride, width: 0, height: 0 };
    this.forEachNode(frame, (place, coefficients, [left, top, width, height]) => {
      target.start = top * stride + left;
      target.width = width;
      target.height = height;
      decodeNode(levelOf(place), this.words, coefficients, this.#code, target);
    });
  }

  /** Calls `visit` with the nodes of a frame, level by level: their places, the words at which their coefficients start, and the
   *  rectangles of the unit that they cover. */
  forEachNode({ at }: NodeFrame, visit: (place: Place, coefficients: number, rect: Rect) => void): void {
    const { words } = this;
    const count = words[at];
    const places = at + HEADER_WORDS;
    const coefficients = aligned(places + Math.ceil(count / 2));
    let node = 0;
    for (let level = 0; level < LEVELS; level += 1) {
      for (const end = node + words[at + 1 + level]; node < end; node += 1) {
        const corner = words[places + (node >> 1)] >>> (16 * (node & 1));
        const place = placeOf(level, corner & 0xff, (corner >>> 8) & 0xff);
        visit(place, coefficients + NODE_WORDS * node, this.#grid.rectOf(place));
      }
    }
  }
}

function aligned(words: number): number {
  return Math.ceil(words / ALIGN) * ALIGN;
}

/** Writes the runtime form of a chunk. */
class Runtime {
  readonly frames: NodeFrame[] = [];
  readonly #grid: Grid;
  #words = new Uint32Array(256);
  #length = 0;

  constructor(grid: Grid) {
    this.#grid = grid;
  }

  /** Appends the nodes of a frame, level by level. */
  push(frame: number, { places, words, coarse }: Nodes & { coarse?: Nodes }): void {
    const at = this.#length;
    const firstPlace = at + HEADER_WORDS;
    const firstNode = aligned(firstPlace + Math.ceil(places.length / 2));
    this.#reserve(firstNode + NODE_WORDS * places.length);
    const out = this.#words;
    out[at] = places.length;
    let node = 0;
    let [pixels, leaves] = [0, 0];
    for (let level = 0; level < LEVELS; level += 1) {
      const before = node;
      places.forEach((place, from) => {
        if (levelOf(place) === level) {
          out[firstPlace + (node >> 1)] |= (place & 0xffff) << (16 * (node & 1));
          for (let word = 0; word < NODE_WORDS; word += 1) {
            out[firstNode + NODE_WORDS * node + word] = words[NODE_WORDS * from + word];
          }
          pixels += this.#grid.pixelsOf(place);
          node += 1;
        }
      });
      out[at + 1 + level] = node - before;
      leaves += (node - before) * 4 ** level;
    }
    this.frames.push({ frame, at, pixels, leaves, ...(coarse && { coarse }) });
  }

  #reserve(length: number): void {
    if (length > this.#words.length) {
      const larger = new Uint32Array(Math.max(length, 2 * this.#words.length));
      larger.set(this.#words.subarray(0, this.#length));
      this.#words = larger;
    }
    this.#length = length;
  }

  finish(): Uint32Array {
    return this.#words.slice(0, this.#length);
  }
}
