// BC7 (blocks.md 8). Mirrors src/codec/block/bc7.rs. Needs bptc.wgsl.

// Bit allocation of a mode.
struct Bc7Mode {
    subsets: u32,
    partition_bits: u32,
    rotation_bits: u32,
    selection_bits: u32,
    color_bits: u32,
    alpha_bits: u32,
    // P-bits: 0 none, 1 one per endpoint, 2 one per subset.
    low_bits: u32,
    index_bits: u32,
    second_index_bits: u32,
}

// Returns a row of the mode table in blocks.md 8; subsets is 0 if the mode is reserved.
fn bc7_mode(number: u32) -> Bc7Mode {
    switch (number) {
        case 0u: {
            return Bc7Mode(3u, 4u, 0u, 0u, 4u, 0u, 1u, 3u, 0u);
        }
        case 1u: {
            return Bc7Mode(2u, 6u, 0u, 0u, 6u, 0u, 2u, 3u, 0u);
        }
        case 2u: {
            return Bc7Mode(3u, 6u, 0u, 0u, 5u, 0u, 0u, 2u, 0u);
        }
        case 3u: {
            return Bc7Mode(2u, 6u, 0u, 0u, 7u, 0u, 1u, 2u, 0u);
        }
        case 4u: {
            return Bc7Mode(1u, 0u, 2u, 1u, 5u, 6u, 0u, 2u, 3u);
        }
        case 5u: {
            return Bc7Mode(1u, 0u, 2u, 0u, 7u, 8u, 0u, 2u, 2u);
        }
        case 6u: {
            return Bc7Mode(1u, 0u, 0u, 0u, 7u, 7u, 1u, 4u, 0u);
        }
        case 7u: {
            return Bc7Mode(2u, 6u, 0u, 0u, 5u, 5u, 1u, 2u, 0u);
        }
        default: {
            return Bc7Mode();
        }
    }
}

// Fields of a block before the endpoints, and the bit offsets of the endpoints and indices.
struct Bc7 {
    words: vec4u,
    mode: Bc7Mode,
    parts: BptcPartition,
    rotation: u32,
    selection: u32,
    endpoints_at: u32,
    indices_at: u32,
    second_indices_at: u32,
}

fn bc7_open(words: vec4u) -> Bc7 {
    let number = countTrailingZeros(words.x);
    let mode = bc7_mode(number);
    let rotation_at = number + 1u + mode.partition_bits;
    let selection_at = rotation_at + mode.rotation_bits;
    let endpoints_at = selection_at + mode.selection_bits;
    var indices_at = endpoints_at + 2u * mode.subsets * (3u * mode.color_bits + mode.alpha_bits);
    if (mode.low_bits > 0u) {
        indices_at += 2u * mode.subsets / mode.low_bits;
    }
    return Bc7(
        words,
        mode,
        bptc_partition(mode.subsets, bptc_bits(words, number + 1u, mode.partition_bits)),
        bptc_bits(words, rotation_at, mode.rotation_bits),
        bptc_bits(words, selection_at, mode.selection_bits),
        endpoints_at,
        indices_at,
        indices_at + 16u * mode.index_bits - mode.subsets,
    );
}

// Decodes endpoint `number` to 8 bits per channel.
fn bc7_endpoint(block: Bc7, number: u32) -> vec4u {
    let words = block.words;
    let mode = block.mode;
    let at = block.endpoints_at;
    let step = 2u * mode.subsets * mode.color_bits;
    let color_at = at + number * mode.color_bits;
    var value = vec4u(
        bptc_bits(words, color_at, mode.color_bits),
        bptc_bits(words, color_at + step, mode.color_bits),
        bptc_bits(words, color_at + 2u * step, mode.color_bits),
        bptc_bits(words, at + 3u * step + number * mode.alpha_bits, mode.alpha_bits),
    );
    var count = vec4u(vec3u(mode.color_bits), mode.alpha_bits);
    if (mode.low_bits > 0u) {
        let low_at = at + 3u * step + 2u * mode.subsets * mode.alpha_bits;
        value = (value << vec4u(1u)) | vec4u(bptc_bits(words, low_at + number / mode.low_bits, 1u));
        count += 1u;
    }
    if (mode.alpha_bits == 0u) {
        value.w = 255u;
        count.w = 8u;
    }
    return (value << (8u - count)) | (value >> (2u * count - 8u));
}

// Decodes one pixel: r | g << 8 | b << 16 | a << 24.
fn bc7_pixel(block: Bc7, texel: u32) -> u32 {
    let mode = block.mode;
    if (mode.subsets == 0u) {
        return 0u;
    }
    let pair = 2u * bptc_subset(block.parts, texel);
    let a = bc7_endpoint(block, pair);
    let b = bc7_endpoint(block, pair + 1u);
    // An index and its number of bits.
    let first = vec2u(bptc_index(block.words, block.indices_at, mode.index_bits, block.parts, texel), mode.index_bits);
    var of_color = first;
    var of_alpha = first;
    if (mode.second_index_bits > 0u) {
        let count = mode.second_index_bits;
        let second = vec2u(bptc_index(block.words, block.second_indices_at, count, block.parts, texel), count);
        if (block.selection == 1u) {
            of_color = second;
        } else {
            of_alpha = second;
        }
    }
    let color = bptc_mix(a.xyz, b.xyz, of_color.x, of_color.y);
    let alpha = bptc_mix(a.www, b.www, of_alpha.x, of_alpha.y).x;
    var pixel = vec4u(color, alpha);
    switch (block.rotation) {
        case 1u: {
            pixel = pixel.wyzx;
        }
        case 2u: {
            pixel = pixel.xwzy;
        }
        case 3u: {
            pixel = pixel.xywz;
        }
        default: {}
    }
    return pixel.x | (pixel.y << 8u) | (pixel.z << 16u) | (pixel.w << 24u);
}

// Decodes all 16 pixels of a block.
fn bc7_texels(words: vec4u, out: ptr<function, array<u32, 16>>) {
    let block = bc7_open(words);
    for (var texel = 0u; texel < 16u; texel++) {
        (*out)[texel] = bc7_pixel(block, texel);
    }
}
