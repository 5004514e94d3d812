// Keyframes in blocks of BC1 or as samples (color.md 4). Needs `block_of`, `word_at`, `sample_pixel` and
// `bc1_texel`.

fn keyframe_pixel(keyframe: Record, unit: Unit, pixel: u32) -> vec3u {
    if (keyframe.coding != KEYFRAME_BLOCKS) {
        return sample_pixel(keyframe, pixel);
    }
    let place = block_of(unit, pixel);
    let at = keyframe.at + 8u * place.x;
    let texel = bc1_texel(vec2u(word_at(at), word_at(at + 4u)), place.y);
    return vec3u(texel & 255u, (texel >> 8u) & 255u, (texel >> 16u) & 255u);
}
