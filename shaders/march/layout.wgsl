// Input of a picture, as src/gpu/render/scene.rs writes it; a test compares the two.

struct Scene {
    // Forward, and right and down to the edges of the picture at distance 1.
    forward: vec3<f32>,
    width: u32,
    right: vec3<f32>,
    height: u32,
    down: vec3<f32>,
    // The first row of this dispatch.
    first_row: u32,
    // Rays in each row and column of a pixel.
    samples: u32,
    view_count: u32,
    distance_count: u32,
    refine: u32,
    // A hit that differs more is disoccluded.
    tolerance: f32,
    // What is shown of surfaces that no view saw: HOLES_BLANK, HOLES_NEAREST or HOLES_BEHIND.
    holes: u32,
    coding: u32,
    // Light of the brightest code.
    gain: f32,
    max_bounces: u32,
    // Rows of this dispatch.
    rows: u32,
    // Rows of texels of the pyramid of an image: the power of two that its rows fit into.
    pyramid_rows: u32,
    // Points of a segment at most, a power of two; 1 where every point is tested.
    longest_segment: u32,
    // Points of the first segment.
    first_segment: u32,
    // Proxies; their environment maps follow the active views.
    proxy_count: u32,
    // Clip planes of the camera: metres along its axis.
    near_m: f32,
    far_m: f32,
    // The middle of the picture, in parts of `right` and `down`: 0 unless its window is off-axis.
    middle: vec2<f32>,
    // Logarithm of the ratio of adjacent distances.
    log_step: f32,
    // The view nearest to the eye.
    nearest_view: u32,
    // REFINE_ANGLES, REFINE_EDGES and REFINE_THIN.
    refinements: u32,
    // Whether a background is shown: BACKGROUND_OPAQUE or BACKGROUND_TRANSPARENT.
    background: u32,
    spare: vec2<f32>,
}

struct View {
    // Metres, along the axes of the world.
    from_eye: vec3<f32>,
    // Of an environment map, the radius of the proxy.
    near_m: f32,
    // The columns of the matrix that turns directions of the world into those of the probe.
    turn_x: vec3<f32>,
    camera_weight: f32,
    turn_y: vec3<f32>,
    // Of all texels, or more than that.
    greatest_inverse_depth: f32,
    turn_z: vec3<f32>,
    // Of an environment map, how far from the surface of the proxy its points are, in metres.
    reach_m: f32,
    // Rows of `faces`, or NO_FACE.
    faces: array<u32, 8>,
}

struct Face {
    // Where its texels begin in the textures, and the layer.
    column: u32,
    row: u32,
    layer: u32,
    has_material: u32,
    width: u32,
    height: u32,
    // Where its pyramid begins, in the same layer of other textures, and how many levels it has; 0: it proves nothing.
    pyramid_column: u32,
    pyramid_row: u32,
    levels: u32,
    // Number of its face.
    number: u32,
    scale: vec2<f32>,
    centre: vec2<f32>,
    // Whether the fourth component of its colours is alpha; else it is opaque.
    has_alpha: u32,
    spare: u32,
}

// No image of a view.
const NO_FACE = 0xffffffffu;
// The number of the image of a perspective probe.
const VIEW_FACE = 6u;
// Colours are linear light, codes of sRGB, or codes of light.
const CODING_LIGHT = 0u;
const CODING_SRGB = 1u;
const CODING_LINEAR = 2u;

const HOLES_BLANK = 0u;
const HOLES_NEAREST = 1u;
const HOLES_BEHIND = 2u;
const BACKGROUND_OPAQUE = 0u;
const BACKGROUND_TRANSPARENT = 1u;
// Bits.
const REFINE_ANGLES = 1u;
const REFINE_EDGES = 2u;
const REFINE_THIN = 4u;

@group(0) @binding(0) var<storage, read> scene: Scene;
@group(0) @binding(1) var<storage, read> views: array<View>;
@group(0) @binding(2) var<storage, read> faces: array<Face>;
