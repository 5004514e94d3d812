// What views say of a point: BetweenViewpointAndGeometry of algorithm 4 (CALF 6). Mirrors src/march/active_views.rs.
// Needs `project`, `inverse_depth_bits` and what asked_all.wgsl has.

const OPEN = 0u;
const BEHIND = 1u;
const NOT_KNOWN = 2u;
// The smallest normal number.
const MIN_POSITIVE: f32 = 1.17549435e-38;

// The view that said last that a point is open: it is asked first.
var<private> open_view: u32;

fn to_probe(view: u32, direction: vec3<f32>) -> vec3<f32> {
    return views[view].turn_x * direction.x + views[view].turn_y * direction.y + views[view].turn_z * direction.z;
}

fn local_of(view: u32, point: vec3<f32>) -> vec3<f32> {
    return to_probe(view, point - views[view].from_eye);
}

fn nearest_inverse_depth(at: Projected) -> u32 {
    let last = vec2(faces[at.face].width, faces[at.face].height) - 1u;
    return inverse_depth_bits(at.face, min(vec2<u32>(max(at.at, vec2(0.0))), last));
}

fn evidence(view: u32, point: vec3<f32>) -> u32 {
    let local = local_of(view, point);
    let squared = dot(local, local);
    let near = squared < views[view].near_m * views[view].near_m;
    let at = project(view, local);
    if (at.face == NO_FACE) {
        // The centre itself has no direction.
        return select(NOT_KNOWN, OPEN, near && squared <= MIN_POSITIVE);
    }
    // Within near it is so even where no texel was decoded.
    if (near) {
        return OPEN;
    }
    let surface = nearest_inverse_depth(at);
    if (surface == UNKNOWN) {
        return NOT_KNOWN;
    }
    return select(BEHIND, OPEN, bitcast<f32>(surface) < at.inverse_depth);
}

// The view that is asked in this turn: that of `open_view` has changed places with the first.
fn view_of_turn(turn: u32) -> u32 {
    return asked_view(select(select(turn, 0u, turn == open_view), open_view, turn == 0u));
}

fn is_surface(point: vec3<f32>) -> bool {
    var behind = false;
    for (var turn = 0u; turn < asked_count(); turn++) {
        let view = view_of_turn(turn);
        let says = evidence(view, point);
        if (says == OPEN) {
            remember_open(view);
            return false;
        }
        behind |= says == BEHIND;
    }
    return behind;
}
