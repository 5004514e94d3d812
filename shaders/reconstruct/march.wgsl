// Where a ray meets a surface: RayIntersection of algorithm 4 (CALF 6), every point looked at. Mirrors
// src/reconstruct/march.rs. Needs `is_surface`.

fn intersect(ray: Ray) -> Hit {
    var before_m = 0.0;
    for (var at = 0u; at < scene.distance_count; at++) {
        counted[MARCH_STEPS]++;
        let distance_m = distances_m[at];
        if (is_surface(point_at(ray, distance_m))) {
            return Hit(true, refine(ray, before_m, distance_m));
        }
        before_m = distance_m;
    }
    return Hit(false, 0.0);
}
