// Secondary rays of reflective and refractive surfaces: CalculateColor_RR of algorithm 4 (CALF 6.1). Mirrors
// src/render/march/specular/secondary_rays.rs.
//
// Replaces diffuse.wgsl. WGSL has no recursion, so surfaces that are still to be shaded are kept on a stack. Needs
// `surface_material`, `patch_at`, `pass_through`, `intersect_from`, `surface_color`, `with_view`, `background_color`,
// `light_of`, and the declarations of active_views.wgsl.

const MIN_SHARE: f32 = 1.0 / 256.0;
const LIFT_TEXELS: f32 = 1.0;
const HIDDEN_TEXELS: f32 = 12.0;
const RECORDED_SINE: f32 = 0.05;
const SETTLE_TIMES = 8u;
// Capacity of the stack. A surface has at most four secondary rays, so eight bounces need at most 25 entries.
const MAX_PENDING = 32u;

// A surface hit that is still to be shaded; `light` is linear RGB.
struct Pending {
    point: vec3<f32>,
    direction: vec3<f32>,
    light: vec3<f32>,
    share: f32,
    bounces: u32,
}

struct Recorded {
    share: f32,
    light: vec3<f32>,
}

const FOUND_NOTHING = 0u;
// Radiance that needs no further rays.
const FOUND_LIGHT = 1u;
const FOUND_SURFACE = 2u;

struct Found {
    kind: u32,
    point: vec3<f32>,
    light: vec3<f32>,
}

var<private> pending: array<Pending, MAX_PENDING>;
var<private> pending_count: u32;

// Result of leaving the surface at a ray's origin: a hit on another surface, or empty space at step `first`.
struct Departure {
    found: bool,
    hit: Hit,
    first: u32,
}

fn leave_surface(ray: Ray, texel_m: f32) -> Departure {
    var at = IN_SURFACE;
    var is_empty = false;
    var empty_m = 0.0;
    while (at.step < scene.distance_count) {
        at = next_from_surface(at, texel_m);
        counted[MARCH_STEPS]++;
        if (!is_surface(point_at(ray, at.distance_m))) {
            if (at.is_step) {
                return Departure(true, Hit(false, 0.0), at.step - 1u);
            }
            is_empty = true;
            empty_m = at.distance_m;
        } else if (is_empty) {
            return Departure(true, Hit(true, refine(ray, empty_m, at.distance_m, scene.refine)), 0u);
        } else if (at.distance_m > HIDDEN_TEXELS * texel_m) {
            break;
        }
    }
    return Departure(false, Hit(false, 0.0), 0u);
}

// Returns the proxy whose environment map is `around`; none for ALL_VIEWS.
fn proxy_of(around: u32) -> Sphere {
    if (around == ALL_VIEWS) {
        return Sphere(false, vec3(0.0), 0.0);
    }
    return Sphere(true, views[around].from_eye, views[around].near_m);
}

// Returns the environment map of the proxy whose surface contains a point, or ALL_VIEWS.
fn around_of(point: vec3<f32>) -> u32 {
    for (var at = 0u; at < scene.proxy_count; at++) {
        let sphere = proxy_of(scene.view_count + at);
        if (abs(length(point - sphere.centre) - sphere.radius_m) <= views[scene.view_count + at].reach_m) {
            return scene.view_count + at;
        }
    }
    return ALL_VIEWS;
}

// The surface at a hit, and the environment map of its proxy or ALL_VIEWS.
struct Front {
    surface: Patch,
    point: vec3<f32>,
    around: u32,
}

fn front_of(met: Ray, is_glass: bool) -> Front {
    let around = around_of(met.origin);
    if (is_glass && around != ALL_VIEWS) {
        let sphere = proxy_of(around);
        let entry = entry_of(sphere, met);
        let outwards = entry.point - sphere.centre;
        let size = length(outwards);
        if (entry.found && size > MIN_LENGTH) {
            return Front(Patch(true, true, outwards / size, 1.0 / sphere.radius_m, 0.0), entry.point, around);
        }
    }
    return Front(patch_at(met.origin), met.origin, ALL_VIEWS);
}

// Traces a secondary ray. `around` is the environment map of the proxy that the ray leaves, or ALL_VIEWS.
fn trace(ray: Ray, texel_m: f32, around: u32) -> Found {
    let nothing = Found(FOUND_NOTHING, vec3(0.0), vec3(0.0));
    counted[SECONDARY_RAYS]++;
    var left = Departure(true, Hit(false, 0.0), 0u);
    if (around == ALL_VIEWS) {
        left = leave_surface(ray, texel_m);
    }
    if (!left.found) {
        return nothing;
    }
    var hit = left.hit;
    if (!hit.found) {
        alone = around;
        hit = intersect_from(ray, left.first);
        alone = ALL_VIEWS;
    }
    if (!hit.found) {
        let seen = background_color(ray.direction);
        if (seen.found) {
            return Found(FOUND_LIGHT, vec3(0.0), light_of(seen.color));
        }
        return nothing;
    }
    let point = point_at(ray, hit.distance_m);
    let seen = surface_color(point);
    if (seen.found && seen.difference <= scene.tolerance) {
        return Found(FOUND_SURFACE, point, light_of(seen.color));
    }
    // No view sees the point directly, but one may see it through the solid.
    if (around != ALL_VIEWS) {
        alone = around;
        let through = surface_color(point);
        alone = ALL_VIEWS;
        if (through.found) {
            return Found(FOUND_LIGHT, vec3(0.0), light_of(through.color));
        }
    }
    return nothing;
}

// Returns the radiance of a traced ray times its share; pushes a surface onto the stack and returns 0 for it.
fn take(found: Found, direction: vec3<f32>, share: f32, bounces: u32) -> vec3<f32> {
    if (found.kind == FOUND_SURFACE && pending_count < MAX_PENDING) {
        pending[pending_count] = Pending(found.point, direction, found.light, share, bounces - 1u);
        pending_count++;
        return vec3(0.0);
    }
    return share * found.light;
}

// Returns the radiance recorded by views whose direction to a point is close to the eye's, and its share: 1 for a view in the
// same direction, 0 if the sine of the angle is RECORDED_SINE or more for all views.
fn recorded_of(point: vec3<f32>) -> Recorded {
    var greatest = 0.0;
    var sum = EMPTY_SUM;
    for (var number = 0u; number < view_count(); number++) {
        let view = view_at(number);
        let from_view = point - views[view].from_eye;
        let at = project(view, local_of(view, point));
        if (at.face == NO_FACE || dot(point, from_view) <= 0.0) {
            continue;
        }
        let surface = nearest_inverse_depth(at);
        if (surface == BACKGROUND || surface == UNKNOWN) {
            continue;
        }
        if (abs(log(bitcast<f32>(surface) / at.inverse_depth)) > scene.tolerance) {
            continue;
        }
        let sine = length(cross(point, views[view].from_eye)) / (length(point) * length(from_view));
        let share = clamp(1.0 - sine / RECORDED_SINE, 0.0, 1.0);
        if (share > 0.0) {
            greatest = max(greatest, share);
            sum = with_view(sum, view, at, share);
        }
    }
    let seen = seen_of(sum);
    if (!seen.found) {
        return Recorded(0.0, vec3(0.0));
    }
    return Recorded(greatest * greatest * (3.0 - 2.0 * greatest), light_of(seen.color));
}

// Moves a hit of a primary ray along the ray to the surface of the texels that contain it.
fn on_texels(point: vec3<f32>, direction: vec3<f32>) -> vec3<f32> {
    let from_m = length(point);
    let behind_m = from_m * exp(HOLE_DIFFERENCE);
    let ray = Ray(vec3(0.0), direction);
    counted[MARCH_STEPS] += 2u;
    if (is_surface(point) || !is_surface(point_at(ray, behind_m))) {
        return point;
    }
    return point_at(ray, refine(ray, from_m, behind_m, SETTLE_TIMES));
}

// Splits the share of a surface among its secondary rays.
fn divide(next: Pending) -> vec3<f32> {
    let whole = next.share * next.light;
    if (next.bounces == 0u) {
        return whole;
    }
    counted[MATERIAL_SAMPLES]++;
    let seen = surface_material(next.point);
    if (!seen.found) {
        return whole;
    }
    // Only hits of eye rays use recorded radiance; secondary rays arrive from other directions.
    var seen_there = Recorded(0.0, vec3(0.0));
    var point = next.point;
    if (next.bounces == scene.max_bounces) {
        if ((scene.refinements & REFINE_EDGES) != 0u) {
            point = on_texels(point, next.direction);
        }
        seen_there = recorded_of(point);
    }
    let recorded = next.share * seen_there.share * seen_there.light;
    let share = next.share - next.share * seen_there.share;
    let rest = recorded + share * next.light;
    if (share < MIN_SHARE) {
        return rest;
    }
    counted[NORMAL_EVALS]++;
    let at_point = front_of(Ray(point, next.direction), seen.refract > 0.0);
    let front = at_point.surface;
    let cosine = -dot(next.direction, front.normal);
    if (!front.found || cosine <= 0.0) {
        return rest;
    }
    let material = at_angle(seen, cosine);
    var exits: array<Exit, MAX_INSIDE>;
    if (share * material.refract >= MIN_SHARE) {
        exits = pass_through(Ray(at_point.point, next.direction), front, material.ior, proxy_of(at_point.around));
    }
    // One loop for the refracted rays and the reflected one, because drivers inline functions at each call.
    var light = vec3(0.0);
    var left = share;
    for (var at = 0u; at <= MAX_INSIDE; at++) {
        let origin = at_point.point + LIFT_TEXELS * front.texel_m * front.normal;
        var ray = Ray(origin, reflect(next.direction, front.normal));
        var part = share * material.reflect;
        if (at < MAX_INSIDE) {
            ray = exits[at].ray;
            part = share * material.refract * exits[at].part;
        }
        if (part < MIN_SHARE) {
            continue;
        }
        let found = trace(ray, front.texel_m, at_point.around);
        if (found.kind != FOUND_NOTHING) {
            light += take(found, ray.direction, part, next.bounces);
            left -= part;
        }
    }
    return recorded + light + max(left, 0.0) * next.light;
}

fn surface_light(ray: Ray, distance_m: f32, seen: Seen) -> vec3<f32> {
    pending[0] = Pending(point_at(ray, distance_m), ray.direction, light_of(seen.color), 1.0, scene.max_bounces);
    pending_count = 1u;
    var light = vec3(0.0);
    while (pending_count > 0u) {
        pending_count--;
        light += divide(pending[pending_count]);
    }
    return light;
}
