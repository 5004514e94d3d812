// Keyframes of samples alone (color.md 4). Needs `sample_pixel`.

fn keyframe_pixel(keyframe: Record, unit: Unit, pixel: u32) -> vec3u {
    return sample_pixel(keyframe, pixel);
}
