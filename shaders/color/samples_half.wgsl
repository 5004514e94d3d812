// Pixels of keyframes that are stored as they are, three halves each (color.md 4). Needs `word_at` and
// `half_at`.

fn sample_pixel(keyframe: Record, pixel: u32) -> vec3u {
    let at = keyframe.at + 6u * pixel;
    let low = word_at(at);
    return vec3u(low & 0xffffu, low >> 16u, half_at(at + 4u));
}
