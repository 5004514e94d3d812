//! What `place` says: a table, JSON, CSV, and what charts are drawn from.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use glam::DVec3;
use serde::Serialize;
use serde_json::{Value, json};

use super::Args;
use crate::dataset::cameras::CameraSet;
use crate::error::Result;
use crate::placement::{Figures, Lighting, Placed, Placement, Search};
use crate::report::anatomy::counted;
use crate::report::placement::Curve;
use crate::report::{Column, Table, csv};

/// Part of the surface below which a region is taken to be in the wrong place.
const HARDLY_ANYTHING: f64 = 0.01;

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
    /// What it found for each k of `--compare-k`.
    pub decays: Vec<(f64, Placement)>,
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
    k_per_m: f64,
}

fn rows(placement: &Placement, k_per_m: f64) -> impl Iterator<Item = Row> + '_ {
    placement.cameras.iter().enumerate().map(move |(at, placed)| {
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
            k_per_m,
        }
    })
}

fn percent(share: f64) -> String {
    format!("{:.2}", 100.0 * share)
}

/// A number as people write it: with a power of ten only where it is very small or very large.
fn plain(value: f64) -> String {
    if value == 0.0 {
        "0".to_owned()
    } else if (1e-3..1e4).contains(&value) {
        let digits = (3.0 - value.log10()).ceil().clamp(0.0, 6.0) as usize;
        format!("{value:.digits$}")
    } else {
        format!("{value:.3e}")
    }
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
        self.placements().map(|placement| self.curve(placement, self.search.problem().rate_per_m())).collect()
    }

    /// The curves of `--compare-k`.
    pub fn decays(&self) -> Vec<Curve> {
        self.decays.iter().map(|(k, placement)| self.curve(placement, *k)).collect()
    }

    fn curve(&self, placement: &Placement, rate_per_m: f64) -> Curve {
        Curve {
            lighting: placement.lighting,
            scene: self.scene_name(),
            rate_per_m,
            figures: placement.cameras.iter().map(|placed| placed.figures).collect(),
            reachable: placement.reachable,
        }
    }

    /// What a user may not expect, a sentence each.
    pub fn notes(&self) -> Vec<String> {
        let (found, bounds, region) = (self.placement, self.search.surface_bounds(), self.search.region().bounds());
        let mut notes = Vec::new();
        if self.args.stop().cameras == Some(found.cameras.len() - found.started) && self.args.is_endless() {
            let count = found.cameras.len() - found.started;
            notes.push(format!("stopped after {count} cameras; say by --cameras how many more there may be"));
        }
        if let Some(wanted) = self.args.uniform.map(|count| count as usize)
            && found.cameras.len() - found.started < wanted
        {
            let count = counted((found.cameras.len() - found.started) as u64, "camera");
            notes.push(format!(
                "there is room for {count} only, if none is to be much closer to another than on a grid"
            ));
        }
        let away = (bounds.min - region.max).max(region.min - bounds.max).max(DVec3::ZERO).length();
        let across = (bounds.max - bounds.min).length();
        let is_blind = found.reachable.seen < HARDLY_ANYTHING;
        if is_blind || away > across {
            let digits = across + (bounds.min.abs().max(bounds.max.abs())).max_element();
            let corner = |at: DVec3| at.to_array().map(|value| metres(value, digits)).join(", ");
            notes.push(format!(
                "from the region {}% of the surface can be seen, and it is {} m away from the scene, which reaches from {} to {}; \
                 see whether it lies where viewers are to be",
                percent(found.reachable.seen),
                plain(away),
                corner(bounds.min),
                corner(bounds.max)
            ));
        }
        notes
    }

    /// One row for each camera of each lighting.
    ///
    /// # Errors
    /// When it cannot be written as CSV.
    pub fn csv(&self) -> Result<String> {
        let rate_per_m = self.search.problem().rate_per_m();
        let asked = self.placements().flat_map(|placement| rows(placement, rate_per_m));
        let decays = self.decays.iter().flat_map(|(k, placement)| rows(placement, *k));
        csv::of_rows(&asked.chain(decays).collect::<Vec<_>>())
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
            "{}, {} on surfaces, {}; k {} per metre, viewer distance at least {} m",
            counted(self.search.candidate_count() as u64, "candidate"),
            counted(self.search.surface_samples() as u64, "point"),
            match self.frames.len() {
                1 => "1 frame".to_owned(),
                count => format!("{count} frames of {}-{}", self.range[0], self.range[1]),
            },
            plain(self.search.problem().rate_per_m()),
            plain(self.search.min_distance_m()),
        );
        let _ = writeln!(
            text,
            "What a candidate adds was worked out {}, where trying all each time takes {}, and estimated {}; {} beside the best \
             {} tried; {:.2} s",
            counted(placement.objective_calls, "time"),
            placement.plain_objective_calls,
            counted(placement.bound_calls, "time"),
            counted(placement.refinement_calls, "position"),
            if placement.refinement_calls == 1 { "was" } else { "were" },
            self.seconds
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
        let within = match placement.lighting {
            Lighting::Diffuse => format!(", within {}", percent(reachable.within)),
            Lighting::Specular { .. } => format!(", seen {}", percent(reachable.seen)),
        };
        let aside = if self.is_written(placement) { "" } else { ", for comparison: not written" };
        format!(
            "{}: {of}{aside}. In percent; reachable: coverage {}{within}",
            self.args.scene,
            percent(reachable.coverage)
        )
    }

    /// Whether a placement is the one that was asked for.
    fn is_written(&self, placement: &Placement) -> bool {
        std::ptr::eq(placement, self.placement)
    }

    fn table(&self, placement: &Placement) -> Table {
        let mut columns = vec![
            Column::Left("Camera"),
            Column::Right("x"),
            Column::Right("y"),
            Column::Right("z"),
            Column::Right("Gain"),
            Column::Right("Coverage"),
        ];
        // Coverage of specular surfaces is of directions; of what is beside it, both tell parts of the surface.
        let is_diffuse = placement.lighting == Lighting::Diffuse;
        columns
            .extend(if is_diffuse { vec!["Weighted", "Within"] } else { vec!["Seen"] }.into_iter().map(Column::Right));
        let mut table = Table::new(&columns);
        let bounds = self.search.region().bounds();
        let diagonal_m = (bounds.max - bounds.min).length();
        for (at, placed) in placement.cameras.iter().enumerate() {
            let [x, y, z] = placed.position.to_array().map(|value| metres(value, diagonal_m));
            let Figures { coverage, seen, weighted, within } = placed.figures;
            let mark = if at < placement.started { " (given)" } else { "" };
            let name = if self.is_written(placement) { self.set.name_of(at) } else { at.to_string() };
            let beside = if is_diffuse { vec![weighted, within] } else { vec![seen] };
            let shares = [placed.gain, coverage].into_iter().chain(beside).map(percent);
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
            "candidates": self.search.candidate_count(),
            "surface_samples": self.search.surface_samples(),
            "facets": self.search.problem().surfels().len(),
            "objective_calls": self.placement.objective_calls,
            "bound_calls": self.placement.bound_calls,
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
                    "bound_calls": placement.bound_calls,
                    "plain_objective_calls": placement.plain_objective_calls,
                })
            };
            all["convergence"] = self.placements().map(curve).collect();
        }
        if !self.decays.is_empty() {
            let curve = |(k, placement): &(f64, Placement)| {
                let each = |value: fn(&Figures) -> f64| {
                    placement.cameras.iter().map(|placed| value(&placed.figures)).collect::<Vec<f64>>()
                };
                json!({
                    "k_per_m": k,
                    "seen": each(|figures| figures.seen),
                    "weighted": each(|figures| figures.weighted),
                    "within": each(|figures| figures.within),
                })
            };
            all["decay"] = self.decays.iter().map(curve).collect();
        }
        all
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_plain_unless_tiny_or_huge() {
        let found = [0.0, 0.00125, 1.2345678, 577.35, 9999.4, 1.5e5, 2e-9].map(plain);
        assert_eq!(found, ["0", "0.001250", "1.235", "577.4", "9999", "1.500e5", "2.000e-9"]);
        assert_eq!([metres(1.23456, 5.0), metres(0.001234567, 0.002)], ["1.235", "0.001235"]);
    }
}
