// Counts the active pixels of each row, as `active_counts` of src/epipolar/drawing.rs does. A workgroup counts one row.

@group(0) @binding(0) var<storage, read> block: PixelRows;
// Per pixel: the triangle number plus 1, or 0 if it shows none, and a word that is not read.
@group(0) @binding(1) var<storage, read> shown: array<vec2u>;
@group(0) @binding(2) var<storage, read_write> counts: array<u32>;

var<workgroup> active_count: atomic<u32>;

@compute @workgroup_size(SLICE_WORKGROUP)
fn count_active(
    @builtin(local_invocation_index) local: u32,
    @builtin(workgroup_id) id: vec3u,
    @builtin(num_workgroups) groups: vec3u,
) {
    let row = id.x + id.y * groups.x;
    if (row >= block.rows) {
        return;
    }
    var count = 0u;
    for (var column = local; column < block.width; column += SLICE_WORKGROUP) {
        count += select(0u, 1u, shown[row * block.stride + column].x != 0u);
    }
    atomicAdd(&active_count, count);
    workgroupBarrier();
    if (local == 0u) {
        counts[row] = atomicLoad(&active_count);
    }
}
