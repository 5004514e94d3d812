// Cells of half floats (color.md 3, 4). Needs `word_at`, `half_at`, `pack` and `pictures`.

fn empty_block() -> array<vec2u, 16> {
    return array<vec2u, 16>();
}

// A pixel of a keyframe that is stored as it is, three halves each.
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
