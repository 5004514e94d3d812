//! What `place` says: a table, JSON, CSV, and what charts are drawn from.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use serde::Serialize;
use serde_json::{Value, json};

use super::Args;
use crate::dataset::cameras::CameraSet;
use crate::error::Result;
use crate::placement::{Figures, Lighting, Placed, Placement, Search};
use crate::report::placement::Curve;
use crate::report::{Column, Table, csv};

/// Everything that is told.
pub struct Report<'a> {
    /// The command line.
    pub args: &'a Args,
    /// The search.
    pub search: &'a Search<'a>,
    /// What it found.
    pub placement: &'a Placement,
    /// What it found for the other lighting, where that was asked for.
    pub comparison: Option<Placement>,
    /// The cameras as they are written.
    pub set: &'a CameraSet,
    /// First and last frame that cameras serve.
    pub range: [u32; 2],
    /// Those that were looked at.
    pub frames: Vec<u32>,
    /// Of reading, searching and placing.
    pub seconds: f64,
}

/// θ, where there is one.
pub fn theta_deg(lighting: Lighting) -> Option<f64> {
    match lighting {
        Lighting::Diffuse => None,
        Lighting::Specular { theta_deg } => Some(theta_deg),
    }
}

/// A camera in CSV.
#[derive(Debug, Serialize)]
struct Row {
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
}

fn rows(placement: &Placement) -> impl Iterator<Item = Row> + '_ {
    placement.cameras.iter().enumerate().map(|(at, placed)| {
        let [x, y, z] = placed.position.to_array();
        let Figures { coverage, seen, weighted, within } = placed.figures;
        let lighting = placement.lighting.name();
        Row {
            lighting,
            camera: at,
            started: at < placement.started,
            x,
            y,
            z,
            gain: placed.gain,
            coverage,
            seen,
            weighted,
            within,
        }
    })
}

fn percent(share: f64) -> String {
    format!("{:.2}", 100.0 * share)
}

/// A length with as many digits as tell candidates apart.
fn metres(value: f64, diagonal_m: f64) -> String {
    let digits = (3.0 - diagonal_m.max(1e-300).log10()).ceil().clamp(0.0, 12.0) as usize;
    format!("{value:.digits$}")
}

impl Report<'_> {
    fn placements(&self) -> impl Iterator<Item = &Placement> {
        std::iter::once(self.placement).chain(&self.comparison)
    }

    /// The scene without the folder that it is in.
    fn scene_name(&self) -> String {
        let name = Path::new(&self.args.scene).file_name();
        name.map_or_else(|| self.args.scene.clone(), |name| name.to_string_lossy().into_owned())
    }

    /// The curves of all lightings that were placed for, the one that was asked for first.
    pub fn curves(&self) -> Vec<Curve> {
        let curve = |placement: &Placement| Curve {
            lighting: placement.lighting,
            scene: self.scene_name(),
            rate_per_m: self.search.problem().rate_per_m(),
            figures: placement.cameras.iter().map(|placed| placed.figures).collect(),
            reachable: placement.reachable,
        };
        self.placements().map(curve).collect()
    }

    /// One row for each camera of each lighting.
    ///
    /// # Errors
    /// When it cannot be written as CSV.
    pub fn csv(&self) -> Result<String> {
        csv::of_rows(&self.placements().flat_map(rows).collect::<Vec<_>>())
    }

    /// The table and what belongs to it.
    pub fn text(&self, files: &[PathBuf]) -> String {
        let mut text = String::new();
        for placement in self.placements() {
            let _ = writeln!(text, "{}\n{}", self.heading(placement), self.table(placement));
        }
        let placement = self.placement;
        let _ = writeln!(
            text,
            "{} candidates, {} points on surfaces, {}; k {:.3e} per metre, viewer distance at least {:.3e} m",
            self.search.views().len(),
            self.search.surface_samples(),
            match self.frames.len() {
                1 => "1 frame".to_owned(),
                count => format!("{count} frames of {}-{}", self.range[0], self.range[1]),
            },
            self.search.problem().rate_per_m(),
            self.search.min_distance_m(),
        );
        let _ = writeln!(
            text,
            "{} gains computed where the plain search computes {}, {} beside the best candidates; {:.2} s",
            placement.objective_calls, placement.plain_objective_calls, placement.refinement_calls, self.seconds
        );
        files.iter().for_each(|path| {
            let _ = writeln!(text, "{}", path.display());
        });
        text
    }

    fn heading(&self, placement: &Placement) -> String {
        let of = match placement.lighting {
            Lighting::Diffuse => "diffuse surfaces".to_owned(),
            Lighting::Specular { theta_deg } => format!("specular surfaces, theta {theta_deg} degrees"),
        };
        let reachable = placement.reachable;
        format!(
            "{}: {of}. In percent; reachable: coverage {}, within {}",
            self.args.scene,
            percent(reachable.coverage),
            percent(reachable.within)
        )
    }

    fn table(&self, placement: &Placement) -> Table {
        let mut table = Table::new(&[
            Column::Left("Camera"),
            Column::Right("x"),
            Column::Right("y"),
            Column::Right("z"),
            Column::Right("Gain"),
            Column::Right("Coverage"),
            Column::Right("Weighted"),
            Column::Right("Within"),
        ]);
        let diagonal_m = placement.cameras.iter().map(|placed| placed.position.length()).fold(0.0, f64::max);
        for (at, placed) in placement.cameras.iter().enumerate() {
            let [x, y, z] = placed.position.to_array().map(|value| metres(value, diagonal_m));
            let Figures { coverage, weighted, within, .. } = placed.figures;
            let mark = if at < placement.started { " (given)" } else { "" };
            let name = if std::ptr::eq(placement, self.placement) { self.set.name_of(at) } else { at.to_string() };
            let shares = [placed.gain, coverage, weighted, within].map(percent);
            table.row([format!("{name}{mark}"), x, y, z].into_iter().chain(shares));
        }
        table
    }

    /// Everything.
    pub fn json(&self, files: &[PathBuf]) -> Value {
        let last = self.placement.cameras.last().map_or(Figures::default(), |placed| placed.figures);
        let camera = |(at, placed): (usize, &Placed)| {
            json!({
                "name": self.set.name_of(at),
                "position": placed.position.to_array(),
                "given": at < self.placement.started,
                "gain": placed.gain,
                "coverage": placed.figures.coverage,
                "seen": placed.figures.seen,
                "weighted": placed.figures.weighted,
                "within": placed.figures.within,
            })
        };
        let mut all = json!({
            "cameras": self.placement.cameras.iter().enumerate().map(camera).collect::<Vec<_>>(),
            "lighting": self.placement.lighting.name(),
            "theta_deg": theta_deg(self.placement.lighting),
            "k_per_m": self.search.problem().rate_per_m(),
            "min_distance_m": self.search.min_distance_m(),
            "frames": self.range,
            "frames_looked_at": self.frames,
            "candidates": self.search.views().len(),
            "surface_samples": self.search.surface_samples(),
            "facets": self.search.problem().facets().len(),
            "objective_calls": self.placement.objective_calls,
            "plain_objective_calls": self.placement.plain_objective_calls,
            "refinement_calls": self.placement.refinement_calls,
            "coverage": last.coverage,
            "weighted": last.weighted,
            "within": last.within,
            "reachable": self.placement.reachable,
            "coverage_of_reachable": last.coverage / self.placement.reachable.coverage.max(f64::MIN_POSITIVE),
            "seconds": self.seconds,
            "files": files,
        });
        if self.comparison.is_some() {
            let curve = |placement: &Placement| {
                json!({
                    "lighting": placement.lighting.name(),
                    "theta_deg": theta_deg(placement.lighting),
                    "coverage": placement.cameras.iter().map(|placed| placed.figures.coverage).collect::<Vec<_>>(),
                    "reachable": placement.reachable,
                    "objective_calls": placement.objective_calls,
                    "plain_objective_calls": placement.plain_objective_calls,
                })
            };
            all["convergence"] = self.placements().map(curve).collect();
        }
        all
    }
}
