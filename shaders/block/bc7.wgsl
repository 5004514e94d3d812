// BC7 (blocks.md 8). Mirrors src/block/bc7.rs. Needs bptc.wgsl.

// How the bits of a block are dealt out.
struct Bc7Mode {
    subsets: u32,
    partition_bits: u32,
    rotation_bits: u32,
    selection_bits: u32,
    color_bits: u32,
    alpha_bits: u32,
    // Endpoints that share a lowest bit: 0 none, 1 each has its own, 2 those of a subset.
    low_bits: u32,
    index_bits: u32,
    second_index_bits: u32,
}

const BC7_MODES = array<Bc7Mode, 8>(
    Bc7Mode(3u, 4u, 0u, 0u, 4u, 0u, 1u, 3u, 0u),
    Bc7Mode(2u, 6u, 0u, 0u, 6u, 0u, 2u, 3u, 0u),
    Bc7Mode(3u, 6u, 0u, 0u, 5u, 0u, 0u, 2u, 0u),
    Bc7Mode(2u, 6u, 0u, 0u, 7u, 0u, 1u, 2u, 0u),
    Bc7Mode(1u, 0u, 2u, 1u, 5u, 6u, 0u, 2u, 3u),
    Bc7Mode(1u, 0u, 2u, 0u, 7u, 8u, 0u, 2u, 2u),
    Bc7Mode(1u, 0u, 0u, 0u, 7u, 7u, 1u, 4u, 0u),
    Bc7Mode(2u, 6u, 0u, 0u, 5u, 5u, 1u, 2u, 0u),
);

// Endpoint `number` of a block whose endpoints start at bit `at`, 8 bits a channel.
fn bc7_endpoint(words: vec4u, mode: Bc7Mode, at: u32, number: u32) -> vec4u {
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

// A pixel of a block: r | g << 8 | b << 16 | a << 24.
fn bc7_texel(words: vec4u, texel: u32) -> u32 {
    let number = countTrailingZeros(words.x);
    if (number > 7u) {
        return 0u;
    }
    let mode = BC7_MODES[number];
    var at = number + 1u;
    let parts = bptc_partition(mode.subsets, bptc_bits(words, at, mode.partition_bits));
    at += mode.partition_bits;
    let rotation = bptc_bits(words, at, mode.rotation_bits);
    at += mode.rotation_bits;
    let selection = bptc_bits(words, at, mode.selection_bits);
    at += mode.selection_bits;
    let pair = 2u * bptc_subset(parts, texel);
    let a = bc7_endpoint(words, mode, at, pair);
    let b = bc7_endpoint(words, mode, at, pair + 1u);
    at += 2u * mode.subsets * (3u * mode.color_bits + mode.alpha_bits);
    if (mode.low_bits > 0u) {
        at += 2u * mode.subsets / mode.low_bits;
    }
    // An index and how many bits it has.
    let first = vec2u(bptc_index(words, at, mode.index_bits, parts, texel), mode.index_bits);
    var of_color = first;
    var of_alpha = first;
    if (mode.second_index_bits > 0u) {
        at += 16u * mode.index_bits - mode.subsets;
        let second = vec2u(bptc_index(words, at, mode.second_index_bits, parts, texel), mode.second_index_bits);
        if (selection == 1u) {
            of_color = second;
        } else {
            of_alpha = second;
        }
    }
    let color = bptc_mix(a.xyz, b.xyz, of_color.x, of_color.y);
    let alpha = bptc_mix(a.www, b.www, of_alpha.x, of_alpha.y).x;
    var pixel = vec4u(color, alpha);
    switch (rotation) {
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

// All pixels of a block.
fn bc7_texels(words: vec4u, out: ptr<function, array<u32, 16>>) {
    for (var texel = 0u; texel < 16u; texel++) {
        (*out)[texel] = bc7_texel(words, texel);
    }
}
