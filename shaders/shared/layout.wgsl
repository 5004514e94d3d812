// Structs and constants of kernels.json; a test compares the two.

// A tile or a cell.
struct Unit {
    // First word of its picture.
    picture: u32,
    // Pixels.
    width: u32,
    height: u32,
    // Words per row: `(width + 1) / 2` for codes, `width` for bytes, `2 * width` for halves.
    stride: u32,
    // W of its stream; 0 where every frame is whole, so that any frame can follow any.
    window: u32,
    // Domain of its modelling functions: one of DOMAIN_…, the logarithm at near, codes per unit of the logarithm. Of the
    // transform codec, `base` is the first word of its stream's table sets.
    domain: u32,
    base: u32,
    scale: u32,
}

// A resident chunk.
struct Chunk {
    // Its rows in the table of records.
    first_record: u32,
    record_count: u32,
    // Colour: byte of the stream at which its weights start, and their number.
    weights_at: u32,
    weight_count: u32,
}

// What a frame changes: a record of depth or material, or a keyframe of colour; of the transform codec, a frame that differs
// from the one before.
struct Record {
    // Counted from the chunk's first frame.
    frame: u32,
    // Nodes: word of the header in the stream. Keyframes: byte of the first sample or block. Transform: byte of the chunk.
    at: u32,
    // Boxes, or regions of a transform: rows in the table of boxes.
    first: u32,
    count: u32,
    // Invocations; of a keyframe, those of a blend.
    work: u32,
    // Keyframes: KEYFRAME_….
    coding: u32,
}

// A rectangle of values of one record, or a region of the transform codec.
struct BoxRow {
    // Pixels in the unit.
    x: u32,
    y: u32,
    width: u32,
    height: u32,
    // Byte of the stream at which its values start.
    at: u32,
    // BOX_….
    coding: u32,
    // Invocations of the record's boxes up to and including this one.
    end: u32,
}

// A unit to decode.
struct Item {
    unit: u32,
    // Rows in the table of chunks: the chunk that holds the frame, and the one after it where a cell blends into it.
    chunk: u32,
    next: u32,
    // Counted from the chunk's first frame.
    frame: u32,
    // Identifies the chunk; never 0.
    key: u32,
}

// What a unit's picture shows.
struct State {
    // Key of the chunk; 0 for nothing.
    key: u32,
    // Colour: the keyframe.
    frame: u32,
    // Colour only.
    weight: u32,
}

// Work on one unit.
struct Job {
    unit: u32,
    // Invocations of all jobs up to and including this one.
    end: u32,
    // Records; of colour, the two keyframes.
    record: u32,
    next: u32,
    weight: u32,
}

// Workgroups of the next dispatch: with an invocation for each part of the work (x, y, z), or a workgroup for each (part_x, …).
struct Dispatch {
    x: u32,
    y: u32,
    z: u32,
    part_x: u32,
    part_y: u32,
    part_z: u32,
}

// A rectangle of texels whose inverse depths are written.
struct DepthJob {
    // First word of the tile's picture; NONE: every texel becomes `table`.
    picture: u32,
    stride: u32,
    // In the tile.
    left: u32,
    top: u32,
    width: u32,
    // First of the inverse depths by code among the tables.
    table: u32,
    // Ray length of the first texel among the tables; NONE for planar depth.
    ray_length: u32,
    ray_length_pitch: u32,
    // Word of the planes for the first texel.
    output: u32,
    pitch: u32,
    // Invocations of all jobs up to and including this one.
    end: u32,
}

// A rectangle of one level of a depth pyramid.
struct PyramidJob {
    // First word of the level below, or of the texels.
    below: u32,
    below_pitch: u32,
    below_width: u32,
    below_height: u32,
    left: u32,
    top: u32,
    width: u32,
    // First word of the level.
    output: u32,
    pitch: u32,
    // Upper bound of what is written, as bits of a float.
    limit: u32,
    // Invocations of all jobs up to and including this one.
    end: u32,
}

// Lists, with the number of their rows; `total` is the number of invocations.

struct Items {
    count: u32,
    spare: u32,
    list: array<Item>,
}

struct Jobs {
    total: u32,
    count: u32,
    list: array<Job>,
}

struct DepthJobs {
    total: u32,
    count: u32,
    list: array<DepthJob>,
}

struct PyramidJobs {
    total: u32,
    count: u32,
    list: array<PyramidJob>,
}

const NONE: u32 = 0xffffffffu;
const WORKGROUP: u32 = 64u;
const MAX_GROUPS: u32 = 65535u;
const NODE_HEADER_WORDS: u32 = 12u;
const LEVELS: u32 = 9u;
const BOX_VALUES: u32 = 0u;
const BOX_CONSTANT: u32 = 1u;
const BOX_BLOCKS: u32 = 2u;
const KEYFRAME_SAMPLES: u32 = 0u;
const KEYFRAME_BLOCKS: u32 = 1u;
const DOMAIN_LOG: u32 = 0u;
const DOMAIN_LINEAR: u32 = 1u;
const DOMAIN_INVERSE: u32 = 2u;
