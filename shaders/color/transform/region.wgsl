// The tree of blocks of a region (color.md 6.4). Mirrors src/color/transform/region.rs and src/color/transform/blocks.rs. One
// invocation reads, and stops where all of them have something to do.

// A node: place in squares of 4x4 pixels, size 4*2^level pixels, frames of the chunk.
struct Block {
    x: u32,
    y: u32,
    level: u32,
    frame: u32,
    frames: u32,
}

// Where reading is.
struct Reader {
    // State of the rANS decoder, and the next 16 bits of the stream.
    state: u32,
    next_half: u32,
    node_count: u32,
    // Pixels that are still to show.
    pixels_left: u32,
    block: Block,
    // Next channel of the block; 3 where it is read.
    channel: u32,
    // Planes so far, of all blocks; number of the first one of this block.
    plane_number: u32,
    first_plane_number: u32,
    // Number of planes of the last channel that had some, at most 2.
    planes_before: u32,
    // Greatest class of the last position in the first planes of this block's channels before.
    first_class: u32,
    // Whether the block has a palette of which something is to be read; its colours, next frame, where the indices of the
    // frame before are, and whether that repeated the one before it.
    in_palette: u32,
    color_count: u32,
    next_frame: u32,
    slot: u32,
    frame_repeats: u32,
    // Colours in the cache.
    cached: u32,
    // Iterations of loops in this turn, about.
    iterations: u32,
    turn: u32,
}

// What to do with what was read last.
struct Stop {
    // READ_ON or one of STOP_….
    reason: u32,
    turn: u32,
    block: Block,
    channel: u32,
    // Columns and rows of the channel's coefficients.
    extent: vec2u,
    color_count: u32,
    slot: u32,
}

const READ_ON: u32 = 0u;
const STOP_END: u32 = 1u;
// A channel of a transformed block that shows the frame.
const STOP_CHANNEL: u32 = 2u;
// The frame of a block with a palette.
const STOP_PALETTE: u32 = 3u;
// All frames of a block with a palette.
const STOP_MEANS: u32 = 4u;

const NODE_QUARTERS: u32 = 1u;
const NODE_PARTS: u32 = 2u;
const NODE_PALETTE: u32 = 3u;

// Iterations after which another invocation goes on: Mesa's software Vulkan ends all loops of 8 invocations after 65535
// iterations in all. It counts one for a loop that none of them enters, and so about ten for the least that is read.
const MOST_ITERATIONS: u32 = 8192u;
const LEAST_ITERATIONS: u32 = 10u;
const TURN_INVOCATIONS: u32 = 8u;

// Nodes to read, the next one last: three quarters of each of three sizes, a half of each of five lengths, and three frames.
var<workgroup> nodes: array<u32, 17>;
var<workgroup> saved: Reader;
var<private> reader: Reader;
var<private> wanted_frame: u32;

fn push_node(x: u32, y: u32, level: u32, frame: u32, frames: u32) {
    nodes[reader.node_count] = x | (y << 3u) | (level << 6u) | (frame << 8u) | (frames << 16u);
    reader.node_count++;
}

fn node_of(word: u32) -> Block {
    return Block(word & 7u, (word >> 3u) & 7u, (word >> 6u) & 3u, (word >> 8u) & 255u, word >> 16u);
}

fn open_region(size: vec2u, frames: u32) {
    let squares = (max(size.x, size.y) + 3u) / 4u;
    let level = firstLeadingBit(2u * squares - 1u);
    push_node(0u, 0u, level, 0u, frames);
    reader.pixels_left = 16u << (2u * level);
    reader.channel = 3u;
    reader.cached = open_cache();
    saved = reader;
}

fn push_children(block: Block, kind: u32) {
    if (kind == NODE_QUARTERS) {
        let level = block.level - 1u;
        let half = 1u << level;
        push_node(block.x + half, block.y + half, level, block.frame, block.frames);
        push_node(block.x, block.y + half, level, block.frame, block.frames);
        push_node(block.x + half, block.y, level, block.frame, block.frames);
        push_node(block.x, block.y, level, block.frame, block.frames);
    } else if (block.frames == 3u) {
        push_node(block.x, block.y, block.level, block.frame + 2u, 1u);
        push_node(block.x, block.y, block.level, block.frame + 1u, 1u);
        push_node(block.x, block.y, block.level, block.frame, 1u);
    } else {
        let first = (block.frames + 1u) / 2u;
        push_node(block.x, block.y, block.level, block.frame + first, block.frames - first);
        push_node(block.x, block.y, block.level, block.frame, first);
    }
}

fn read_node() {
    reader.node_count--;
    reader.block = node_of(nodes[reader.node_count]);
    let kind = symbol(node_context(reader.block.level, reader.block.frames));
    if (kind == NODE_PALETTE) {
        open_palette(reader.block.level);
    } else if (kind == NODE_QUARTERS || kind == NODE_PARTS) {
        push_children(reader.block, kind);
    } else {
        open_block();
    }
}

// Reads a node, a channel of a block or a frame of a palette's block.
fn read_some(extent: ptr<function, vec2u>) -> u32 {
    let block = reader.block;
    let frame = wanted_frame - block.frame;
    let shows = frame < block.frames;
    if (reader.pixels_left == 0u) {
        return STOP_END;
    }
    if (reader.channel < 3u) {
        *extent = read_channel(block, reader.channel, select(NONE, frame, shows));
        reader.channel++;
        if (!shows) {
            return READ_ON;
        }
        if (reader.channel == 3u) {
            reader.pixels_left -= 16u << (2u * block.level);
        }
        return STOP_CHANNEL;
    }
    if (reader.in_palette == 1u) {
        if (reader.next_frame == block.frames) {
            reader.in_palette = 0u;
            if (block.level > 0u) {
                return STOP_MEANS;
            }
            // 4×4 pixels: cheaper in one invocation than a barrier.
            note_palette(block, 0u, 0u, reader.color_count, reader.slot);
            return READ_ON;
        }
        read_frame(4u << block.level);
        if (reader.next_frame != frame + 1u) {
            return READ_ON;
        }
        reader.pixels_left -= 16u << (2u * block.level);
        return STOP_PALETTE;
    }
    if (reader.node_count == 0u) {
        return STOP_END;
    }
    read_node();
    return READ_ON;
}

// Reads until there is something to do for all invocations, or another one goes on.
fn read_region() -> Stop {
    reader = saved;
    var reason = READ_ON;
    var extent = vec2u();
    while (reason == READ_ON && reader.iterations < MOST_ITERATIONS) {
        reader.iterations += LEAST_ITERATIONS;
        reason = read_some(&extent);
    }
    if (reader.iterations >= MOST_ITERATIONS) {
        reader.iterations = 0u;
        reader.turn++;
    }
    saved = reader;
    return Stop(reason, reader.turn, reader.block, reader.channel - 1u, extent, reader.color_count, reader.slot);
}
