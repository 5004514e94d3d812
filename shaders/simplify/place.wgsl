// Corners of triangles in clip coordinates, as Pixels in src/simplify/raster/triangle.rs. Needs layout.wgsl.

struct Placed {
    @builtin(position) position: vec4<f32>,
    // Homogeneous texture coordinates.
    @location(0) stq: vec3<f32>,
    // Along the axis of the camera, in metres.
    @location(1) depth_m: f32,
};

@vertex
fn place(@builtin(vertex_index) index: u32) -> Placed {
    let at = 6u * index;
    let point = vec3(corners[at], corners[at + 1u], corners[at + 2u]);
    // The eye is subtracted in two parts: single precision would move near triangles of a scene that lies far from the origin.
    let from_eye = (point - picture.eye) - picture.eye_rest;
    let x = dot(from_eye, picture.right);
    let y = dot(from_eye, picture.down);
    let z = dot(from_eye, picture.forward);
    var placed: Placed;
    placed.position = vec4(
        x * picture.scale_x + z * picture.shift_x,
        y * picture.scale_y + z * picture.shift_y,
        picture.nearest_m,
        z,
    );
    placed.stq = vec3(corners[at + 3u], corners[at + 4u], corners[at + 5u]);
    placed.depth_m = z;
    return placed;
}

// Whether near and far of the camera leave a surface.
fn in_range(depth_m: f32) -> bool {
    return depth_m >= picture.near_m && depth_m <= picture.far_m;
}
