// Keyframes in blocks (color.md 4): which block holds a pixel. Mirrors src/color/keyframe_blocks.rs.

// Number of the block that holds a pixel, and of the pixel in it.
fn block_of(unit: Unit, pixel: u32) -> vec2u {
    let x = pixel % unit.width;
    let y = pixel / unit.width;
    let columns = (unit.width + 3u) / 4u;
    return vec2u(y / 4u * columns + x / 4u, y % 4u * 4u + x % 4u);
}
