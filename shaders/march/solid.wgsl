// Refraction through a solid (CALF 6.1). Mirrors src/render/march/specular/solid.rs. Needs `patch_at`, `surface_material`, `fresnel`,
// `is_surface` and `refine`.

const FLAT: f32 = 2e-3;
const BEHIND_TEXELS: f32 = 3.0;
const MAX_INSIDE = 3u;
const NO_LIMIT_M: f32 = 1e30;

// A ray that leaves a solid, and its fraction of the entered radiance; 0 if nothing leaves.
struct Exit {
    ray: Ray,
    part: f32,
}

// A refracted direction; not found in total internal reflection.
struct Bent {
    found: bool,
    direction: vec3<f32>,
}

// Point where a ray inside a solid meets its back, and the outward normal.
struct Back {
    found: bool,
    point: vec3<f32>,
    normal: vec3<f32>,
}

// A sphere, or none. Mirrors src/render/march/specular/sphere.rs.
struct Sphere {
    found: bool,
    centre: vec3<f32>,
    radius_m: f32,
}

// Distance of the first point that is empty in a view.
struct FirstEmpty {
    found: bool,
    distance_m: f32,
}

fn refracted(direction: vec3<f32>, normal: vec3<f32>, ratio: f32) -> Bent {
    let cosine = clamp(-dot(direction, normal), 0.0, 1.0);
    let behind_squared = 1.0 - ratio * ratio * (1.0 - cosine * cosine);
    if (behind_squared <= 0.0) {
        return Bent(false, vec3(0.0));
    }
    let bent = ratio * direction + (ratio * cosine - sqrt(behind_squared)) * normal;
    let size = length(bent);
    return Bent(size > MIN_LENGTH, bent / max(size, MIN_LENGTH));
}

fn first_empty(ray: Ray, texel_m: f32, limit_m: f32) -> FirstEmpty {
    var before_m = 0.0;
    var at = IN_SURFACE;
    while (at.step < scene.distance_count) {
        at = next_from_surface(at, texel_m);
        let distance_m = at.distance_m;
        if (distance_m > limit_m) {
            break;
        }
        counted[MARCH_STEPS]++;
        if (!is_surface(point_at(ray, distance_m))) {
            // The surface is at the near end of this interval.
            return FirstEmpty(true, refine(ray, distance_m, before_m, scene.refine));
        }
        before_m = distance_m;
    }
    return FirstEmpty(false, 0.0);
}

// Point where the line of a ray enters a sphere.
struct Entry {
    found: bool,
    point: vec3<f32>,
}

fn entry_of(sphere: Sphere, ray: Ray) -> Entry {
    let from_centre = ray.origin - sphere.centre;
    let along = dot(ray.direction, from_centre);
    let squared = along * along - (dot(from_centre, from_centre) - sphere.radius_m * sphere.radius_m);
    return Entry(squared > 0.0, point_at(ray, -along - sqrt(max(squared, 0.0))));
}

// Returns the distance at which a ray leaves a sphere; 0 if it misses.
fn exit_of(sphere: Sphere, ray: Ray) -> f32 {
    let from_centre = ray.origin - sphere.centre;
    let along = dot(ray.direction, from_centre);
    let squared = along * along - (dot(from_centre, from_centre) - sphere.radius_m * sphere.radius_m);
    return select(0.0, sqrt(max(squared, 0.0)) - along, squared >= 0.0);
}

fn back_of(inside: Ray, sphere: Sphere, is_whole: bool, texel_m: f32) -> Back {
    let chord_m = exit_of(sphere, inside);
    if (sphere.found && !(chord_m > 0.0)) {
        return Back(false, vec3(0.0), vec3(0.0));
    }
    var open = FirstEmpty(false, 0.0);
    if (!is_whole) {
        open = first_empty(inside, texel_m, select(NO_LIMIT_M, 2.0 * chord_m, sphere.found));
    }
    if (open.found) {
        let end = point_at(inside, open.distance_m);
        counted[NORMAL_EVALS]++;
        let material = surface_material(end);
        if (material.found && material.refract > 0.0) {
            let seen = patch_at(end);
            if (seen.found && dot(seen.normal, inside.direction) > 0.0) {
                return Back(true, end, seen.normal);
            }
        }
    }
    if (!sphere.found) {
        return Back(false, vec3(0.0), vec3(0.0));
    }
    let end = point_at(inside, select(chord_m, min(chord_m, open.distance_m), open.found));
    let outwards = end - sphere.centre;
    let size = length(outwards);
    return Back(size > MIN_LENGTH, end, outwards / max(size, MIN_LENGTH));
}

// Returns the rays that leave a solid. `whole` is the proxy of the solid, if it has one.
fn pass_through(ray: Ray, front: Patch, ior: f32, whole: Sphere) -> array<Exit, MAX_INSIDE> {
    var exits: array<Exit, MAX_INSIDE>;
    if (!front.bends) {
        return exits;
    }
    let bend = front.curvature;
    let behind = ray.origin + ray.direction * (BEHIND_TEXELS * front.texel_m);
    if (!whole.found && !is_surface(behind) && bend * front.texel_m < -FLAT) {
        // A concave front with empty space behind it: the ray was inside and leaves.
        let leaving = refracted(ray.direction, front.normal, ior);
        if (leaving.found) {
            exits[0] = Exit(Ray(ray.origin, leaving.direction), 1.0);
        }
        return exits;
    }
    let entering = refracted(ray.direction, front.normal, 1.0 / ior);
    if (!entering.found) {
        return exits;
    }
    var inside = Ray(ray.origin, entering.direction);
    var sphere = whole;
    if (!whole.found && bend * front.texel_m > FLAT) {
        sphere = Sphere(true, ray.origin - front.normal / bend, 1.0 / bend);
    }
    var share = 1.0;
    for (var turn = 0u; turn < MAX_INSIDE; turn++) {
        let back = back_of(inside, sphere, whole.found, front.texel_m);
        if (!back.found) {
            // A pane, which the ray passes unchanged.
            if (!sphere.found && turn == 0u) {
                exits[turn] = Exit(ray, share);
            }
            break;
        }
        var kept = 1.0;
        let leaving = refracted(inside.direction, -back.normal, ior);
        if (leaving.found) {
            kept = fresnel(dot(leaving.direction, back.normal), ior);
            exits[turn] = Exit(Ray(back.point, leaving.direction), share * (1.0 - kept));
        }
        share *= kept;
        inside = Ray(back.point, reflect(inside.direction, -back.normal));
    }
    return exits;
}
