// Blends triangles in order and counts them, as Compositing::Painter in src/simplify/raster.rs does. Needs place.wgsl and
// texels.wgsl.

struct Fragment {
    // Linear RGB premultiplied by alpha, and alpha.
    @location(0) light: vec4<f32>,
    @location(1) count: f32,
};

@fragment
fn paint(placed: Placed) -> Fragment {
    if !in_range(placed.depth_m) {
        discard;
    }
    let found = sample(placed.stq.xy / placed.stq.z);
    return Fragment(vec4(found.rgb * found.a, found.a), 1.0);
}
