// Boxes of depth codes (depth.md 4). Mirrors `impl Texel for u16` of src/codec/depth/texel.rs.
//
// An invocation writes a word: two codes, or only the one inside the box. Another box of the record may write the other half of
// the same word, so a single half is written with atomic bit operations. Needs `box_value`.

@group(0) @binding(0) var<storage, read> units: array<Unit>;
@group(0) @binding(1) var<storage, read> records: array<Record>;
@group(0) @binding(2) var<storage, read> jobs: Jobs;
@group(0) @binding(3) var<storage, read> boxes: array<BoxRow>;
@group(0) @binding(4) var<storage, read> stream: array<u32>;
@group(0) @binding(5) var<storage, read_write> pictures: array<atomic<u32>>;

// Reads the code at column x and row y of a box that is not block-compressed.
fn stored_value(row: BoxRow, x: u32, y: u32) -> u32 {
    if (row.coding == BOX_CONSTANT) {
        return half_at(row.at);
    }
    return half_at(row.at + 2u * (y * row.width + x));
}

@compute @workgroup_size(WORKGROUP)
fn decode_codes(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let invocation = invocation_of(id, groups);
    if (invocation >= jobs.total) {
        return;
    }
    let found = box_part(invocation);
    let unit = units[found.unit];
    let row = boxes[found.row];
    let first = row.x / 2u;
    let words = (row.x + row.width + 1u) / 2u - first;
    let y = found.part / words;
    let word = first + found.part % words;
    let at = unit.picture + (row.y + y) * unit.stride + word;
    let left = 2u * word >= row.x;
    let right = 2u * word + 1u < row.x + row.width;
    var codes = 0u;
    var mask = 0u;
    if (left) {
        codes = box_value(row, 2u * word - row.x, y);
        mask = 0xffffu;
    }
    if (right) {
        codes |= box_value(row, 2u * word + 1u - row.x, y) << 16u;
        mask |= 0xffff0000u;
    }
    if (left && right) {
        atomicStore(&pictures[at], codes);
    } else {
        atomicAnd(&pictures[at], ~mask);
        atomicOr(&pictures[at], codes);
    }
}
