// Rays, in metres from the eye, and the distances of their samples. Mirrors src/render/march/ray.rs.

@group(0) @binding(3) var<storage, read> distances_m: array<f32>;

struct Ray {
    origin: vec3<f32>,
    // Unit vector.
    direction: vec3<f32>,
}

// First intersection of a ray with a surface, if any.
struct Hit {
    found: bool,
    distance_m: f32,
}

fn point_at(ray: Ray, distance_m: f32) -> vec3<f32> {
    return ray.origin + ray.direction * distance_m;
}

const GROWTH: f32 = 0.125;
const MAX_BEFORE_STEPS = 64u;

// Next distance of a ray that starts on a surface; if it is a step, its index follows from `step`.
struct FromSurface {
    distance_m: f32,
    // Index of the next step.
    step: u32,
    is_step: bool,
    // Number of distances before the first step.
    before: u32,
}

const IN_SURFACE = FromSurface(0.0, 0u, false, 0u);

// `Steps::off_surface`: texel-sized intervals before the first step, then the steps. Requires that a step remains.
fn next_from_surface(last: FromSurface, texel_m: f32) -> FromSurface {
    let next_m = last.distance_m + max(texel_m, GROWTH * last.distance_m);
    if (!last.is_step && last.before < MAX_BEFORE_STEPS && next_m < distances_m[0]) {
        return FromSurface(next_m, 0u, false, last.before + 1u);
    }
    return FromSurface(distances_m[last.step], last.step + 1u, true, last.before);
}

// Returns the first hit of a ray at or after step `first`; nearer points count as empty. Needs `first_step`.
fn intersect_from(ray: Ray, first: u32) -> Hit {
    return refined(ray, first_step(ray, first));
}

// Returns the refined hit in the interval that ends at a step; none if `step` is past the last one.
fn refined(ray: Ray, step: u32) -> Hit {
    if (step >= scene.distance_count) {
        return Hit(false, 0.0);
    }
    let before_m = select(0.0, distances_m[max(step, 1u) - 1u], step > 0u);
    return Hit(true, refine(ray, before_m, distances_m[step], scene.refine));
}

// Bisects the interval in which a surface begins; returns the end of the interval that is on the surface. Needs `is_surface`.
fn refine(ray: Ray, from_m: f32, to_m: f32, times: u32) -> f32 {
    var empty_m = from_m;
    var surface_m = to_m;
    for (var turn = 0u; turn < times; turn++) {
        let middle_m = 0.5 * (empty_m + surface_m);
        counted[REFINE_STEPS]++;
        if (is_surface(point_at(ray, middle_m))) {
            surface_m = middle_m;
        } else {
            empty_m = middle_m;
        }
    }
    return surface_m;
}
