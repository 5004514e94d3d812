// Draws the nearest texel whose alpha covers the sample, as Compositing::ZBuffer in src/simplify/raster.rs does. Needs
// layout.wgsl, place.wgsl and texels.wgsl.

// Low bits of an inverse depth that are ignored in the depth test.
const DEPTH_BITS_LEFT_OUT: u32 = 10u;

struct Nearest {
    @location(0) light: vec4<f32>,
    @builtin(frag_depth) depth: f32,
};

@fragment
fn cover(placed: Placed) -> Nearest {
    let found = sample(placed.stq.xy / placed.stq.z);
    if !in_range(placed.depth_m) || found.a <= picture.threshold {
        discard;
    }
    // `nearest_m` is a power of two, so the multiplication does not change the mantissa.
    let bits = (bitcast<u32>(1.0 / placed.depth_m) >> DEPTH_BITS_LEFT_OUT) << DEPTH_BITS_LEFT_OUT;
    return Nearest(vec4(found.rgb, 1.0), picture.nearest_m * bitcast<f32>(bits));
}
