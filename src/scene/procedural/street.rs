//! A street corner in the evening: a toy shop with a sign at −Z, a lane beside it that ends at a clock tower 28 m away, houses
//! around a small square, and a stall with toys within reach. The last sun is on the roofs; lamps are lit below.
//!
//! A toy train, a pinwheel, a lantern and a balloon move. They cast no shadows, so all else is static.

mod houses;
mod shop;
mod stall;

use std::f64::consts::TAU;

use glam::DVec3;

use self::houses::WARM;
use super::parts::{Definition, ball, block, bulb, lamp, rgb, wall};
use crate::{CastsShadow, Lamp, Light, Object, Quad, SceneAtTime, Sky, Sun, Texture};

pub(super) const SCENE: Definition =
    Definition { name: "street", region: (DVec3::new(0.0, 1.5, 0.0), DVec3::new(0.3, 0.15, 0.3)), fixed, at };

/// Lamps on brackets along the lane.
const LANE_LAMPS: [DVec3; 3] = [DVec3::new(1.95, 2.7, -5.4), DVec3::new(0.0, 2.8, -12.0), DVec3::new(1.95, 2.8, -20.0)];
/// Hook of the swinging lantern, and length of its cord, metres.
const HOOK: DVec3 = DVec3::new(1.0, 3.15, -3.1);
const CORD_M: f64 = 0.72;
const BALLOON: DVec3 = DVec3::new(2.3, 10.1, -27.0);

fn fixed() -> Vec<Object> {
    let paving =
        Texture::Bricks { colors: [rgb(0.3, 0.29, 0.28), rgb(0.13, 0.125, 0.125)], size: [0.46, 0.3], joint: 0.02 };
    let iron = Texture::Solid(rgb(0.03, 0.032, 0.035));
    // The ground casts no shadow: nothing is below it, and nearly every shadow ray starts on it.
    let mut objects = vec![wall([-11.0, 0.0, -34.0], DVec3::Z * 43.0, DVec3::X * 18.0, paving)];
    objects.extend(shop::objects());
    objects.extend(houses::objects());
    objects.extend(stall::objects());
    for at in LANE_LAMPS {
        let wall_x = if at.x > 1.0 { 2.5 } else { -0.6 };
        objects.push(block(
            [at.x.min(wall_x), at.y + 0.12, at.z - 0.015],
            [at.x.max(wall_x), at.y + 0.15, at.z + 0.015],
            iron,
        ));
        objects.push(bulb(at, 0.11, 3.4 * WARM));
    }
    objects.push(block([HOOK.x - 0.05, HOOK.y, HOOK.z - 0.03], [2.4, HOOK.y + 0.06, HOOK.z + 0.03], iron));
    objects.extend(festoon([DVec3::new(-0.5, 3.5, -6.5), DVec3::new(2.4, 3.6, -6.5)]));
    objects.extend(festoon([DVec3::new(-0.6, 4.3, -14.0), DVec3::new(2.6, 4.3, -14.0)]));
    objects
}

/// Returns a sagging string of coloured bulbs across the lane.
fn festoon(ends: [DVec3; 2]) -> Vec<Object> {
    const BULBS: u32 = 9;
    let at = |step: u32| {
        let share = f64::from(step) / f64::from(BULBS + 1);
        ends[0].lerp(ends[1], share) - DVec3::Y * (1.6 * share * (1.0 - share))
    };
    let colors = [rgb(2.6, 1.7, 0.7), rgb(2.4, 0.5, 0.3), rgb(0.6, 1.5, 0.9), rgb(2.6, 1.2, 0.4), rgb(0.5, 0.9, 1.9)];
    let mut objects = Vec::new();
    for step in 0..=BULBS {
        let (from, u) = (at(step), at(step + 1) - at(step));
        let v = 0.018 * DVec3::new(-u.y, u.x, 0.0).normalize_or_zero();
        objects.push(cord(Quad { corner: from, u, v }));
    }
    for (step, color) in (1..=BULBS).zip(colors.into_iter().cycle()) {
        objects.push(bulb(at(step) - DVec3::Y * 0.05, 0.055, color));
    }
    objects
}

/// Creates a dark strip that casts no shadow.
fn cord(quad: Quad) -> Object {
    wall(quad.corner.to_array(), quad.u, quad.v, Texture::Solid(rgb(0.04, 0.035, 0.03)))
}

fn at(phase: f64, mut objects: Vec<Object>) -> SceneAtTime {
    let (sin, cos) = (TAU * phase).sin_cos();
    let still = objects.len();
    objects.extend(stall::moving(phase));

    let swing = 0.14 * sin;
    let lantern = HOOK + CORD_M * DVec3::new(swing.sin(), -swing.cos(), 0.0);
    let v = 0.014 * DVec3::new(swing.cos(), swing.sin(), 0.0);
    objects.push(cord(Quad { corner: HOOK - 0.5 * v, u: lantern - HOOK, v }));
    objects.push(bulb(lantern, 0.15, rgb(1.5, 0.7, 0.2)));

    let balloon = BALLOON + DVec3::new(0.12 * cos, 0.3 * sin, 0.0);
    let stripes = Texture::Stripes { colors: [rgb(0.72, 0.14, 0.08), rgb(0.85, 0.74, 0.48)], wave: DVec3::X * 2.4 };
    objects.push(ball(balloon, 1.05, stripes));
    let basket = balloon - DVec3::Y * 1.3;
    let half = DVec3::new(0.2, 0.16, 0.2);
    let wicker = Texture::Solid(rgb(0.35, 0.2, 0.1));
    objects.push(block((basket - half).to_array(), (basket + half).to_array(), wicker));

    let reaching = |at: DVec3, radiance: DVec3, reach: f64| Lamp { reach, ..lamp(at, radiance) };
    let mut lamps: Vec<Lamp> = LANE_LAMPS.iter().map(|at| reaching(*at, 3.0 * WARM, 6.5)).collect();
    lamps.extend(shop::LAMPS.map(|(at, radiance, reach)| reaching(at, radiance * WARM, reach)));
    // The light of the lantern does not swing with it.
    lamps.push(reaching(HOOK - CORD_M * DVec3::Y, rgb(1.0, 0.5, 0.18), 3.4));
    let sun = Sun { direction: DVec3::new(-0.85, 0.4, 0.25).normalize(), radiance: rgb(1.75, 1.02, 0.55) };
    let sky = Sky {
        horizon: rgb(0.95, 0.56, 0.36),
        zenith: rgb(0.13, 0.24, 0.52),
        ambient: rgb(0.2, 0.24, 0.36),
        gradient_start: 0.0,
    };
    for object in objects.iter_mut().skip(still) {
        object.casts_shadow = CastsShadow::No;
    }
    SceneAtTime::with_meshes(objects, stall::meshes(), Light { suns: vec![sun], lamps, sky })
}

#[cfg(test)]
mod tests {
    use super::super::{DemoKind, DemoScene};
    use crate::capture::{PassSettings, SamplePattern, Viewpoint, capture_view};
    use crate::{Pass, capture_face};
    use codec::image::{ColorPlane, DepthKind, Face, ImageProjection};
    use codec::monitor::Silent;
    use glam::DVec3;

    /// Glyphs of the sign, top row first, in the order in which they are read.
    const SIGN: [(&str, [&str; 7]); 9] = [
        ("L", ["#....", "#....", "#....", "#....", "#....", "#....", "#####"]),
        ("I", ["#", "#", "#", "#", "#", "#", "#"]),
        ("G", [".###.", "#...#", "#....", "#.###", "#...#", "#...#", ".###."]),
        ("H", ["#...#", "#...#", "#...#", "#####", "#...#", "#...#", "#...#"]),
        ("T", ["#####", "..#..", "..#..", "..#..", "..#..", "..#..", "..#.."]),
        ("F", ["#####", "#....", "#....", "####.", "#....", "#....", "#...."]),
        ("O", [".###.", "#...#", "#...#", "#...#", "#...#", "#...#", ".###."]),
        ("L", ["#....", "#....", "#....", "#....", "#....", "#....", "#####"]),
        ("D", ["###..", "#..#.", "#...#", "#...#", "#...#", "#..#.", "###.."]),
    ];

    /// Captures a perspective image of the sign's board, looking along −Z.
    fn picture_of_the_sign() -> ColorPlane {
        let scene = DemoScene::new(DemoKind::Street).at(0.0);
        let position = DVec3::new(super::shop::SIGN.x, super::shop::SIGN.y, -1.5);
        let projection = ImageProjection::Pinhole { size: [720, 144], intrinsics: [720.0, 720.0, 360.0, 72.0] };
        let samples = SamplePattern::new(4).unwrap();
        let settings = PassSettings {
            passes: &[Pass::Color],
            samples: &samples,
            depth: DepthKind::Distance,
            far_m: f64::INFINITY,
        };
        let from = Viewpoint { position, orientation: None, projection };
        capture_view(&scene, &from, &settings, &Silent).unwrap().color.unwrap()
    }

    /// Returns the glyphs of inked pixels, from left to right: runs of columns with ink, each sampled at 5 by 7 points.
    fn glyphs(inked: impl Fn(u32, u32) -> bool, [width, height]: [u32; 2]) -> Vec<Vec<String>> {
        let in_column = |x: u32| (0..height).any(|y| inked(x, y));
        let columns: Vec<u32> = (0..width).collect();
        let runs = columns.chunk_by(|a, b| in_column(*a) == in_column(*b)).filter(|run| in_column(run[0]));
        let rows: Vec<u32> = (0..height).filter(|&y| (0..width).any(|x| inked(x, y))).collect();
        let (top, bottom) = (f64::from(rows[0]), f64::from(*rows.last().unwrap()));
        // Half the width of a stroke.
        let margin = 0.081 * (bottom - top);
        let of_run = |run: &[u32]| {
            let (left, right) = (f64::from(run[0]) + margin, f64::from(*run.last().unwrap()) - margin);
            let count = if right - left < 2.0 * margin { 1 } else { 5 };
            let at = |row: u32, column: u32| {
                let x = left + (right - left) * f64::from(column) / f64::from((count - 1).max(1));
                let y = top + margin + (bottom - top - 2.0 * margin) * f64::from(row) / 6.0;
                if inked(x.round() as u32, y.round() as u32) { '#' } else { '.' }
            };
            (0..7).map(|row| (0..count).map(|column| at(row, column)).collect()).collect()
        };
        runs.map(of_run).collect()
    }

    #[test]
    fn the_sign_reads_from_left_to_right() {
        let picture = picture_of_the_sign();
        let size = [picture.width(), picture.height()];
        // Gold on green.
        let inked = |x: u32, y: u32| {
            let [red, green, _] = picture.get(x, y).map(|value| value.to_f32());
            red > green
        };
        let read = glyphs(inked, size);
        let expected: Vec<Vec<String>> = SIGN.iter().map(|(_, rows)| rows.map(str::to_owned).into()).collect();
        assert_eq!(read, expected);
        let mirrored = glyphs(|x, y| inked(size[0] - 1 - x, y), size);
        assert_ne!(mirrored, expected);
    }

    #[test]
    fn depths_go_from_half_a_metre_to_thirty() {
        let (middle, half) = DemoScene::new(DemoKind::Street).probe_region();
        let scene = DemoScene::new(DemoKind::Street).at(0.5);
        let depth = capture_face(&scene, middle - DVec3::Z * half.z, Face::Nz, 64).unwrap().1;
        let finite = depth.data().iter().copied().filter(|metres| metres.is_finite());
        let (near, far) =
            finite.fold((f32::INFINITY, 0.0f32), |(near, far), metres| (near.min(metres), far.max(metres)));
        assert!((0.5..1.1).contains(&near) && (27.0..33.0).contains(&far), "{near} {far}");
        // Half of the pixels are farther than 3 m.
        assert!(depth.data().iter().filter(|metres| **metres > 3.0).count() > 64 * 64 / 2);
    }

    #[test]
    fn most_of_the_street_is_static() {
        let scene = DemoScene::new(DemoKind::Street);
        let (middle, _) = scene.probe_region();
        let [a, b] = [1.0, 1.0 + 1.0 / 24.0].map(|time| capture_face(&scene.at(time), middle, Face::Nz, 96).unwrap().1);
        let same = a.data().iter().zip(b.data()).filter(|(a, b)| a == b).count();
        assert!(same < 96 * 96 && same * 100 > 96 * 96 * 90, "{same}");
    }
}
