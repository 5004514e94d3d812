// Pixels of keyframes that are stored as they are, three halves each (color.md 4). Needs `half_at`.

fn sample_pixel(keyframe: Record, pixel: u32) -> vec3u {
    let at = keyframe.at + 6u * pixel;
    return vec3u(half_at(at), half_at(at + 2u), half_at(at + 4u));
}
