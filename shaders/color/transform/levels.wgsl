// Reads the levels of a transformed block (color.md 6.6), and accumulates the spatial coefficients of one frame while reading.
// Mirrors src/codec/color/transform/levels.rs and `FrameLevels` of src/codec/color/transform/reconstruct.rs.

fn open_block() {
    reader.first_plane_number = reader.plane_number + 1u;
    reader.planes_before = 0u;
    reader.first_class = 0u;
    reader.extents = 0u;
    reader.channel = 0u;
    reader.next = NEXT_CHANNEL;
}

// Returns the magnitude of a neighbour in this plane; 0 if it is not read yet.
fn magnitude_at(position: u32) -> u32 {
    let held = scratch[region_slot].magnitudes[position];
    return select(0u, held & 15u, held >> 8u == reader.plane_number);
}

// Reads the scan index of a plane's last nonzero level; the context depends on the class of that index in the previous plane.
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

// Reads the number of planes of a channel, and predicts the level of its mean.
fn open_channel() {
    let block = reader.block;
    let channel = reader.channel;
    let length = length_index(block.frames);
    reader.plane_count = min(number(planes_context(channel, block.level, length, reader.planes_before)), block.frames);
    if (channel == 0u || reader.plane_count > 0u) {
        reader.planes_before = min(reader.plane_count, 2u);
    }
    reader.iterations += 3u << (2u * block.level);
    reader.mean_level = predicted_level(block, channel, step_of(channel, length, block.level, 0u));
    reader.last_sum = 0;
    reader.extent = vec2u(1u, 1u);
    reader.coded = 0u;
    reader.class_before = reader.first_class;
    reader.plane = 0u;
    reader.next = NEXT_PLANE;
    if (reader.plane_count == 0u) {
        close_channel();
    }
}

// Reads the levels of a plane. If the block contains the wanted frame, adds their contribution to the coefficients of that
// frame.
fn read_plane() {
    let block = reader.block;
    let channel = reader.channel;
    let plane = reader.plane;
    reader.plane++;
    reader.plane_number++;
    let temporal = select(min(plane, 2u), 3u, block.frames == 1u);
    if (reader.plane < reader.plane_count) {
        reader.coded = symbol(coded_context(channel, temporal, block.level, reader.coded));
        if (reader.coded == 0u) {
            reader.class_before = 0u;
            return;
        }
    }
    let last = last_position(channel, temporal, block.level, reader.class_before);
    reader.class_before = 1u + firstLeadingBit(last + 1u);
    if (plane == 0u) {
        reader.first_class = max(reader.first_class, reader.class_before);
    }
    reader.iterations += last + 1u;
    let length = length_index(block.frames);
    let scan = scan_at(block.level);
    let row = basis_at(block.frames) + plane * block.frames;
    let frame = frame_in(block);
    var weight = 0;
    if (frame != NONE) {
        weight = i32(tables[row + frame]);
    }
    let last_weight = i32(tables[row + block.frames - 1u]);
    let first = coefficients_at(channel, block.x, block.y);
    let last_contexts = last_level_contexts(channel, temporal);
    let contexts = level_contexts(channel, temporal);
    for (var left = last + 1u; left > 0u; left--) {
        let entry = tables[scan + left - 1u];
        let position = entry & 0xffffu;
        let held = scratch[region_slot].magnitudes[position];
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
        scratch[region_slot].magnitudes[position] = (reader.plane_number << 8u) | (greatest << 4u) | counted;
        if (magnitude == 0u) {
            continue;
        }
        var level = i32(magnitude);
        if (few_bits(1u) == 1u) {
            level = -level;
        }
        reader.extent = max(reader.extent, vec2u(position & 31u, position >> 5u) + 1u);
        if (plane == 0u && position == 0u) {
            reader.mean_level += level;
            continue;
        }
        let frequency = (position & 31u) + (position >> 5u);
        let coefficient = dequantise(level, step_of(channel, length, block.level, frequency));
        if (frame != NONE) {
            scratch[region_slot].coefficients[first + position] += coefficient * weight;
        }
        if (position == 0u) {
            reader.last_sum += coefficient * last_weight;
        }
    }
    reader.coded = 1u;
    if (reader.plane == reader.plane_count) {
        close_channel();
    }
}

// Records the mean of a channel; after the third channel, finishes the block.
fn close_channel() {
    let block = reader.block;
    let channel = reader.channel;
    let mean_step = step_of(channel, length_index(block.frames), block.level, 0u);
    let mean = dequantise(reader.mean_level, mean_step) << 8u;
    note_block(block, channel, reader.last_sum + mean);
    let shows = frame_in(block) != NONE;
    if (shows) {
        scratch[region_slot].coefficients[coefficients_at(channel, block.x, block.y)] += mean;
    }
    reader.extents |= ((reader.extent.x - 1u) | ((reader.extent.y - 1u) << 5u)) << (10u * channel);
    reader.channel++;
    reader.next = NEXT_CHANNEL;
    if (reader.channel < 3u) {
        return;
    }
    reader.next = NEXT_NODE;
    if (shows) {
        let at = scratch[region_slot].leaf_count;
        scratch[region_slot].leaves[at] = Leaf(block.x | (block.y << 3u) | (block.level << 6u), reader.extents);
        scratch[region_slot].leaf_count = at + 1u;
        count_shown(block);
    }
}
