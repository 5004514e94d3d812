//! Houses along the lane and around the square, the clock tower, and what stands before them.

use glam::{DQuat, DVec3};

use super::super::parts::{ball, block, rgb};
use crate::{CastsShadow, Material, Object, Quad, Shape, Texture};

/// Colour of lamplight, of radiance 1.
pub(super) const WARM: DVec3 = DVec3::new(1.0, 0.66, 0.32);

/// Plane of a wall, in metres, and the axis that it faces.
#[derive(Debug, Clone, Copy)]
pub(super) enum Way {
    /// Faces +Z.
    Z(f64),
    /// Faces −Z.
    BackZ(f64),
    /// Faces +X.
    X(f64),
    /// Faces −X.
    BackX(f64),
}

impl Way {
    /// Creates a box that stands out from the wall, given its extent along the wall and in height, and its depths.
    fn block(self, along: [f64; 2], up: [f64; 2], depth: [f64; 2], texture: Texture) -> Object {
        let ([a, b], [low, high], [d, e]) = (along, up, depth);
        match self {
            Way::Z(z) => block([a, low, z + d], [b, high, z + e], texture),
            Way::BackZ(z) => block([a, low, z - e], [b, high, z - d], texture),
            Way::X(x) => block([x + d, low, a], [x + e, high, b], texture),
            Way::BackX(x) => block([x - e, low, a], [x - d, high, b], texture),
        }
    }
}

#[derive(Debug, Clone, Copy)]
pub(super) enum Pane {
    Dark,
    /// Radiance of a lit room.
    Lit(f64),
}

/// Returns a window with a frame and a cross, on a wall.
pub(super) fn window(way: Way, along: [f64; 2], up: [f64; 2], pane: Pane) -> Vec<Object> {
    let frame = Texture::Solid(rgb(0.55, 0.52, 0.46));
    let mut glass = way.block(along, up, [0.0, 0.035], Texture::Solid(rgb(0.035, 0.045, 0.06)));
    if let Pane::Lit(radiance) = pane {
        glass.material.emission = radiance * WARM;
    }
    let ([a, b], [low, high]) = (along, up);
    let (middle, height) = (0.5 * (a + b), low + 0.62 * (high - low));
    let parts = [
        way.block([a - 0.055, b + 0.055], [low - 0.05, high + 0.055], [0.0, 0.03], frame),
        way.block([a - 0.08, b + 0.08], [low - 0.09, low - 0.03], [0.0, 0.1], frame),
        glass,
        way.block([middle - 0.018, middle + 0.018], [low, high], [0.0, 0.05], frame),
        way.block([a, b], [height - 0.018, height + 0.018], [0.0, 0.05], frame),
    ];
    // Their shadows are smaller than a pixel from most places.
    parts.map(|part| Object { casts_shadow: CastsShadow::No, ..part }).into()
}

fn plaster(light: DVec3) -> Texture {
    Texture::Mottled { colors: [light, 0.74 * light], size: 1.3 }
}

pub(super) fn objects() -> Vec<Object> {
    let stone = plaster(rgb(0.46, 0.43, 0.38));
    let slate = Texture::Solid(rgb(0.16, 0.13, 0.13));
    let mut objects = Vec::new();
    let mut house = |min: [f64; 3], max: [f64; 3], texture: Texture| {
        objects.push(block(min, max, texture));
        let [x, y, z] = max;
        objects.push(block([min[0] - 0.16, y, min[2] - 0.1], [x + 0.16, y + 0.16, z + 0.1], slate));
    };
    // The right side of the lane, and its left side beyond the shop.
    house([2.4, 0.0, -9.0], [7.0, 5.3, 5.6], plaster(rgb(0.56, 0.43, 0.29)));
    house([2.6, 0.0, -17.0], [7.0, 6.5, -9.0], plaster(rgb(0.55, 0.3, 0.24)));
    house([2.4, 0.0, -27.5], [7.0, 5.2, -17.0], plaster(rgb(0.42, 0.45, 0.44)));
    house([-5.0, 0.0, -17.0], [-0.7, 5.9, -9.0], plaster(rgb(0.62, 0.54, 0.4)));
    house([-5.0, 0.0, -27.5], [-0.5, 5.0, -17.0], plaster(rgb(0.5, 0.33, 0.22)));
    // The left and the rear of the square.
    house([-10.0, 0.0, -9.5], [-6.4, 5.4, 3.6], plaster(rgb(0.62, 0.53, 0.43)));
    house([-9.5, 0.0, 6.2], [7.0, 4.6, 8.8], plaster(rgb(0.6, 0.43, 0.32)));

    let right = [
        (2.4, -7.9, [Pane::Dark, Pane::Lit(0.75)]),
        (2.4, -5.9, [Pane::Lit(0.95), Pane::Dark]),
        (2.4, -3.7, [Pane::Dark, Pane::Lit(0.6)]),
        (2.4, 0.2, [Pane::Lit(0.8), Pane::Dark]),
        (2.4, 2.6, [Pane::Dark, Pane::Dark]),
        (2.6, -11.2, [Pane::Lit(0.8), Pane::Dark]),
        (2.6, -13.4, [Pane::Dark, Pane::Lit(0.9)]),
        (2.4, -19.5, [Pane::Lit(0.9), Pane::Dark]),
        (2.4, -23.0, [Pane::Dark, Pane::Lit(0.7)]),
    ];
    for (x, z, [below, above]) in right {
        objects.extend(window(Way::BackX(x), [z, z + 0.8], [1.0, 2.3], below));
        objects.extend(window(Way::BackX(x), [z, z + 0.8], [3.4, 4.6], above));
    }
    for (x, z, pane) in [(-0.5, -7.6, Pane::Lit(0.8)), (-0.7, -11.5, Pane::Lit(0.7)), (-0.7, -14.5, Pane::Lit(0.7))] {
        objects.extend(window(Way::X(x), [z, z + 0.8], [1.1, 2.3], pane));
    }
    for (z, pane) in [(-2.4, Pane::Lit(0.8)), (0.6, Pane::Dark)] {
        objects.extend(window(Way::X(-6.4), [z, z + 0.9], [1.1, 2.4], pane));
        objects.extend(window(Way::X(-6.4), [z, z + 0.9], [3.4, 4.5], Pane::Dark));
    }
    for (x, pane) in [(-4.4, Pane::Lit(0.9)), (-1.9, Pane::Dark), (1.0, Pane::Lit(0.7))] {
        objects.extend(window(Way::BackZ(6.2), [x, x + 0.9], [1.1, 2.4], pane));
    }
    // Doors.
    let oak =
        Texture::Planks { colors: [rgb(0.3, 0.15, 0.07), rgb(0.17, 0.08, 0.04)], size: [2.4, 0.14], joint: 0.008 };
    let green =
        Texture::Planks { colors: [rgb(0.1, 0.2, 0.12), rgb(0.06, 0.13, 0.08)], size: [2.4, 0.14], joint: 0.008 };
    for (way, at, paint) in
        [(Way::BackX(2.4), -1.8, oak), (Way::BackX(2.6), -15.6, green), (Way::BackZ(6.2), -0.4, green)]
    {
        let turn = match way {
            Way::BackX(_) | Way::X(_) => DQuat::from_rotation_x(0.5 * std::f64::consts::PI),
            _ => DQuat::from_rotation_z(0.5 * std::f64::consts::PI),
        };
        let leaf = way.block([at, at + 0.95], [0.0, 2.15], [0.0, 0.04], paint);
        objects.push(Object { texture_from_world: turn, ..leaf });
        objects.push(way.block([at - 0.12, at + 1.07], [2.15, 2.3], [0.0, 0.1], stone));
        for side in [at - 0.12, at + 0.95] {
            objects.push(way.block([side, side + 0.12], [0.0, 2.15], [0.0, 0.07], stone));
        }
    }
    objects.extend(tower());
    objects.extend(square());
    objects
}

fn tower() -> Vec<Object> {
    let stone =
        Texture::Bricks { colors: [rgb(0.5, 0.43, 0.35), rgb(0.36, 0.31, 0.26)], size: [0.7, 0.35], joint: 0.03 };
    let dark = Texture::Solid(rgb(0.04, 0.035, 0.035));
    let mut face = ball(DVec3::new(0.95, 6.0, -29.75), 1.9, Texture::Solid(rgb(0.3, 0.3, 0.3)));
    face.material.emission = rgb(1.1, 0.92, 0.6);
    let mut objects = vec![
        block([-0.65, 0.0, -31.2], [2.55, 7.4, -28.0], stone),
        block([-0.85, 7.4, -31.4], [2.75, 7.65, -27.8], Texture::Solid(rgb(0.4, 0.35, 0.3))),
        face,
        block([0.35, 0.0, -28.0], [1.55, 2.7, -27.97], dark),
    ];
    // The hands show ten past ten.
    for (tip, width) in [(DVec3::new(0.45, 0.26, 0.0), 0.07), (DVec3::new(-0.3, 0.2, 0.0), 0.1)] {
        let v = width * DVec3::new(-tip.y, tip.x, 0.0).normalize_or_zero();
        let quad = Quad { corner: DVec3::new(0.95, 6.0, -27.83) - 0.5 * v, u: tip, v };
        objects.push(Object::new(Shape::Quad(quad), Material::diffuse(dark)));
    }
    objects
}

/// Returns a tree, a bench, crates and flower boxes.
fn square() -> Vec<Object> {
    let wood =
        Texture::Planks { colors: [rgb(0.42, 0.27, 0.15), rgb(0.27, 0.16, 0.08)], size: [1.5, 0.12], joint: 0.008 };
    let bark = Texture::Mottled { colors: [rgb(0.2, 0.14, 0.09), rgb(0.1, 0.07, 0.05)], size: 0.08 };
    let leaves = Texture::Mottled { colors: [rgb(0.05, 0.13, 0.03), rgb(0.2, 0.3, 0.07)], size: 0.16 };
    let mut objects = vec![
        block([1.7, 0.0, -4.1], [2.3, 0.55, -3.5], wood),
        block([1.8, 0.55, -4.0], [2.3, 0.95, -3.55], wood),
        block([1.75, 0.0, -3.35], [2.25, 0.42, -2.85], wood),
        ball(DVec3::new(2.0, 0.5, -3.1), 0.16, Texture::Solid(rgb(0.65, 0.3, 0.05))),
        // A bench and a tree.
        block([-2.9, 0.42, 2.6], [-1.2, 0.47, 3.05], wood),
        block([-2.9, 0.6, 3.05], [-1.2, 0.95, 3.09], wood),
        block([-2.8, 0.0, 2.65], [-2.72, 0.42, 3.0], wood),
        block([-1.4, 0.0, 2.65], [-1.32, 0.42, 3.0], wood),
        block([-4.3, 0.0, 1.1], [-4.1, 2.0, 1.3], bark),
    ];
    for (at, radius) in
        [([-4.2, 2.9, 1.2], 1.0), ([-4.8, 2.4, 0.8], 0.65), ([-3.6, 2.5, 1.7], 0.6), ([-4.0, 3.5, 0.7], 0.6)]
    {
        objects.push(ball(at.into(), radius, leaves));
    }
    // Flower boxes under the shop's upper windows, and a pot beside it.
    let blossoms = [rgb(0.7, 0.1, 0.12), rgb(0.8, 0.45, 0.5), rgb(0.75, 0.55, 0.1)];
    for x in [-2.9, -1.65] {
        objects.push(block([x, 3.38, -4.0], [x + 0.85, 3.52, -3.8], wood));
        for (number, color) in (0..6).zip(blossoms.into_iter().cycle()) {
            let at = DVec3::new(x + 0.08 + 0.14 * f64::from(number), 3.57, -3.9);
            objects.push(ball(at, 0.075, if number % 2 == 0 { leaves } else { Texture::Solid(color) }));
        }
    }
    let clay = Texture::Mottled { colors: [rgb(0.45, 0.2, 0.1), rgb(0.33, 0.14, 0.07)], size: 0.1 };
    objects.push(block([-3.51, 0.0, -3.75], [-3.19, 0.34, -3.43], clay));
    objects.push(ball(DVec3::new(-3.35, 0.56, -3.59), 0.27, leaves));
    for (step, color) in (0..5).zip(blossoms.into_iter().cycle()) {
        let (sin, cos) = (1.4 * f64::from(step)).sin_cos();
        let at = DVec3::new(-3.35 + 0.17 * cos, 0.72 + 0.05 * sin, -3.59 + 0.17 * sin);
        objects.push(ball(at, 0.05, Texture::Solid(color)));
    }
    objects
}
