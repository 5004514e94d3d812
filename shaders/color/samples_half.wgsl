// Cells of half floats (color.md 3, 4): `impl Sample for HalfKey` of src/color/blend.rs. Needs `word_at`, `half_at`, `lerp`
// and `pictures`.

// A pixel as it lies in pictures: r | g << 16, then b.
fn unpack(pixel: vec2u) -> vec3u {
    return vec3u(pixel.x & 0xffffu, pixel.x >> 16u, pixel.y & 0xffffu);
}

fn pack(color: vec3u) -> vec2u {
    return vec2u(color.x | (color.y << 16u), color.z);
}

fn empty_block() -> array<vec2u, 16> {
    return array<vec2u, 16>();
}

// A pixel of a keyframe that is stored as it is, three halves each.
fn sample_pixel(keyframe: Record, pixel: u32) -> vec3u {
    let at = keyframe.at + 6u * pixel;
    return unpack(vec2u(word_at(at), half_at(at + 4u)));
}

fn between(a: vec3u, b: vec3u, weight: u32) -> vec3u {
    return bits_of(lerp(keys_of(a), keys_of(b), weight));
}

fn put_pixel(unit: Unit, pixel: u32, color: vec3u) {
    let words = pack(color);
    let at = unit.picture + 2u * pixel;
    pictures[at] = words.x;
    pictures[at + 1u] = words.y;
}
