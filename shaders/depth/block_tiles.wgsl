// Block tiles of block-compressed boxes (depth.md 14): finds the block that holds a pixel. Mirrors src/codec/depth/block_tiles.rs;
// the table of boxes has one row per piece.

// Returns the index of the block that holds a pixel of a piece, and the index of the pixel in that block.
fn piece_block(row: BoxRow, x: u32, y: u32) -> vec2u {
    let columns = (row.width + 3u) / 4u;
    return vec2u(y / 4u * columns + x / 4u, y % 4u * 4u + x % 4u);
}
