// Colors of the overlay of nodes, those of the program's coding maps (src/cli/report/coding_map/tints.rs), and what they stand for.

/** Kinds of coding; their places in this list are their numbers in a map (src/wasm/coding_map.rs). */
export const CODINGS = [
  "none",
  // Functions of nodes.
  "raw",
  "biquadratic",
  "platelet",
  "bc4w",
  // Boxes.
  "values",
  "one value",
  "blocks",
  // Blocks of predictive coding.
  "background",
  "plane",
  "changed plane",
  "quarters",
  "pixels",
] as const;
export type Coding = (typeof CODINGS)[number];

/** Bits of a byte of a map that are the number of a kind. */
export const CODING_BITS = 0x3f;
/** Bit of pixels that an earlier frame of the chunk wrote. */
export const KEPT = 0x40;
/** Bit of pixels beside which, on the left or above, another node, box or block begins or the unit ends. */
export const BORDER = 0x80;

/** Red, green and blue, 0 to 255. */
export type Color = [number, number, number];

/** Codings of one color, and their names for the viewer. */
export interface LegendRow {
  color: Color;
  codings: Coding[];
  name: string;
}

export const CODING_LEGEND: readonly LegendRow[] = [
  { color: [213, 94, 0], codings: ["raw", "values", "pixels"], name: "Raw codes; pixel by pixel" },
  { color: [240, 228, 66], codings: ["biquadratic", "plane"], name: "Biquadratic; plane carried on" },
  { color: [0, 114, 178], codings: ["platelet", "changed plane"], name: "Platelet; plane with a change" },
  { color: [204, 121, 167], codings: ["bc4w", "blocks", "quarters"], name: "BC4w or BC5 block; quarters" },
  { color: [0, 158, 115], codings: ["one value", "background"], name: "One value; background" },
];

/** Parts of the light of a color that are left where an earlier frame wrote a pixel, and along borders. */
const KEPT_SHARE = 0.45;
const BORDER_SHARE = 0.3;

/** The colors of all bytes of a coding map; `undefined` for pixels without a coding. */
export function codingColors(): (Color | undefined)[] {
  return Array.from({ length: 256 }, (_, byte) => {
    const coding = CODINGS[byte & CODING_BITS];
    const row = CODING_LEGEND.find(({ codings }) => codings.includes(coding));
    const share = ((byte & KEPT) !== 0 ? KEPT_SHARE : 1) * ((byte & BORDER) !== 0 ? BORDER_SHARE : 1);
    return row?.color.map((part) => Math.round(part * share)) as Color | undefined;
  });
}
