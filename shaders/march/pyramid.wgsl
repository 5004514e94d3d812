// Computes the maximum inverse depths of squares of texels, one pyramid level per dispatch: `DepthPyramid::update` of
// src/render/march/pyramid.rs. An invocation writes one square. Inverse depths are never negative, so their bits compare as integers.
// Needs `job_of`.

@group(0) @binding(0) var<storage, read> jobs: PyramidJobs;
@group(0) @binding(1) var<storage, read_write> planes: array<u32>;

@compute @workgroup_size(WORKGROUP)
fn write_squares(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let invocation = invocation_of(id, groups);
    if (invocation >= jobs.total) {
        return;
    }
    let number = job_of(invocation);
    let job = jobs.list[number];
    let square = invocation - job_begin(number);
    let at = vec2u(job.left + square % job.width, job.top + square / job.width);
    let last = vec2u(job.below_width, job.below_height) - 1u;
    var greatest = 0u;
    for (var corner = 0u; corner < 4u; corner++) {
        let below = min(2u * at + vec2u(corner % 2u, corner / 2u), last);
        greatest = max(greatest, planes[job.below + below.y * job.below_pitch + below.x]);
    }
    planes[job.output + at.y * job.pitch + at.x] = min(greatest, job.limit);
}
