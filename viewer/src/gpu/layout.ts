// Structs and constants that the host shares with WGSL: those of shaders/kernels.json. All members are 32-bit words.

import table from "../../../shaders/kernels.json";

/** Constants of the kernel table by name. */
export const CONSTANTS = table.constants;

/** Words before the rows of a list: of items, their number and 0; of jobs, the sum of their work and their number. */
export const LIST_HEAD_WORDS = 2;

type Scalar = "u32" | "i32" | "f32";

interface Member {
  scalar: Scalar;
  /** Words from the start of the row. */
  offset: number;
  words: number;
}

interface Layout {
  members: ReadonlyMap<string, Member>;
  words: number;
}

/** Scalar, words and alignment in words of the types of members. */
const TYPES: Readonly<Record<string, [scalar: Scalar, words: number, alignment: number]>> = {
  u32: ["u32", 1, 1],
  i32: ["i32", 1, 1],
  f32: ["f32", 1, 1],
  "vec2<f32>": ["f32", 2, 2],
  "vec3<f32>": ["f32", 3, 4],
  "array<u32, 8>": ["u32", 8, 1],
};

function layoutOf(members: readonly string[]): Layout {
  const found = new Map<string, Member>();
  let [end, largest] = [0, 1];
  for (const member of members) {
    const [name = "", type = ""] = member.split(": ");
    const known = TYPES[type];
    if (known === undefined) {
      throw new Error(`shaders/kernels.json: ${type} is no type of a member`);
    }
    const [scalar, words, alignment] = known;
    const offset = Math.ceil(end / alignment) * alignment;
    found.set(name, { scalar, offset, words });
    end = offset + words;
    largest = Math.max(largest, alignment);
  }
  return { members: found, words: Math.ceil(end / largest) * largest };
}

const LAYOUTS: ReadonlyMap<string, Layout> = new Map(table.structs.map((row) => [row.name, layoutOf(row.members)]));

function layout(struct: string): Layout {
  const found = LAYOUTS.get(struct);
  if (found === undefined) {
    throw new Error(`shaders/kernels.json has no struct ${struct}`);
  }
  return found;
}

function member(struct: string, name: string): Member {
  const found = layout(struct).members.get(name);
  if (found === undefined) {
    throw new Error(`shaders/kernels.json: ${struct} has no member ${name}`);
  }
  return found;
}

/** Words of a row of a struct, as the stride of an array of them. */
export function rowWords(struct: string): number {
  return layout(struct).words;
}

/** Word at which a member starts in a row of its struct. */
export function memberOffset(struct: string, name: string): number {
  return member(struct, name).offset;
}

/** Values of members by name: a number, or as many as a vector or an array has. Those that are left out keep their words. */
export type RowValues = Readonly<Record<string, number | readonly number[]>>;

/** Writes members of a row that starts at word `at`: integers modulo 2^32, floats as the bits of single ones. */
export function putRow(words: Uint32Array, at: number, struct: string, values: RowValues): void {
  for (const [name, value] of Object.entries(values)) {
    const { scalar, offset, words: count } = member(struct, name);
    const parts = typeof value === "number" ? [value] : value;
    if (parts.length !== count) {
      throw new Error(`${struct}.${name} has ${count} words and not ${parts.length}`);
    }
    if (scalar === "f32") {
      new Float32Array(words.buffer, words.byteOffset, words.length).set(parts, at + offset);
    } else {
      words.set(parts, at + offset);
    }
  }
}

/** Rows of a struct, one behind the other. */
export function rowsOf(struct: string, rows: readonly RowValues[]): Uint32Array {
  const pitch = rowWords(struct);
  const words = new Uint32Array(rows.length * pitch);
  rows.forEach((row, number) => putRow(words, number * pitch, struct, row));
  return words;
}

/** A list of rows behind its head. */
export function listOf(head: readonly [number, number], rows: Uint32Array): Uint32Array {
  const words = new Uint32Array(LIST_HEAD_WORDS + rows.length);
  words.set(head);
  words.set(rows, LIST_HEAD_WORDS);
  return words;
}
