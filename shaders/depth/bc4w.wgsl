// BC4w blocks (depth.md 8). Mirrors src/codec/depth/bc4w.rs. Needs `stream`.

struct Bc4w {
    // 13-bit endpoints of sides A and B.
    a: vec2u,
    b: vec2u,
    // Endpoints of the line: x0, y0, x1, y1.
    line: vec4i,
}

fn bc4w_at(at: u32) -> Bc4w {
    let low = stream[at + 6u];
    let high = stream[at + 7u];
    let a = vec2u(low & 8191u, (low >> 13u) & 8191u);
    let b = vec2u(((low >> 26u) | (high << 6u)) & 8191u, (high >> 7u) & 8191u);
    let line = (vec4u(high) >> vec4u(20u, 23u, 26u, 29u)) & vec4u(7u);
    return Bc4w(a, b, vec4i(line));
}

// Returns the 16-bit code of a 3-bit index between two 13-bit endpoints.
fn palette_code(endpoints: vec2u, index: u32) -> u32 {
    let d = (endpoints << vec2u(3u)) | (endpoints >> vec2u(10u));
    if (index == 0u) {
        return d.x;
    }
    if (index == 1u) {
        return d.y;
    }
    if (endpoints.x > endpoints.y) {
        return ((8u - index) * d.x + (index - 1u) * d.y + 3u) / 7u;
    }
    if (index == 6u) {
        return 0u;
    }
    if (index == 7u) {
        return 65535u;
    }
    return ((6u - index) * d.x + (index - 1u) * d.y + 2u) / 5u;
}

// Returns the code of pixel (x, y), both 0 to 7, of the block whose first word is at `at`.
fn bc4w_code(block: Bc4w, at: u32, x: u32, y: u32) -> u32 {
    let bit = 24u * y + 3u * x;
    let shift = bit & 31u;
    var index = stream[at + (bit >> 5u)] >> shift;
    if (shift > 29u) {
        index |= stream[at + (bit >> 5u) + 1u] << (32u - shift);
    }
    let p = vec2i(i32(x), i32(y)) - block.line.xy;
    let d = block.line.zw - block.line.xy;
    return palette_code(select(block.a, block.b, d.x * p.y - d.y * p.x > 0), index & 7u);
}
