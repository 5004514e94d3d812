// BC5 (blocks.md 5). Mirrors src/codec/block/formats.rs. Needs `bc4_texel`.

// Decodes one pixel: r | g << 8.
fn bc5_texel(words: vec4u, texel: u32) -> u32 {
    return bc4_texel(words.xy, texel) | (bc4_texel(words.zw, texel) << 8u);
}

// Decodes all 16 pixels of a block.
fn bc5_texels(words: vec4u, out: ptr<function, array<u32, 16>>) {
    for (var texel = 0u; texel < 16u; texel++) {
        (*out)[texel] = bc5_texel(words, texel);
    }
}
