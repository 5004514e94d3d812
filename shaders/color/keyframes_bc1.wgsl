// Keyframes in blocks of BC1 or as samples (color.md 4). Mirrors src/color/keyframe_blocks.rs. Needs `word_at`,
// `sample_block` and `bc1_texels`.

fn keyframe_block(keyframe: Record, unit: Unit, block: u32, out: ptr<function, array<u32, 16>>) {
    if (keyframe.coding != KEYFRAME_BLOCKS) {
        sample_block(keyframe, unit, block, out);
        return;
    }
    let at = keyframe.at + 8u * block;
    bc1_texels(vec2u(word_at(at), word_at(at + 4u)), out);
}
