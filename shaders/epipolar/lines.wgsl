// Columns of lines (Epipolar 3.3.2): `moved` of src/epipolar/lines.rs. Needs `product`.

const COLUMN_BITS: u32 = 8u;
const MAX_MOVED: i32 = 0x20000000;

// Returns (disparity · place + 2^27) >> 28, clamped to ±MAX_MOVED.
fn moved(disparity: i32, place: i32) -> i32 {
    var found = product(u32(abs(disparity)), u32(abs(place)));
    if ((disparity < 0) != (place < 0)) {
        found = vec2u(~found.x + 1u, ~found.y + select(0u, 1u, found.x == 0u));
    }
    let rounded = found.x + (1u << 27u);
    let high = found.y + select(0u, 1u, rounded < found.x);
    // The result is out of range if the top bits of the high word are not all equal to its sign bit.
    let beyond = i32(high) >> 25u;
    if (beyond != 0 && beyond != -1) {
        return select(MAX_MOVED, -MAX_MOVED, beyond < 0);
    }
    return i32((high << 4u) | (rounded >> 28u));
}
