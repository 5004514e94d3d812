// Occupancy of points: BetweenViewpointAndGeometry of algorithm 4 (CALF 6). Mirrors src/render/march/active_views.rs. Needs `project`,
// `inverse_depth_bits` and the declarations of marched_views.wgsl.

// Reach in texels of the footprint around a point: all texels that contain a point within this distance decide its occupancy.
const AROUND_REACH: f32 = 0.5 - 1.0 / 64.0;

const EMPTY = 0u;
const OCCUPIED = 1u;
const NOT_KNOWN = 2u;
// Smallest positive normal float.
const MIN_POSITIVE: f32 = 1.17549435e-38;

// The last view that found a point empty; it is tested first.
var<private> empty_view: u32;

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

// Returns the maximum inverse depth of the texels in a point's footprint.
fn footprint_inverse_depth(at: Projected) -> u32 {
    if (!is_around) {
        return nearest_inverse_depth(at);
    }
    let end = vec2(faces[at.face].width, faces[at.face].height) - 1u;
    let first = min(vec2<u32>(max(at.at - AROUND_REACH, vec2(0.0))), end);
    let last = min(vec2<u32>(max(at.at + AROUND_REACH, vec2(0.0))), end);
    var greatest = inverse_depth_bits(at.face, first);
    if (last.x != first.x) {
        greatest = max(greatest, inverse_depth_bits(at.face, vec2(last.x, first.y)));
    }
    if (last.y != first.y) {
        greatest = max(greatest, inverse_depth_bits(at.face, vec2(first.x, last.y)));
        if (last.x != first.x) {
            greatest = max(greatest, inverse_depth_bits(at.face, last));
        }
    }
    return greatest;
}

fn occupancy(view: u32, point: vec3<f32>) -> u32 {
    let local = local_of(view, point);
    let squared = dot(local, local);
    let near = squared < views[view].near_m * views[view].near_m;
    let at = project(view, local);
    if (at.face == NO_FACE) {
        // The centre of projection itself has no direction.
        return select(NOT_KNOWN, EMPTY, near && squared <= MIN_POSITIVE);
    }
    // Points within near are empty regardless of the texels.
    if (near) {
        return EMPTY;
    }
    let surface = footprint_inverse_depth(at);
    if (surface == UNKNOWN) {
        return NOT_KNOWN;
    }
    return select(OCCUPIED, EMPTY, bitcast<f32>(surface) < at.inverse_depth);
}

// Returns the view to test in this turn: `empty_view` is swapped with the first view.
fn view_of_turn(turn: u32) -> u32 {
    return view_at(select(select(turn, 0u, turn == empty_view), empty_view, turn == 0u));
}

fn is_surface(point: vec3<f32>) -> bool {
    var behind = false;
    for (var turn = 0u; turn < view_count(); turn++) {
        let view = view_of_turn(turn);
        let says = occupancy(view, point);
        if (says == EMPTY) {
            remember_empty(view);
            return false;
        }
        behind |= says == OCCUPIED;
    }
    return behind || until_unknown;
}
