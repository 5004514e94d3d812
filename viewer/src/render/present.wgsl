// Shows pictures on a canvas: exposure, tone map, the curve of sRGB, two eyes, overlays.

struct Look {
    // Of a picture, in pixels.
    size: vec2<u32>,
    // Of the canvas, in pixels.
    canvas: vec2<u32>,
    gain: f32,
    tone_map: u32,
    eyes: u32,
    // Whether holes are marked, and how much of the overlay is shown.
    marks_holes: u32,
    overlay: f32,
}

const TONE_REINHARD = 1u;
const TONE_FILMIC = 2u;
const SIDE_BY_SIDE = 1u;
const ANAGLYPH = 2u;
const HOLE = vec3(1.0, 0.0, 0.7);

@group(0) @binding(0) var<storage, read> left: array<vec4<f32>>;
@group(0) @binding(1) var<storage, read> right: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read> overlay: array<vec4<f32>>;
@group(0) @binding(3) var<uniform> look: Look;

@vertex
fn cover(@builtin(vertex_index) corner: u32) -> @builtin(position) vec4<f32> {
    return vec4(f32(corner % 2u) * 4.0 - 1.0, f32(corner / 2u) * 4.0 - 1.0, 0.0, 1.0);
}

// The curves of src/glb/shaders.ts.
fn mapped(light: vec3<f32>) -> vec3<f32> {
    let exposed = max(light * look.gain, vec3(0.0));
    if (look.tone_map == TONE_REINHARD) {
        return exposed / (1.0 + exposed);
    }
    if (look.tone_map == TONE_FILMIC) {
        // The fit of Narkowicz to the curve of ACES.
        return exposed * (2.51 * exposed + 0.03) / (exposed * (2.43 * exposed + 0.59) + 0.14);
    }
    return exposed;
}

fn coded(light: vec3<f32>) -> vec3<f32> {
    let within = clamp(light, vec3(0.0), vec3(1.0));
    return select(1.055 * pow(within, vec3(1.0 / 2.4)) - 0.055, 12.92 * within, within <= vec3(0.0031308));
}

fn shown(pixel: vec4<f32>, mark: vec4<f32>) -> vec3<f32> {
    let is_hole = look.marks_holes == 1u && pixel.a < 0.5;
    let code = select(coded(mapped(pixel.rgb)), HOLE, is_hole);
    return mix(code, coded(mark.rgb), look.overlay);
}

fn pixel_at(place: vec2<f32>, canvas: vec2<f32>) -> u32 {
    let at = min(vec2<u32>(place * vec2<f32>(look.size) / canvas), look.size - 1u);
    return at.y * look.size.x + at.x;
}

@fragment
fn present(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    var canvas = vec2<f32>(look.canvas);
    var place = position.xy;
    let is_split = look.eyes == SIDE_BY_SIDE;
    let is_right = is_split && place.x >= canvas.x / 2.0;
    if (is_split) {
        canvas.x /= 2.0;
        place.x -= select(0.0, canvas.x, is_right);
    }
    let at = pixel_at(place, canvas);
    let one = shown(select(left[at], right[at], is_right), overlay[at]);
    if (look.eyes != ANAGLYPH) {
        return vec4(one, 1.0);
    }
    let other = shown(right[at], overlay[at]);
    return vec4(one.r, other.g, other.b, 1.0);
}
