// Reads the block tree of a region (color.md 6.4), one region per invocation. Mirrors src/codec/color/transform/region.rs and
// src/codec/color/transform/blocks.rs. A long region takes several passes; reading ends when all pixels of the wanted frame are
// known.

const NODE_QUARTERS: u32 = 1u;
const NODE_PARTS: u32 = 2u;
const NODE_PALETTE: u32 = 3u;

// Iterations after which a pass ends. Mesa's software Vulkan terminates all loops of 8 invocations after 65535 iterations in
// total, and a loop that none of them enters counts as one. A step counts its own iterations plus STEP_ITERATIONS, the number
// of loops in `read_regions`; the longest step, a frame of a palette, counts 2060. So 8 invocations take at most 8 * (4999 +
// 2060) iterations. The host counts passes with the same numbers.
const PASS_ITERATIONS: u32 = 5000u;
const STEP_ITERATIONS: u32 = 12u;

var<private> reader: Reader;
var<private> wanted_frame: u32;

fn push_node(x: u32, y: u32, level: u32, frame: u32, frames: u32) {
    scratch[region_slot].nodes[reader.node_count] = x | (y << 3u) | (level << 6u) | (frame << 8u) | (frames << 16u);
    reader.node_count++;
}

fn node_of(word: u32) -> Block {
    return Block(word & 7u, (word >> 3u) & 7u, (word >> 6u) & 3u, (word >> 8u) & 255u, word >> 16u);
}

fn open_region() {
    open_substream(region.at / 4u + 3u);
    let squares = (max(region.width, region.height) + 3u) / 4u;
    let level = firstLeadingBit(2u * squares - 1u);
    push_node(0u, 0u, level, 0u, stream[chunk + 4u]);
    reader.pixels_left = 16u << (2u * level);
    open_cache();
    reader.next = NEXT_NODE;
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
    if (reader.node_count == 0u) {
        reader.next = NEXT_END;
        return;
    }
    reader.node_count--;
    reader.block = node_of(scratch[region_slot].nodes[reader.node_count]);
    let kind = symbol(node_context(reader.block.level, reader.block.frames));
    if (kind == NODE_PALETTE) {
        open_palette(reader.block.level);
    } else if (kind == NODE_QUARTERS || kind == NODE_PARTS) {
        push_children(reader.block, kind);
    } else {
        open_block();
    }
}

// Subtracts the pixels of a block that shows the wanted frame; ends reading when none remain.
fn count_shown(block: Block) {
    reader.pixels_left -= 16u << (2u * block.level);
    if (reader.pixels_left == 0u) {
        reader.next = NEXT_END;
    }
}

// Returns the index of the wanted frame in a block; NONE if the block does not contain it.
fn frame_in(block: Block) -> u32 {
    let frame = wanted_frame - block.frame;
    return select(NONE, frame, frame < block.frames);
}

@compute @workgroup_size(WORKGROUP)
fn read_regions(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let number = invocation_of(id, groups);
    if (number >= jobs.total || scratch[number].reader.next == NEXT_END) {
        return;
    }
    let record = find_region(number);
    distributions = unit.base + stream[chunk];
    wanted_frame = record.frame;
    reader = scratch[region_slot].reader;
    if (reader.next == NEXT_OPEN) {
        open_region();
    }
    reader.iterations = 0u;
    while (reader.next != NEXT_END && reader.iterations < PASS_ITERATIONS) {
        reader.iterations += STEP_ITERATIONS;
        switch (reader.next) {
            case NEXT_CHANNEL: {
                open_channel();
            }
            case NEXT_PLANE: {
                read_plane();
            }
            case NEXT_FRAME: {
                read_frame();
            }
            default: {
                read_node();
            }
        }
    }
    scratch[region_slot].reader = reader;
}
