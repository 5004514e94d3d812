// Cells of 8-bit samples (color.md 3, 4): `impl Sample for u8` of src/codec/color/blend.rs. Needs `word_at`, `lerp` and `pictures`.

// Unpacks a pixel from the layout of `pictures`: r | g << 8 | b << 16.
fn unpack(pixel: u32) -> vec3u {
    return vec3u(pixel & 255u, (pixel >> 8u) & 255u, (pixel >> 16u) & 255u);
}

fn pack(color: vec3u) -> u32 {
    return color.x | (color.y << 8u) | (color.z << 16u);
}

fn empty_block() -> array<u32, 16> {
    return array<u32, 16>();
}

// Reads a pixel of a raw keyframe: three bytes per pixel.
fn sample_pixel(keyframe: Record, pixel: u32) -> vec3u {
    return unpack(word_at(keyframe.at + 3u * pixel));
}

fn between(a: vec3u, b: vec3u, weight: u32) -> vec3u {
    return lerp(a, b, weight);
}

fn put_pixel(unit: Unit, pixel: u32, color: vec3u) {
    // The row stride may exceed the width.
    pictures[unit.picture + pixel + pixel / unit.width * (unit.stride - unit.width)] = pack(color);
}
