// What colour a point has: CalculateColor of algorithm 4 (CALF 6). Mirrors src/march/interpolate.rs. Needs `project`
// and `local_of`.

const DEPTH_EPSILON: f32 = 0.02;

// What views saw. `difference` is meant only where something was found.
struct Seen {
    found: bool,
    // As it is coded: codes over 255, or light.
    color: vec3<f32>,
    difference: f32,
}

// Four texels around a place, the first two above the others, with their weights.
struct Taps {
    texels: array<vec2<u32>, 4>,
    weights: vec4<f32>,
}

struct Sum {
    color: vec3<f32>,
    weight: f32,
    difference: f32,
}

const EMPTY_SUM = Sum(vec3(0.0), 0.0, 1e30);

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
    if (sum.weight > 0.0) {
        return Seen(true, sum.color / sum.weight, sum.difference);
    }
    return Seen(false, vec3(0.0), sum.difference);
}

// A sum with the texels of surfaces around a point in a view, by the share of the view.
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
        sum.color += weight * texel_color(at.face, taps.texels[tap]);
        sum.weight += weight;
        sum.difference = min(sum.difference, difference);
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

fn background_color(direction: vec3<f32>) -> Seen {
    var sum = EMPTY_SUM;
    for (var number = 0u; number < view_count(); number++) {
        let view = view_at(number);
        let at = project(view, to_probe(view, direction));
        if (at.face == NO_FACE) {
            continue;
        }
        var taps = taps_around(at.at, at.face);
        for (var tap = 0u; tap < 4u; tap++) {
            if (inverse_depth_bits(at.face, taps.texels[tap]) == BACKGROUND) {
                let weight = taps.weights[tap] * views[view].camera_weight;
                sum.color += weight * texel_color(at.face, taps.texels[tap]);
                sum.weight += weight;
                sum.difference = 0.0;
            }
        }
    }
    return seen_of(sum);
}
