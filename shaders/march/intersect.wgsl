// Where a ray meets a surface: RayIntersection of algorithm 4 (CALF 6), testing every point. Mirrors
// src/march/intersect.rs. Needs `is_surface`.

// From the step `first` on: nearer points count as empty.
fn intersect_from(ray: Ray, first: u32) -> Hit {
    var before_m = select(0.0, distances_m[max(first, 1u) - 1u], first > 0u);
    for (var at = first; at < scene.distance_count; at++) {
        counted[MARCH_STEPS]++;
        let distance_m = distances_m[at];
        if (is_surface(point_at(ray, distance_m))) {
            return Hit(true, refine(ray, before_m, distance_m));
        }
        before_m = distance_m;
    }
    return Hit(false, 0.0);
}

fn intersect(ray: Ray) -> Hit {
    return intersect_from(ray, 0u);
}
