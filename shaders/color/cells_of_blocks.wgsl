// Decodes cells whose keyframes may be block-compressed (color.md 4): `CellState` of src/codec/decode/decoder.rs. An invocation
// writes the 4x4 pixels of a block. Needs `keyframe_block`, `empty_block`, `unpack`, `sample_pixel`, `between` and `put_pixel`.

@group(0) @binding(0) var<storage, read> units: array<Unit>;
@group(0) @binding(1) var<storage, read> records: array<Record>;
@group(0) @binding(2) var<storage, read> jobs: Jobs;
@group(0) @binding(3) var<storage, read> stream: array<u32>;
@group(0) @binding(4) var<storage, read_write> pictures: array<u32>;

fn in_blocks(keyframe: Record) -> bool {
    return keyframe.coding == KEYFRAME_BLOCKS;
}

@compute @workgroup_size(WORKGROUP)
fn decode_blocks(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let invocation = invocation_of(id, groups);
    if (invocation >= jobs.total) {
        return;
    }
    let number = job_of(invocation);
    let job = jobs.list[number];
    let unit = units[job.unit];
    let block = invocation - job_begin(number);
    let first = records[job.record];
    let second = records[job.next];
    var first_block = empty_block();
    var second_block = empty_block();
    if (in_blocks(first)) {
        keyframe_block(first, block, &first_block);
    }
    if (job.weight > 0u && in_blocks(second)) {
        keyframe_block(second, block, &second_block);
    }
    let columns = (unit.width + 3u) / 4u;
    let corner = 4u * vec2u(block % columns, block / columns);
    for (var texel = 0u; texel < 16u; texel++) {
        let x = corner.x + texel % 4u;
        let y = corner.y + texel / 4u;
        if (x >= unit.width || y >= unit.height) {
            continue;
        }
        let pixel = y * unit.width + x;
        var color = unpack(first_block[texel]);
        if (!in_blocks(first)) {
            color = sample_pixel(first, pixel);
        }
        if (job.weight > 0u) {
            var next = unpack(second_block[texel]);
            if (!in_blocks(second)) {
                next = sample_pixel(second, pixel);
            }
            color = between(color, next, job.weight);
        }
        put_pixel(unit, pixel, color);
    }
}
