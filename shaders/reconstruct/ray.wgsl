// A ray in metres from the eye, and the distances at which it is looked at: `Ray` and `Steps` of src/reconstruct/march.rs.

@group(0) @binding(3) var<storage, read> distances_m: array<f32>;

struct Ray {
    origin: vec3<f32>,
    // Of length 1.
    direction: vec3<f32>,
}

// Where a ray meets a surface, if it does.
struct Hit {
    found: bool,
    distance_m: f32,
}

fn point_at(ray: Ray, distance_m: f32) -> vec3<f32> {
    return ray.origin + ray.direction * distance_m;
}

// Halves the interval in which a surface begins; answers its end that is in the surface. Needs `is_surface`.
fn refine(ray: Ray, from_m: f32, to_m: f32) -> f32 {
    var open_m = from_m;
    var surface_m = to_m;
    for (var turn = 0u; turn < scene.refine; turn++) {
        let middle_m = 0.5 * (open_m + surface_m);
        counted[REFINE_STEPS]++;
        if (is_surface(point_at(ray, middle_m))) {
            surface_m = middle_m;
        } else {
            open_m = middle_m;
        }
    }
    return surface_m;
}
