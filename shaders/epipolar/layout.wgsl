// Structs and constants of kernels.json that the kernels of epipolar slices share; src/gpu/epipolar/block.rs writes them.

// Scanlines of some output views. A pixel's number is (row * views + view) * width + column.
struct SliceBlock {
    // Pixels of a scanline.
    width: u32,
    rows: u32,
    views: u32,
    spare: u32,
}

// Lines of a scanline that move together, one pixel after another.
struct SliceRun {
    // Column of the first pixel's middle in its own view, 1/256 pixels.
    column: i32,
    // 1/4096 pixels over the baseline.
    disparity: i32,
    // The first line, counted from the first of its scanline.
    first: u32,
    // The source, RUN_…, and the number of lines above RUN_LENGTH_BITS.
    flags: u32,
}

// A source, seen from a view; sources follow each other, each with all views.
struct SlicePlace {
    // How far the view stands to the right of the source, in 2^-24 of the baseline.
    place: i32,
    // What keys are raised by.
    bias: u32,
}

// Light of a line: bits of half floats.
struct LineLight {
    // Red and green in other views.
    steady_rg: u32,
    // Blue, and LIGHT_… in the high half; 0 for light that is the same from every eye.
    steady_b: u32,
    // As its own view shows it.
    own_rg: u32,
    own_b: u32,
}

// Rows of pixels.
struct PixelRows {
    width: u32,
    rows: u32,
    // Pixels from a row to the next.
    stride: u32,
    spare: u32,
}

const NONE: u32 = 0xffffffffu;
const WORKGROUP: u32 = 64u;
const SLICE_WORKGROUP: u32 = 256u;
// Columns that a workgroup finds winners of.
const SLICE_COLUMNS: u32 = 1024u;

// The next run begins with the next pixel of the same surface.
const RUN_JOINS: u32 = 65536u;
// The lines are of the first layer.
const RUN_FIRST: u32 = 131072u;
const RUN_LENGTH_BITS: u32 = 18u;

// A winner is two words: the line, counted from the first of its scanline, or NONE; the weight of the line beside it in 255ths, and
// whether that is the line after it or the one before.
const WINNER_AFTER: u32 = 256u;
const WINNER_BEFORE: u32 = 512u;
// A source shows its own pixel.
const WINNER_OWN: u32 = 1024u;

const LIGHT_GLOSS: u32 = 1u;
const LIGHT_TRACED: u32 = 2u;

// What a pixel shows, in the high half of its second word: 0 for a line.
const SHOWN_HOLE: u32 = 1u;
const SHOWN_OPTICAL: u32 = 2u;
// A line, and a highlight that is to be added.
const SHOWN_GLOSS: u32 = 3u;
