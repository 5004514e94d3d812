//! Surfaces of one probe, looked up in another: what a probe sees cannot lie in front of what another sees there.

use glam::{DQuat, DVec3};
use rayon::prelude::*;

use super::views::View;
use crate::dataset::DepthKind;

/// Distances that differ by less than this share are the same.
const TOLERANCE: f64 = 0.01;
/// Samples of a probe that are looked up in another, about.
const SAMPLES: u64 = 3000;

/// Where a probe is taken to stand and how it is turned.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// Centre.
    pub position: DVec3,
    /// Turns the probe's axes into the world's.
    pub turn: DQuat,
}

/// A way to read a dataset.
#[derive(Debug, Clone, PartialEq)]
pub struct Reading {
    /// What depth measures.
    pub kind: DepthKind,
    /// Depth is to be multiplied with it; 1 as stated.
    pub scale: f64,
    /// Of each view.
    pub poses: Vec<Pose>,
}

/// What became of the samples that were looked up.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Tally {
    /// The other probe sees a surface at the same place.
    pub agree: u64,
    /// The other probe sees through it: two probes that contradict each other.
    pub in_front: u64,
    /// The other probe sees something nearer, as it may.
    pub hidden: u64,
}

impl Tally {
    /// All that could be compared.
    pub fn tested(&self) -> u64 {
        self.agree + self.in_front + self.hidden
    }

    /// Share of what could be compared that agrees.
    pub fn agreement(&self) -> f64 {
        self.agree as f64 / self.tested().max(1) as f64
    }

    /// Share of what could be compared that the other probe sees through.
    pub fn contradiction(&self) -> f64 {
        self.in_front as f64 / self.tested().max(1) as f64
    }

    fn add(self, other: Tally) -> Tally {
        Tally {
            agree: self.agree + other.agree,
            in_front: self.in_front + other.in_front,
            hidden: self.hidden + other.hidden,
        }
    }
}

impl std::iter::Sum for Tally {
    fn sum<I: Iterator<Item = Tally>>(items: I) -> Tally {
        items.fold(Tally::default(), Tally::add)
    }
}

/// Looks up samples of `views[from]` in `views[to]`.
pub fn look_up(views: &[View], [from, to]: [usize; 2], reading: &Reading) -> Tally {
    let (here, there) = (reading.poses[from], reading.poses[to]);
    let back = there.turn.conjugate();
    let total: u64 = views[from].faces.iter().map(|face| face.stored.data().len() as u64).sum();
    // A grid of every nth sample, in both directions.
    let stride = ((total as f64 / SAMPLES as f64).sqrt().round() as u32).max(1);
    let mut tally = Tally::default();
    for samples in &views[from].faces {
        for y in (stride / 2..samples.stored.height()).step_by(stride as usize) {
            for x in (stride / 2..samples.stored.width()).step_by(stride as usize) {
                let Some(point) = samples.point(reading.kind, x, y) else { continue };
                let world = here.turn * (point * reading.scale) + here.position;
                let seen = back * (world - there.position);
                let distance = seen.length();
                if distance.is_nan() || distance <= 0.0 {
                    continue;
                }
                let Some([near, far]) = views[to].range_towards(reading.kind, seen) else { continue };
                if distance < near * reading.scale * (1.0 - TOLERANCE) {
                    tally.in_front += 1;
                } else if distance > far * reading.scale * (1.0 + TOLERANCE) {
                    tally.hidden += 1;
                } else {
                    tally.agree += 1;
                }
            }
        }
    }
    tally
}

/// Looks up along all `pairs`, (from, to); a tally for each.
pub fn look_up_all(views: &[View], pairs: &[[usize; 2]], reading: &Reading) -> Vec<Tally> {
    pairs.par_iter().map(|pair| look_up(views, *pair, reading)).collect()
}
