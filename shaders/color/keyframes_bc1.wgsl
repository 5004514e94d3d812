// Keyframes in BC1 blocks (color.md 4). Mirrors src/codec/color/keyframe_blocks.rs. Needs `word_at` and `bc1_texels`.

fn keyframe_block(keyframe: Record, block: u32, out: ptr<function, array<u32, 16>>) {
    let at = keyframe.at + 8u * block;
    bc1_texels(vec2u(word_at(at), word_at(at + 4u)), out);
}
