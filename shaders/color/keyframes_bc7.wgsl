// Keyframes in BC7 blocks (color.md 4). Mirrors src/codec/color/keyframe_blocks.rs. Needs `word_at` and `bc7_texels`.

fn keyframe_block(keyframe: Record, block: u32, out: ptr<function, array<u32, 16>>) {
    let at = keyframe.at + 16u * block;
    bc7_texels(vec4u(word_at(at), word_at(at + 4u), word_at(at + 8u), word_at(at + 12u)), out);
}
