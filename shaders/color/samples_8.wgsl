// Pixels of keyframes that are stored as they are, three bytes each (color.md 4). Needs `word_at`.

fn sample_pixel(keyframe: Record, pixel: u32) -> vec3u {
    let bytes = word_at(keyframe.at + 3u * pixel);
    return vec3u(bytes & 255u, (bytes >> 8u) & 255u, (bytes >> 16u) & 255u);
}
