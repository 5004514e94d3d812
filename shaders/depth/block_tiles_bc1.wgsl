// Block tiles in BC1 blocks or as raw values (depth.md 14): `impl Texel for [u8; 3]` of src/codec/depth/texel.rs. Needs
// `piece_block`, `word_at`, `stored_value` and `bc1_texel`.

fn box_value(row: BoxRow, x: u32, y: u32) -> u32 {
    if (row.coding != BOX_BLOCKS) {
        return stored_value(row, x, y);
    }
    let place = piece_block(row, x, y);
    let at = row.at + 8u * place.x;
    return bc1_texel(vec2u(word_at(at), word_at(at + 4u)), place.y);
}
