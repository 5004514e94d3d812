// Converts depth codes to inverse depths of the texels of a view (CALF 6.2): `write_depth` of src/render/views/face_cache.rs with
// `InverseDepth` of src/render/views/inverse_depth.rs. An invocation writes a texel. Needs `job_of`.

@group(0) @binding(0) var<storage, read> pictures: array<u32>;
@group(0) @binding(1) var<storage, read> tables: array<u32>;
@group(0) @binding(2) var<storage, read> jobs: DepthJobs;
@group(0) @binding(3) var<storage, read_write> planes: array<u32>;

@compute @workgroup_size(WORKGROUP)
fn write_depths(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let invocation = invocation_of(id, groups);
    if (invocation >= jobs.total) {
        return;
    }
    let number = job_of(invocation);
    let job = jobs.list[number];
    let texel = invocation - job_begin(number);
    let x = texel % job.width;
    let y = texel / job.width;
    var bits = job.table;
    if (job.picture != NONE) {
        let column = job.left + x;
        let codes = pictures[job.picture + (job.top + y) * job.stride + column / 2u];
        bits = tables[job.table + ((codes >> (16u * (column % 2u))) & 0xffffu)];
        if (job.ray_length != NONE) {
            let ray_length = tables[job.ray_length + y * job.ray_length_pitch + x];
            bits = bitcast<u32>(bitcast<f32>(bits) * bitcast<f32>(ray_length));
        }
    }
    planes[job.output + y * job.pitch + x] = bits;
}
