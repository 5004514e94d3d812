// How shaders number tone maps and layouts of two eyes: gpu/present.wgsl and glb/shaders.ts, and src/wasm.

export type StereoLayout = "mono" | "side-by-side" | "anaglyph";
export type ToneMapName = "none" | "reinhard" | "filmic";

export const TONE_MAP_NUMBERS: Readonly<Record<ToneMapName, number>> = { none: 0, reinhard: 1, filmic: 2 };
export const STEREO_NUMBERS: Readonly<Record<StereoLayout, number>> = { mono: 0, "side-by-side": 1, anaglyph: 2 };
