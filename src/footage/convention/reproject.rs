//! Reprojects samples of one probe into another. A surface of one probe cannot be in front of the surface that the other sees in
//! that direction.

use super::hypotheses::Hypothesis;
use super::probe_samples::ProbeSamples;

/// Relative tolerance of distances.
const TOLERANCE: f64 = 0.01;
/// Approximate number of samples of a probe that are reprojected into another.
const SAMPLES: u64 = 3000;

/// Counts of the samples of one probe, compared with the surfaces that another probe sees in their direction.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Tally {
    /// Samples for which both probes see a surface at the same position.
    pub agree: u64,
    /// Samples in front of the surface that the other probe sees: a contradiction.
    pub in_front: u64,
    /// Samples behind the surface that the other probe sees: no contradiction.
    pub hidden: u64,
}

impl Tally {
    pub fn tested(&self) -> u64 {
        self.agree + self.in_front + self.hidden
    }

    /// Share of the compared samples that agree.
    pub fn agreement(&self) -> f64 {
        self.agree as f64 / self.tested().max(1) as f64
    }

    /// Share of the compared samples that contradict: the other probe sees through them.
    pub fn contradiction(&self) -> f64 {
        self.in_front as f64 / self.tested().max(1) as f64
    }
}

impl std::iter::Sum for Tally {
    fn sum<I: Iterator<Item = Tally>>(items: I) -> Tally {
        items.fold(Tally::default(), |sum, Tally { agree, in_front, hidden }| Tally {
            agree: sum.agree + agree,
            in_front: sum.in_front + in_front,
            hidden: sum.hidden + hidden,
        })
    }
}

/// Reprojects samples of `probes[from]` into `probes[to]`.
pub fn look_up(probes: &[ProbeSamples], [from, to]: [usize; 2], hypothesis: &Hypothesis) -> Tally {
    let (here, there) = (hypothesis.poses[from], hypothesis.poses[to]);
    let back = there.turn.conjugate();
    let total: u64 = probes[from].faces.iter().map(|face| face.stored.data().len() as u64).sum();
    // A grid of every nth sample in both directions.
    let stride = ((total as f64 / SAMPLES as f64).sqrt().round() as u32).max(1);
    let mut tally = Tally::default();
    for samples in &probes[from].faces {
        for y in (stride / 2..samples.stored.height()).step_by(stride as usize) {
            for x in (stride / 2..samples.stored.width()).step_by(stride as usize) {
                let Some(point) = samples.point(hypothesis.kind, x, y) else { continue };
                let world = here.turn * (point * hypothesis.scale) + here.position;
                let seen = back * (world - there.position);
                let distance = seen.length();
                if distance.is_nan() || distance <= 0.0 {
                    continue;
                }
                let Some([near, far]) = probes[to].range_towards(hypothesis.kind, seen) else { continue };
                if distance < near * hypothesis.scale * (1.0 - TOLERANCE) {
                    tally.in_front += 1;
                } else if distance > far * hypothesis.scale * (1.0 + TOLERANCE) {
                    tally.hidden += 1;
                } else {
                    tally.agree += 1;
                }
            }
        }
    }
    tally
}
