// Platelets: two planes divided by a line (arithmetic.md 6). Mirrors src/codec/depth/platelet.rs. Needs `stream`.

struct Plane {
    a0: i32,
    a1: i32,
    a5: i32,
}

// Side test of the line: a pixel is on side B if the value is positive.
struct SideTest {
    start: i32,
    across: i32,
    down: i32,
}

struct Platelet {
    a: Plane,
    b: Plane,
    test: SideTest,
}

fn side_test(line: u32, level: u32) -> SideTest {
    let units = 8i << level;
    let shared_units = min(units, 256);
    let of_pixels = 256 / shared_units;
    let of_points = units / shared_units;
    let x0 = i32(line & 255u);
    let y0 = i32((line >> 8u) & 255u);
    let dx = i32((line >> 16u) & 255u) - x0;
    let dy = i32(line >> 24u) - y0;
    let start = dx * (of_pixels - y0 * of_points) - dy * (of_pixels - x0 * of_points);
    return SideTest(start, -dy * 2 * of_pixels, dx * 2 * of_pixels);
}

fn plane_at(at: u32) -> Plane {
    return Plane(bitcast<i32>(stream[at]), bitcast<i32>(stream[at + 1u]), bitcast<i32>(stream[at + 2u]));
}

fn platelet_at(at: u32, level: u32) -> Platelet {
    return Platelet(plane_at(at), plane_at(at + 3u), side_test(stream[at + 6u], level));
}

// Evaluates the function at a pixel, in Q14 with wrapping arithmetic.
fn platelet_value(f: Platelet, x: i32, y: i32) -> i32 {
    var side = f.a;
    if (f.test.start + f.test.across * x + f.test.down * y > 0) {
        side = f.b;
    }
    return side.a5 + side.a0 * x + side.a1 * y;
}
