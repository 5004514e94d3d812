// Cells of half-float samples (color.md 3, 4). Needs `word_at`, `half_at`, `pack` and `pictures`.

fn empty_block() -> array<vec2u, 16> {
    return array<vec2u, 16>();
}

// Reads a pixel of a raw keyframe: three half floats per pixel.
fn sample_pixel(keyframe: Record, pixel: u32) -> vec3u {
    let at = keyframe.at + 6u * pixel;
    return unpack(vec2u(word_at(at), half_at(at + 4u)));
}

fn put_pixel(unit: Unit, pixel: u32, color: vec3u) {
    let words = pack(color);
    let at = unit.picture + 2u * pixel;
    pictures[at] = words.x;
    pictures[at + 1u] = words.y;
}
