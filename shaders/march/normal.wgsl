// Estimates the normal and curvature of a surface point from the depths around it (CALF 6.1). Mirrors
// src/render/march/specular/normal.rs. Needs `project`, `local_of`, `texel_material` and `DEPTH_EPSILON`.

const SAME_SURFACE: f32 = 0.02;
const MAX_REACH: i32 = 2;
const FIT: f32 = 0.01;
const SAME_PATCH: f32 = 0.03;
const SAME_MATERIAL: i32 = 64;
// The texel has no inverse depth on this surface.
const NO_TEXEL: f32 = -1.0;
// A shorter vector has no direction.
const MIN_LENGTH: f32 = 1e-30;

// `curvature` is only defined if `bends`.
struct Patch {
    found: bool,
    bends: bool,
    normal: vec3<f32>,
    curvature: f32,
    texel_m: f32,
}

const NO_PATCH = Patch(false, false, vec3(0.0), 0.0, 0.0);

struct Axes {
    forward: vec3<f32>,
    right: vec3<f32>,
    down: vec3<f32>,
}

// Inverse depth around the centre of a texel: c[0] + c[1]x + c[2]y + c[3]x² + c[4]xy + c[5]y².
struct Fit {
    found: bool,
    bends: bool,
    c: array<f32, 6>,
}

// Neighbourhood of a texel; `solid` is -1 if there is no material.
struct Around {
    face: u32,
    texel: vec2<u32>,
    solid: i32,
}

// Surface patch in one view, in the view's axes.
struct LocalPatch {
    found: bool,
    bends: bool,
    normal: vec3<f32>,
    curvature: f32,
    texel_m: f32,
    difference: f32,
    facing: f32,
}

fn face_axes(number: u32) -> Axes {
    switch number {
        case 0u: {
            return Axes(vec3(1.0, 0.0, 0.0), vec3(0.0, 0.0, -1.0), vec3(0.0, -1.0, 0.0));
        }
        case 1u: {
            return Axes(vec3(-1.0, 0.0, 0.0), vec3(0.0, 0.0, 1.0), vec3(0.0, -1.0, 0.0));
        }
        case 2u: {
            return Axes(vec3(0.0, 1.0, 0.0), vec3(1.0, 0.0, 0.0), vec3(0.0, 0.0, 1.0));
        }
        case 3u: {
            return Axes(vec3(0.0, -1.0, 0.0), vec3(1.0, 0.0, 0.0), vec3(0.0, 0.0, -1.0));
        }
        case 4u: {
            return Axes(vec3(0.0, 0.0, 1.0), vec3(1.0, 0.0, 0.0), vec3(0.0, -1.0, 0.0));
        }
        case 5u: {
            return Axes(vec3(0.0, 0.0, -1.0), vec3(-1.0, 0.0, 0.0), vec3(0.0, -1.0, 0.0));
        }
        default: {
            return Axes(vec3(0.0, 0.0, -1.0), vec3(1.0, 0.0, 0.0), vec3(0.0, -1.0, 0.0));
        }
    }
}

fn solid_of(face: u32, texel: vec2<u32>) -> i32 {
    if (faces[face].has_material == 0u) {
        return -1;
    }
    let weights = round(texel_material(face, texel).xy * 255.0);
    return i32(weights.x) + i32(weights.y);
}

// Returns the inverse depth of a neighbour that may belong to the same surface, or NO_TEXEL.
fn texel_around(around: Around, x: i32, y: i32) -> f32 {
    let place = vec2<i32>(around.texel) + vec2(x, y);
    if (any(place < vec2(0)) || place.x >= i32(faces[around.face].width) || place.y >= i32(faces[around.face].height)) {
        return NO_TEXEL;
    }
    let texel = vec2<u32>(place);
    let bits = inverse_depth_bits(around.face, texel);
    if (bits == BACKGROUND || bits == UNKNOWN) {
        return NO_TEXEL;
    }
    if (around.solid >= 0 && abs(solid_of(around.face, texel) - around.solid) > SAME_MATERIAL) {
        return NO_TEXEL;
    }
    return bitcast<f32>(bits);
}

fn fit_value(fit: Fit, at: vec2<f32>) -> f32 {
    let c = fit.c;
    return c[0] + c[1] * at.x + c[2] * at.y + c[3] * at.x * at.x + c[4] * at.x * at.y + c[5] * at.y * at.y;
}

fn fit_slope(fit: Fit, at: vec2<f32>) -> vec2<f32> {
    let c = fit.c;
    return vec2(c[1] + 2.0 * c[3] * at.x + c[4] * at.y, c[2] + c[4] * at.x + 2.0 * c[5] * at.y);
}

const NO_FIT = Fit(false, false, array(0.0, 0.0, 0.0, 0.0, 0.0, 0.0));

// Fits a quadratic polynomial by least squares to a complete square of texels.
fn bent(around: Around, reach: i32) -> Fit {
    let side = f32(2 * reach + 1);
    // Sums of x² and of (x² − mean)² over a row.
    var squares = 0.0;
    for (var column = -reach; column <= reach; column++) {
        squares += f32(column * column);
    }
    let mean_square = squares / side;
    var fourths = 0.0;
    for (var column = -reach; column <= reach; column++) {
        let off = f32(column * column) - mean_square;
        fourths += off * off;
    }
    var sums = array(0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
    for (var row = -reach; row <= reach; row++) {
        for (var column = -reach; column <= reach; column++) {
            let inverse = texel_around(around, column, row);
            if (inverse < 0.0) {
                return NO_FIT;
            }
            let x = f32(column);
            let y = f32(row);
            sums[0] += inverse;
            sums[1] += x * inverse;
            sums[2] += y * inverse;
            sums[3] += (x * x - mean_square) * inverse;
            sums[4] += x * y * inverse;
            sums[5] += (y * y - mean_square) * inverse;
        }
    }
    var c = array(
        sums[0] / (side * side),
        sums[1] / (side * squares),
        sums[2] / (side * squares),
        sums[3] / (side * fourths),
        sums[4] / (squares * squares),
        sums[5] / (side * fourths),
    );
    c[0] -= mean_square * (c[3] + c[5]);
    let fit = Fit(true, true, c);
    let far = FIT * c[0];
    for (var row = -reach; row <= reach; row++) {
        for (var column = -reach; column <= reach; column++) {
            let value = fit_value(fit, vec2(f32(column), f32(row)));
            if (!(abs(texel_around(around, column, row) - value) <= far)) {
                return NO_FIT;
            }
        }
    }
    return fit;
}

// Fits a plane through the centre of 3 x 3 texels to those with a similar inverse depth.
fn flat_fit(around: Around) -> Fit {
    let middle = texel_around(around, 0, 0);
    var squares = vec3(0.0);
    var differences = vec2(0.0);
    for (var row = -1; row <= 1; row++) {
        for (var column = -1; column <= 1; column++) {
            let other = texel_around(around, column, row);
            if (other < 0.0 || abs(other - middle) > SAME_PATCH * middle) {
                continue;
            }
            let x = f32(column);
            let y = f32(row);
            squares += vec3(x * x, x * y, y * y);
            differences += vec2(x, y) * (other - middle);
        }
    }
    let determinant = squares.x * squares.z - squares.y * squares.y;
    if (determinant < 0.5) {
        return NO_FIT;
    }
    let x = (differences.x * squares.z - differences.y * squares.y) / determinant;
    let y = (differences.y * squares.x - differences.x * squares.y) / determinant;
    return Fit(true, false, array(middle, x, y, 0.0, 0.0, 0.0));
}

fn fit_around(face: u32, texel: vec2<u32>) -> Fit {
    let around = Around(face, texel, solid_of(face, texel));
    if (texel_around(around, 0, 0) < 0.0) {
        return NO_FIT;
    }
    for (var reach = MAX_REACH; reach >= 1; reach--) {
        let fit = bent(around, reach);
        if (fit.found) {
            return fit;
        }
    }
    return flat_fit(around);
}

// Returns the coordinates at distance 1 of an offset in texels from the centre of a texel.
fn plane_at(face: u32, texel: vec2<u32>, offset: vec2<f32>) -> vec2<f32> {
    return (vec2<f32>(texel) + 0.5 + offset - faces[face].centre) / faces[face].scale;
}

// Returns the unit normal of a fit; 0 if it is degenerate.
fn fit_normal(fit: Fit, face: u32, texel: vec2<u32>, offset: vec2<f32>) -> vec3<f32> {
    let plane = plane_at(face, texel, offset);
    let by = fit_slope(fit, offset) * faces[face].scale;
    let ahead = fit_value(fit, offset) - dot(by, plane);
    let axes = face_axes(faces[face].number);
    let normal = -(by.x * axes.right + by.y * axes.down + ahead * axes.forward);
    let size = length(normal);
    return select(vec3(0.0), normal / max(size, MIN_LENGTH), size > MIN_LENGTH);
}

fn fit_point(fit: Fit, face: u32, texel: vec2<u32>, offset: vec2<f32>) -> vec3<f32> {
    let plane = plane_at(face, texel, offset);
    let axes = face_axes(faces[face].number);
    let value = fit_value(fit, offset);
    return (axes.forward + plane.x * axes.right + plane.y * axes.down) / select(value, MIN_LENGTH, abs(value) < MIN_LENGTH);
}

fn patch_of_view(view: u32, local: vec3<f32>) -> LocalPatch {
    let none = LocalPatch(false, false, vec3(0.0), 0.0, 0.0, 0.0, 0.0);
    let at = project(view, local);
    if (at.face == NO_FACE) {
        return none;
    }
    let last = vec2(faces[at.face].width, faces[at.face].height) - 1u;
    let texel = min(vec2<u32>(max(at.at, vec2(0.0))), last);
    let offset = at.at - (vec2<f32>(texel) + 0.5);
    let fit = fit_around(at.face, texel);
    if (!fit.found) {
        return none;
    }
    let value = fit_value(fit, offset);
    // A fit may be negative away from the texel centre.
    let difference = select(1e30, abs(log(max(value, MIN_LENGTH) / at.inverse_depth)), value > 0.0);
    if (!(difference <= SAME_SURFACE)) {
        return none;
    }
    let normal = fit_normal(fit, at.face, texel, offset);
    let facing = -dot(normal, local / max(length(local), MIN_LENGTH));
    if (!(facing > 0.0)) {
        return none;
    }
    var turned = 0.0;
    var moved = 0.0;
    var bends = fit.bends;
    for (var axis = 0u; axis < 2u; axis++) {
        let step = select(vec2(0.0, 1.0), vec2(1.0, 0.0), axis == 0u);
        let a = fit_normal(fit, at.face, texel, -step);
        let b = fit_normal(fit, at.face, texel, step);
        bends = bends && any(a != vec3(0.0)) && any(b != vec3(0.0));
        let along = fit_point(fit, at.face, texel, step) - fit_point(fit, at.face, texel, -step);
        turned += dot(along, b - a);
        moved += dot(along, along);
    }
    bends = bends && moved > MIN_LENGTH;
    let texel_m = 1.0 / (at.inverse_depth * min(abs(faces[at.face].scale.x), abs(faces[at.face].scale.y)));
    return LocalPatch(true, bends, normal, turned / max(moved, MIN_LENGTH), texel_m, difference, facing);
}

// Rotates a direction from probe axes to world axes.
fn from_probe(view: u32, direction: vec3<f32>) -> vec3<f32> {
    return vec3(
        dot(views[view].turn_x, direction),
        dot(views[view].turn_y, direction),
        dot(views[view].turn_z, direction),
    );
}

fn patch_at(point: vec3<f32>) -> Patch {
    var normal = vec3(0.0);
    var curvature = 0.0;
    var bent_weight = 0.0;
    var best_weight = 0.0;
    var texel_m = 0.0;
    for (var view = 0u; view < scene.view_count; view++) {
        let seen = patch_of_view(view, local_of(view, point));
        if (!seen.found) {
            continue;
        }
        let weight = views[view].camera_weight * seen.facing / (seen.difference + DEPTH_EPSILON);
        normal += weight * from_probe(view, seen.normal);
        if (seen.bends) {
            curvature += weight * seen.curvature;
            bent_weight += weight;
        }
        if (weight > best_weight) {
            best_weight = weight;
            texel_m = seen.texel_m;
        }
    }
    let size = length(normal);
    if (size <= MIN_LENGTH) {
        return NO_PATCH;
    }
    let bends = bent_weight > 0.0;
    return Patch(true, bends, normal / size, curvature / select(1.0, bent_weight, bends), texel_m);
}
