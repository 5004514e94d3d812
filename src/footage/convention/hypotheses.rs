//! Hypotheses about a dataset: common mistakes in kind and scale of depth, positions and orientations.

use glam::{DMat3, DQuat, DVec3};

use super::face_permutation::signed_axes;
use super::probe_samples::{Pose, ProbeSamples};
use crate::dataset::{DepthKind, Projection};

/// Ratios of units that are commonly confused: millimetres, centimetres, feet, powers of ten.
const UNITS: [f64; 8] = [0.001, 0.01, 0.1, 0.3048, 1.0 / 0.3048, 10.0, 100.0, 1000.0];
/// Ratio of consecutive scales in the full search.
const SCALE_STEP: f64 = 1.08;
/// Number of scales above 1, and below 1, in the full search.
const SCALE_STEPS: i32 = 36;

#[derive(Debug, Clone, PartialEq)]
pub struct Hypothesis {
    pub kind: DepthKind,
    /// Factor applied to depth; 1 as declared.
    pub scale: f64,
    pub poses: Vec<Pose>,
}

impl Hypothesis {
    pub fn declared(kind: DepthKind, probes: &[ProbeSamples]) -> Hypothesis {
        Hypothesis { kind, scale: 1.0, poses: probes.iter().map(|probe| probe.pose).collect() }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Subject {
    Kind,
    Scale,
    Positions,
    Orientations,
}

/// A hypothesis that differs from another in one subject.
#[derive(Debug, Clone)]
pub struct Alternative {
    pub subject: Subject,
    /// Phrase that follows "with " in a sentence.
    pub words: String,
    pub hypothesis: Hypothesis,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Extent {
    /// Common hypotheses, to test whether the data can distinguish them from the declared one.
    Common,
    /// All hypotheses, to find the mistake.
    All,
}

/// Returns the hypotheses that differ from `base` in one subject, common mistakes first.
pub fn alternatives(base: &Hypothesis, names: &[String], projection: Projection, extent: Extent) -> Vec<Alternative> {
    let mut all = Vec::new();
    // A panorama has no planar depth.
    if projection != Projection::Equirect {
        let (kind, words) = match base.kind {
            DepthKind::Distance => (DepthKind::Planar, "depth as planar"),
            DepthKind::Planar => (DepthKind::Distance, "depth as distance"),
        };
        let hypothesis = Hypothesis { kind, ..base.clone() };
        all.push(Alternative { subject: Subject::Kind, words: words.into(), hypothesis: hypothesis.clone() });
        // Also combine kind and scale: correcting only one of two mistakes may not improve the fit.
        if extent == Extent::All {
            all.extend(UNITS.map(|factor| scaled(&hypothesis, factor, Subject::Kind, &format!("{words} and"))));
        }
    }
    let mut factors = UNITS.to_vec();
    if extent == Extent::All {
        factors.extend((1..=SCALE_STEPS).flat_map(|step| [SCALE_STEP.powi(step), SCALE_STEP.powi(-step)]));
    }
    all.extend(factors.into_iter().map(|factor| scaled(base, factor, Subject::Scale, "depth")));
    positions(base, names, extent, &mut all);
    orientations(base, &mut all);
    all
}

/// `base` with depth multiplied by `factor`; `what` begins its description.
fn scaled(base: &Hypothesis, factor: f64, subject: Subject, what: &str) -> Alternative {
    let words = format!("{what} {} as large", times(factor));
    Alternative { subject, words, hypothesis: Hypothesis { scale: base.scale * factor, ..base.clone() } }
}

/// Formats a factor: `0.001 times`, `12.600 times`.
fn times(factor: f64) -> String {
    if (0.01..100.0).contains(&factor) { format!("{factor:.3} times") } else { format!("{factor} times") }
}

fn positions(base: &Hypothesis, names: &[String], extent: Extent, all: &mut Vec<Alternative>) {
    let moved = |words: String, place: &dyn Fn(usize) -> DVec3| {
        let pose = |(index, pose): (usize, &Pose)| Pose { position: place(index), ..*pose };
        let poses = base.poses.iter().enumerate().map(pose).collect();
        Alternative { subject: Subject::Positions, words, hypothesis: Hypothesis { poses, ..base.clone() } }
    };
    let mut found = Vec::new();
    if extent == Extent::All {
        for a in 0..names.len() {
            for b in a + 1..names.len() {
                let mut order: Vec<usize> = (0..names.len()).collect();
                order.swap(a, b);
                let words = format!("the positions of probes {} and {} exchanged", names[a], names[b]);
                found.push(moved(words, &|index| base.poses[order[index]].position));
            }
        }
    }
    for (words, axes) in axis_orders() {
        found.push(moved(format!("positions as {words}"), &|index| axes * base.poses[index].position));
    }
    // Only relative positions matter.
    let offsets =
        |of: &Hypothesis| -> Vec<DVec3> { of.poses.iter().map(|pose| pose.position - of.poses[0].position).collect() };
    let own = offsets(base);
    let same = |other: &Hypothesis| offsets(other).iter().zip(&own).all(|(a, b)| a.distance(*b) < 1e-9);
    all.extend(found.into_iter().filter(|alternative| !same(&alternative.hypothesis)));
}

/// Returns the 47 signed axis permutations other than the identity as matrices, with names such as `(x, -y, z)`; fewest changes
/// first.
fn axis_orders() -> Vec<(String, DMat3)> {
    let mut found = Vec::new();
    for axes in signed_axes() {
        let word =
            |(axis, sign): (usize, f64)| format!("{}{}", if sign < 0.0 { "-" } else { "" }, ["x", "y", "z"][axis]);
        let changed = usize::from(axes.map(|(axis, _)| axis) != [0, 1, 2]);
        let changed = changed + axes.iter().filter(|(_, sign)| *sign < 0.0).count();
        let [x, y, z] = axes.map(|(axis, sign)| DVec3::AXES[axis] * sign);
        found.push((changed, format!("({})", axes.map(word).join(", ")), DMat3::from_cols(x, y, z).transpose()));
    }
    found.sort_by_key(|(changed, _, _)| *changed);
    found.into_iter().filter(|(changed, _, _)| *changed > 0).map(|(_, words, axes)| (words, axes)).collect()
}

/// A description, and the transformation of a pose.
type Way<'a> = (&'a str, &'a dyn Fn(&Pose) -> Pose);

fn orientations(base: &Hypothesis, all: &mut Vec<Alternative>) {
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
        let hypothesis = Hypothesis { poses: base.poses.iter().map(way).collect(), ..base.clone() };
        all.push(Alternative { subject: Subject::Orientations, words: words.into(), hypothesis });
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
