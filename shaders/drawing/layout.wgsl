// Input of all drawings, written by src/gpu/drawing.rs.

// A picture to draw, and the position of its sample within the pixels.
struct DrawnPicture {
    // Unit axes of the camera.
    right: vec3<f32>,
    // Transform from tangents to clip coordinates: scale and shift of x, then of y.
    scale_x: f32,
    down: vec3<f32>,
    shift_x: f32,
    forward: vec3<f32>,
    scale_y: f32,
    // Eye position in metres, in single precision; `eye_rest` is its rounding error.
    eye: vec3<f32>,
    shift_y: f32,
    eye_rest: vec3<f32>,
    // Distance in metres that maps to buffer depth 1, a power of two; infinity maps to 0.
    nearest_m: f32,
    // Depth range of the surfaces that are drawn, in metres; finite.
    near_m: f32,
    far_m: f32,
    // A texel covers the sample if its alpha is above this threshold.
    threshold: f32,
    spare: u32,
};

@group(0) @binding(0) var<storage, read> picture: DrawnPicture;
// Corners of triangles: the first three words of each are its position in metres.
@group(0) @binding(1) var<storage, read> corners: array<f32>;

// Returns the clip coordinates of the corner at word `at`. w is the depth along the camera axis, in metres.
fn clip_position(at: u32) -> vec4<f32> {
    let point = vec3(corners[at], corners[at + 1u], corners[at + 2u]);
    // The eye is subtracted in two parts: single precision alone would displace near triangles in a scene far from the origin.
    let from_eye = (point - picture.eye) - picture.eye_rest;
    let x = dot(from_eye, picture.right);
    let y = dot(from_eye, picture.down);
    let z = dot(from_eye, picture.forward);
    return vec4(
        x * picture.scale_x + z * picture.shift_x,
        y * picture.scale_y + z * picture.shift_y,
        picture.nearest_m,
        z,
    );
}
