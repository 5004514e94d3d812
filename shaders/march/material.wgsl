// Interpolates the material of a surface point: SampleMaterial of algorithm 4 (CALF 6.1). Mirrors
// src/render/march/specular/material.rs. Needs `project`, `local_of`, `taps_around` and `DEPTH_EPSILON`.

@group(0) @binding(9) var materials: texture_2d_array<f32>;

const MIN_WEIGHT: f32 = 0.5 / 255.0;
const CLEAR: f32 = 0.95;
// Range of refractive indices that an 8-bit code represents.
const MIN_IOR: f32 = 1.0;
const GREATEST_IOR: f32 = 3.0;

struct Material {
    found: bool,
    reflect: f32,
    refract: f32,
    ior: f32,
}

const NO_MATERIAL = Material(false, 0.0, 0.0, MIN_IOR);

// Returns the weights of reflection and refraction and the refractive index, as codes over 255.
fn texel_material(face: u32, texel: vec2<u32>) -> vec3<f32> {
    let place = vec2(faces[face].column, faces[face].row) + texel;
    return textureLoad(materials, place, faces[face].layer, 0).rgb;
}

fn surface_material(point: vec3<f32>) -> Material {
    // Weighted sums of reflection, refraction, index times refraction, and the sum of the weights.
    var sum = vec4(0.0);
    for (var view = 0u; view < scene.view_count; view++) {
        let at = project(view, local_of(view, point));
        if (at.face == NO_FACE || faces[at.face].has_material == 0u) {
            continue;
        }
        var taps = taps_around(at.at, at.face);
        for (var tap = 0u; tap < 4u; tap++) {
            let surface = inverse_depth_bits(at.face, taps.texels[tap]);
            if (surface == BACKGROUND || surface == UNKNOWN) {
                continue;
            }
            let difference = abs(log(bitcast<f32>(surface) / at.inverse_depth));
            let weight = taps.weights[tap] * views[view].camera_weight / (difference + DEPTH_EPSILON);
            let coded = texel_material(at.face, taps.texels[tap]);
            sum += weight * vec4(coded.x, coded.y, coded.y * coded.z, 1.0);
        }
    }
    if (!(sum.x + sum.y > MIN_WEIGHT * sum.w)) {
        return NO_MATERIAL;
    }
    var ior = MIN_IOR;
    if (sum.y > 0.0) {
        ior += sum.z / sum.y * (GREATEST_IOR - MIN_IOR);
    }
    let whole = max(sum.w, sum.x + sum.y);
    return Material(true, sum.x / whole, sum.y / whole, ior);
}

fn fresnel(direct: f32, ior: f32) -> f32 {
    let cosine = clamp(direct, 0.0, 1.0);
    let inside = sqrt(max(1.0 - (1.0 - cosine * cosine) / (ior * ior), 0.0));
    let sums = vec2(cosine + ior * inside, ior * cosine + inside);
    // At grazing incidence with an index of 1 nothing is reflected.
    if (min(sums.x, sums.y) <= 0.0) {
        return 0.0;
    }
    let parts = vec2(cosine - ior * inside, ior * cosine - inside) / sums;
    return min(0.5 * dot(parts, parts), 1.0);
}

fn at_angle(material: Material, cosine: f32) -> Material {
    let whole = material.reflect + material.refract;
    if (material.refract == 0.0 || whole < CLEAR) {
        return material;
    }
    let reflected = whole * fresnel(cosine, material.ior);
    return Material(true, reflected, whole - reflected, material.ior);
}
