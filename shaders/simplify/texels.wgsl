// Samples the atlas bilinearly in linear RGB, as src/simplify/raster/texels.rs does. Filtering units may round weights to 8
// bits, which would cause errors of several codes in dark texels next to bright ones.

// Linear value of each sRGB code.
@group(0) @binding(2) var<storage, read> light_of_codes: array<f32>;
// sRGB codes and alpha.
@group(0) @binding(3) var atlas: texture_2d_array<u32>;

fn texel(at: vec2<i32>) -> vec4<f32> {
    let codes = textureLoad(atlas, at, 0, 0);
    return vec4(light_of_codes[codes.r], light_of_codes[codes.g], light_of_codes[codes.b], f32(codes.a) / 255.0);
}

// Returns linear RGB, not premultiplied, and alpha.
fn sample(uv: vec2<f32>) -> vec4<f32> {
    let last = vec2<f32>(textureDimensions(atlas)) - 1.0;
    let at = clamp(uv * (last + 1.0) - 0.5, vec2(0.0), last);
    let first = vec2<i32>(at);
    let next = min(first + 1, vec2<i32>(last));
    let part = at - floor(at);
    let upper = mix(texel(first), texel(vec2(next.x, first.y)), part.x);
    let lower = mix(texel(vec2(first.x, next.y)), texel(next), part.x);
    return mix(upper, lower, part.y);
}
