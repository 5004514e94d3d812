// Boxes without block compression (depth.md 4). Needs `stored_value`.

fn box_value(row: BoxRow, x: u32, y: u32) -> u32 {
    return stored_value(row, x, y);
}
