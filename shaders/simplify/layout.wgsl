// Input of the drawings of textured triangles; src/gpu/quads.rs writes it.

// Bits of an inverse depth that a z-buffer does not compare.
const DEPTH_BITS_LEFT_OUT: u32 = 10u;

// A picture, and the place of its sample in the pixels.
struct QuadPicture {
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

@group(0) @binding(0) var<storage, read> picture: QuadPicture;
// Position in metres and homogeneous texture coordinates, for each corner of each triangle.
@group(0) @binding(1) var<storage, read> corners: array<f32>;
