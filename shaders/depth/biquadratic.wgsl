// Biquadratic functions (arithmetic.md 6). Mirrors src/codec/depth/biquadratic.rs. Needs `stream`.

struct Biquadratic {
    a0: i32,
    a1: i32,
    a2: i32,
    a3: i32,
    a4: i32,
    a5: i32,
}

fn biquadratic_at(at: u32) -> Biquadratic {
    return Biquadratic(
        bitcast<i32>(stream[at]),
        bitcast<i32>(stream[at + 1u]),
        bitcast<i32>(stream[at + 2u]),
        bitcast<i32>(stream[at + 3u]),
        bitcast<i32>(stream[at + 4u]),
        bitcast<i32>(stream[at + 5u]),
    );
}

// Evaluates the function at a pixel, in Q14 with wrapping arithmetic.
fn biquadratic_value(f: Biquadratic, x: i32, y: i32) -> i32 {
    let u = f.a0 + ((f.a2 * y + f.a3 * x + 128) >> 8u);
    let v = f.a1 + ((f.a4 * y + 128) >> 8u);
    return f.a5 + u * x + v * y;
}
