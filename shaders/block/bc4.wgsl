// BC4 (blocks.md 4). Mirrors src/codec/block/formats.rs.

// Decodes the value of one pixel.
fn bc4_texel(words: vec2u, texel: u32) -> u32 {
    let at = 16u + 3u * texel;
    let shift = at & 31u;
    var i = words[at >> 5u] >> shift;
    if (shift > 29u) {
        i |= words.y << (32u - shift);
    }
    i &= 7u;
    let a = words.x & 255u;
    let b = (words.x >> 8u) & 255u;
    if (i == 0u) {
        return a;
    }
    if (i == 1u) {
        return b;
    }
    if (a > b) {
        return ((8u - i) * a + (i - 1u) * b + 3u) / 7u;
    }
    if (i == 6u) {
        return 0u;
    }
    if (i == 7u) {
        return 255u;
    }
    return ((6u - i) * a + (i - 1u) * b + 2u) / 5u;
}

// Decodes all 16 values of a block.
fn bc4_texels(words: vec2u, out: ptr<function, array<u32, 16>>) {
    for (var texel = 0u; texel < 16u; texel++) {
        (*out)[texel] = bc4_texel(words, texel);
    }
}
