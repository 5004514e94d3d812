// Transforms triangle corners to clip coordinates, as Pixels in src/simplify/raster/triangle.rs does. Needs layout.wgsl. A
// corner is six words: its position and its homogeneous texture coordinates.

struct Placed {
    @builtin(position) position: vec4<f32>,
    // Homogeneous texture coordinates.
    @location(0) stq: vec3<f32>,
    // Depth along the camera axis, in metres.
    @location(1) depth_m: f32,
};

@vertex
fn place(@builtin(vertex_index) index: u32) -> Placed {
    let at = 6u * index;
    var placed: Placed;
    placed.position = clip_position(at);
    placed.stq = vec3(corners[at + 3u], corners[at + 4u], corners[at + 5u]);
    placed.depth_m = placed.position.w;
    return placed;
}

// True if a depth lies between the camera's near and far.
fn in_range(depth_m: f32) -> bool {
    return depth_m >= picture.near_m && depth_m <= picture.far_m;
}
