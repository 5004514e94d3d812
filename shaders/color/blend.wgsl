// Interpolation between two keyframes (arithmetic.md 3, 4). Mirrors src/codec/color/blend.rs.

fn lerp(a: vec3u, b: vec3u, weight: u32) -> vec3u {
    return (a * (255u - weight) + b * weight + 127u) / 255u;
}

// Maps bit patterns of half floats to integer keys that increase with the value.
fn keys_of(bits: vec3u) -> vec3u {
    return bits ^ select(vec3u(0x8000u), vec3u(0xffffu), bits >= vec3u(0x8000u));
}

fn bits_of(keys: vec3u) -> vec3u {
    return keys ^ select(vec3u(0xffffu), vec3u(0x8000u), keys >= vec3u(0x8000u));
}
