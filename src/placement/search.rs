//! Algorithm 1 of CALF 4: the best camera, again and again, until the next one adds too little.
//!
//! Enters: a scene at a few moments, a region, [`Settings`], and cameras that there are already. Leaves: [`Placement`].

use glam::DVec3;

use super::candidates::{CandidateKind, Refinement, Room};
use super::coverage::{Coverage, Figures};
use super::greedy::{self, Calls, Choice, Lazy};
use super::objective::{Lighting, Problem, State, View};
use super::region::Region;
use super::site::{Facets, Site, ViewerDistance};
use crate::effort::Effort;
use crate::error::{Error, Result};
use crate::mesh::AxisBox;
use crate::monitor::Monitor;
use crate::scene::{Scene, SceneAtTime};

/// The gain, as a part of all area and time, at which a search ends where nobody says when: 0.1%.
pub const DEFAULT_UNTIL: f64 = 1e-3;
/// k where none is given, times the diagonal of the region's box: across the whole region, e⁻⁴ is left.
pub const DEFAULT_RATE: f64 = 4.0;
/// The smallest viewer distance where none is given, as a part of the diagonal of the region's box.
pub const DEFAULT_MIN_DISTANCE: f64 = 0.05;
/// How far beyond the viewer distance a camera still counts as within it, as a part of the diagonal of the region's box; or a
/// part of that distance, where it is more: [`super::coverage::WITHIN`].
pub const WITHIN_REGION: f64 = 0.05;
/// The room that a camera has around it, as a part of the region's diagonal or of the scene's, whichever is smaller.
pub const CLEARANCE: f64 = 1e-3;
/// New cameras at which a search ends where nobody says how many.
pub const DEFAULT_MOST_CAMERAS: usize = 1000;
/// θ below which cameras hardly ever cover for each other, degrees: gains do not fade, and a number of cameras must be given.
pub const LEAST_THETA_DEG: f64 = 1.0;
/// Candidates times points, at most. A bit for each takes half a gibibyte, and as many for each of up to two sides of a point.
pub const MOST_SIGHTS: u64 = 1 << 32;

/// How a search goes about it.
#[derive(Debug, Clone, Copy)]
pub struct Settings {
    /// k per metre, for [`DEFAULT_RATE`] `None`.
    pub rate_per_m: Option<f64>,
    /// The smallest viewer distance in metres, for [`DEFAULT_MIN_DISTANCE`] `None`.
    pub min_distance_m: Option<f64>,
    /// How hard it looks; it decides what follows where that is `None`.
    pub effort: Effort,
    /// How candidates are spread.
    pub kind: CandidateKind,
    /// How many candidates, about.
    pub candidates: Option<usize>,
    /// How many points on surfaces, over all moments.
    pub surface_samples: Option<usize>,
}

/// What an effort comes to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Extent {
    /// Candidates.
    pub candidates: usize,
    /// Points on surfaces, over all moments.
    pub surface_samples: usize,
    /// Moments of a scene that moves, at most.
    pub moments: usize,
    /// Steps of refinement.
    pub steps: usize,
}

impl Extent {
    /// The extent of an effort.
    pub fn of(effort: Effort) -> Extent {
        let extent =
            |candidates, surface_samples, moments, steps| Extent { candidates, surface_samples, moments, steps };
        match effort {
            Effort::Fast => extent(256, 2048, 4, 1),
            Effort::Normal => extent(1024, 8192, 16, 3),
            Effort::Exhaustive => extent(4096, 32768, 64, 6),
        }
    }
}

/// At most `most` frames spread over a range, in order.
pub fn spread_frames([first, last]: [u32; 2], most: usize) -> Vec<u32> {
    let count = u64::from(last.saturating_sub(first)) + 1;
    let taken = count.min(most.max(1) as u64);
    // The middle of each of so many equal parts.
    (0..taken).map(|at| first + ((2 * at + 1) * count / (2 * taken)) as u32).collect()
}

/// The scene at each of the frames, at so many a second.
pub fn moments(scene: &Scene, frames: &[u32], fps: f64) -> Vec<SceneAtTime> {
    frames.iter().map(|frame| scene.at(f64::from(*frame) / fps)).collect()
}

/// When a search ends: at whatever comes first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stop {
    /// After so many new cameras.
    pub cameras: Option<usize>,
    /// Where the next camera's gain, a part of all area and time, is no more than this.
    pub until: f64,
}

/// A camera, and what it and those before it come to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Placed {
    /// Where, metres.
    pub position: DVec3,
    /// What it added to the objective, as a part of all area and time.
    pub gain: f64,
    /// What is covered with it.
    pub figures: Figures,
}

/// What a search has found.
#[derive(Debug, Clone, PartialEq)]
pub struct Placement {
    /// For which lighting.
    pub lighting: Lighting,
    /// The cameras, those that there were first.
    pub cameras: Vec<Placed>,
    /// How many there were.
    pub started: usize,
    /// Gains of candidates that were computed, each a sum over all facets that the candidate sees. Bounds are not among them, nor
    /// are gains beside candidates.
    pub objective_calls: u64,
    /// Bounds of gains of candidates that were computed instead or before: a decay for each eight facets, not for each.
    pub bound_calls: u64,
    /// How many plain greedy search asks for to choose the same: all candidates in each round.
    pub plain_objective_calls: u64,
    /// Gains asked for beside the best candidates, which is the same for both.
    pub refinement_calls: u64,
    /// What all candidates and cameras together cover: more is not to be had from the region.
    pub reachable: Figures,
}

/// A search that knows what candidates see, and can place cameras for any lighting.
#[derive(Debug)]
pub struct Search<'a> {
    site: Site,
    region: &'a Region,
    clearance_m: f64,
    facets: Facets,
    problem: Problem,
    views: Vec<View>,
    steps: usize,
    effort: Effort,
    min_distance_m: f64,
}

impl<'a> Search<'a> {
    /// Finds candidates and what they see. Tells the monitor of [`Settings::steps`] steps.
    ///
    /// # Errors
    /// When there is no surface, no room for a camera, more asked for than memory should hold, or the user asks to stop.
    pub fn new(
        moments: Vec<SceneAtTime>,
        region: &'a Region,
        settings: &Settings,
        monitor: &dyn Monitor,
    ) -> Result<Search<'a>> {
        let (wanted, samples) = settings.counts();
        if (wanted as u64).saturating_mul(samples as u64) > MOST_SIGHTS {
            return Err(Error::Usage(format!(
                "{wanted} candidates times {samples} points on surfaces is more than {MOST_SIGHTS}; ask for fewer of either"
            )));
        }
        let site = Site::new(moments, samples)?;
        let surfaces = site.bounds();
        let clearance_m = CLEARANCE * (surfaces.max - surfaces.min).length().min(region.diagonal_m());
        let candidates = Room { site: &site, region, clearance_m }.candidates(settings.kind, wanted)?;
        let each_done = || {
            monitor.advance(1);
            monitor.check()
        };
        let sights = site.sights(&candidates, &each_done)?;
        let least_m = settings.min_distance_m.unwrap_or(DEFAULT_MIN_DISTANCE * region.diagonal_m());
        let facets = site.facets(&candidates, &sights, &ViewerDistance { region, least_m });
        monitor.check()?;
        let views = candidates.iter().zip(&sights).map(|(at, sight)| site.view(&facets, *at, sight)).collect();
        let of_region = if region.diagonal_m() > 0.0 { DEFAULT_RATE / region.diagonal_m() } else { 0.0 };
        let problem = Problem::new(facets.facets.clone(), settings.rate_per_m.unwrap_or(of_region));
        let steps = if settings.kind == CandidateKind::Grid { 0 } else { Extent::of(settings.effort).steps };
        let (effort, min_distance_m) = (settings.effort, least_m);
        Ok(Search { site, region, clearance_m, facets, problem, views, steps, effort, min_distance_m })
    }

    /// Where cameras may be.
    pub fn region(&self) -> &Region {
        self.region
    }

    /// A box around the points on surfaces.
    pub fn surface_bounds(&self) -> AxisBox {
        self.site.bounds()
    }

    /// Places what follows for another k, per metre.
    pub fn set_rate_per_m(&mut self, rate_per_m: f64) {
        self.problem.set_rate_per_m(rate_per_m);
    }

    /// The facets, and k.
    pub fn problem(&self) -> &Problem {
        &self.problem
    }

    /// What candidates see.
    pub fn views(&self) -> &[View] {
        &self.views
    }

    /// Points on surfaces.
    pub fn surface_samples(&self) -> usize {
        self.site.points().len()
    }

    /// The smallest viewer distance, metres.
    pub fn min_distance_m(&self) -> f64 {
        self.min_distance_m
    }

    /// Positions that are spread over the region without a search: [`Room::hammersley`].
    ///
    /// # Errors
    /// When there is no room for a single one.
    pub fn spread(&self, wanted: usize) -> Result<Vec<DVec3>> {
        self.room().hammersley(wanted)
    }

    /// What a position sees.
    pub fn look(&self, position: DVec3) -> View {
        self.site.look(&self.facets, position)
    }

    /// Whether a camera could be placed at a position.
    pub fn admits(&self, position: DVec3) -> bool {
        self.room().admits(position)
    }

    fn room(&self) -> Room<'_> {
        Room { site: &self.site, region: self.region, clearance_m: self.clearance_m }
    }

    /// Places cameras behind those that there are already.
    ///
    /// # Errors
    /// When the user asks to stop.
    pub fn place(&self, lighting: Lighting, start: &[DVec3], stop: Stop, monitor: &dyn Monitor) -> Result<Placement> {
        let mut state = State::new(&self.problem, lighting);
        let tolerance_m = WITHIN_REGION * self.region.diagonal_m();
        let mut coverage = Coverage::new(&self.problem, lighting, tolerance_m);
        let mut cameras = Vec::new();
        let mut reachable = Coverage::new(&self.problem, lighting, tolerance_m);
        reachable.add(&self.views.iter().collect::<Vec<_>>());
        let mut keep = |view: &View, gain: f64, state: &mut State<'_>| {
            state.add(view);
            coverage.add(&[view]);
            reachable.add(&[view]);
            cameras.push(Placed { position: view.position, gain, figures: coverage.figures() });
        };
        for position in start {
            monitor.check()?;
            let view = self.look(*position);
            let gain = state.gain(&view);
            keep(&view, gain, &mut state);
        }
        let mut lazy = Lazy::new(&state, &self.views);
        let mut calls = Calls { gains: 0, bounds: self.views.len() as u64 };
        let (mut rounds, mut refinement_calls) = (0, 0);
        let mut placed = 0;
        while stop.cameras.is_none_or(|most| placed < most) {
            monitor.check()?;
            rounds += 1;
            let Some(choice) = self.best(&mut lazy, &state, &mut calls) else { break };
            let around =
                Refinement { state: &state, facets: &self.facets, candidates: self.views.len(), steps: self.steps };
            let from = (&self.views[choice.candidate], choice);
            let (view, gain) = self.room().refine(&around, from, &mut refinement_calls);
            if gain <= stop.until {
                break;
            }
            keep(&view, gain, &mut state);
            placed += 1;
        }
        Ok(Placement {
            lighting,
            cameras,
            started: start.len(),
            objective_calls: calls.gains,
            bound_calls: if self.effort == Effort::Exhaustive { 0 } else { calls.bounds },
            plain_objective_calls: rounds * self.views.len() as u64,
            refinement_calls,
            reachable: reachable.figures(),
        })
    }

    fn best(&self, lazy: &mut Lazy, state: &State<'_>, calls: &mut Calls) -> Option<Choice> {
        match self.effort {
            Effort::Exhaustive => greedy::plain(state, &self.views, &mut calls.gains),
            Effort::Fast | Effort::Normal => lazy.best(state, &self.views, calls),
        }
    }
}

impl Settings {
    /// Candidates and points on surfaces that are asked for.
    pub fn counts(&self) -> (usize, usize) {
        let extent = Extent::of(self.effort);
        (self.candidates.unwrap_or(extent.candidates), self.surface_samples.unwrap_or(extent.surface_samples))
    }

    /// Steps that [`Search::new`] tells of, at most.
    pub fn steps(&self) -> u64 {
        self.counts().0 as u64
    }
}

#[cfg(test)]
mod tests;
