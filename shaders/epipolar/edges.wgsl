// Counts edges along scanlines, as `edges` of src/epipolar/erosion.rs does: a pixel is at an edge if its move differs from the
// mean move of five pixels. A workgroup sums one scanline. Needs `running_sum`.

@group(0) @binding(0) var<storage, read> block: PixelRows;
// Movement of each pixel towards the other source, in 1/256 pixels.
@group(0) @binding(1) var<storage, read> moves: array<i32>;
// Number of edges up to and including each pixel.
@group(0) @binding(2) var<storage, read_write> edges: array<u32>;

// Pixels on each side of the window's centre.
const EROSION_REACH: u32 = 2u;
// Maximum difference from the mean within a surface, in 1/256 pixels.
const EROSION_TOLERANCE: u32 = 256u;

fn is_edge(start: u32, column: u32) -> bool {
    let first = column - min(column, EROSION_REACH);
    let end = min(column + EROSION_REACH + 1u, block.width);
    var sum = 0;
    for (var at = first; at < end; at++) {
        sum += moves[start + at];
    }
    let count = i32(end - first);
    return abs(count * moves[start + column] - sum) > count * i32(EROSION_TOLERANCE);
}

@compute @workgroup_size(SUM_WORKGROUP)
fn count_edges(
    @builtin(local_invocation_index) local: u32,
    @builtin(workgroup_id) id: vec3u,
    @builtin(num_workgroups) groups: vec3u,
) {
    let row = id.x + id.y * groups.x;
    if (row >= block.rows) {
        return;
    }
    let start = row * block.stride;
    var before = 0u;
    for (var first = 0u; first < block.width; first += SUM_WORKGROUP) {
        let column = first + local;
        var edge = 0u;
        if (column < block.width && is_edge(start, column)) {
            edge = 1u;
        }
        let count = before + running_sum(local, edge);
        if (column < block.width) {
            edges[start + column] = count;
        }
        before += sums[SUM_WORKGROUP - 1u];
    }
}
