//! The toy shop: a brick front with a sign, an awning, and a lit window with toys.

use std::sync::LazyLock;

use glam::{DQuat, DVec3};

use super::super::lettering;
use super::super::parts::{ball, block, bulb, rgb, room, wall};
use super::houses::{Pane, WARM, Way, window};
use crate::mesh::AxisBox;
use crate::{CastsShadow, Object, Phong, Segment, Texture};

/// The front of the shop, and the corner to the lane, metres.
const FRONT_Z: f64 = -4.0;
const CORNER_X: f64 = -0.5;
const TOP_Y: f64 = 5.6;
pub(super) const SIGN: DVec3 = DVec3::new(-1.8, 2.7, FRONT_Z + 0.07);
const LETTERS_M: f64 = 0.26;

/// Position, strength and reach of the lamps in the window and above the sign.
pub(super) const LAMPS: [(DVec3, f64, f64); 2] =
    [(DVec3::new(-2.2, 2.3, -4.75), 2.0, 5.0), (DVec3::new(-1.8, 3.3, -3.3), 1.3, 3.2)];

static LETTERS: LazyLock<Vec<Segment>> = LazyLock::new(|| lettering::line("LIGHTFOLD", LETTERS_M));

pub(super) fn objects() -> Vec<Object> {
    let bricks =
        Texture::Bricks { colors: [rgb(0.42, 0.19, 0.12), rgb(0.36, 0.32, 0.28)], size: [0.24, 0.08], joint: 0.012 };
    let stone = Texture::Mottled { colors: [rgb(0.5, 0.47, 0.42), rgb(0.38, 0.35, 0.31)], size: 0.4 };
    let teal =
        Texture::Planks { colors: [rgb(0.07, 0.2, 0.19), rgb(0.045, 0.14, 0.135)], size: [1.4, 0.16], joint: 0.008 };
    let back_z = FRONT_Z - 0.25;
    let mut objects = vec![
        // The front around the window and the door, and the wall along the lane.
        block([-4.6, 0.0, back_z], [-2.9, TOP_Y, FRONT_Z], bricks),
        block([-2.9, 2.15, back_z], [-0.65, TOP_Y, FRONT_Z], bricks),
        block([-1.5, 0.0, back_z], [-1.32, 2.15, FRONT_Z], bricks),
        block([-0.65, 0.0, back_z], [CORNER_X, TOP_Y, FRONT_Z], bricks),
        block([CORNER_X - 0.25, 0.0, -9.0], [CORNER_X, TOP_Y, back_z], bricks),
        block([-2.9, 0.0, back_z], [-1.5, 0.76, FRONT_Z], teal),
        // Sill, plinth and cornice.
        block([-2.98, 0.76, back_z], [-1.42, 0.81, FRONT_Z + 0.1], stone),
        block([-4.6, 0.0, FRONT_Z], [-2.95, 0.35, FRONT_Z + 0.04], stone),
        block([-4.75, TOP_Y, -9.0], [CORNER_X + 0.15, TOP_Y + 0.22, FRONT_Z + 0.18], stone),
    ];
    objects.extend(display());
    objects.extend(door());
    objects.extend(sign());
    objects.extend(awning());
    for (x, pane) in [(-2.85, Pane::Lit(0.9)), (-1.6, Pane::Dark)] {
        objects.extend(window(Way::Z(FRONT_Z), [x, x + 0.75], [3.6, 4.9], pane));
        for side in [x - 0.42, x + 0.8] {
            // The planks of shutters are upright.
            let shutter = block([side, 3.6, FRONT_Z], [side + 0.37, 4.9, FRONT_Z + 0.04], teal);
            objects.push(Object { texture_from_world: DQuat::from_rotation_z(0.5 * std::f64::consts::PI), ..shutter });
        }
    }
    objects
}

/// Returns the room behind the window.
fn display() -> Vec<Object> {
    let inside = AxisBox { min: DVec3::new(-3.1, 0.8, -5.5), max: DVec3::new(-1.35, 2.5, FRONT_Z - 0.25) };
    let cream = Texture::Mottled { colors: [rgb(0.7, 0.6, 0.44), rgb(0.6, 0.5, 0.35)], size: 0.5 };
    let wood =
        Texture::Planks { colors: [rgb(0.5, 0.31, 0.16), rgb(0.33, 0.18, 0.08)], size: [0.9, 0.12], joint: 0.005 };
    let mut objects = room(inside, [wood, cream, cream, cream, cream, cream]);
    // The last wall is open.
    objects.pop();
    for y in [1.3, 1.75] {
        objects.push(block([-3.05, y, -5.48], [-1.4, y + 0.03, -5.2], wood));
    }
    let painted = |r: f64, g: f64, b: f64| Texture::Solid(rgb(r, g, b));
    let (red, blue, yellow, green) =
        (painted(0.6, 0.07, 0.04), painted(0.06, 0.17, 0.5), painted(0.75, 0.5, 0.06), painted(0.1, 0.36, 0.14));
    let beach =
        Texture::Stripes { colors: [rgb(0.65, 0.08, 0.05), rgb(0.75, 0.7, 0.6)], wave: DVec3::new(5.0, 2.0, 0.0) };
    let checker = Texture::Checker { colors: [rgb(0.08, 0.2, 0.55), rgb(0.72, 0.68, 0.55)], size: 0.09 };
    objects.extend([
        ball(DVec3::new(-2.62, 0.97, -4.6), 0.17, beach),
        ball(DVec3::new(-1.72, 0.94, -4.55), 0.14, checker),
        block([-2.3, 0.8, -4.75], [-2.08, 1.02, -4.53], yellow),
        block([-2.06, 0.8, -4.78], [-1.9, 0.96, -4.62], blue),
        block([-2.22, 1.02, -4.72], [-2.06, 1.18, -4.56], red),
        // A bear.
        ball(DVec3::new(-2.42, 0.92, -4.95), 0.13, painted(0.34, 0.18, 0.08)),
        ball(DVec3::new(-2.42, 1.11, -4.93), 0.09, painted(0.36, 0.2, 0.09)),
        ball(DVec3::new(-2.49, 1.19, -4.93), 0.035, painted(0.36, 0.2, 0.09)),
        ball(DVec3::new(-2.35, 1.19, -4.93), 0.035, painted(0.36, 0.2, 0.09)),
    ]);
    for (number, color) in [red, yellow, blue, green, red, blue, green, yellow].into_iter().enumerate() {
        let x = -2.97 + 0.2 * number as f64;
        let height = 0.12 + 0.02 * (number * 5 % 7) as f64;
        objects.push(block([x, 1.33, -5.4], [x + 0.13, 1.33 + height, -5.28], color));
        if number % 2 == 0 {
            objects.push(ball(DVec3::new(x + 0.12, 1.87, -5.32), 0.09, color));
        }
    }
    for object in &mut objects {
        // Light from the window is not stopped by its own ceiling and toys on shelves.
        object.casts_shadow = if object.bounds.max.y < 1.25 { CastsShadow::Yes } else { CastsShadow::No };
    }
    objects.push(bulb(LAMPS[0].0, 0.07, 4.0 * WARM));
    objects
}

fn door() -> Vec<Object> {
    let oak =
        Texture::Planks { colors: [rgb(0.3, 0.13, 0.05), rgb(0.18, 0.07, 0.03)], size: [2.3, 0.13], joint: 0.008 };
    let z = FRONT_Z - 0.15;
    let leaf = block([-1.32, 0.0, z - 0.05], [-0.65, 2.15, z], oak);
    let mut knob = ball(DVec3::new(-0.76, 1.02, z + 0.03), 0.028, Texture::Solid(rgb(0.5, 0.32, 0.08)));
    knob.material.phong = Phong { weight: DVec3::splat(0.5), exponent: 60.0 };
    let mut objects =
        vec![Object { texture_from_world: DQuat::from_rotation_z(0.5 * std::f64::consts::PI), ..leaf }, knob];
    objects.extend(window(Way::Z(z), [-1.2, -0.77], [1.25, 1.95], Pane::Lit(0.8)));
    let stone = Texture::Mottled { colors: [rgb(0.42, 0.4, 0.36), rgb(0.32, 0.3, 0.27)], size: 0.3 };
    objects.push(block([-1.45, 0.0, FRONT_Z - 0.2], [-0.55, 0.12, FRONT_Z + 0.3], stone));
    objects
}

fn sign() -> Vec<Object> {
    let gold = Texture::Solid(rgb(0.6, 0.4, 0.1));
    let half = DVec3::new(1.22, 0.26, 0.0);
    let lettering =
        Texture::Strokes { colors: [rgb(0.02, 0.075, 0.06), rgb(0.85, 0.62, 0.2)], segments: &LETTERS, width: 0.05 };
    let (min, max) = (SIGN - half, SIGN + half);
    let board = block([min.x, min.y, FRONT_Z], max.to_array(), lettering);
    let mut objects = vec![Object { anchor: SIGN, ..board }];
    for y in [min.y - 0.03, max.y] {
        objects.push(block([min.x - 0.03, y, FRONT_Z], [max.x + 0.03, y + 0.03, SIGN.z + 0.02], gold));
    }
    for x in [min.x - 0.03, max.x] {
        objects.push(block([x, min.y, FRONT_Z], [x + 0.03, max.y, SIGN.z + 0.02], gold));
    }
    let iron = Texture::Solid(rgb(0.03, 0.03, 0.03));
    for x in [-2.5, -1.8, -1.1] {
        // A lamp on an arm.
        let z = LAMPS[1].0.z;
        objects.push(block([x - 0.012, 3.34, FRONT_Z], [x + 0.012, 3.365, z], iron));
        objects.push(bulb(DVec3::new(x, 3.3, z), 0.06, 3.0 * WARM));
    }
    objects
}

fn awning() -> Vec<Object> {
    let colors = [rgb(0.62, 0.09, 0.06), rgb(0.78, 0.7, 0.56)];
    let (top, fall) = (DVec3::new(-3.05, 2.4, FRONT_Z + 0.01), DVec3::new(0.0, -0.42, 0.75));
    let cloth = Texture::Cloth { colors, wave: DVec3::X * 5.5, weft: DVec3::new(0.0, -7.0, 12.0) };
    let u = DVec3::X * 1.65;
    let edge = top + fall;
    let mut slope = wall(top.to_array(), fall, u, cloth);
    slope.casts_shadow = CastsShadow::Yes;
    vec![slope, wall([edge.x, edge.y - 0.13, edge.z], u, DVec3::Y * 0.13, cloth)]
}
