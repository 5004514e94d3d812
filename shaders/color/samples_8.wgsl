// Pixels of keyframes that are stored as they are, three bytes each (color.md 4). Needs `byte_at`.

fn sample_pixel(keyframe: Record, pixel: u32) -> vec3u {
    let at = keyframe.at + 3u * pixel;
    return vec3u(byte_at(at), byte_at(at + 1u), byte_at(at + 2u));
}
