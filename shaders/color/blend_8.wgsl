// Cells of 8-bit samples (color.md 4): `impl Sample for u8` of src/color/blend.rs. An invocation writes a pixel. Needs
// `keyframe_pixel`.

@group(0) @binding(0) var<storage, read> units: array<Unit>;
@group(0) @binding(1) var<storage, read> records: array<Record>;
@group(0) @binding(2) var<storage, read> jobs: Jobs;
@group(0) @binding(3) var<storage, read> stream: array<u32>;
@group(0) @binding(4) var<storage, read_write> pictures: array<u32>;

@compute @workgroup_size(WORKGROUP)
fn decode_cells_8(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let invocation = invocation_of(id, groups);
    if (invocation >= jobs.total) {
        return;
    }
    let number = job_of(invocation);
    let job = jobs.list[number];
    let unit = units[job.unit];
    let pixel = invocation - job_begin(number);
    var color = keyframe_pixel(records[job.record], unit, pixel);
    if (job.weight > 0u) {
        color = lerp(color, keyframe_pixel(records[job.next], unit, pixel), job.weight);
    }
    pictures[unit.picture + pixel] = color.x | (color.y << 8u) | (color.z << 16u);
}
