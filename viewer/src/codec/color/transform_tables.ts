// The tables of the transform codec as the device has them: those of the format, then the table sets of streams
// (src/gpu/transform_tables.rs; formats/color.md 6, entropy.md).

import type { ColorHeader } from "../../format/types.ts";
import { colorModel, type EntropyTables, tableSets } from "../entropy.ts";
import { type Distributions, SYMBOLS } from "../rans.ts";
import { basis, LENGTHS, lengthIndex } from "./transform/basis.ts";
import { SUM_CLASSES } from "./transform/levels.ts";
import { OCTAVE, OFFSET_SETS, ROOTS } from "./transform/steps.ts";
import { MAX_FRAMES } from "./transform/payload.ts";
import { SCANS } from "./transform/scan.ts";

/** Points of the largest basis in space, which is no length of a block. */
const MAX_POINTS = 32;
/** Distributions of a table set (formats/color.md 6.7). */
const DISTRIBUTIONS = 118;

/** Words of a table set: first slot of each symbol, and from bit 16 the slot behind its last. */
export const SET_WORDS = DISTRIBUTIONS * SYMBOLS;

/** The tables of streams of one family in one buffer. Other codecs' headers are left out; without any other, there are no words. Streams
 *  of equal tables share them. `firstSets` has the first word of the sets of each stream. */
export function transformTables(headers: ColorHeader[]): { words: Uint32Array; firstSets: number[] } {
  const streams = headers.flatMap(({ coding }) => (coding.name === "transform" ? [coding.tables] : []));
  if (streams.length === 0) {
    return { words: new Uint32Array(), firstSets: [] };
  }
  const words = tablesOfFormat();
  const known: { tables: EntropyTables; first: number }[] = [];
  const firstSets = streams.map((tables) => {
    const same = known.find((other) => isEqual(other.tables, tables));
    if (same !== undefined) {
      return same.first;
    }
    const first = words.length;
    known.push({ tables, first });
    tableSets(tables).forEach((set) => pushSet(words, set));
    return first;
  });
  return { words: Uint32Array.from(words), firstSets };
}

function isEqual(one: EntropyTables, other: EntropyTables): boolean {
  return (
    one.own.length === other.own.length &&
    one.own.every(({ starts }, set) => starts.every((start, at) => start === other.own[set].starts[at]))
  );
}

function pushSet(words: number[], { starts }: Distributions): void {
  for (let distribution = 0; distribution < DISTRIBUTIONS; distribution++) {
    const first = distribution * (SYMBOLS + 1);
    for (let symbol = 0; symbol < SYMBOLS; symbol++) {
      words.push(starts[first + symbol] | (starts[first + symbol + 1] << 16));
    }
  }
}

/** Words of the tables of the format: heads of bases by their points, classes of sums, scans, distributions of contexts, bases. */
function tablesOfFormat(): number[] {
  const scans = SCANS.flatMap(({ places, classes }) => Array.from(places, (place, at) => place | (classes[at] << 16)));
  const distributions = Array.from(colorModel().distributionOf, (distribution) => distribution * SYMBOLS);
  const heads = Array<number>(MAX_FRAMES + 1).fill(LENGTHS.length);
  const steps = [...OCTAVE, ...ROOTS, ...OFFSET_SETS.flatMap((set) => [...set])];
  const first = heads.length + SUM_CLASSES.length + scans.length + distributions.length + steps.length;
  const bases: number[] = [];
  for (const points of [...LENGTHS, MAX_POINTS]) {
    heads[points] = lengthIndex(points) | ((first + bases.length) << 8);
    for (let at = 0; at < points * points; at++) {
      bases.push(basis(points, Math.floor(at / points), at % points) >>> 0);
    }
  }
  return [...heads, ...SUM_CLASSES, ...scans, ...distributions, ...steps, ...bases];
}
