// Levels of a transformed block (color.md 6.6), summed up to the spatial coefficients of one frame while they are read. Mirrors
// src/color/transform/levels.rs and `FrameLevels` of src/color/transform/reconstruct.rs.

// Spatial coefficients of a channel, 32 a row, in units of 2^-(8 + fraction); all 0 where nobody works on them.
var<workgroup> coefficients: array<i32, 1024>;
// Of a position in the plane that was the last to read it: the plane's number, the greatest magnitude in the first planes of
// this block's channels (4 bits), and the magnitude (4 bits). Two more rows, as neighbours lie below; those on the right of the
// last column are on the left of a row, where this plane has not been yet.
var<workgroup> magnitudes: array<u32, 1088>;

fn open_block() {
    reader.first_plane_number = reader.plane_number + 1u;
    reader.planes_before = 0u;
    reader.first_class = 0u;
    reader.channel = 0u;
}

// Magnitude of a neighbour in this plane.
fn magnitude_at(position: u32) -> u32 {
    let held = magnitudes[position];
    return select(0u, held & 15u, held >> 8u == reader.plane_number);
}

// Index in the scan of a plane's last level, with the class of that in the plane before.
fn last_position(channel: u32, temporal: u32, level: u32, class_before: u32) -> u32 {
    let logarithm = symbol(last_context(channel, temporal, level, class_before));
    if (logarithm == 0u) {
        return 0u;
    }
    let high_bits = min(logarithm, 2u);
    let low_bits = logarithm - high_bits;
    let high = symbol(last_bits_context(channel, logarithm)) & ((1u << high_bits) - 1u);
    let index = (1u << logarithm) | (high << low_bits) | few_bits(low_bits);
    return min(index - 1u, (16u << (2u * level)) - 1u);
}

// Reads the levels of a channel of a block, adds the coefficients of the block's frame `frame` unless that is NONE, and answers
// the columns and rows that have some.
fn read_channel(block: Block, channel: u32, frame: u32) -> vec2u {
    let length = length_index(block.frames);
    let count = min(number(planes_context(channel, block.level, length, reader.planes_before)), block.frames);
    if (channel == 0u || count > 0u) {
        reader.planes_before = min(count, 2u);
    }
    reader.iterations += count + 2u * (1u << (2u * block.level));
    let scan = scan_at(block.level);
    let functions = basis_at(block.frames);
    let mean_step = step_of(channel, length, block.level, 0u);
    var mean_level = predicted_level(block, channel, mean_step);
    // Constant coefficients of the block's last frame.
    var last_sum = 0;
    var extent = vec2u(1u, 1u);
    var coded = false;
    var class_before = reader.first_class;
    for (var plane = 0u; plane < count; plane++) {
        reader.plane_number++;
        let temporal = select(min(plane, 2u), 3u, block.frames == 1u);
        if (plane + 1u < count) {
            coded = flag(coded_context(channel, temporal, block.level, coded));
            if (!coded) {
                class_before = 0u;
                continue;
            }
        }
        let last = last_position(channel, temporal, block.level, class_before);
        class_before = 1u + firstLeadingBit(last + 1u);
        if (plane == 0u) {
            reader.first_class = max(reader.first_class, class_before);
        }
        reader.iterations += last + 1u;
        let row = functions + plane * block.frames;
        var weight = 0;
        if (frame != NONE) {
            weight = i32(tables[row + frame]);
        }
        let last_weight = i32(tables[row + block.frames - 1u]);
        let last_contexts = last_level_contexts(channel, temporal);
        let contexts = level_contexts(channel, temporal);
        for (var left = last + 1u; left > 0u; left--) {
            let entry = tables[scan + left - 1u];
            let position = entry & 0xffffu;
            let held = magnitudes[position];
            let number_of_held = held >> 8u;
            let channels = select(0u, (held >> 4u) & 15u, number_of_held >= reader.first_plane_number);
            var other = channels;
            if (plane > 0u) {
                other = select(0u, held & 15u, number_of_held + 1u == reader.plane_number);
            }
            other = min(other, 2u);
            let is_last = left == last + 1u;
            var context = last_contexts + 3u * (entry >> 16u) + other;
            if (!is_last) {
                let sum = magnitude_at(position + 1u) + magnitude_at(position + 2u) + magnitude_at(position + 32u)
                    + magnitude_at(position + 33u) + magnitude_at(position + 64u);
                let class_of_sum = tables[SUM_CLASSES_AT + min(sum, 11u)];
                context = contexts + 3u * (8u * (entry >> 16u) + class_of_sum) + other;
            }
            let magnitude = number(context) + u32(is_last);
            let counted = min(magnitude, 15u);
            let greatest = select(channels, max(channels, counted), plane == 0u);
            magnitudes[position] = (reader.plane_number << 8u) | (greatest << 4u) | counted;
            if (magnitude == 0u) {
                continue;
            }
            var level = i32(magnitude);
            if (few_bits(1u) == 1u) {
                level = -level;
            }
            extent = max(extent, vec2u(position & 31u, position >> 5u) + 1u);
            if (plane == 0u && position == 0u) {
                mean_level += level;
                continue;
            }
            let frequency = (position & 31u) + (position >> 5u);
            let coefficient = dequantise(level, step_of(channel, length, block.level, frequency));
            coefficients[position] += coefficient * weight;
            if (position == 0u) {
                last_sum += coefficient * last_weight;
            }
        }
        coded = true;
    }
    let mean = dequantise(mean_level, mean_step) << 8u;
    note_block(block, channel, last_sum + mean);
    if (frame != NONE) {
        coefficients[0] += mean;
    }
    return extent;
}
