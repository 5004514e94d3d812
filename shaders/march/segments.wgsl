// Marches over whole segments of a ray that one view proves to be empty (CALF 6, algorithm 4). Mirrors src/render/march/segments.rs.
// Needs `occupancy` and `refine`.

@group(0) @binding(8) var pyramids: texture_2d_array<u32>;

const ROUNDING: f32 = 1.0 / 1048576.0;
const SURELY_BELOW_ONE: f32 = 1.0 - ROUNDING;
const MIN_M: f32 = 1e-18;

// A point in the plane at depth 1 of a face; `face` is its index, or NO_FACE behind a perspective view.
struct PlanePlace {
    face: u32,
    // Before the division by `planar_m`.
    plane: vec2<f32>,
    planar_m: f32,
}

// Returns the bits of an upper bound of the inverse depths in a rectangle of texels, corners included.
fn greatest_between(face: u32, low: vec2<u32>, high: vec2<u32>) -> u32 {
    let extent = max(high.x - low.x, high.y - low.y);
    let level = select(firstLeadingBit(extent), 0u, extent == 0u);
    if (level > faces[face].levels) {
        return UNKNOWN;
    }
    var greatest = 0u;
    let first = low >> vec2(level);
    let last = high >> vec2(level);
    // Levels are stored below each other: half of the rows, a quarter, and so on.
    let rows = scene.pyramid_rows;
    let above = vec2(faces[face].pyramid_column, faces[face].pyramid_row + rows - (rows >> (max(level, 1u) - 1u)));
    for (var row = first.y; row <= last.y; row++) {
        for (var column = first.x; column <= last.x; column++) {
            let at = vec2(column, row);
            if (level == 0u) {
                greatest = max(greatest, inverse_depth_bits(face, at));
            } else {
                greatest = max(greatest, textureLoad(pyramids, above + at, faces[face].layer, 0).r);
            }
        }
    }
    return greatest;
}

fn plane_of(view: u32, local: vec3<f32>) -> PlanePlace {
    if (views[view].faces[VIEW_FACE] != NO_FACE) {
        return PlanePlace(select(NO_FACE, VIEW_FACE, local.z < 0.0), vec2(local.x, -local.y), -local.z);
    }
    let place = cube_face(local);
    return PlanePlace(place.face, place.plane, place.planar_m);
}

fn greatest_coordinate(x: vec3<f32>) -> f32 {
    return max(abs(x.x), max(abs(x.y), abs(x.z)));
}

fn is_segment_empty(view: u32, from_point: vec3<f32>, to_point: vec3<f32>, reach_m: f32) -> bool {
    let error_m = ROUNDING * (reach_m + greatest_coordinate(views[view].from_eye)) + MIN_M;
    let a_local = local_of(view, from_point);
    let b_local = local_of(view, to_point);
    let all_m = max(greatest_coordinate(a_local), greatest_coordinate(b_local)) + 2.0 * error_m;
    if (views[view].greatest_inverse_depth * all_m < SURELY_BELOW_ONE) {
        return true;
    }
    let a = plane_of(view, a_local);
    let b = plane_of(view, b_local);
    let nearest_m = min(a.planar_m, b.planar_m);
    let farthest_m = max(a.planar_m, b.planar_m) + 2.0 * error_m;
    if (a.face == NO_FACE || a.face != b.face || nearest_m < 4.0 * error_m) {
        return false;
    }
    let face = views[view].faces[a.face];
    if (face == NO_FACE) {
        return false;
    }
    let one = a.plane * (1.0 / a.planar_m);
    let two = b.plane * (1.0 / b.planar_m);
    let widths = max(abs(one), abs(two));
    let widest = max(widths.x, widths.y);
    let slack = (1.0 + widest) * (4.0 * error_m / nearest_m + ROUNDING);
    let is_view = a.face == VIEW_FACE;
    if (!is_view && widest + slack > 1.0) {
        return false;
    }
    let size = vec2(f32(faces[face].width), f32(faces[face].height));
    let margin = slack * abs(faces[face].scale) + size * ROUNDING;
    let one_at = one * faces[face].scale + faces[face].centre;
    let two_at = two * faces[face].scale + faces[face].centre;
    let low = min(one_at, two_at) - margin;
    let high = max(one_at, two_at) + margin;
    if (is_view && !(all(low >= vec2(0.0)) && all(high < size))) {
        return false;
    }
    let reach = select(0.0, AROUND_REACH, is_around);
    let from_texel = vec2<u32>(clamp(low - reach, vec2(0.0), size - 1.0));
    let to_texel = vec2<u32>(clamp(high + reach, vec2(0.0), size - 1.0));
    let greatest = greatest_between(face, from_texel, to_texel);
    return greatest != UNKNOWN && bitcast<f32>(greatest) * farthest_m < SURELY_BELOW_ONE;
}

// Returns the step at which marching ends; `scene.distance_count` if the ray hits nothing. Mirrors src/render/march/segments.rs.
fn first_step(ray: Ray, first: u32) -> u32 {
    let count = scene.distance_count;
    let origin = greatest_coordinate(ray.origin);
    let direction = greatest_coordinate(ray.direction);
    var at = first;
    // Length of the first segment: the largest that is aligned at `first`, at most `scene.first_segment`.
    var length = select(min(first & (~first + 1u), scene.first_segment), scene.first_segment, first == 0u);
    // The last point that is empty in no view, and whether a view finds it occupied.
    var blocked = count;
    var is_surface_there = false;
    while (at < count) {
        let last = min(at + length, count) - 1u;
        var passed = false;
        if (blocked == last) {
            // A segment that ends at this point cannot be empty: halve it.
            if (last == at && is_surface_there) {
                return at;
            }
            if (last == at) {
                length = 1u;
                passed = true;
            } else {
                length /= 2u;
            }
        } else {
            if (last == at) {
                length = 1u;
            }
            counted[MARCH_STEPS]++;
            let from_point = point_at(ray, distances_m[at]);
            let to_point = point_at(ray, distances_m[last]);
            let reach_m = origin + direction * distances_m[last];
            var sees_past = false;
            var behind = false;
            for (var turn = 0u; turn < view_count(); turn++) {
                let view = view_of_turn(turn);
                let says = occupancy(view, to_point);
                sees_past |= says == EMPTY;
                behind |= says == OCCUPIED;
                if (says == EMPTY && (at == last || is_segment_empty(view, from_point, to_point, reach_m))) {
                    remember_empty(view);
                    passed = true;
                    break;
                }
            }
            if (!passed && !sees_past) {
                blocked = last;
                is_surface_there = behind || until_unknown;
            }
            if (!passed && last > at) {
                length /= 2u;
            }
        }
        if (passed) {
            at += length;
            if (at % (2u * length) == 0u && length < scene.longest_segment) {
                length *= 2u;
            }
        }
    }
    return count;
}
