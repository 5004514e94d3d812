// The way of a ray through glass (CALF 6.1). Mirrors src/march/specular/solid.rs. Needs `patch_at`, `surface_material`,
// `fresnel`, `is_surface` and `refine`.

const FLAT: f32 = 2e-3;
const BEHIND_TEXELS: f32 = 3.0;
const MAX_INSIDE = 3u;
const NO_LIMIT_M: f32 = 1e30;

// A ray that leaves a solid, and its part of the light that entered; 0: it stays inside.
struct Exit {
    ray: Ray,
    part: f32,
}

// A direction, if any.
struct Bent {
    found: bool,
    direction: vec3<f32>,
}

// Where a ray inside of a solid meets its back, and the normal there, which points out of the solid.
struct Back {
    found: bool,
    point: vec3<f32>,
    normal: vec3<f32>,
}

// A ball that touches the front and is bent as it is.
struct Ball {
    found: bool,
    centre: vec3<f32>,
    radius_m: f32,
}

// The distance from which on a view sees past a ray.
struct FirstOpen {
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
    return Bent(size > LEAST_LENGTH, bent / max(size, LEAST_LENGTH));
}

fn first_open(ray: Ray, texel_m: f32, limit_m: f32) -> FirstOpen {
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
            // From behind, what is open comes last.
            return FirstOpen(true, refine(ray, distance_m, before_m));
        }
        before_m = distance_m;
    }
    return FirstOpen(false, 0.0);
}

// Where a ray that comes from outside first meets a ball.
struct Entry {
    found: bool,
    point: vec3<f32>,
}

fn entry_of(ball: Ball, ray: Ray) -> Entry {
    let from_centre = ray.origin - ball.centre;
    let along = dot(ray.direction, from_centre);
    let squared = along * along - (dot(from_centre, from_centre) - ball.radius_m * ball.radius_m);
    return Entry(squared > 0.0, point_at(ray, -along - sqrt(max(squared, 0.0))));
}

// How far a ray, which need not start on the ball, goes until it leaves it; 0: it does not go through it.
fn exit_of(ball: Ball, ray: Ray) -> f32 {
    let from_centre = ray.origin - ball.centre;
    let along = dot(ray.direction, from_centre);
    let squared = along * along - (dot(from_centre, from_centre) - ball.radius_m * ball.radius_m);
    return select(0.0, sqrt(max(squared, 0.0)) - along, squared >= 0.0);
}

fn back_of(inside: Ray, ball: Ball, is_whole: bool, texel_m: f32) -> Back {
    let chord_m = exit_of(ball, inside);
    if (ball.found && !(chord_m > 0.0)) {
        return Back(false, vec3(0.0), vec3(0.0));
    }
    var open = FirstOpen(false, 0.0);
    if (!is_whole) {
        open = first_open(inside, texel_m, select(NO_LIMIT_M, 2.0 * chord_m, ball.found));
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
    if (!ball.found) {
        return Back(false, vec3(0.0), vec3(0.0));
    }
    let end = point_at(inside, select(chord_m, min(chord_m, open.distance_m), open.found));
    let outwards = end - ball.centre;
    let size = length(outwards);
    return Back(size > LEAST_LENGTH, end, outwards / max(size, LEAST_LENGTH));
}

// `whole` is the ball that the solid is known to be, if it is.
fn pass_through(ray: Ray, front: Patch, ior: f32, whole: Ball) -> array<Exit, MAX_INSIDE> {
    var exits: array<Exit, MAX_INSIDE>;
    if (!front.bends) {
        return exits;
    }
    let bend = front.curvature;
    let behind = ray.origin + ray.direction * (BEHIND_TEXELS * front.texel_m);
    if (!whole.found && !is_surface(behind) && bend * front.texel_m < -FLAT) {
        // A hollow with open space behind it: the ray was inside, and leaves.
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
    var ball = whole;
    if (!whole.found && bend * front.texel_m > FLAT) {
        ball = Ball(true, ray.origin - front.normal / bend, 1.0 / bend);
    }
    var share = 1.0;
    for (var turn = 0u; turn < MAX_INSIDE; turn++) {
        let back = back_of(inside, ball, whole.found, front.texel_m);
        if (!back.found) {
            // A pane.
            if (!ball.found && turn == 0u) {
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
