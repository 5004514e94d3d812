//! Distinguishes planar depth from distance by planes in the images of one probe.
//!
//! With planar depth Z, 1/Z of a plane is linear along rows and columns of an image; if distance is taken for Z, or Z for
//! distance, it is not. Many triples of samples are therefore collinear under the true kind, and few under the other. A dome
//! around the probe and a wall perpendicular to the view cannot be distinguished, even if the dome is off-centre or the wall
//! slightly slanted, so only triples with a steep change of depth are counted.

use rayon::prelude::*;

use super::between_probes::DECISIVE;
use super::finding::{Finding, Verdict, percent};
use super::probe_samples::{FaceSamples, ProbeSamples};
use crate::dataset::DepthKind;

/// Distances between the samples of a triple in u or v: short for small surfaces, long for noisy depth.
const SPANS: [f64; 2] = [0.125, 0.25];
/// A triple is collinear if its middle 1/Z differs from the mean of both ends by at most this fraction of the middle value, times
/// the square of the span. The two kinds differ by up to 0.5 in this measure.
const STRAIGHT: f64 = 0.05;
/// Minimum relative change of 1/stored over a triple, per unit of u or v. Inside a sphere of radius r, at distance e from its
/// centre, distance changes by at most e / sqrt(r² - e²), almost without curvature, so that a dome is not counted up to
/// e = 0.44 r. A plane reaches this change at a slant of 27 degrees.
const SLOPE: f64 = 0.5;
/// With fewer triples that are collinear under one kind only, the check is inconclusive.
const MIN_TRIPLES: u64 = 400;
/// As [`MIN_TRIPLES`], as a share of all triples.
const MIN_SHARE: f64 = 0.02;

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Triples {
    /// Number of triples with a steep change.
    pub all: u64,
    /// Number of triples that are collinear as distance only.
    pub distance: u64,
    /// Number of triples that are collinear as planar depth only.
    pub planar: u64,
}

/// Counts the triples of a face along rows and columns.
pub fn count(samples: &FaceSamples) -> Triples {
    let (width, height) = (samples.stored.width(), samples.stored.height());
    // 1/Z if the stored depth is distance, and if it is planar.
    let values = |x: u32, y: u32| -> Option<[f64; 2]> {
        let stored = f64::from(samples.stored.get(x, y));
        let factor = samples.to_distance(DepthKind::Planar, x, y);
        stored.is_finite().then(|| [factor / stored, 1.0 / stored])
    };
    let mut found = Triples::default();
    for span in SPANS {
        let [step_x, step_y] = samples.spacing().map(|spacing| ((span / spacing).round() as u32).max(1));
        for (dx, dy) in [(step_x, 0), (0, step_y)] {
            let span = f64::from(dx) * samples.spacing()[0] + f64::from(dy) * samples.spacing()[1];
            for y in dy..height.saturating_sub(dy) {
                for x in dx..width.saturating_sub(dx) {
                    let ends = values(x - dx, y - dy).zip(values(x + dx, y + dy));
                    let Some((middle, (before, after))) = values(x, y).zip(ends) else { continue };
                    if (after[1] - before[1]).abs() / 2.0 < SLOPE * span * middle[1] {
                        continue;
                    }
                    let straight = |kind: usize| {
                        let bend = (before[kind] + after[kind]) / 2.0 - middle[kind];
                        bend.abs() <= STRAIGHT * span * span * middle[kind]
                    };
                    found.all += 1;
                    match (straight(0), straight(1)) {
                        (true, false) => found.distance += 1,
                        (false, true) => found.planar += 1,
                        _ => {}
                    }
                }
            }
        }
    }
    found
}

/// Compares the numbers of triples that are collinear under each kind, over all probes.
pub fn check(views: &[ProbeSamples], kind: DepthKind) -> Finding {
    let faces: Vec<&FaceSamples> = views.iter().flat_map(|view| &view.faces).collect();
    let counts: Vec<Triples> = faces.into_par_iter().map(count).collect();
    let found = counts.into_iter().fold(Triples::default(), |sum, Triples { all, distance, planar }| Triples {
        all: sum.all + all,
        distance: sum.distance + distance,
        planar: sum.planar + planar,
    });
    let (distance, planar) = ((found.distance, "distance"), (found.planar, "planar depth"));
    let [(declared, name), (other, other_name)] = match kind {
        DepthKind::Distance => [distance, planar],
        DepthKind::Planar => [planar, distance],
    };
    let share = |count: u64| count as f64 / found.all.max(1) as f64;
    let margin = declared.max(other) as f64 / declared.min(other).max(1) as f64;
    let enough = |count: u64| count >= MIN_TRIPLES && share(count) >= MIN_SHARE;
    let shares = format!(
        "{} of the surfaces are straight as {name} only and {} as {other_name} only",
        percent(share(declared)),
        percent(share(other))
    );
    let (verdict, says) = if enough(declared) && declared > other && margin >= DECISIVE {
        (Verdict::Fine, shares)
    } else if enough(other) && other > declared && margin >= DECISIVE {
        (Verdict::Suspect, format!("{shares}: depth looks like {other_name}"))
    } else {
        (Verdict::CannotTell, format!("{shares}, which is inconclusive"))
    };
    Finding::new("depth.kind.flatness", verdict, says).with(&[
        ("straight_as_declared", share(declared)),
        ("straight_as_the_other", share(other)),
        ("margin", margin),
        ("samples", found.all as f64),
    ])
}

#[cfg(test)]
mod tests {
    use glam::{DQuat, DVec3};

    use super::super::probe_samples::Pose;
    use super::*;
    use codec::image::{Face, ImageProjection, Plane};

    const SIDE: u32 = 64;

    /// Returns a probe at the origin that sees a surface at `distance` metres in each direction.
    fn probe(distance: impl Fn(DVec3) -> f64, kind: DepthKind) -> ProbeSamples {
        let face = |face: Face| {
            let plane = Plane::from_fn(SIDE, SIDE, |x, y| {
                let [u, v] = [x, y].map(|at| (f64::from(at) + 0.5) / f64::from(SIDE) * 2.0 - 1.0);
                let metres = distance(face.direction(x, y, SIDE).normalize());
                let planar = metres / (1.0 + u * u + v * v).sqrt();
                (if kind == DepthKind::Planar { planar } else { metres }) as f32
            });
            FaceSamples::new(face, |x, y| plane.get(x, y), ImageProjection::cube_face(face, SIDE))
        };
        let pose = Pose { position: DVec3::ZERO, turn: DQuat::IDENTITY };
        ProbeSamples { name: "0".into(), frame: 0, pose, faces: Face::CUBE.map(face).to_vec() }
    }

    /// Returns a probe inside a dome of radius 10 m, at `offset` from its centre.
    fn dome(offset: DVec3) -> ProbeSamples {
        let distance = move |direction: DVec3| {
            let along = direction.dot(offset);
            -along + (along * along + 100.0 - offset.length_squared()).sqrt()
        };
        probe(distance, DepthKind::Distance)
    }

    /// Returns a probe inside a box, not at its centre.
    fn room(kind: DepthKind) -> ProbeSamples {
        let (low, high) = (DVec3::new(-3.5, -1.5, -3.0), DVec3::new(2.5, 1.25, 4.0));
        let distance = move |direction: DVec3| {
            let walls = [0, 1, 2].map(|axis| {
                let wall = if direction[axis] > 0.0 { high[axis] } else { low[axis] };
                if direction[axis] == 0.0 { f64::INFINITY } else { wall / direction[axis] }
            });
            walls.into_iter().fold(f64::INFINITY, f64::min)
        };
        probe(distance, kind)
    }

    #[test]
    fn a_dome_says_nothing_wherever_the_probe_stands() {
        for share in [0.0, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.4] {
            for towards in [DVec3::X, DVec3::NEG_Y, DVec3::new(1.0, 2.0, 3.0)] {
                let views = [dome(towards.normalize() * 10.0 * share)];
                for kind in [DepthKind::Distance, DepthKind::Planar] {
                    let found = check(&views, kind);
                    assert_eq!(found.verdict, Verdict::CannotTell, "{share} {towards} {kind:?}: {found:?}");
                }
            }
        }
    }

    #[test]
    fn a_room_says_what_its_depth_is() {
        for stored in [DepthKind::Distance, DepthKind::Planar] {
            for declared in [DepthKind::Distance, DepthKind::Planar] {
                let found = check(&[room(stored)], declared);
                let verdict = if stored == declared { Verdict::Fine } else { Verdict::Suspect };
                assert_eq!(found.verdict, verdict, "{stored:?} said to be {declared:?}: {found:?}");
            }
        }
    }
}
