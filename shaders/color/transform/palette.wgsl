// Palette blocks (color.md 6.8). Mirrors src/codec/color/transform/palette.rs.

fn index_in(position: u32, of_slot: u32) -> u32 {
    return (scratch[region_slot].indices[position >> 2u] >> (8u * (position & 3u) + 4u * of_slot)) & 15u;
}

fn put_index(position: u32, index: u32) {
    let shift = 8u * (position & 3u) + 4u * reader.slot;
    let held = scratch[region_slot].indices[position >> 2u];
    scratch[region_slot].indices[position >> 2u] = (held & ~(15u << shift)) | (index << shift);
}

// Initialises the cache with the chunk's colours and fills the remaining entries with 0.
fn open_cache() {
    reader.cached = stream[chunk + 3u];
    for (var at = 0u; at < 15u; at++) {
        var color = vec2u();
        if (at < reader.cached) {
            let first = chunk + COLORS + 2u * at;
            color = vec2u(stream[first], stream[first + 1u]);
        }
        scratch[region_slot].cache[at] = color;
    }
}

// Moves a colour to the front of the cache. If the colour is new and the cache is full, drops the last entry.
fn touch(color: vec2u) {
    var moved = color;
    var at = 0u;
    loop {
        let held = scratch[region_slot].cache[at];
        scratch[region_slot].cache[at] = moved;
        moved = held;
        if (at == min(reader.cached, 14u) || all(held == color)) {
            break;
        }
        at++;
    }
    reader.cached = max(reader.cached, at + 1u);
}

fn open_palette(level: u32) {
    reader.color_count = symbol(CONTEXT_PALETTE_SIZE + level) + 1u;
    for (var at = 0u; at < reader.color_count; at++) {
        let place = symbol(CONTEXT_PALETTE_COLOR);
        if (place < 15u) {
            scratch[region_slot].palette[at] = scratch[region_slot].cache[place];
        } else {
            let red = bits(KEY_BITS);
            let green = bits(KEY_BITS);
            scratch[region_slot].palette[at] = vec2u(red | (green << 16u), bits(KEY_BITS));
        }
    }
    for (var at = reader.color_count; at > 0u; at--) {
        touch(scratch[region_slot].palette[at - 1u]);
    }
    reader.next_frame = 0u;
    reader.slot = 0u;
    reader.frame_repeats = 0u;
    reader.iterations += 17u * reader.color_count;
    reader.next = NEXT_FRAME;
}

// Reads a palette index. A symbol below the number of distinct values among a, b and c selects one of these values; otherwise
// the index follows as raw bits.
fn read_index(context: u32, a: u32, b: u32, c: u32) -> u32 {
    let place = symbol(context);
    var second = b;
    var third = c;
    var count = 1u + u32(b != a);
    if (c != a && c != b) {
        if (count == 1u) {
            second = c;
        }
        count++;
    }
    if (place >= count) {
        return few_bits(firstLeadingBit(reader.color_count - 1u) + 1u);
    }
    return select(select(third, second, place == 1u), a, place == 0u);
}

// Reads the indices of a frame, row by row. Those of the previous frame, if any, are in the other slot.
fn read_indices(side: u32, is_first: bool) {
    let before = reader.slot ^ 1u;
    var repeats = false;
    for (var number = 0u; number < side * side; number++) {
        let x = number % side;
        let y = number / side;
        let at = 32u * y + x;
        if (x == 0u && !(is_first && y == 0u)) {
            repeats = flag(select(CONTEXT_LATER_ROW, CONTEXT_ROW, is_first) + u32(repeats));
        }
        var held = 0u;
        if (!is_first) {
            held = index_in(at, before);
        }
        var above = held;
        if (y > 0u) {
            above = index_in(at - 32u, reader.slot);
        }
        if (repeats) {
            put_index(at, select(held, above, is_first));
            continue;
        }
        var left = above;
        if (x > 0u) {
            left = index_in(at - 1u, reader.slot);
        }
        if (y == 0u) {
            above = left;
        }
        if (is_first) {
            var above_left = above;
            if (x > 0u && y > 0u) {
                above_left = index_in(at - 33u, reader.slot);
            }
            var above_right = above;
            if (y > 0u && x + 1u < side) {
                above_right = index_in(at - 31u, reader.slot);
            }
            let context = u32(left == above) | (u32(above_left == left) << 1u) | (u32(above_left == above) << 2u)
                | (u32(above_right == above) << 3u);
            put_index(at, read_index(CONTEXT_PIXEL + context, left, above, above));
        } else {
            let left_changed = x > 0u && left != index_in(at - u32(x > 0u), before);
            let above_changed = y > 0u && above != index_in(at - select(0u, 32u, y > 0u), before);
            let context = u32(left_changed) | (u32(above_changed) << 1u) | (u32(left == held) << 2u)
                | (u32(above == held) << 3u);
            put_index(at, read_index(CONTEXT_LATER_PIXEL + context, held, left, above));
        }
    }
}

// Reads the indices of the next frame, or that it repeats the previous one.
fn read_next_indices(side: u32) {
    let is_first = reader.next_frame == 0u;
    reader.next_frame++;
    if (reader.color_count == 1u) {
        return;
    }
    if (!is_first) {
        reader.frame_repeats = symbol(CONTEXT_LATER_FRAME + reader.frame_repeats);
        if (reader.frame_repeats == 1u) {
            return;
        }
        reader.slot ^= 1u;
    }
    reader.iterations += side * side;
    read_indices(side, is_first);
}

// Reads the next frame of a palette block, and writes its pixels if it is the wanted frame. After the last frame, records the
// means.
fn read_frame() {
    let block = reader.block;
    let side = 4u << block.level;
    if (reader.next_frame == block.frames) {
        note_palette(block);
        reader.next = NEXT_NODE;
        return;
    }
    read_next_indices(side);
    if (reader.next_frame == frame_in(block) + 1u) {
        reader.iterations += side * side;
        for (var at = 0u; at < side * side; at++) {
            let x = at & (side - 1u);
            let y = at >> (2u + block.level);
            put(4u * block.x + x, 4u * block.y + y, palette_keys(x, y));
        }
        count_shown(block);
    }
}

fn keys_of_color(color: vec2u) -> vec3i {
    return vec3i(vec3u(color.x & 0xffffu, color.x >> 16u, color.y));
}

// Returns the keys of a pixel of the palette block.
fn palette_keys(x: u32, y: u32) -> vec3i {
    var index = 0u;
    if (reader.color_count > 1u) {
        index = index_in(32u * y + x, reader.slot);
    }
    return keys_of_color(scratch[region_slot].palette[index]);
}

// Records the means of the palette block (color.md 6.5).
fn note_palette(block: Block) {
    let squares = 1u << block.level;
    reader.iterations += 18u * squares * squares;
    for (var square = 0u; square < squares * squares; square++) {
        let x = square & (squares - 1u);
        let y = square >> block.level;
        var sums = vec3i(0);
        for (var at = 0u; at < 16u; at++) {
            sums += palette_keys(4u * x + at % 4u, 4u * y + at / 4u);
        }
        let channels = channels_of((sums + 8) >> vec3u(4u)) << vec3u(FRACTION_BITS);
        note_square(first_square(block, 0u) + 8u * y + x, channels);
    }
}
