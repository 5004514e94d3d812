// Where a ray meets a surface: RayIntersection of algorithm 4 (CALF 6), testing every point. Mirrors
// src/march/intersect.rs. Needs `is_surface`.

// The first step at which marching ends, or all of them.
fn first_step(ray: Ray, first: u32) -> u32 {
    var at = first;
    while (at < scene.distance_count) {
        counted[MARCH_STEPS]++;
        if (is_surface(point_at(ray, distances_m[at]))) {
            break;
        }
        at++;
    }
    return at;
}
