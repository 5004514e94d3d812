// Keyframes in blocks of BC7 or as samples (color.md 4). Needs `block_of`, `word_at`, `sample_pixel` and
// `bc7_texel`.

fn keyframe_pixel(keyframe: Record, unit: Unit, pixel: u32) -> vec3u {
    if (keyframe.coding != KEYFRAME_BLOCKS) {
        return sample_pixel(keyframe, pixel);
    }
    let place = block_of(unit, pixel);
    let at = keyframe.at + 16u * place.x;
    let texel = bc7_texel(vec4u(word_at(at), word_at(at + 4u), word_at(at + 8u), word_at(at + 12u)), place.y);
    return vec3u(texel & 255u, (texel >> 8u) & 255u, (texel >> 16u) & 255u);
}
