// Entropy models: contexts of a codec's symbols, the distributions that they share, and table sets, the built-in ones of formats/ and
// those of codec headers (formats/color.md 6.6 and 6.7, formats/depth.md 15.7 and 15.8).

import colorText from "../../../formats/color-tables.txt";
import depthText from "../../../formats/depth-tables.txt";
import { FormatError } from "../format/types.ts";
import { type Distributions, distributionsOf, SLOTS, SYMBOLS } from "./rans.ts";

/** Most table sets that a codec header brings along. */
const MAX_OWN_SETS = 8;

/** `depth`: predictive depth and alpha (depth.md 15). `color`: the transform codec (color.md 6). */
export type ModelName = "depth" | "color";

/** Symbols of one kind. */
interface Family {
  /** Number of its first context, behind those of the families before. */
  firstContext: number;
  contexts: number;
  /** Values of a symbol. */
  alphabet: number;
  firstDistribution: number;
  distributions: number;
}

/** Names of the families of a model, in the order of its tables. */
export interface FamilyNames {
  depth: "frame" | "mode" | "smallMode" | "change" | "pixel" | "escape" | "candidate";
  color:
    | ("node" | "planes" | "coded" | "last" | "lastBits" | "levels" | "paletteSize" | "paletteColor")
    | ("row" | "pixel" | "laterFrame" | "laterRow" | "laterPixel");
}

/** Contexts and distributions of a codec. */
export interface Model<Name extends ModelName> {
  /** First context of each family. */
  readonly firstContext: Readonly<Record<FamilyNames[Name], number>>;
  /** Distribution of each context. */
  readonly distributionOf: Uint8Array;
  /** Values of the symbols of each distribution, 2 to 16. */
  readonly alphabets: Uint8Array;
  readonly builtIn: readonly Distributions[];
}

/** The table sets that payloads of a stream name: the built-in ones of the model, then these. Plain data, which can be sent to a worker. */
export interface EntropyTables {
  model: ModelName;
  own: Distributions[];
}

/** Name, contexts, values of a symbol, distributions. */
type FamilyRow<Family> = readonly [Family, number, number, number];

interface Source<Name extends ModelName> {
  families: readonly FamilyRow<FamilyNames[Name]>[];
  sets: number;
  text: string;
}

const DEPTH: Source<"depth"> = {
  families: [
    ["frame", 2, 2, 2],
    ["mode", 363, 10, 40],
    ["smallMode", 32, 7, 16],
    ["change", 12, 15, 12],
    ["pixel", 810, 12, 96],
    ["escape", 36, 16, 20],
    ["candidate", 3, 16, 3],
  ],
  sets: 9,
  text: depthText,
};

const COLOR: Source<"color"> = {
  families: [
    ["node", 40, 4, 8],
    ["planes", 324, 16, 12],
    ["coded", 96, 2, 8],
    ["last", 384, 11, 12],
    ["lastBits", 22, 4, 3],
    ["levels", 1296, 16, 32],
    ["paletteSize", 4, 16, 4],
    ["paletteColor", 1, 16, 1],
    ["row", 2, 2, 2],
    ["pixel", 16, 3, 16],
    ["laterFrame", 2, 2, 2],
    ["laterRow", 2, 2, 2],
    ["laterPixel", 16, 4, 16],
  ],
  sets: 10,
  text: colorText,
};

const known: { depth?: Model<"depth">; color?: Model<"color"> } = {};

/** The model of predictive depth, read from depth-tables.txt at the first call (depth.md 15.8). */
export function depthModel(): Model<"depth"> {
  return (known.depth ??= read(DEPTH));
}

/** The model of the transform codec, read from color-tables.txt at the first call (color.md 6.7). */
export function colorModel(): Model<"color"> {
  return (known.color ??= read(COLOR));
}

function modelOf(name: ModelName): Model<"depth"> | Model<"color"> {
  return name === "depth" ? depthModel() : colorModel();
}

function read<Name extends ModelName>(source: Source<Name>): Model<Name> {
  const numbers = source.text.replaceAll(/#.*/g, "").trim().split(/\s+/).map(Number);
  let at = 0;
  const next = (): number => {
    const value = numbers[at];
    if (value === undefined || !Number.isInteger(value)) {
      throw new Error("a file of entropy tables breaks its format");
    }
    at += 1;
    return value;
  };
  const families = familiesOf(source.families);
  const distributionOf = families.flatMap((family) =>
    Array.from({ length: family.contexts }, () => family.firstDistribution + next()),
  );
  const alphabets = families.flatMap((family) => Array<number>(family.distributions).fill(family.alphabet));
  const builtIn = Array.from({ length: source.sets }, () => setOf(alphabets, () => next(), true));
  if (at !== numbers.length) {
    throw new Error("a file of entropy tables has more numbers than its format says");
  }
  const first = source.families.map(([name], row) => [name, families[row].firstContext]);
  const firstContext = Object.fromEntries(first) as Record<FamilyNames[Name], number>;
  return {
    firstContext,
    distributionOf: Uint8Array.from(distributionOf),
    alphabets: Uint8Array.from(alphabets),
    builtIn,
  };
}

function familiesOf(rows: readonly FamilyRow<string>[]): Family[] {
  let firstContext = 0;
  let firstDistribution = 0;
  return rows.map(([, contexts, alphabet, distributions]) => {
    const family = { firstContext, contexts, alphabet, firstDistribution, distributions };
    firstContext += contexts;
    firstDistribution += distributions;
    return family;
  });
}

/** Distributions of frequencies in their order; with `isWhole` those of last symbols are among them, and are otherwise what is left. */
function setOf(alphabets: ArrayLike<number>, frequency: () => number, isWhole: boolean): Distributions {
  const starts = new Uint16Array(alphabets.length * (SYMBOLS + 1)).fill(SLOTS);
  for (let at = 0; at < alphabets.length; at += 1) {
    const first = at * (SYMBOLS + 1);
    starts[first] = 0;
    let sum = 0;
    for (let symbol = 1; symbol < alphabets[at]; symbol += 1) {
      sum += frequency();
      if (sum > SLOTS) {
        throw new FormatError(`The frequencies of distribution ${at} sum to more than ${SLOTS} (entropy.md 4).`);
      }
      starts[first + symbol] = sum;
    }
    if (isWhole && sum + frequency() !== SLOTS) {
      throw new Error(`the frequencies of distribution ${at} do not sum to ${SLOTS}`);
    }
  }
  return distributionsOf(starts);
}

/** Reads the own table sets of a codec header (entropy.md 4): `varint` gives its next number (container.md 1). `count` is 0 to 8, else a
 *  FormatError. */
export function readTables(model: ModelName, count: number, varint: () => number): EntropyTables {
  if (count > MAX_OWN_SETS) {
    const section = model === "depth" ? "depth.md 3" : "color.md 2";
    throw new FormatError(`A codec header has ${count} table sets, at most ${MAX_OWN_SETS} are legal (${section}).`);
  }
  const { alphabets } = modelOf(model);
  return { model, own: Array.from({ length: count }, () => setOf(alphabets, varint, false)) };
}

/** The built-in sets alone. */
export function builtInTables(model: ModelName): EntropyTables {
  return { model, own: [] };
}

/** A table set by the number that payloads name it with, `undefined` where the stream has none of this number. */
export function tableSet(tables: EntropyTables, number: number): Distributions | undefined {
  const { builtIn } = modelOf(tables.model);
  return number < builtIn.length ? builtIn[number] : tables.own[number - builtIn.length];
}

/** All table sets in the order of their numbers, for tables of a device (src/gpu/transform_tables.rs). */
export function tableSets(tables: EntropyTables): readonly Distributions[] {
  return [...modelOf(tables.model).builtIn, ...tables.own];
}
