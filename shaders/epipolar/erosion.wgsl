// Counts the pixels that have an edge between their position and their position in the other source (Epipolar 3.3.1), as
// `eroded` of src/epipolar/erosion.rs does. A workgroup counts one scanline.

@group(0) @binding(0) var<storage, read> block: PixelRows;
// Movement of each pixel towards the other source, in 1/256 pixels.
@group(0) @binding(1) var<storage, read> moves: array<i32>;
// Number of edges up to and including each pixel.
@group(0) @binding(2) var<storage, read> edges: array<u32>;
@group(0) @binding(3) var<storage, read_write> eroded: array<u32>;

const MOVE_BITS: u32 = 8u;

var<workgroup> eroded_count: atomic<u32>;

fn is_eroded(start: u32, column: u32) -> bool {
    let end = i32(column) + ((moves[start + column] + (1 << (MOVE_BITS - 1u))) >> MOVE_BITS);
    // A pixel that moves out of the other image does not count.
    if (end < 0 || end >= i32(block.width)) {
        return false;
    }
    return edges[start + u32(end)] != edges[start + column];
}

@compute @workgroup_size(SLICE_WORKGROUP)
fn count_eroded(
    @builtin(local_invocation_index) local: u32,
    @builtin(workgroup_id) id: vec3u,
    @builtin(num_workgroups) groups: vec3u,
) {
    let row = id.x + id.y * groups.x;
    if (row >= block.rows) {
        return;
    }
    let start = row * block.stride;
    var count = 0u;
    for (var column = local; column < block.width; column += SLICE_WORKGROUP) {
        count += select(0u, 1u, is_eroded(start, column));
    }
    atomicAdd(&eroded_count, count);
    workgroupBarrier();
    if (local == 0u) {
        eroded[row] = atomicLoad(&eroded_count);
    }
}
