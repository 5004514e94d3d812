// Blocks of few colours (color.md 6.8). Mirrors src/color/transform/palette.rs. Colours are two words: keys of red and green,
// key of blue.

var<workgroup> cache: array<vec2u, 15>;
var<workgroup> palette: array<vec2u, 16>;

// The indices of two frames are in turns in the low and the high half of the bytes of `scratch`.
fn index_in(position: u32, of_slot: u32) -> u32 {
    return (u32(scratch[position]) >> (4u * of_slot)) & 15u;
}

fn put_index(position: u32, index: u32) {
    let shift = 4u * reader.slot;
    scratch[position] = i32((u32(scratch[position]) & ~(15u << shift)) | (index << shift));
}

// Moves a colour to the front of the cache; the last one is dropped where it is new and the cache is full.
fn touch(color: vec2u) {
    var moved = color;
    var at = 0u;
    loop {
        let held = cache[at];
        cache[at] = moved;
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
            palette[at] = cache[place];
        } else {
            let red = bits(KEY_BITS);
            let green = bits(KEY_BITS);
            palette[at] = vec2u(red | (green << 16u), bits(KEY_BITS));
        }
    }
    for (var at = reader.color_count; at > 0u; at--) {
        touch(palette[at - 1u]);
    }
    reader.next_frame = 0u;
    reader.slot = 0u;
    reader.frame_repeats = 0u;
    reader.in_palette = 1u;
}

// Reads an index: that of the first, second or third of the different ones among a, b and c, or another one.
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

// Reads indices of a frame, row by row. Those of the frame before are in the other slot; none are before the first frame.
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

// Reads the next frame of the palette's block.
fn read_frame(side: u32) {
    let is_first = reader.next_frame == 0u;
    reader.next_frame++;
    if (reader.color_count == 1u) {
        return;
    }
    reader.iterations += side * side;
    if (!is_first) {
        reader.frame_repeats = symbol(CONTEXT_LATER_FRAME + reader.frame_repeats);
        if (reader.frame_repeats == 1u) {
            return;
        }
        reader.slot ^= 1u;
    }
    read_indices(side, is_first);
}

fn keys_of_color(color: vec2u) -> vec3i {
    return vec3i(vec3u(color.x & 0xffffu, color.x >> 16u, color.y));
}

// Keys of a pixel of a block with a palette.
fn palette_keys(x: u32, y: u32, color_count: u32, of_slot: u32) -> vec3i {
    var index = 0u;
    if (color_count > 1u) {
        index = index_in(32u * y + x, of_slot);
    }
    return keys_of_color(palette[index]);
}

// Notes the mean of square (x, y) of a block with a palette (color.md 6.5).
fn note_palette(block: Block, x: u32, y: u32, color_count: u32, of_slot: u32) {
    var sums = vec3i(0);
    for (var at = 0u; at < 16u; at++) {
        sums += palette_keys(4u * x + at % 4u, 4u * y + at / 4u, color_count, of_slot);
    }
    let channels = channels_of((sums + 8) >> vec3u(4u)) << vec3u(FRACTION_BITS);
    note_square(first_square(block, 0u) + 8u * y + x, channels);
}
