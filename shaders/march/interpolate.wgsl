// Interpolates the colour of a point: CalculateColor of algorithm 4 (CALF 6). Mirrors src/render/march/interpolate.rs. Needs `project`
// and `local_of`.

const DEPTH_EPSILON: f32 = 0.02;
const HOLE_DIFFERENCE: f32 = 0.1;
const ANGLE_EPSILON: f32 = 0.0005;
const CAMERA_EPSILON: f32 = 0.01;
const EDGE_PENALTY: f32 = 6.0;
const BACKGROUND_EDGE_PENALTY: f32 = 20.0;
const NEARER: f32 = 1.105171;
const DEPTH_CUT: f32 = 0.2;
const CUT_WEIGHT: f32 = 0.001;

// Result of an interpolation over views. `difference` is only defined if `found`.
struct Seen {
    found: bool,
    // As coded: codes over 255, or linear RGB.
    color: vec3<f32>,
    difference: f32,
    coverage: f32,
    alpha: f32,
}

// The four texels around a position with their bilinear weights, the upper two first.
struct Taps {
    texels: array<vec2<u32>, 4>,
    weights: vec4<f32>,
}

struct Sum {
    color: vec3<f32>,
    weight: f32,
    // Sum of the weights times alpha: the weights of the colours.
    shown: f32,
    difference: f32,
}

const EMPTY_SUM = Sum(vec3(0.0), 0.0, 0.0, 1e30);

fn taps_around(at: vec2<f32>, face: u32) -> Taps {
    let last = vec2(f32(faces[face].width), f32(faces[face].height)) - 1.0;
    let corner = floor(at - 0.5);
    let part = at - 0.5 - corner;
    let first = vec2<u32>(clamp(corner, vec2(0.0), last));
    let second = vec2<u32>(clamp(corner + 1.0, vec2(0.0), last));
    let across = vec2(1.0 - part.x, part.x);
    let down = vec2(1.0 - part.y, part.y);
    return Taps(
        array(first, vec2(second.x, first.y), vec2(first.x, second.y), second),
        vec4(across * down.x, across * down.y),
    );
}

fn seen_of(sum: Sum) -> Seen {
    if (sum.shown > 0.0) {
        return Seen(true, sum.color / sum.shown, sum.difference, 1.0, sum.shown / sum.weight);
    }
    return Seen(sum.weight > 0.0, vec3(0.0), sum.difference, 1.0, 0.0);
}

// Adds a texel to a sum.
fn with_texel(before: Sum, color: vec4<f32>, weight: f32, difference: f32) -> Sum {
    let shown = weight * color.a;
    return Sum(
        before.color + shown * color.rgb,
        before.weight + weight,
        before.shown + shown,
        min(before.difference, difference),
    );
}

// Adds the surface texels around a point in a view to a sum, weighted by the view's share.
fn with_view(before: Sum, view: u32, at: Projected, share: f32) -> Sum {
    var sum = before;
    var taps = taps_around(at.at, at.face);
    for (var tap = 0u; tap < 4u; tap++) {
        let surface = inverse_depth_bits(at.face, taps.texels[tap]);
        if (surface == BACKGROUND || surface == UNKNOWN) {
            continue;
        }
        let difference = abs(log(bitcast<f32>(surface) / at.inverse_depth));
        let weight = share * (taps.weights[tap] * views[view].camera_weight / (difference + DEPTH_EPSILON));
        sum = with_texel(sum, texel_color(at.face, taps.texels[tap]), weight, difference);
    }
    return sum;
}

fn surface_color(point: vec3<f32>) -> Seen {
    var sum = EMPTY_SUM;
    for (var number = 0u; number < view_count(); number++) {
        let view = view_at(number);
        let at = project(view, local_of(view, point));
        if (at.face != NO_FACE) {
            sum = with_view(sum, view, at, 1.0);
        }
    }
    return seen_of(sum);
}

// Returns the weight of a view for a point on a primary ray, from the angle between the eye ray and the view ray, and from
// resolution.
fn angle_weight(view: u32, point: vec3<f32>) -> f32 {
    let from_view = point - views[view].from_eye;
    let from_eye_m = length(point);
    let from_view_m = length(from_view);
    let sine = length(cross(point, from_view)) / max(from_eye_m * from_view_m, MIN_POSITIVE);
    let angle = select(1.0, sine, dot(point, from_view) > 0.0);
    let blur = max(from_view_m / max(from_eye_m, MIN_POSITIVE) - 1.0, 0.0);
    return 1.0 / (angle + blur + ANGLE_EPSILON);
}

// Returns the factor on the weight of a view's texels that are next to a nearer surface; `epsilon` is the ε used in `weight`.
fn edge_part_of(view: u32, weight: f32, epsilon: f32, penalty: f32) -> f32 {
    if (!is_around || all(views[view].from_eye == vec3(0.0))) {
        return 1.0;
    }
    return 1.0 / (1.0 + penalty - penalty * epsilon * weight);
}

fn is_nearer(face: u32, texel: vec2<u32>, inverse_depth: f32) -> bool {
    let surface = inverse_depth_bits(face, texel);
    return surface != UNKNOWN && bitcast<f32>(surface) > inverse_depth;
}

// True if one of the four adjacent texels shows a surface with a greater inverse depth.
fn is_beside_nearer(face: u32, texel: vec2<u32>, inverse_depth: f32) -> bool {
    return (texel.x > 0u && is_nearer(face, texel - vec2(1u, 0u), inverse_depth))
        || (texel.x + 1u < faces[face].width && is_nearer(face, texel + vec2(1u, 0u), inverse_depth))
        || (texel.y > 0u && is_nearer(face, texel - vec2(0u, 1u), inverse_depth))
        || (texel.y + 1u < faces[face].height && is_nearer(face, texel + vec2(0u, 1u), inverse_depth));
}

fn fit_weight(difference: f32) -> f32 {
    let weight = 1.0 / (difference + DEPTH_EPSILON);
    if ((scene.refinements & REFINE_ANGLES) == 0u) {
        return weight;
    }
    return max(weight - 1.0 / (DEPTH_CUT + DEPTH_EPSILON), CUT_WEIGHT * weight);
}

// Returns the colour, coverage and alpha of a surface point on a primary ray.
fn seen_from_eye(point: vec3<f32>) -> Seen {
    var sum = EMPTY_SUM;
    var opaque = 0.0;
    var covered = 0.0;
    var all = 0.0;
    for (var number = 0u; number < view_count(); number++) {
        let view = view_at(number);
        let at = project(view, local_of(view, point));
        if (at.face == NO_FACE) {
            continue;
        }
        var of_view = views[view].camera_weight;
        var epsilon = CAMERA_EPSILON;
        if ((scene.refinements & REFINE_ANGLES) != 0u) {
            of_view = angle_weight(view, point);
            epsilon = ANGLE_EPSILON;
        }
        let edge_part = edge_part_of(view, of_view, epsilon, EDGE_PENALTY);
        var taps = taps_around(at.at, at.face);
        for (var tap = 0u; tap < 4u; tap++) {
            let surface = inverse_depth_bits(at.face, taps.texels[tap]);
            if (surface == UNKNOWN) {
                continue;
            }
            let weight = taps.weights[tap] * of_view;
            if (surface == BACKGROUND) {
                all += weight;
                continue;
            }
            let nearer = log(bitcast<f32>(surface) / at.inverse_depth);
            let difference = abs(nearer);
            all += select(0.0, weight, nearer <= scene.tolerance);
            let covers = select(0.0, weight, difference <= scene.tolerance);
            covered += covers;
            let color = texel_color(at.face, taps.texels[tap]);
            opaque += covers * color.a;
            let is_edge = edge_part < 1.0
                && is_beside_nearer(at.face, taps.texels[tap], bitcast<f32>(surface) * NEARER);
            let fitting = weight * fit_weight(difference) * select(1.0, edge_part, is_edge);
            sum = with_texel(sum, color, fitting, difference);
        }
    }
    var seen = seen_of(sum);
    if (all > 0.0) {
        seen.coverage = covered / all;
    }
    if (covered > 0.0) {
        seen.alpha = opaque / covered;
    }
    return seen;
}

fn background_color(direction: vec3<f32>) -> Seen {
    var sum = EMPTY_SUM;
    for (var number = 0u; number < view_count(); number++) {
        let view = view_at(number);
        let at = project(view, to_probe(view, direction));
        if (at.face == NO_FACE) {
            continue;
        }
        var taps = taps_around(at.at, at.face);
        let of_view = views[view].camera_weight;
        let edge_part = edge_part_of(view, of_view, CAMERA_EPSILON, BACKGROUND_EDGE_PENALTY);
        for (var tap = 0u; tap < 4u; tap++) {
            if (inverse_depth_bits(at.face, taps.texels[tap]) == BACKGROUND) {
                let is_edge = edge_part < 1.0 && is_beside_nearer(at.face, taps.texels[tap], 0.0);
                let weight = taps.weights[tap] * of_view * select(1.0, edge_part, is_edge);
                sum = with_texel(sum, texel_color(at.face, taps.texels[tap]), weight, 0.0);
            }
        }
    }
    return seen_of(sum);
}
