// Input of a picture, written by src/gpu/render/scene.rs; a test compares the two.

struct Scene {
    // Camera axes: forward has length 1; right and down reach the edges of the picture at distance 1.
    forward: vec3<f32>,
    width: u32,
    right: vec3<f32>,
    height: u32,
    down: vec3<f32>,
    // First row of this dispatch.
    first_row: u32,
    // Number of rays in each row and column of a pixel.
    samples: u32,
    view_count: u32,
    distance_count: u32,
    refine: u32,
    // A hit with a greater depth difference is disoccluded.
    tolerance: f32,
    // Rendering of disoccluded surfaces: HOLES_BLANK, HOLES_NEAREST or HOLES_BEHIND.
    holes: u32,
    coding: u32,
    // Linear value of the brightest code.
    gain: f32,
    max_bounces: u32,
    // Number of rows of this dispatch.
    rows: u32,
    // Height of an image's pyramid in texels: the image height rounded up to a power of two.
    pyramid_rows: u32,
    // Maximum number of points in a segment, a power of two; 1 if every point is tested.
    longest_segment: u32,
    // Number of points in the first segment.
    first_segment: u32,
    // Number of proxies; their environment maps follow the active views in `views`.
    proxy_count: u32,
    // Clip planes of the camera: metres along its axis.
    near_m: f32,
    far_m: f32,
    // Centre of the picture in multiples of `right` and `down`; 0 unless the window is off-axis.
    middle: vec2<f32>,
    // Logarithm of the ratio of adjacent distances.
    log_step: f32,
    // Index of the view nearest to the eye.
    nearest_view: u32,
    // Set of REFINE_ANGLES, REFINE_EDGES and REFINE_THIN.
    refinements: u32,
    // Rendering of the background: BACKGROUND_OPAQUE or BACKGROUND_TRANSPARENT.
    background: u32,
    spare: vec2<f32>,
}

struct View {
    // Vector from the eye to the view in metres, in world axes.
    from_eye: vec3<f32>,
    // Near distance in metres; for an environment map, the radius of the proxy.
    near_m: f32,
    // Columns of the matrix that rotates world directions to probe axes.
    turn_x: vec3<f32>,
    camera_weight: f32,
    turn_y: vec3<f32>,
    // Upper bound of the inverse depths of all texels.
    greatest_inverse_depth: f32,
    turn_z: vec3<f32>,
    // Environment maps only: maximum distance of a point from the proxy's surface, in metres.
    reach_m: f32,
    // Rows of `faces`, or NO_FACE.
    faces: array<u32, 8>,
}

struct Face {
    // Position of its first texel in the textures, and the layer.
    column: u32,
    row: u32,
    layer: u32,
    has_material: u32,
    width: u32,
    height: u32,
    // Position of its pyramid, in the same layer of the pyramid texture, and the number of levels; 0 if it has no pyramid.
    pyramid_column: u32,
    pyramid_row: u32,
    levels: u32,
    // Index of the cube face, or VIEW_FACE.
    number: u32,
    scale: vec2<f32>,
    centre: vec2<f32>,
    // 1 if the fourth component of its colours is alpha; 0 if it is opaque.
    has_alpha: u32,
    spare: u32,
}

// The view has no such image.
const NO_FACE = 0xffffffffu;
// Index of the image of a perspective probe.
const VIEW_FACE = 6u;
// Coding of colours: linear RGB, sRGB codes, or linear codes.
const CODING_LIGHT = 0u;
const CODING_SRGB = 1u;
const CODING_LINEAR = 2u;

const HOLES_BLANK = 0u;
const HOLES_NEAREST = 1u;
const HOLES_BEHIND = 2u;
const BACKGROUND_OPAQUE = 0u;
const BACKGROUND_TRANSPARENT = 1u;
// Bit flags of `refinements`.
const REFINE_ANGLES = 1u;
const REFINE_EDGES = 2u;
const REFINE_THIN = 4u;

@group(0) @binding(0) var<storage, read> scene: Scene;
@group(0) @binding(1) var<storage, read> views: array<View>;
@group(0) @binding(2) var<storage, read> faces: array<Face>;
