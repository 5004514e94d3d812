// Contexts of symbols (color.md 6.6), and where the tables of the format are (src/gpu/transform_tables.rs). Mirrors
// src/color/transform/contexts.rs. Needs `tables`.

// First contexts of the kinds of symbols.
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

// First words of tables. Word n, for a basis of n points: the index of the length in 8 bits, and from bit 8 the first word of its
// functions. Classes of sums of magnitudes start here.
const SUM_CLASSES_AT: u32 = 97u;
// Positions of each size of blocks in the order of coding, and from bit 16 their classes.
const SCAN_AT: u32 = 109u;
// First word of each context's distribution in a set.
const CLUSTERS_AT: u32 = 1469u;
// Of steps (color.md 6.3): an octave, and the inverse roots of lengths; offsets by frequency of each set, for luma and chroma.
const OCTAVE_AT: u32 = 3674u;
const ROOTS_AT: u32 = 3690u;
const OFFSETS_AT: u32 = 3699u;

// Index of a number of frames among the lengths of transforms; of others, the number of lengths.
fn length_index(frames: u32) -> u32 {
    return tables[frames] & 255u;
}

// First word of a basis, whose functions are rows.
fn basis_at(points: u32) -> u32 {
    return tables[points] >> 8u;
}

fn scan_at(level: u32) -> u32 {
    // Blocks of 4, 8, 16 and 32 pixels square.
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

// Contexts of a plane's last level, by class of its position and the magnitude in the plane before.
fn last_level_contexts(channel: u32, temporal: u32) -> u32 {
    return CONTEXT_LEVELS + 18u * (4u * u32(channel > 0u) + temporal);
}

// Contexts of a plane's other levels, by class of the position, class of the sum around it and the magnitude before.
fn level_contexts(channel: u32, temporal: u32) -> u32 {
    return CONTEXT_LEVELS + 144u + 144u * (4u * u32(channel > 0u) + temporal);
}
