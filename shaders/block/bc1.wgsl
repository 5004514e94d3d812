// BC1 (blocks.md 3). Mirrors src/codec/block/formats.rs.

// Expands a 5:6:5 colour to 8 bits per channel by replicating the high bits.
fn bc1_expand(color: u32) -> vec3u {
    let r = color >> 11u;
    let g = (color >> 5u) & 63u;
    let b = color & 31u;
    return vec3u((r << 3u) | (r >> 2u), (g << 2u) | (g >> 4u), (b << 3u) | (b >> 2u));
}

// Decodes one pixel: r | g << 8 | b << 16.
fn bc1_texel(words: vec2u, texel: u32) -> u32 {
    let first = words.x & 0xffffu;
    let second = words.x >> 16u;
    let a = bc1_expand(first);
    let b = bc1_expand(second);
    var color = a;
    switch ((words.y >> (2u * texel)) & 3u) {
        case 0u: {}
        case 1u: {
            color = b;
        }
        case 2u: {
            color = select((a + b + 1u) >> vec3u(1u), (2u * a + b + 1u) / 3u, first > second);
        }
        default: {
            color = select(vec3u(0u), (a + 2u * b + 1u) / 3u, first > second);
        }
    }
    return color.x | (color.y << 8u) | (color.z << 16u);
}

// Decodes all 16 pixels of a block.
fn bc1_texels(words: vec2u, out: ptr<function, array<u32, 16>>) {
    for (var texel = 0u; texel < 16u; texel++) {
        (*out)[texel] = bc1_texel(words, texel);
    }
}
