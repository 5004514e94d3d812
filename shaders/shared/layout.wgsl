// Structs and constants of kernels.json; a test compares the two.

// A depth tile or a colour cell.
struct Unit {
    // First word of its picture.
    picture: u32,
    // Size in pixels.
    width: u32,
    height: u32,
    // Words per row: `(width + 1) / 2` for codes, `width` for bytes, `2 * width` for halves.
    stride: u32,
    // W of its stream; 0 if every frame is coded independently, so that any frame can follow any other.
    window: u32,
    // Domain of its modelling functions: one of DOMAIN_…, the logarithm at the near distance, and codes per unit of the
    // logarithm. For the transform codec `base` is the first word of the stream's table sets.
    domain: u32,
    base: u32,
    scale: u32,
}

// A resident chunk.
struct Chunk {
    // Its range of rows in the table of records.
    first_record: u32,
    record_count: u32,
    // Colour only: byte offset of its weights in the stream, and their number.
    weights_at: u32,
    weight_count: u32,
}

// Change of a frame: a record of depth or material, or a keyframe of colour. For the transform codec: a frame that differs from
// the previous one.
struct Record {
    // Frame, relative to the first frame of the chunk.
    frame: u32,
    // Nodes: word offset of the header in the stream. Keyframes: byte offset of the first sample or block. Transform: byte
    // offset of the chunk.
    at: u32,
    // Range of rows in the table of boxes: boxes, or regions of the transform codec.
    first: u32,
    count: u32,
    // Number of invocations; for a keyframe, those of a blend.
    work: u32,
    // KEYFRAME_…, for keyframes only.
    coding: u32,
}

// A rectangle of values of one record, or a region of the transform codec.
struct BoxRow {
    // Position and size in the unit, in pixels.
    x: u32,
    y: u32,
    width: u32,
    height: u32,
    // Byte offset of its values in the stream.
    at: u32,
    // One of BOX_….
    coding: u32,
    // Number of invocations of the record's boxes up to and including this one.
    end: u32,
}

// A unit to decode.
struct Item {
    unit: u32,
    // Rows in the table of chunks: the chunk of the frame, and the following chunk if the cell blends into it.
    chunk: u32,
    next: u32,
    // Frame, relative to the first frame of the chunk.
    frame: u32,
    // Identifies the chunk; never 0.
    key: u32,
}

// Current content of a unit's picture.
struct State {
    // Key of the chunk; 0 if the picture is empty.
    key: u32,
    // Frame of the chunk; for colour, the keyframe.
    frame: u32,
    // Colour only.
    weight: u32,
}

// Work on one unit.
struct Job {
    unit: u32,
    // Number of invocations of all jobs up to and including this one.
    end: u32,
    // The record to apply; for colour, the two keyframes to blend.
    record: u32,
    next: u32,
    weight: u32,
}

// Size of the next dispatch in workgroups: one invocation per part of the work (x, y, z), or one workgroup per part (part_x,
// part_y, part_z).
struct Dispatch {
    x: u32,
    y: u32,
    z: u32,
    part_x: u32,
    part_y: u32,
    part_z: u32,
}

// A rectangle of texels to convert to inverse depths.
struct DepthJob {
    // First word of the tile's picture. If NONE, every texel is set to the bits in `table`.
    picture: u32,
    stride: u32,
    // Position and size in the tile, in pixels.
    left: u32,
    top: u32,
    width: u32,
    // Offset of the table that maps codes to inverse depths.
    table: u32,
    // Offset of the ray length of the first texel; NONE for planar depth.
    ray_length: u32,
    ray_length_pitch: u32,
    // Offset of the first texel in the planes, in words.
    output: u32,
    pitch: u32,
    // Number of invocations of all jobs up to and including this one.
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
    // Upper bound of the written values, as bits of a float.
    limit: u32,
    // Number of invocations of all jobs up to and including this one.
    end: u32,
}

// Lists with their lengths; `total` is the number of invocations.

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
