// Contexts of symbols (color.md 6.6), and offsets of the format's tables in `tables` (src/kernels/transform_tables.rs). Mirrors
// src/codec/color/transform/contexts.rs. Needs `tables`.

// First context of each symbol family.
const CONTEXT_NODE: u32 = 0u;
const CONTEXT_PLANES: u32 = 40u;
const CONTEXT_CODED: u32 = 364u;
const CONTEXT_LAST: u32 = 460u;
const CONTEXT_LAST_BITS: u32 = 844u;
const CONTEXT_LEVELS: u32 = 866u;
const CONTEXT_PALETTE_SIZE: u32 = 2162u;
const CONTEXT_PALETTE_COLOR: u32 = 2166u;
const CONTEXT_ROW: u32 = 2167u;
const CONTEXT_PIXEL: u32 = 2169u;
const CONTEXT_LATER_FRAME: u32 = 2185u;
const CONTEXT_LATER_ROW: u32 = 2187u;
const CONTEXT_LATER_PIXEL: u32 = 2189u;

// First word of each table. Words 0 to 96 are an index of the bases: word n, for a basis of n points, holds the length index in
// 8 bits, and the first word of the basis from bit 8. The classes of sums of magnitudes follow.
const SUM_CLASSES_AT: u32 = 97u;
// Scan order of each block size: the position, and its class from bit 16.
const SCAN_AT: u32 = 109u;
// First word of each context's distribution, within a table set.
const CLUSTERS_AT: u32 = 1469u;
// Tables for steps (color.md 6.3): one octave; the inverse roots of the lengths; the frequency offsets of each set, luma then
// chroma.
const OCTAVE_AT: u32 = 3674u;
const ROOTS_AT: u32 = 3690u;
const OFFSETS_AT: u32 = 3699u;

// Returns the index of a number of frames among the transform lengths; the number of lengths if it is none of them.
fn length_index(frames: u32) -> u32 {
    return tables[frames] & 255u;
}

// Returns the first word of a basis. Each row is one basis function.
fn basis_at(points: u32) -> u32 {
    return tables[points] >> 8u;
}

fn scan_at(level: u32) -> u32 {
    // Blocks of 4, 8, 16 and 32 pixels on a side.
    return SCAN_AT + ((16u << (2u * level)) - 16u) / 3u;
}

fn node_context(level: u32, frames: u32) -> u32 {
    return CONTEXT_NODE + 10u * level + length_index(frames);
}

fn planes_context(channel: u32, level: u32, length: u32, before: u32) -> u32 {
    return CONTEXT_PLANES + 3u * (9u * (4u * channel + level) + length) + before;
}

fn coded_context(channel: u32, temporal: u32, level: u32, before: u32) -> u32 {
    return CONTEXT_CODED + 2u * (4u * (4u * channel + temporal) + level) + before;
}

fn last_context(channel: u32, temporal: u32, level: u32, class_before: u32) -> u32 {
    return CONTEXT_LAST + 12u * (4u * (4u * u32(channel > 0u) + level) + temporal) + class_before;
}

fn last_bits_context(channel: u32, logarithm: u32) -> u32 {
    return CONTEXT_LAST_BITS + 11u * u32(channel > 0u) + logarithm;
}

// Returns the first context of a plane's last level; the offset depends on the class of its position and the magnitude in the
// previous plane.
fn last_level_contexts(channel: u32, temporal: u32) -> u32 {
    return CONTEXT_LEVELS + 18u * (4u * u32(channel > 0u) + temporal);
}

// Returns the first context of a plane's other levels; the offset depends on the class of the position, the class of the sum of
// neighbours, and the magnitude in the previous plane.
fn level_contexts(channel: u32, temporal: u32) -> u32 {
    return CONTEXT_LEVELS + 144u + 144u * (4u * u32(channel > 0u) + temporal);
}
