// Declarations of both kernels of the transform codec: the words of a chunk, and the scratch memory of a region, in which
// `transform-read-…` leaves the blocks that `transform-…` shows. A chunk is words: its table set, from the first of its stream's
// sets; slopes of chroma; number of colours; number of frames; set of frequency offsets; the colours, two words each. A region is
// the step indices of its channels and its substream. Needs `put_pixel`.

@group(0) @binding(0) var<storage, read> units: array<Unit>;
@group(0) @binding(1) var<storage, read> records: array<Record>;
@group(0) @binding(2) var<storage, read> jobs: Jobs;
@group(0) @binding(3) var<storage, read> boxes: array<BoxRow>;
@group(0) @binding(4) var<storage, read> stream: array<u32>;
@group(0) @binding(5) var<storage, read> tables: array<u32>;
@group(0) @binding(6) var<storage, read_write> pictures: array<u32>;
@group(0) @binding(7) var<storage, read_write> scratch: array<Scratch>;

// A node: place in squares of 4x4 pixels, size 4*2^level pixels, frames of the chunk.
struct Block {
    x: u32,
    y: u32,
    level: u32,
    frame: u32,
    frames: u32,
}

// State of reading.
struct Reader {
    // Next thing to read: one of NEXT_….
    next: u32,
    // State of the rANS decoder, and the next 16 bits of the stream.
    state: u32,
    next_half: u32,
    node_count: u32,
    // Pixels that are still to show.
    pixels_left: u32,
    block: Block,
    // Channel of the block; its planes, and the next one.
    channel: u32,
    plane_count: u32,
    plane: u32,
    // 1 if the plane before has levels; class of its last position, 0 without levels.
    coded: u32,
    class_before: u32,
    // Level of the channel's mean, and sum of the constant coefficients in the block's last frame.
    mean_level: i32,
    last_sum: i32,
    // Columns and rows of the channel's coefficients; those of the channels before, as in `Leaf`.
    extent: vec2u,
    extents: u32,
    // Planes so far, of all blocks; number of the first one of this block.
    plane_number: u32,
    first_plane_number: u32,
    // Number of planes of the last channel that had some, at most 2.
    planes_before: u32,
    // Greatest class of the last position in the first planes of this block's channels before.
    first_class: u32,
    // Colours of the block's palette, next frame, in which half of the bytes the indices of the frame before are, and whether that
    // repeated the one before it.
    color_count: u32,
    next_frame: u32,
    slot: u32,
    frame_repeats: u32,
    // Colours in the cache.
    cached: u32,
    // Iterations of loops in this pass, about.
    iterations: u32,
}

// A transformed block that shows the frame.
struct Leaf {
    // x | y << 3 | level << 6.
    place: u32,
    // Extents of the channels, each from bit 10 * channel: columns of coefficients less 1 | rows less 1 << 5.
    extents: u32,
}

// State of a region between passes and kernels. `reader`, `leaf_count`, `magnitudes` and `coefficients` are 0 before the first pass,
// and `transform-…` sets them to 0 again; all else is written before it is read.
struct Scratch {
    // Colours are two words: keys of red and green, key of blue.
    cache: array<vec2u, 15>,
    palette: array<vec2u, 16>,
    reader: Reader,
    // Nodes to read, the next one last: three quarters of each of three sizes, a half of each of five lengths, and three frames.
    nodes: array<u32, 17>,
    leaf_count: u32,
    leaves: array<Leaf, 64>,
    // Indices of a palette, a byte for each pixel: two frames in turns in the low and the high half.
    indices: array<u32, 256>,
    // Means of squares of 4x4 pixels, by channel, then row by row.
    means: array<i32, 192>,
    // For each position, of the plane that was the last to read it: the plane's number, the greatest magnitude in the first planes of
    // this block's channels (4 bits), and the magnitude (4 bits). Two more rows, as neighbours lie below; those on the right of
    // the last column are on the left of a row, where this plane has not been yet.
    magnitudes: array<u32, 1088>,
    // Spatial coefficients in units of 2^-(8 + fraction), by channel, then row by row, those of a block from its first pixel on.
    coefficients: array<i32, 3072>,
}

// Words of a `Scratch`.
const SCRATCH_WORDS: u32 = 4848u;

const NEXT_OPEN: u32 = 0u;
const NEXT_NODE: u32 = 1u;
const NEXT_CHANNEL: u32 = 2u;
const NEXT_PLANE: u32 = 3u;
const NEXT_FRAME: u32 = 4u;
const NEXT_END: u32 = 5u;

const OFFSET_SET: u32 = 5u;
const COLORS: u32 = 6u;

// Number of this region in `scratch`, and first word of its chunk.
var<private> region_slot: u32;
var<private> chunk: u32;
var<private> unit: Unit;
var<private> region: BoxRow;

// Finds the work of a region, and returns its record.
fn find_region(number: u32) -> Record {
    region_slot = number;
    let place = job_of(number);
    let job = jobs.list[place];
    let record = records[job.record];
    unit = units[job.unit];
    region = boxes[record.first + number - job_begin(place)];
    chunk = record.at / 4u;
    return record;
}

fn slope_of(channel: u32) -> i32 {
    return i32(stream[chunk + channel]);
}

// Bits of the fraction of the channels of pixels.
fn pixel_fraction() -> u32 {
    return select(0u, FINE_BITS, stream[chunk + OFFSET_SET] > 0u);
}

// Index of the first coefficient of a channel of a block.
fn coefficients_at(channel: u32, x: u32, y: u32) -> u32 {
    return 1024u * channel + 128u * y + 4u * x;
}

// Writes pixel (x, y) of the region, unless it lies outside.
fn put(x: u32, y: u32, keys: vec3i) {
    if (x < region.width && y < region.height) {
        put_pixel(unit, (region.y + y) * unit.width + region.x + x, sample_of(keys));
    }
}
