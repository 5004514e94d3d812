//! The ways in which depth, positions and orientations of a dataset are commonly mistaken for one another.

use glam::{DMat3, DQuat, DVec3};

use super::reproject::{Pose, Reading};
use crate::dataset::{DepthKind, Projection};

/// Scales by which units are mixed up: metres with milli- and centimetres, feet, and decades.
const UNITS: [f64; 9] = [0.001, 0.01, 0.1, 0.3048, 1.0 / 0.3048, 10.0, 100.0, 1000.0, 1.0];
/// Ratio of neighbouring scales where none of the usual ones is known to be right.
const SCALE_STEP: f64 = 1.08;
/// Steps to either side of 1.
const SCALE_STEPS: i32 = 36;

/// What a reading changes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Subject {
    /// Planar depth or distance.
    Kind,
    /// Metres per unit.
    Scale,
    /// Where probes stand.
    Positions,
    /// How they are turned.
    Orientations,
}

/// A reading that differs from another in one thing.
#[derive(Debug, Clone)]
pub struct Change {
    /// In what.
    pub subject: Subject,
    /// As a sentence goes on after "reading ".
    pub words: String,
    /// The whole of it.
    pub reading: Reading,
}

/// How many readings are tried.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Extent {
    /// The usual ones, to know whether the pictures could tell.
    Usual,
    /// All, to find what is wrong.
    All,
}

/// All readings that differ from `base` in one thing; common mistakes first.
pub fn changes(base: &Reading, names: &[String], projection: Projection, extent: Extent) -> Vec<Change> {
    let mut all = Vec::new();
    // A panorama has no planar depth.
    if projection != Projection::Equirect {
        let (kind, words) = match base.kind {
            DepthKind::Distance => (DepthKind::Planar, "depth as planar"),
            DepthKind::Planar => (DepthKind::Distance, "depth as distance"),
        };
        all.push(Change { subject: Subject::Kind, words: words.into(), reading: Reading { kind, ..base.clone() } });
        // Each alone may not look better than neither.
        if extent == Extent::All {
            all.extend(UNITS.into_iter().filter(|factor| *factor != 1.0).map(|factor| Change {
                subject: Subject::Kind,
                words: format!("{words} and {} as large", times(factor)),
                reading: Reading { kind, scale: base.scale * factor, ..base.clone() },
            }));
        }
    }
    scales(base, extent, &mut all);
    positions(base, names, extent, &mut all);
    orientations(base, &mut all);
    all
}

fn scales(base: &Reading, extent: Extent, all: &mut Vec<Change>) {
    let mut factors: Vec<f64> = UNITS.into_iter().filter(|factor| *factor != 1.0).collect();
    if extent == Extent::All {
        factors.extend((1..=SCALE_STEPS).flat_map(|step| [SCALE_STEP.powi(step), SCALE_STEP.powi(-step)]));
    }
    for factor in factors {
        all.push(Change {
            subject: Subject::Scale,
            words: format!("depth {} as large", times(factor)),
            reading: Reading { scale: base.scale * factor, ..base.clone() },
        });
    }
}

/// `0.001 times`, `12.6 times`.
fn times(factor: f64) -> String {
    if (0.01..100.0).contains(&factor) { format!("{factor:.3} times") } else { format!("{factor} times") }
}

fn positions(base: &Reading, names: &[String], extent: Extent, all: &mut Vec<Change>) {
    let moved = |words: String, place: &dyn Fn(usize) -> DVec3| {
        let pose = |(index, pose): (usize, &Pose)| Pose { position: place(index), ..*pose };
        let poses = base.poses.iter().enumerate().map(pose).collect();
        Change { subject: Subject::Positions, words, reading: Reading { poses, ..base.clone() } }
    };
    let before = all.len();
    if extent == Extent::All {
        for a in 0..names.len() {
            for b in a + 1..names.len() {
                let other = |index| {
                    if index == a {
                        b
                    } else if index == b {
                        a
                    } else {
                        index
                    }
                };
                let words = format!("the positions of probes {} and {} exchanged", names[a], names[b]);
                all.push(moved(words, &|index| base.poses[other(index)].position));
            }
        }
    }
    for (words, axes) in axis_orders() {
        all.push(moved(format!("positions as {words}"), &|index| axes * base.poses[index].position));
    }
    // Where probes stand relative to each other is all that counts.
    let offsets = |reading: &Reading| -> Vec<DVec3> {
        reading.poses.iter().map(|pose| pose.position - reading.poses[0].position).collect()
    };
    let own = offsets(base);
    let same = |reading: &Reading| offsets(reading).iter().zip(&own).all(|(a, b)| a.distance(*b) < 1e-9);
    let kept: Vec<Change> = all.drain(before..).filter(|change| !same(&change.reading)).collect();
    all.extend(kept);
}

/// All ways to take the axes of positions for one another, but not as they are: `(x, -y, z)` and what multiplies a
/// position. One axis reversed first, two exchanged next.
fn axis_orders() -> Vec<(String, DMat3)> {
    let mut found = Vec::new();
    for order in [[0, 1, 2], [0, 2, 1], [1, 0, 2], [2, 1, 0], [1, 2, 0], [2, 0, 1]] {
        for signs in [0u8, 1, 2, 4, 3, 5, 6, 7] {
            let sign = |row: usize| if signs >> row & 1 == 1 { -1.0 } else { 1.0 };
            let axis = [DVec3::X, DVec3::Y, DVec3::Z];
            let rows = [0, 1, 2].map(|row| axis[order[row]] * sign(row));
            let word =
                |row: usize| format!("{}{}", if sign(row) < 0.0 { "-" } else { "" }, ["x", "y", "z"][order[row]]);
            let changed = usize::from(order != [0, 1, 2]) + signs.count_ones() as usize;
            let words = format!("({}, {}, {})", word(0), word(1), word(2));
            found.push((changed, words, DMat3::from_cols(rows[0], rows[1], rows[2]).transpose()));
        }
    }
    found.sort_by_key(|(changed, _, _)| *changed);
    found.into_iter().filter(|(changed, _, _)| *changed > 0).map(|(_, words, axes)| (words, axes)).collect()
}

/// Words, and what they make of a pose.
type Way<'a> = (&'a str, &'a dyn Fn(&Pose) -> Pose);

fn orientations(base: &Reading, all: &mut Vec<Change>) {
    if base.poses.iter().all(|pose| pose.turn.angle_between(DQuat::IDENTITY) < 1e-6) {
        return;
    }
    let half_turn = DQuat::from_xyzw(1.0, 0.0, 0.0, 0.0);
    let first = |turn: DQuat| DQuat::from_xyzw(turn.y, turn.z, turn.w, turn.x);
    let from_world = |pose: &Pose| {
        let turn = pose.turn.conjugate();
        Pose { position: turn * -pose.position, turn }
    };
    let ways: [Way<'_>; 6] = [
        ("orientations as none", &|pose| Pose { turn: DQuat::IDENTITY, ..*pose }),
        ("orientations as their inverse", &|pose| Pose { turn: pose.turn.conjugate(), ..*pose }),
        ("orientations as w, x, y, z", &|pose| Pose { turn: first(pose.turn), ..*pose }),
        ("cameras as looking along +Z with +Y down", &|pose| Pose { turn: pose.turn * half_turn, ..*pose }),
        ("poses as those of the world before the cameras", &|pose| from_world(pose)),
        ("poses as those of the world before cameras that look along +Z with +Y down", &|pose| {
            let pose = from_world(pose);
            Pose { turn: pose.turn * half_turn, ..pose }
        }),
    ];
    for (words, way) in ways {
        all.push(Change {
            subject: Subject::Orientations,
            words: words.into(),
            reading: Reading { poses: base.poses.iter().map(way).collect(), ..base.clone() },
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axis_orders_are_all_there_are_and_their_names_are_true() {
        let orders = axis_orders();
        assert_eq!(orders.len(), 47);
        let point = DVec3::new(2.0, 3.0, 5.0);
        let named = |name: &str| orders.iter().find(|(words, _)| words == name).unwrap().1 * point;
        assert_eq!(named("(x, -y, z)"), DVec3::new(2.0, -3.0, 5.0));
        assert_eq!(named("(x, z, -y)"), DVec3::new(2.0, 5.0, -3.0));
        assert_eq!(named("(y, z, x)"), DVec3::new(3.0, 5.0, 2.0));
        assert!(orders[0].0.matches('-').count() == 1 && orders[0].0.starts_with("(-x, y"));
    }
}
