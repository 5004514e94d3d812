// Packing and interpolation of half-float pixels: `impl Sample for HalfKey` of src/codec/color/blend.rs. Needs `lerp`.

// Unpacks a pixel from the layout of `pictures`: r | g << 16 in the first word, b in the second.
fn unpack(pixel: vec2u) -> vec3u {
    return vec3u(pixel.x & 0xffffu, pixel.x >> 16u, pixel.y & 0xffffu);
}

fn pack(color: vec3u) -> vec2u {
    return vec2u(color.x | (color.y << 16u), color.z);
}

fn between(a: vec3u, b: vec3u, weight: u32) -> vec3u {
    return bits_of(lerp(keys_of(a), keys_of(b), weight));
}
