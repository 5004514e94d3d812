// Counts the triangles over each sample, as src/simplify/raster.rs does for both kinds of compositing. Needs place.wgsl.

@fragment
fn count(placed: Placed) -> @location(0) f32 {
    if !in_range(placed.depth_m) {
        discard;
    }
    return 1.0;
}
