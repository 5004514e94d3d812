// Block tiles of boxes in blocks (depth.md 14): which block holds a pixel. Mirrors src/depth/block_tiles.rs; the table of boxes has
// a row for each piece.

// Number of the block that holds a pixel of a piece, and of the pixel in it.
fn piece_block(row: BoxRow, x: u32, y: u32) -> vec2u {
    let columns = (row.width + 3u) / 4u;
    return vec2u(y / 4u * columns + x / 4u, y % 4u * 4u + x % 4u);
}
