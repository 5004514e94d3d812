// Intersection of a ray with a surface: RayIntersection of algorithm 4 (CALF 6), testing every point. Mirrors
// src/render/march/intersect.rs. Needs `is_surface`.

// Returns the first step at or after `first` that is on a surface; `scene.distance_count` if there is none.
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
