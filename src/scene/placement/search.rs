//! Greedy camera placement (CALF 4, algorithm 1): adds the best candidate until its gain is too small.

use glam::DVec3;

use super::candidates::{CandidateKind, FreeSpace};
use super::coverage::{Coverage, Figures};
use super::greedy::{self, Calls, Choice, Lazy};
use super::objective::{Lighting, Problem, State, VisibleSet};
use super::region::Region;
use super::sampled_scene::{SampledScene, Surfels};
use crate::SceneAtTime;
use codec::effort::Effort;
use codec::error::{Error, Result};
use codec::monitor::Monitor;

/// Default gain at which a search ends, as a fraction of all area and time.
pub const DEFAULT_UNTIL: f64 = 1e-3;
/// Default k times the diagonal of the region: the suitability decays to e⁻⁴ across the region.
pub const DEFAULT_RATE: f64 = 4.0;
/// Default minimum viewer distance, as a fraction of the region's diagonal.
pub const DEFAULT_MIN_DISTANCE: f64 = 0.05;
/// Minimum tolerance of the viewer distance, as a fraction of the region's diagonal; see [`super::coverage::WITHIN`].
pub const WITHIN_REGION: f64 = 0.05;
/// Clearance of a camera, as a fraction of the smaller of the diagonals of the region and the scene.
pub const CLEARANCE: f64 = 1e-3;
/// Default maximum number of new cameras.
pub const DEFAULT_MAX_CAMERAS: usize = 1000;
/// θ in degrees below which cameras are hardly ever redundant: gains do not decrease, so a number of cameras must be given.
pub const MIN_THETA_DEG: f64 = 1.0;
/// Maximum product of candidates and points. Their bits take half a gibibyte, and the same again for each side of a point.
pub const MAX_VISIBILITY_BITS: u64 = 1 << 32;

#[derive(Debug, Clone, Copy)]
pub struct Settings {
    /// k in 1/m; `None` for [`DEFAULT_RATE`].
    pub rate_per_m: Option<f64>,
    /// Minimum viewer distance in metres; `None` for [`DEFAULT_MIN_DISTANCE`].
    pub min_distance_m: Option<f64>,
    /// Search effort, which gives the values of the fields below that are `None`.
    pub effort: Effort,
    pub kind: CandidateKind,
    pub candidates: Option<usize>,
    /// Number of points on surfaces, over all time samples.
    pub surface_samples: Option<usize>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Extent {
    pub candidates: usize,
    /// Number of points on surfaces, over all time samples.
    pub surface_samples: usize,
    pub time_samples: usize,
    /// Number of refinement steps.
    pub steps: usize,
}

impl Extent {
    pub fn of(effort: Effort) -> Extent {
        let [candidates, surface_samples, time_samples, steps] = match effort {
            Effort::Fast => [256, 2048, 4, 1],
            Effort::Normal => [1024, 8192, 16, 3],
            Effort::Exhaustive => [4096, 32768, 64, 6],
        };
        Extent { candidates, surface_samples, time_samples, steps }
    }
}

/// Returns at most `most` frames of a range, evenly spaced, in ascending order.
pub fn sample_frames([first, last]: [u32; 2], most: usize) -> Vec<u32> {
    let count = u64::from(last.saturating_sub(first)) + 1;
    let taken = count.min(most.max(1) as u64);
    // The middle of each of `taken` equal parts.
    (0..taken).map(|at| first + ((2 * at + 1) * count / (2 * taken)) as u32).collect()
}

/// Limits of a search; the first one reached ends it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stop {
    /// Maximum number of new cameras.
    pub cameras: Option<usize>,
    /// Minimum gain of the next camera, as a fraction of all area and time.
    pub until: f64,
}

/// A camera, and the coverage by it and the cameras before it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Placed {
    pub position: DVec3,
    /// Gain as a fraction of all area and time.
    pub gain: f64,
    pub figures: Figures,
}

#[derive(Debug, Clone, PartialEq)]
pub struct Placement {
    pub lighting: Lighting,
    /// Cameras; the given ones come first.
    pub cameras: Vec<Placed>,
    /// Number of given cameras.
    pub started: usize,
    /// Number of computed gains of candidates. Each is a sum over all surfels that the candidate sees.
    pub objective_calls: u64,
    /// Number of computed bounds of gains. Each computes one decay per eight surfels.
    pub bound_calls: u64,
    /// Number of gains that plain greedy search computes for the same choices: all candidates in each round.
    pub plain_objective_calls: u64,
    /// Number of gains computed in refinement, which is the same for both searches.
    pub refinement_calls: u64,
    /// Coverage by all candidates and cameras together: the maximum that the region allows.
    pub reachable: Figures,
}

/// The visible set of a position, and its gain.
struct ScoredSet {
    visible: VisibleSet,
    gain: f64,
}

/// Candidates and their visible sets, from which cameras are placed for any lighting.
#[derive(Debug)]
pub struct Search<'a> {
    pub sampled: SampledScene,
    pub region: &'a Region,
    clearance_m: f64,
    surfels: Surfels,
    pub problem: Problem,
    /// One visible set per candidate.
    pub visible_sets: Vec<VisibleSet>,
    steps: usize,
    effort: Effort,
    /// Minimum viewer distance in metres.
    pub min_distance_m: f64,
}

impl<'a> Search<'a> {
    /// Finds candidates and their visible sets. The monitor advances by one per candidate.
    pub fn new(
        times: Vec<SceneAtTime>,
        region: &'a Region,
        settings: &Settings,
        monitor: &dyn Monitor,
    ) -> Result<Search<'a>> {
        let (wanted, samples) = settings.counts();
        if (wanted as u64).saturating_mul(samples as u64) > MAX_VISIBILITY_BITS {
            return Err(Error::Usage(format!(
                "{wanted} candidates times {samples} surface samples exceed {MAX_VISIBILITY_BITS}: reduce either"
            )));
        }
        let sampled = SampledScene::new(times, samples)?;
        let surfaces = sampled.bounds();
        let clearance_m = CLEARANCE * (surfaces.max - surfaces.min).length().min(region.diagonal_m());
        let candidates = FreeSpace { sampled: &sampled, region, clearance_m }.candidates(settings.kind, wanted)?;
        let visibility = sampled.visibility(&candidates, monitor)?;
        let min_distance_m = settings.min_distance_m.unwrap_or(DEFAULT_MIN_DISTANCE * region.diagonal_m());
        let surfels = sampled.surfels(&candidates, &visibility, region, min_distance_m);
        monitor.check()?;
        let visible_sets = candidates
            .iter()
            .zip(&visibility)
            .map(|(at, visibility)| sampled.visible_of_points(&surfels, *at, visibility))
            .collect();
        let of_region = if region.diagonal_m() > 0.0 { DEFAULT_RATE / region.diagonal_m() } else { 0.0 };
        let problem = Problem::new(surfels.surfels.clone(), settings.rate_per_m.unwrap_or(of_region));
        let steps = if settings.kind == CandidateKind::Grid { 0 } else { Extent::of(settings.effort).steps };
        let effort = settings.effort;
        Ok(Search { sampled, region, clearance_m, surfels, problem, visible_sets, steps, effort, min_distance_m })
    }

    pub fn visible_set(&self, position: DVec3) -> VisibleSet {
        self.sampled.visible_set(&self.surfels, position)
    }

    pub fn free_space(&self) -> FreeSpace<'_> {
        FreeSpace { sampled: &self.sampled, region: self.region, clearance_m: self.clearance_m }
    }

    /// Searches along the axes for a position with a larger gain. Each step moves to the best of six positions, at half the
    /// distance of the step before. Adds the number of gains computed to `calls`.
    fn refine(&self, state: &State<'_>, from: Choice, calls: &mut u64) -> ScoredSet {
        let free_space = self.free_space();
        let mut best = ScoredSet { visible: self.visible_sets[from.candidate].clone(), gain: from.gain };
        let mut reach = 0.5 * free_space.spacing_m(self.visible_sets.len());
        for _ in 0..self.steps {
            let around = [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z];
            let around = around.map(|axis| best.visible.position + reach * axis);
            for position in around.into_iter().filter(|position| free_space.admits(*position)) {
                let visible = self.visible_set(position);
                *calls += 1;
                let gain = state.gain(&visible);
                if gain > best.gain {
                    best = ScoredSet { visible, gain };
                }
            }
            reach *= 0.5;
        }
        best
    }

    /// Places cameras in addition to the given ones.
    pub fn place(&self, lighting: Lighting, start: &[DVec3], stop: Stop, monitor: &dyn Monitor) -> Result<Placement> {
        let mut state = State::new(&self.problem, lighting);
        let tolerance_m = WITHIN_REGION * self.region.diagonal_m();
        let mut coverage = Coverage::new(&self.problem, lighting, tolerance_m);
        let mut cameras = Vec::new();
        let mut reachable = Coverage::new(&self.problem, lighting, tolerance_m);
        reachable.add(&self.visible_sets.iter().collect::<Vec<_>>());
        let mut keep = |visible: &VisibleSet, gain: f64, state: &mut State<'_>| {
            state.add(visible);
            coverage.add(&[visible]);
            reachable.add(&[visible]);
            cameras.push(Placed { position: visible.position, gain, figures: coverage.figures() });
        };
        for position in start {
            monitor.check()?;
            let visible = self.visible_set(*position);
            let gain = state.gain(&visible);
            keep(&visible, gain, &mut state);
        }
        let mut lazy = Lazy::new(&state, &self.visible_sets);
        let mut calls = Calls { gains: 0, bounds: self.visible_sets.len() as u64 };
        let (mut rounds, mut refinement_calls) = (0, 0);
        let mut placed = 0;
        while stop.cameras.is_none_or(|most| placed < most) {
            monitor.check()?;
            rounds += 1;
            let best = match self.effort {
                Effort::Exhaustive => greedy::plain(&state, &self.visible_sets, &mut calls.gains),
                Effort::Fast | Effort::Normal => lazy.best(&state, &self.visible_sets, &mut calls),
            };
            let Some(choice) = best else { break };
            let ScoredSet { visible, gain } = self.refine(&state, choice, &mut refinement_calls);
            if gain <= stop.until {
                break;
            }
            keep(&visible, gain, &mut state);
            placed += 1;
        }
        Ok(Placement {
            lighting,
            cameras,
            started: start.len(),
            objective_calls: calls.gains,
            bound_calls: if self.effort == Effort::Exhaustive { 0 } else { calls.bounds },
            plain_objective_calls: rounds * self.visible_sets.len() as u64,
            refinement_calls,
            reachable: reachable.figures(),
        })
    }
}

impl Settings {
    /// Returns the numbers of candidates and of points on surfaces.
    pub fn counts(&self) -> (usize, usize) {
        let extent = Extent::of(self.effort);
        (self.candidates.unwrap_or(extent.candidates), self.surface_samples.unwrap_or(extent.surface_samples))
    }
}

#[cfg(test)]
mod tests;
