// Lists active pixels without gaps (Epipolar 3.3.2), as `compact` of src/epipolar/drawing.rs does. A workgroup lists the pixels
// of one row after those of the previous rows. Needs `running_sum`.

@group(0) @binding(0) var<storage, read> block: PixelRows;
// Per pixel: the triangle number plus 1, or 0 if it shows none, and a word that is not read.
@group(0) @binding(1) var<storage, read> shown: array<vec2u>;
// Number of active pixels of each row.
@group(0) @binding(2) var<storage, read> counts: array<u32>;
// Per active pixel: its index, row by row without padding, and its triangle number plus 1.
@group(0) @binding(3) var<storage, read_write> active_pixels: array<vec2u>;

var<workgroup> count_before: atomic<u32>;

@compute @workgroup_size(SUM_WORKGROUP)
fn compact(
    @builtin(local_invocation_index) local: u32,
    @builtin(workgroup_id) id: vec3u,
    @builtin(num_workgroups) groups: vec3u,
) {
    let row = id.x + id.y * groups.x;
    if (row >= block.rows) {
        return;
    }
    var count = 0u;
    for (var other = local; other < row; other += SUM_WORKGROUP) {
        count += counts[other];
    }
    atomicAdd(&count_before, count);
    workgroupBarrier();
    var before = atomicLoad(&count_before);
    for (var first = 0u; first < block.width; first += SUM_WORKGROUP) {
        let column = first + local;
        var found = 0u;
        if (column < block.width) {
            found = shown[row * block.stride + column].x;
        }
        let is_active = select(0u, 1u, found != 0u);
        let end = before + running_sum(local, is_active);
        if (is_active != 0u) {
            active_pixels[end - 1u] = vec2u(row * block.width + column, found);
        }
        before += sums[SUM_WORKGROUP - 1u];
    }
}
