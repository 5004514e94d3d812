// Cells of half floats (color.md 4): `impl Sample for HalfKey` of src/color/blend.rs. An invocation writes a pixel. Needs
// `keyframe_pixel`.

@group(0) @binding(0) var<storage, read> units: array<Unit>;
@group(0) @binding(1) var<storage, read> records: array<Record>;
@group(0) @binding(2) var<storage, read> jobs: Jobs;
@group(0) @binding(3) var<storage, read> stream: array<u32>;
@group(0) @binding(4) var<storage, read_write> pictures: array<u32>;

@compute @workgroup_size(WORKGROUP)
fn decode_cells_half(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let invocation = invocation_of(id, groups);
    if (invocation >= jobs.total) {
        return;
    }
    let number = job_of(invocation);
    let job = jobs.list[number];
    let unit = units[job.unit];
    let pixel = invocation - job_begin(number);
    var bits = keyframe_pixel(records[job.record], unit, pixel);
    if (job.weight > 0u) {
        let next = keyframe_pixel(records[job.next], unit, pixel);
        bits = bits_of(lerp(keys_of(bits), keys_of(next), job.weight));
    }
    let at = unit.picture + 2u * pixel;
    pictures[at] = bits.x | (bits.y << 16u);
    pictures[at + 1u] = bits.z;
}
