// Texels, and the projection of points into the images of a view (CALF 6). Mirrors `View::project` of src/render/views/light_field.rs
// over src/codec/image/texel_map.rs; tests/gpu/projection.rs compares the two.
//
// Inverse depths are read as the bits of floats: +inf marks unknown texels, and shaders may assume that no float is infinite.

@group(0) @binding(4) var inverse_depths: texture_2d_array<u32>;
@group(0) @binding(5) var colors: texture_2d_array<f32>;

const BACKGROUND = 0u;
const UNKNOWN = 0x7f800000u;
// The inverse of a smaller length is not representable on every device.
const MIN_INVERTIBLE_M: f32 = 1e-37;

// Position of a point in an image; `face` is a row of `faces`, or NO_FACE.
struct Projected {
    face: u32,
    at: vec2<f32>,
    inverse_depth: f32,
}

// Index of the cube face, (u, v) at distance 1 before the division by depth, and planar depth of a point.
struct CubePlace {
    face: u32,
    plane: vec2<f32>,
    planar_m: f32,
}

fn cube_face(x: vec3<f32>) -> CubePlace {
    let size = abs(x);
    if (size.x >= size.y && size.x >= size.z) {
        let negative = x.x < 0.0;
        return CubePlace(select(0u, 1u, negative), vec2(select(-x.z, x.z, negative), -x.y), size.x);
    }
    if (size.y >= size.z) {
        let negative = x.y < 0.0;
        return CubePlace(select(2u, 3u, negative), vec2(x.x, select(x.z, -x.z, negative)), size.y);
    }
    let negative = x.z < 0.0;
    return CubePlace(select(4u, 5u, negative), vec2(select(x.x, -x.x, negative), -x.y), size.z);
}

const NOWHERE = Projected(NO_FACE, vec2(0.0), 0.0);

fn project_to_view(from_probe: vec3<f32>, face: u32) -> Projected {
    if (-from_probe.z < MIN_INVERTIBLE_M) {
        return NOWHERE;
    }
    let inverse_depth = 1.0 / -from_probe.z;
    let plane = vec2(from_probe.x * inverse_depth, -from_probe.y * inverse_depth);
    let at = plane * faces[face].scale + faces[face].centre;
    let size = vec2(f32(faces[face].width), f32(faces[face].height));
    if (all(at >= vec2(0.0)) && all(at < size)) {
        return Projected(face, at, inverse_depth);
    }
    return NOWHERE;
}

fn project(view: u32, from_probe: vec3<f32>) -> Projected {
    let single = views[view].faces[VIEW_FACE];
    if (single != NO_FACE) {
        return project_to_view(from_probe, single);
    }
    let place = cube_face(from_probe);
    let face = views[view].faces[place.face];
    if (face == NO_FACE || place.planar_m < MIN_INVERTIBLE_M) {
        return NOWHERE;
    }
    let scale = 1.0 / place.planar_m;
    let at = place.plane * scale * faces[face].scale + faces[face].centre;
    return Projected(face, at, scale);
}

// Returns the bits of a texel's inverse planar depth.
fn inverse_depth_bits(face: u32, texel: vec2<u32>) -> u32 {
    let place = vec2(faces[face].column, faces[face].row) + texel;
    return textureLoad(inverse_depths, place, faces[face].layer, 0).r;
}

// Returns the colour of a texel, as codes over 255 or linear RGB, and its alpha.
fn texel_color(face: u32, texel: vec2<u32>) -> vec4<f32> {
    let place = vec2(faces[face].column, faces[face].row) + texel;
    let color = textureLoad(colors, place, faces[face].layer, 0);
    return vec4(color.rgb, select(1.0, color.a, faces[face].has_alpha != 0u));
}
