// Input of all drawings; src/gpu/drawing.rs writes it.

// A picture, and the place of its sample in the pixels.
struct DrawnPicture {
    // Axes of the camera, of length 1.
    right: vec3<f32>,
    // From tangents to clip coordinates: factor and shift of x, then of y.
    scale_x: f32,
    down: vec3<f32>,
    shift_x: f32,
    forward: vec3<f32>,
    scale_y: f32,
    // Metres: the eye in single precision, and what that leaves of it.
    eye: vec3<f32>,
    shift_y: f32,
    eye_rest: vec3<f32>,
    // Depth in metres that has depth 1 in the buffer, a power of two; infinity has 0.
    nearest_m: f32,
    // Depths between which surfaces are drawn, in metres; finite.
    near_m: f32,
    far_m: f32,
    // Alpha above which a texel covers the sample.
    threshold: f32,
    spare: u32,
};

@group(0) @binding(0) var<storage, read> picture: DrawnPicture;
// Corners of triangles: the first three words of each are its position in metres.
@group(0) @binding(1) var<storage, read> corners: array<f32>;

// Clip coordinates of the corner that starts at a word. The last one is the depth along the axis of the camera, in metres.
fn clip_position(at: u32) -> vec4<f32> {
    let point = vec3(corners[at], corners[at + 1u], corners[at + 2u]);
    // The eye is subtracted in two parts: single precision would move near triangles of a scene that lies far from the origin.
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
