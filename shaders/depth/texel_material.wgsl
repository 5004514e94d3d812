// Boxes of material (depth.md 4, 5). Mirrors `impl Texel for [u8; 3]` of src/codec/depth/texel.rs. An invocation writes a pixel.
// Needs `box_value`.

@group(0) @binding(0) var<storage, read> units: array<Unit>;
@group(0) @binding(1) var<storage, read> records: array<Record>;
@group(0) @binding(2) var<storage, read> jobs: Jobs;
@group(0) @binding(3) var<storage, read> boxes: array<BoxRow>;
@group(0) @binding(4) var<storage, read> stream: array<u32>;
@group(0) @binding(5) var<storage, read_write> pictures: array<u32>;

// Reads the pixel at column x and row y of a box that is not block-compressed: r | g << 8 | b << 16.
fn stored_value(row: BoxRow, x: u32, y: u32) -> u32 {
    var at = row.at;
    if (row.coding != BOX_CONSTANT) {
        at += 3u * (y * row.width + x);
    }
    return word_at(at) & 0xffffffu;
}

@compute @workgroup_size(WORKGROUP)
fn decode_material(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let invocation = invocation_of(id, groups);
    if (invocation >= jobs.total) {
        return;
    }
    let found = box_part(invocation);
    let unit = units[found.unit];
    let row = boxes[found.row];
    let x = found.part % row.width;
    let y = found.part / row.width;
    pictures[unit.picture + (row.y + y) * unit.stride + row.x + x] = box_value(row, x, y);
}
