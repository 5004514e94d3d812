// The light of a surface where neither mirrors nor glass send rays on: that part of `outcome` of src/march/render.rs.
// Needs `light_of`.

fn surface_light(ray: Ray, distance_m: f32, seen: Seen) -> vec3<f32> {
    return light_of(seen.color);
}
