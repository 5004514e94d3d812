// Decodes cells whose keyframes are raw samples (color.md 4): `CellState` of src/codec/decode/decoder.rs. An invocation writes a
// pixel. Needs `sample_pixel`, `between` and `put_pixel`.

@group(0) @binding(0) var<storage, read> units: array<Unit>;
@group(0) @binding(1) var<storage, read> records: array<Record>;
@group(0) @binding(2) var<storage, read> jobs: Jobs;
@group(0) @binding(3) var<storage, read> stream: array<u32>;
@group(0) @binding(4) var<storage, read_write> pictures: array<u32>;

@compute @workgroup_size(WORKGROUP)
fn decode_cells(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let invocation = invocation_of(id, groups);
    if (invocation >= jobs.total) {
        return;
    }
    let number = job_of(invocation);
    let job = jobs.list[number];
    let pixel = invocation - job_begin(number);
    var color = sample_pixel(records[job.record], pixel);
    if (job.weight > 0u) {
        color = between(color, sample_pixel(records[job.next], pixel), job.weight);
    }
    put_pixel(units[job.unit], pixel, color);
}
