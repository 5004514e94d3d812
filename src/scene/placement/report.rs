//! Placed cameras as JSON and CSV.

use serde::Serialize;

use crate::placement::{Figures, Lighting, Placement, Search};
use footage::dataset::cameras::CameraSet;

#[derive(Debug, Serialize)]
pub struct PlacementReport<'a> {
    cameras: Vec<CameraReport>,
    lighting: &'static str,
    theta_deg: Option<f64>,
    k_per_m: f64,
    min_distance_m: f64,
    /// First and last frame that the cameras serve.
    pub frames: [u32; 2],
    /// Frames in which surfaces were sampled.
    pub frames_looked_at: &'a [u32],
    candidates: usize,
    surface_samples: usize,
    facets: usize,
    objective_calls: u64,
    bound_calls: u64,
    plain_objective_calls: u64,
    refinement_calls: u64,
    coverage: f64,
    weighted: f64,
    within: f64,
    reachable: Figures,
    coverage_of_reachable: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    convergence: Option<Vec<ConvergenceReport>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    decay: Option<Vec<DecayReport>>,
}

#[derive(Debug, Serialize)]
struct CameraReport {
    name: String,
    position: [f64; 3],
    given: bool,
    gain: f64,
    #[serde(flatten)]
    figures: Figures,
}

/// Coverage by number of cameras, for one lighting.
#[derive(Debug, Serialize)]
struct ConvergenceReport {
    lighting: &'static str,
    theta_deg: Option<f64>,
    coverage: Vec<f64>,
    reachable: Figures,
    objective_calls: u64,
    bound_calls: u64,
    plain_objective_calls: u64,
}

/// Coverage by number of cameras, for one rate of decay.
#[derive(Debug, Serialize)]
struct DecayReport {
    k_per_m: f64,
    seen: Vec<f64>,
    weighted: Vec<f64>,
    within: Vec<f64>,
}

#[derive(Debug, Serialize)]
pub struct CameraRow {
    lighting: &'static str,
    camera: usize,
    started: bool,
    x: f64,
    y: f64,
    z: f64,
    gain: f64,
    coverage: f64,
    seen: f64,
    weighted: f64,
    within: f64,
    k_per_m: f64,
}

#[derive(Debug, Clone, PartialEq)]
pub struct DecayPlacement {
    /// Rate of decay beyond the viewer distance, per metre.
    pub rate_per_m: f64,
    pub placement: Placement,
}

impl<'a> PlacementReport<'a> {
    /// Creates the report of the placement that is written as `set`.
    pub fn new(search: &Search<'_>, placement: &Placement, set: &CameraSet, frames: [u32; 2]) -> PlacementReport<'a> {
        let last = placement.cameras.last().map_or(Figures::default(), |placed| placed.figures);
        let cameras = placement.cameras.iter().enumerate().map(|(at, placed)| CameraReport {
            name: set.name_of(at),
            position: placed.position.to_array(),
            given: at < placement.started,
            gain: placed.gain,
            figures: placed.figures,
        });
        PlacementReport {
            cameras: cameras.collect(),
            lighting: placement.lighting.name(),
            theta_deg: placement.lighting.theta_deg(),
            k_per_m: search.problem.rate_per_m,
            min_distance_m: search.min_distance_m,
            frames,
            frames_looked_at: &[],
            candidates: search.visible_sets.len(),
            surface_samples: search.sampled.point_count(),
            facets: search.problem.surfels.len(),
            objective_calls: placement.objective_calls,
            bound_calls: placement.bound_calls,
            plain_objective_calls: placement.plain_objective_calls,
            refinement_calls: placement.refinement_calls,
            coverage: last.coverage,
            weighted: last.weighted,
            within: last.within,
            reachable: placement.reachable,
            coverage_of_reachable: last.coverage / placement.reachable.coverage.max(f64::MIN_POSITIVE),
            convergence: None,
            decay: None,
        }
    }

    /// Adds placements for comparison, if there are any.
    #[must_use]
    pub fn compared(mut self, lightings: &[&Placement], decays: &[DecayPlacement]) -> PlacementReport<'a> {
        self.convergence =
            (lightings.len() > 1).then(|| lightings.iter().map(|of| ConvergenceReport::new(of)).collect());
        self.decay = (!decays.is_empty()).then(|| decays.iter().map(DecayReport::new).collect());
        self
    }
}

impl ConvergenceReport {
    fn new(placement: &Placement) -> ConvergenceReport {
        ConvergenceReport {
            lighting: placement.lighting.name(),
            theta_deg: placement.lighting.theta_deg(),
            coverage: placement.each(|figures| figures.coverage),
            reachable: placement.reachable,
            objective_calls: placement.objective_calls,
            bound_calls: placement.bound_calls,
            plain_objective_calls: placement.plain_objective_calls,
        }
    }
}

impl DecayReport {
    fn new(decay: &DecayPlacement) -> DecayReport {
        DecayReport {
            k_per_m: decay.rate_per_m,
            seen: decay.placement.each(|figures| figures.seen),
            weighted: decay.placement.each(|figures| figures.weighted),
            within: decay.placement.each(|figures| figures.within),
        }
    }
}

impl Placement {
    fn each(&self, value: fn(&Figures) -> f64) -> Vec<f64> {
        self.cameras.iter().map(|placed| value(&placed.figures)).collect()
    }

    /// Returns the rows of CSV; the cameras were placed for the rate of decay `k_per_m`.
    pub fn rows(&self, k_per_m: f64) -> impl Iterator<Item = CameraRow> + '_ {
        self.cameras.iter().enumerate().map(move |(at, placed)| {
            let [x, y, z] = placed.position.to_array();
            let Figures { coverage, seen, weighted, within } = placed.figures;
            CameraRow {
                lighting: self.lighting.name(),
                camera: at,
                started: at < self.started,
                x,
                y,
                z,
                gain: placed.gain,
                coverage,
                seen,
                weighted,
                within,
                k_per_m,
            }
        })
    }
}

impl Lighting {
    pub fn theta_deg(self) -> Option<f64> {
        match self {
            Lighting::Diffuse => None,
            Lighting::Specular { theta_deg } => Some(theta_deg),
        }
    }
}
