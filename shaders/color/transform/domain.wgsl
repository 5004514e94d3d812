// Conversion between keys and channels (color.md 6.2). Mirrors src/codec/color/transform/domain.rs. Needs `slope_of` and `MIDDLE`.

fn predicted_chroma(slope: i32, luma: i32) -> i32 {
    return (slope * luma + 8) >> 4u;
}

fn channels_of(keys: vec3i) -> vec3i {
    let orange = keys.x - keys.z;
    let middle = keys.z + (orange >> 1u);
    let green = keys.y - middle;
    let luma = middle + (green >> 1u) - MIDDLE;
    return vec3i(luma, green - predicted_chroma(slope_of(1u), luma), orange - predicted_chroma(slope_of(2u), luma));
}

// Both the channels and the keys are in units of 2^-fraction.
fn keys_of_channels(channels: vec3i, fraction: u32) -> vec3i {
    let chroma_green = channels.y + predicted_chroma(slope_of(1u), channels.x);
    let orange = channels.z + predicted_chroma(slope_of(2u), channels.x);
    let middle = channels.x + (MIDDLE << fraction) - (chroma_green >> 1u);
    let blue = middle - (orange >> 1u);
    return vec3i(blue + orange, chroma_green + middle, blue);
}
