// Declarations of both kernels of the transform codec: the words of a chunk, and the scratch memory of a region, through which
// `transform-read-…` passes the decoded blocks to `transform-…`. A chunk is a list of words: offset of its table set from the
// first set of the stream; two chroma slopes; number of colours; number of frames; index of the set of frequency offsets; the
// colours, two words each. A region is the step indices of its three channels, then its substream. Needs `put_pixel`.

@group(0) @binding(0) var<storage, read> units: array<Unit>;
@group(0) @binding(1) var<storage, read> records: array<Record>;
@group(0) @binding(2) var<storage, read> jobs: Jobs;
@group(0) @binding(3) var<storage, read> boxes: array<BoxRow>;
@group(0) @binding(4) var<storage, read> stream: array<u32>;
@group(0) @binding(5) var<storage, read> tables: array<u32>;
@group(0) @binding(6) var<storage, read_write> pictures: array<u32>;
@group(0) @binding(7) var<storage, read_write> scratch: array<Scratch>;

// A node of the tree: position in units of 4x4 pixels, size of 4*2^level pixels, first frame in the chunk, number of frames.
struct Block {
    x: u32,
    y: u32,
    level: u32,
    frame: u32,
    frames: u32,
}

// State of the substream reader.
struct Reader {
    // Next element to read: one of NEXT_….
    next: u32,
    // State of the rANS decoder, and the position of the next 16 bits in the stream.
    state: u32,
    next_half: u32,
    node_count: u32,
    // Pixels of the region that no block of the wanted frame has covered yet.
    pixels_left: u32,
    block: Block,
    // Channel of the block that is being read, its number of planes, and its next plane.
    channel: u32,
    plane_count: u32,
    plane: u32,
    // 1 if the previous plane has levels; class of its last position, 0 if it has none.
    coded: u32,
    class_before: u32,
    // Level of the channel's mean, and sum of the DC coefficients in the block's last frame.
    mean_level: i32,
    last_sum: i32,
    // Columns and rows of the channel's coefficients; extents of the block's previous channels, packed as in `Leaf`.
    extent: vec2u,
    extents: u32,
    // Number of planes read so far, over all blocks; number of this block's first plane.
    plane_number: u32,
    first_plane_number: u32,
    // Number of planes of the last channel with any, at most 2.
    planes_before: u32,
    // Maximum class of the last position, over the first planes of this block's previous channels.
    first_class: u32,
    // Number of colours of the block's palette; next frame; which half of each byte of `indices` holds the previous frame; 1 if
    // the previous frame repeated the one before it.
    color_count: u32,
    next_frame: u32,
    slot: u32,
    frame_repeats: u32,
    // Number of colours in the cache.
    cached: u32,
    // Approximate number of loop iterations in this pass.
    iterations: u32,
}

// A transformed block that shows the wanted frame.
struct Leaf {
    // x | y << 3 | level << 6.
    place: u32,
    // Extents of the three channels, each from bit 10 * channel: columns of coefficients minus 1 | (rows minus 1) << 5.
    extents: u32,
}

// State of a region that is kept between passes and kernels. `reader`, `leaf_count`, `magnitudes` and `coefficients` are 0
// before the first pass, and `transform-…` resets them to 0. Everything else is written before it is read.
struct Scratch {
    // A colour is two words: keys of red and green, key of blue.
    cache: array<vec2u, 15>,
    palette: array<vec2u, 16>,
    reader: Reader,
    // Stack of nodes to read. Its maximum depth is three quarters of each of three sizes, a half of each of five lengths, and
    // three frames.
    nodes: array<u32, 17>,
    leaf_count: u32,
    leaves: array<Leaf, 64>,
    // Palette indices, a byte per pixel: two frames alternate between the low and the high 4 bits.
    indices: array<u32, 256>,
    // Means of the 4x4 squares, by channel, then row by row.
    means: array<i32, 192>,
    // One word per position, written by the last plane that read it: the plane's number (from bit 8), the maximum magnitude in
    // the first planes of this block's channels (4 bits), and the magnitude (4 bits). There are two extra rows because contexts
    // use neighbours up to two rows below. A neighbour to the right of the last column wraps to the left of a lower row, at a
    // position that this plane has not written yet.
    magnitudes: array<u32, 1088>,
    // Spatial coefficients in units of 2^-(8 + fraction), by channel, then row by row. Those of a block start at its first
    // pixel.
    coefficients: array<i32, 3072>,
}

// Size of a `Scratch` in words.
const SCRATCH_WORDS: u32 = 4848u;

const NEXT_OPEN: u32 = 0u;
const NEXT_NODE: u32 = 1u;
const NEXT_CHANNEL: u32 = 2u;
const NEXT_PLANE: u32 = 3u;
const NEXT_FRAME: u32 = 4u;
const NEXT_END: u32 = 5u;

const OFFSET_SET: u32 = 5u;
const COLORS: u32 = 6u;

// Index of this region in `scratch`, and first word of its chunk.
var<private> region_slot: u32;
var<private> chunk: u32;
var<private> unit: Unit;
var<private> region: BoxRow;

// Sets the variables above for a region, and returns its record.
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

// Returns the number of fraction bits of a pixel's channels (e in color.md 6).
fn pixel_fraction() -> u32 {
    return select(0u, FINE_BITS, stream[chunk + OFFSET_SET] > 0u);
}

// Returns the index of the first coefficient of a block's channel.
fn coefficients_at(channel: u32, x: u32, y: u32) -> u32 {
    return 1024u * channel + 128u * y + 4u * x;
}

// Writes pixel (x, y) of the region; ignores pixels outside the region.
fn put(x: u32, y: u32, keys: vec3i) {
    if (x < region.width && y < region.height) {
        put_pixel(unit, (region.y + y) * unit.width + region.x + x, sample_of(keys));
    }
}
