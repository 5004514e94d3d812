// Converts coded colours to linear RGB. Mirrors `light_of` of src/render/march/shading.rs.

fn decoded(code: f32) -> f32 {
    if (scene.coding == CODING_LINEAR) {
        return code;
    }
    let size = abs(code);
    if (size <= 0.04045) {
        return code / 12.92;
    }
    return sign(code) * pow((size + 0.055) / 1.055, 2.4);
}

fn light_of(color: vec3<f32>) -> vec3<f32> {
    if (scene.coding == CODING_LIGHT) {
        return color;
    }
    return vec3(decoded(color.r), decoded(color.g), decoded(color.b)) * scene.gain;
}
