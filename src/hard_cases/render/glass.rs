//! Balls of glass that are hard to find: thin caps, tiny and huge ones, a wall far behind.
//!
//! One probe in the origin looks at a ball on the axis −Z; what it is to be is known. Planar depths are single floats, so that
//! points are off by half a rounding of their distance, and that is all that fits may make errors of.

use glam::DVec3;

use crate::error::{Error, Result};
use crate::hard_cases::{Bound, Family, HardCase, Measured, Shelf, Worst};
use crate::image::cube::Face;
use crate::monitor::Silent;
use crate::reconstruct::glass_balls::{GlassBall, GlassBalls, steps_around};
use crate::reconstruct::hidden_planes::IN_PLANE;
use crate::reconstruct::light_field::{LightField, View};
use crate::reconstruct::made::Made;

use super::{CODES, Setup};

/// Width and height of faces in texels.
const TEXELS: u32 = 128;

/// A ball before a wall.
#[derive(Debug, Clone, Copy)]
struct Ball {
    /// How far its centre is along −Z, in metres.
    away_m: f64,
    radius_m: f64,
    /// How far the wall behind it is along −Z, in metres.
    wall_m: f64,
    /// Texels are of glass up to this angle between the ball's normal and the axis, in radians.
    cap: f64,
}

/// The whole front.
const FRONT: f64 = 1.6;
const BALLS: [(&str, Ball); 4] = [
    ("a cap of 17 degrees", Ball { away_m: 3.0, radius_m: 1.0, wall_m: 8.0, cap: 0.3 }),
    ("a radius of 0.01 mm", Ball { away_m: 4e-5, radius_m: 1e-5, wall_m: 2e-4, cap: FRONT }),
    ("100 km away", Ball { away_m: 1e5, radius_m: 2e4, wall_m: 2e5, cap: FRONT }),
    ("a wall 100 km behind", Ball { away_m: 3.0, radius_m: 0.5, wall_m: 1e5, cap: FRONT }),
];

pub(super) fn cases() -> Vec<HardCase> {
    let shelf = |pipeline: &str, unit| Shelf::new(Family::Render, pipeline, unit);
    let fits = shelf("balls of glass, fitted", "radii");
    let walls = shelf("what is hidden behind balls of glass", "logarithm of the distance");
    let mut cases = Vec::new();
    for (name, ball) in BALLS {
        cases.push(fits.case(name, Bound::AtMost(ball.most_off()), move || off(&ball)));
    }
    for (name, ball) in BALLS.into_iter().filter(|(_, ball)| ball.cap == FRONT) {
        // Points beside what is hidden are around it, so a plane through them is no worse between them than at them; it
        // counts where it goes through them to this part, and depths lie between those of texels.
        cases.push(walls.case(name, Bound::AtMost(f64::from(IN_PLANE)), move || behind(&ball)));
    }
    cases
}

impl Ball {
    fn centre(&self) -> DVec3 {
        DVec3::NEG_Z * self.away_m
    }

    /// A point is off by at most half a rounding of its distance. A cap of an angle c is as high as c²/2 radii, and its radius is as
    /// far off as its height is in parts of that: 2/c² for each error at its middle and as much again for one at its edge, and
    /// the centre by as much once more. A front is taken for a cap of 1.
    fn most_off(&self) -> f64 {
        let cap = self.cap.min(1.0);
        let point = 0.5 * f64::from(f32::EPSILON) * self.away_m / self.radius_m;
        // The centre and the radius leave as single floats.
        let rounding = f64::from(f32::EPSILON) * (1.0 + self.away_m / self.radius_m);
        3.0 * 2.0 / (cap * cap) * point + rounding
    }

    /// The distance of what is seen in a direction, and whether that is glass.
    fn sight(&self, direction: DVec3) -> Option<(f64, bool)> {
        let along = self.centre().dot(direction);
        let squared = self.radius_m.powi(2) - (self.away_m.powi(2) - along * along);
        if along > 0.0 && squared > 0.0 {
            let met_m = along - squared.sqrt();
            let normal = (met_m * direction - self.centre()) / self.radius_m;
            return Some((met_m, normal.z >= self.cap.cos()));
        }
        (direction.z < 0.0).then(|| (-self.wall_m / direction.z, false))
    }

    fn setup(&self) -> Setup {
        let near_m = (self.away_m - self.radius_m) / 2.0;
        // Of the wall, what is seen is beyond that nowhere.
        let range_m = [near_m, 2.0 * self.wall_m].map(|metres| metres as f32);
        let made = Made { range_m, ..Made::new(DVec3::ZERO, TEXELS) };
        let mut view: View = made.cube(CODES, &|to| self.sight(to).map(|(distance_m, _)| (distance_m, [90; 3])));
        for (face, texels) in Face::CUBE.into_iter().zip(&mut view.faces) {
            let Some(texels) = texels else { continue };
            let glass = |at: u32| {
                let centre = [at % TEXELS, at / TEXELS].map(|at| at as f32 + 0.5);
                let way = texels.way(face, centre).as_dvec3().normalize();
                if self.sight(way).is_some_and(|(_, glass)| glass) { [0, 255, 64, 0] } else { [0; 4] }
            };
            texels.material = Some((0..TEXELS * TEXELS).map(glass).collect());
            texels.material_changed();
        }
        Setup { field: LightField { views: vec![view], coding: CODES }, eye: DVec3::ZERO, range_m }
    }

    fn found(&self, setup: &Setup) -> Result<GlassBall> {
        let found = GlassBalls::of(&setup.views(), &[1.0], &Silent)?;
        let count = found.balls.len();
        let [ball] = <[GlassBall; 1]>::try_from(found.balls)
            .map_err(|_| Error::invalid(format!("one ball of glass was expected, not {count}")))?;
        Ok(ball)
    }
}

/// How far the centre and the radius that are found are off, in radii.
fn off(ball: &Ball) -> Result<Measured> {
    let found = ball.found(&ball.setup())?.ball;
    let mut worst = Worst::greatest();
    worst.see((found.centre.as_dvec3() - ball.centre()).length() / ball.radius_m, || "its centre".into());
    worst.see((f64::from(found.radius_m) / ball.radius_m - 1.0).abs(), || "its radius".into());
    Ok(worst.measured())
}

/// How far the depths of the wall that the ball hides are off.
fn behind(ball: &Ball) -> Result<Measured> {
    let setup = ball.setup();
    let found = ball.found(&setup)?;
    let views = setup.views();
    // The part of the wall that the probe does not see, as the centre of the ball sees it, well within its edge.
    let hidden = ball.radius_m / ball.away_m;
    let mut worst = Worst::greatest();
    for face in Face::CUBE {
        let Some(texels) = &found.view.faces[face as usize] else { continue };
        for (at, inverse) in (0..).zip(&texels.inverse_depth) {
            let centre = [at % texels.size[0], at / texels.size[0]].map(|at| at as f32 + 0.5);
            let way = texels.way(face, centre).as_dvec3().normalize();
            let expected_m = (ball.away_m - ball.wall_m) / way.z;
            let met = ball.centre() + expected_m * way;
            if way.z < 0.0 && (met.x.hypot(met.y) / -met.z) < 0.9 * hidden {
                let planar_m = expected_m / f64::from(texels.stretch(at % texels.size[0], at / texels.size[0]));
                worst.see((f64::from(*inverse) * planar_m).ln().abs(), || format!("towards {way}"));
            }
        }
    }
    let steps = steps_around(&views, &found.ball, TEXELS);
    Ok(worst.measured().with_note(format!("steps leave {} open", steps.unsure())))
}
