// The nearest texel whose alpha covers the sample, as Compositing::ZBuffer in src/simplify/raster.rs. Needs place.wgsl and texels.wgsl.

@fragment
fn cover(placed: Placed) -> @location(0) vec4<f32> {
    let found = sample(placed.stq.xy / placed.stq.z);
    if !in_range(placed.depth_m) || found.a <= picture.threshold {
        discard;
    }
    return vec4(found.rgb, 1.0);
}
