// Block tiles in BC5 blocks or as raw values (depth.md 14): `impl Texel for u16` of src/codec/depth/texel.rs. Needs `piece_block`,
// `word_at`, `stored_value` and `bc5_texel`.

fn box_value(row: BoxRow, x: u32, y: u32) -> u32 {
    if (row.coding != BOX_BLOCKS) {
        return stored_value(row, x, y);
    }
    let place = piece_block(row, x, y);
    let at = row.at + 16u * place.x;
    let texel = bc5_texel(vec4u(word_at(at), word_at(at + 4u), word_at(at + 8u), word_at(at + 12u)), place.y);
    // Red is the high byte.
    return ((texel & 255u) << 8u) | (texel >> 8u);
}
