// Draws the nearest triangle at each pixel behind the triangles of the previous pass: layers of depth peeling (Epipolar 3.1 to
// 3.3). Needs layout.wgsl.

// Output of the previous pass, per pixel: the triangle number plus 1, and the bits of its buffer depth, which decreases with
// distance.
@group(0) @binding(2) var before: texture_2d_array<u32>;

struct Corner {
    @invariant @builtin(position) position: vec4<f32>,
    @location(0) @interpolate(flat) triangle: u32,
};

// The instance index is the number of the first triangle of a batch.
@vertex
fn place_corner(@builtin(vertex_index) index: u32, @builtin(instance_index) first: u32) -> Corner {
    return Corner(clip_position(3u * index), first + index / 3u);
}

@fragment
fn name_triangle(corner: Corner) -> @location(0) vec2<u32> {
    let depth = corner.position.z;
    if depth >= bitcast<f32>(textureLoad(before, vec2<i32>(corner.position.xy), 0, 0).y) {
        discard;
    }
    return vec2(corner.triangle + 1u, bitcast<u32>(depth));
}
