// Steps (color.md 6.3), means of 4x4 squares, and the levels predicted from them (color.md 6.5). Mirrors
// src/codec/color/transform/steps.rs and src/codec/color/transform/means.rs.

// Returns the step of a level; `frequency` is the sum of its horizontal and vertical frequencies.
fn step_of(channel: u32, length: u32, level: u32, frequency: u32) -> i32 {
    let table = 2u * stream[chunk + OFFSET_SET] + min(channel, 1u);
    let offset = tables[OFFSETS_AT + 64u * table + (((2u * frequency + 1u) << (3u - level)) >> 1u)];
    let index = u32(clamp(i32(stream[region.at / 4u + channel] + offset), 0, 255));
    let mantissa = (tables[OCTAVE_AT + (index & 15u)] * tables[ROOTS_AT + length] + 2048u) >> 12u;
    let shift = 11u - FRACTION_BITS;
    return i32(max(((mantissa << (index >> 4u)) + (1u << (shift - 1u))) >> shift, 1u));
}

fn dequantise(level: i32, step: i32) -> i32 {
    return (level * step + 4) >> 3u;
}

fn first_square(block: Block, channel: u32) -> u32 {
    return 64u * channel + 8u * block.y + block.x;
}

// Returns the predicted level of a block's mean.
fn predicted_level(block: Block, channel: u32, step: i32) -> i32 {
    let first = first_square(block, channel);
    let squares = 1u << block.level;
    let has_left = block.x > 0u;
    let has_above = block.y > 0u;
    var count = squares * squares;
    var shift = 2u * block.level;
    if (block.frame == 0u) {
        count = squares * (u32(has_left) + u32(has_above));
        shift = block.level + u32(has_left && has_above);
    }
    var sum = 0;
    for (var at = 0u; at < count; at++) {
        let x = at & (squares - 1u);
        let y = at >> block.level;
        var square = first + 8u * y + x;
        if (block.frame == 0u) {
            // The squares on the left, then those above.
            square = select(first - 8u + x, first + 8u * x - 1u, has_left && y == 0u);
        }
        sum += scratch[region_slot].means[square];
    }
    let scaled = (sum >> shift) * i32(32u << block.level) + (step >> 1u);
    // Division that rounds down.
    let quotient = scaled / step;
    return quotient - i32(scaled - quotient * step < 0);
}

fn note_square(square: u32, channels: vec3i) {
    scratch[region_slot].means[square] = channels.x;
    scratch[region_slot].means[64u + square] = channels.y;
    scratch[region_slot].means[128u + square] = channels.z;
}

// Records the mean of a block, computed from the sum of its DC coefficients in its last frame.
fn note_block(block: Block, channel: u32, sum: i32) {
    let mean = ((sum + 128) >> 8u) >> (2u + block.level);
    let first = first_square(block, channel);
    for (var at = 0u; at < (1u << (2u * block.level)); at++) {
        scratch[region_slot].means[first + 8u * (at >> block.level) + (at & ((1u << block.level) - 1u))] = mean;
    }
}
