// Follows a primary ray through successive surfaces, each with its share of the ray, to the background. Mirrors
// src/render/march/layers.rs. Needs `first_step`, `refined`, `seen_from_eye`, `background_color`, `surface_light` and `light_of`.

const MIN_LAYER: f32 = 1.0 / 64.0;
const MAX_LAYERS = 8u;
const MAX_EXITS = 64u;

// Result of a primary ray. Mirrors src/render/march/samples.rs.
struct RaySample {
    // Linear RGB times `share`.
    light: vec3<f32>,
    // Fraction of the ray that has a colour.
    share: f32,
    // True if the first surface is disoccluded in all views, or the ray ends without a colour.
    is_hole: bool,
}

// State of a ray on its way through layers.
struct Rest {
    light: vec3<f32>,
    left: f32,
    layers: u32,
    // Surfaces nearer than this are skipped.
    least_m: f32,
    // True while the ray is inside a surface with alpha that has been blended.
    is_within: bool,
    // True if the ray has passed a surface with alpha.
    lets_through: bool,
}

struct FirstHits {
    nearest: Hit,
    all: Hit,
}

fn first_hits(ray: Ray) -> FirstHits {
    var hits = FirstHits(Hit(false, 0.0), Hit(false, 0.0));
    var first = 0u;
    if ((scene.refinements & REFINE_THIN) != 0u && scene.view_count > 0u) {
        alone = scene.nearest_view;
        until_unknown = true;
        first = first_step(ray, 0u);
        until_unknown = false;
        if (first < scene.distance_count && is_surface(point_at(ray, distances_m[first]))) {
            hits.nearest = refined(ray, first);
        }
        alone = ALL_VIEWS;
    }
    hits.all = intersect_from(ray, first);
    return hits;
}

// Blends a surface by its coverage and alpha.
fn show(before: Rest, ray: Ray, distance_m: f32, seen: Seen) -> Rest {
    var coverage = 1.0;
    if ((scene.refinements & REFINE_EDGES) != 0u) {
        coverage = seen.coverage;
    }
    let opacity = coverage * seen.alpha;
    var rest = before;
    let has_alpha = seen.alpha <= 1.0 - MIN_LAYER;
    rest.lets_through = rest.lets_through || has_alpha;
    rest.is_within = rest.is_within || (has_alpha && coverage > 1.0 - MIN_LAYER);
    if (opacity < MIN_LAYER) {
        return rest;
    }
    var left = before.left * (1.0 - opacity);
    if (before.layers + 1u == MAX_LAYERS || opacity > 1.0 - MIN_LAYER || left < MIN_LAYER) {
        left = 0.0;
    }
    is_around = false;
    let light = surface_light(ray, distance_m, seen);
    is_around = (scene.refinements & REFINE_EDGES) != 0u;
    rest.light += (before.left - left) * light;
    rest.left = left;
    rest.layers++;
    rest.least_m = distance_m * exp(HOLE_DIFFERENCE);
    return rest;
}

// Ends a ray whose remaining share has no colour.
fn end_in_hole(rest: Rest, unseen: Seen) -> RaySample {
    if (rest.layers == 0u) {
        let share = select(0.0, 1.0, unseen.found);
        return RaySample(share * light_of(unseen.color), share, true);
    }
    return RaySample(rest.light / (1.0 - rest.left), 1.0, false);
}

fn follow(ray: Ray) -> RaySample {
    let hits = first_hits(ray);
    let cosine = max(dot(ray.direction, scene.forward), MIN_POSITIVE);
    let near_m = scene.near_m / cosine;
    var rest = Rest(vec3(0.0), 1.0, 0u, near_m, false, false);
    var unseen = Seen(false, vec3(0.0), 0.0, 1.0, 1.0);
    var is_hole = false;
    let thin_m = hits.nearest.distance_m;
    if (hits.nearest.found && thin_m >= near_m && thin_m * cosine <= scene.far_m
        && (!hits.all.found || thin_m < hits.all.distance_m * exp(-HOLE_DIFFERENCE))) {
        let seen = seen_from_eye(point_at(ray, thin_m));
        if (seen.found && seen.difference <= scene.tolerance) {
            rest = show(rest, ray, thin_m, seen);
        }
    }
    var hit = hits.all;
    for (var exits = 0u; exits < MAX_EXITS; exits++) {
        if (!hit.found || hit.distance_m * cosine > scene.far_m || rest.left == 0.0) {
            break;
        }
        var at_m = hit.distance_m;
        var within = scene.tolerance;
        var is_inside = false;
        // A surface that begins before the near plane is clipped, including its inside.
        let is_cut = at_m < near_m;
        rest.is_within = rest.is_within && at_m < rest.least_m;
        // Finds the first step behind the hit.
        var next = 0u;
        var above = scene.distance_count;
        while (next < above) {
            let half = (next + above) / 2u;
            if (distances_m[half] <= at_m) {
                next = half + 1u;
            } else {
                above = half;
            }
        }
        loop {
            if (at_m >= rest.least_m && !is_cut && !rest.is_within) {
                let seen = seen_from_eye(point_at(ray, at_m));
                if (seen.found && seen.difference <= within) {
                    rest = show(rest, ray, at_m, seen);
                } else {
                    if (seen.found) {
                        unseen = seen;
                    }
                    if (rest.layers == 0u && !is_inside) {
                        is_hole = true;
                        if (scene.holes != HOLES_BEHIND) {
                            return end_in_hole(rest, unseen);
                        }
                    }
                }
                if (rest.left == 0.0) {
                    return RaySample(rest.light, 1.0, is_hole);
                }
            }
            within = HOLE_DIFFERENCE + scene.log_step;
            is_inside = true;
            if (next >= scene.distance_count || distances_m[min(next, scene.distance_count - 1u)] * cosine > scene.far_m) {
                hit.found = false;
                break;
            }
            counted[MARCH_STEPS]++;
            at_m = distances_m[next];
            if (!is_surface(point_at(ray, at_m))) {
                hit = intersect_from(ray, next);
                break;
            }
            next++;
        }
    }
    if (rest.left == 0.0) {
        return RaySample(rest.light, 1.0, is_hole);
    }
    if (rest.layers == 0u) {
        counted[BACKGROUND_RAYS]++;
    }
    let seen = background_color(ray.direction);
    if (scene.background == BACKGROUND_TRANSPARENT && (seen.found || rest.lets_through)) {
        return RaySample(rest.light, 1.0 - rest.left, is_hole);
    }
    if (seen.found) {
        let share = rest.left * seen.alpha;
        return RaySample(rest.light + share * light_of(seen.color), 1.0 - (rest.left - share), is_hole);
    }
    let ended = end_in_hole(rest, unseen);
    return RaySample(ended.light, ended.share, ended.is_hole || is_hole);
}
