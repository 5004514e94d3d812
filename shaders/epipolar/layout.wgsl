// Structs and constants of kernels.json that the kernels of epipolar slices share, written by src/gpu/epipolar/block.rs.

// Scanlines of some output views. The index of a pixel is (row * views + view) * width + column.
struct SliceBlock {
    // Pixels per scanline.
    width: u32,
    rows: u32,
    views: u32,
    spare: u32,
}

// Lines of a scanline that move together; their columns are one pixel apart.
struct SliceRun {
    // Column of the first pixel's centre in its own view, in 1/256 pixels.
    column: i32,
    // Movement over the whole baseline, in 1/4096 pixels.
    disparity: i32,
    // Index of the first line, relative to the first line of the scanline.
    first: u32,
    // Bits 0 to 15: index of the source; then RUN_… flags; the number of lines from bit RUN_LENGTH_BITS.
    flags: u32,
}

// A source seen from a view. The array is ordered by source, then by view.
struct SlicePlace {
    // Offset of the view to the right of the source, in 2^-24 of the baseline.
    place: i32,
    // Bias added to the depth keys.
    bias: u32,
}

// Radiance of a line, as bits of half floats.
struct LineLight {
    // Red and green in views other than its own.
    steady_rg: u32,
    // Blue, and LIGHT_… in the high half; 0 there if the radiance does not depend on the view.
    steady_b: u32,
    // Radiance in its own view.
    own_rg: u32,
    own_b: u32,
}

// Rows of pixels.
struct PixelRows {
    width: u32,
    rows: u32,
    // Row pitch in pixels.
    stride: u32,
    spare: u32,
}

const NONE: u32 = 0xffffffffu;
const WORKGROUP: u32 = 64u;
const SLICE_WORKGROUP: u32 = 256u;
// Columns processed by a workgroup.
const SLICE_COLUMNS: u32 = 1024u;

// The next run begins with the next pixel of the same surface.
const RUN_JOINS: u32 = 65536u;
// The lines belong to the first layer.
const RUN_FIRST: u32 = 131072u;
const RUN_LENGTH_BITS: u32 = 18u;

// A winner is two words: the line, relative to the first line of its scanline, or NONE; and the weight of the neighbouring line
// in 255ths, with flags that select the line after it or the line before it.
const WINNER_AFTER: u32 = 256u;
const WINNER_BEFORE: u32 = 512u;
// The winner is a source's own pixel in the source's own view.
const WINNER_OWN: u32 = 1024u;

const LIGHT_GLOSS: u32 = 1u;
const LIGHT_TRACED: u32 = 2u;

// Content of a pixel, in the high half of its second word; 0 for a line.
const SHOWN_HOLE: u32 = 1u;
const SHOWN_OPTICAL: u32 = 2u;
// A line whose highlight is still to be added.
const SHOWN_GLOSS: u32 = 3u;
