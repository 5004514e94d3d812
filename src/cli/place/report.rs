//! Reports of `place`: table, JSON, CSV, curves.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use glam::DVec3;
use serde::Serialize;

use super::args::Args;
use crate::report::placement::Curve;
use crate::report::{Table, csv};
use codec::error::{Result, counted};
use footage::dataset::cameras::CameraSet;
use scene::placement::report::{DecayPlacement, PlacementReport};
use scene::placement::{Figures, Lighting, Placement, Search};

/// Visible fraction of the surface below which the region is probably misplaced.
const HARDLY_ANYTHING: f64 = 0.01;

#[derive(Serialize)]
pub struct Document<'a> {
    #[serde(flatten)]
    placement: PlacementReport<'a>,
    seconds: f64,
    files: &'a [PathBuf],
}

pub struct Report<'a> {
    pub args: &'a Args,
    pub search: &'a Search<'a>,
    pub placement: &'a Placement,
    /// Placement for the other lighting, with --plot or --csv.
    pub comparison: Option<Placement>,
    /// Placement for each K of --compare-k.
    pub decays: Vec<DecayPlacement>,
    pub set: &'a CameraSet,
    pub range: [u32; 2],
    pub frames: Vec<u32>,
    pub seconds: f64,
}

fn percent(share: f64) -> String {
    format!("{:.2}", 100.0 * share)
}

/// Formats a number, with a power of ten only if it is very small or very large.
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

/// Formats a length with enough digits to distinguish candidates.
fn metres(value: f64, diagonal_m: f64) -> String {
    let digits = (3.0 - diagonal_m.max(1e-300).log10()).ceil().clamp(0.0, 12.0) as usize;
    format!("{value:.digits$}")
}

impl Report<'_> {
    fn placements(&self) -> impl Iterator<Item = &Placement> {
        std::iter::once(self.placement).chain(&self.comparison)
    }

    /// Returns a curve for each lighting, the requested one first.
    pub fn curves(&self) -> Vec<Curve> {
        self.placements().map(|placement| self.curve(placement, self.search.problem.rate_per_m)).collect()
    }

    pub fn decays(&self) -> Vec<Curve> {
        self.decays.iter().map(|decay| self.curve(&decay.placement, decay.rate_per_m)).collect()
    }

    fn curve(&self, placement: &Placement, rate_per_m: f64) -> Curve {
        // File name without its folder.
        let scene = Path::new(&self.args.scene).file_name().map(|name| name.to_string_lossy().into_owned());
        Curve {
            lighting: placement.lighting,
            scene: scene.unwrap_or_else(|| self.args.scene.clone()),
            rate_per_m,
            figures: placement.cameras.iter().map(|placed| placed.figures).collect(),
            reachable: placement.reachable,
        }
    }

    pub fn notes(&self) -> Vec<String> {
        let (found, bounds, region) = (self.placement, self.search.sampled.bounds(), self.search.region.bounds());
        let mut notes = Vec::new();
        if self.args.stop().cameras == Some(found.cameras.len() - found.started) && self.args.is_endless() {
            let count = found.cameras.len() - found.started;
            notes.push(format!("stopped after {}; --cameras allows more", counted(count as u64, "camera")));
        }
        if let Some(wanted) = self.args.uniform.map(|count| count as usize)
            && found.cameras.len() - found.started < wanted
        {
            let count = counted((found.cameras.len() - found.started) as u64, "camera");
            notes.push(format!("{count} placed: the region has no space for more at an even distance"));
        }
        let away = (bounds.min - region.max).max(region.min - bounds.max).max(DVec3::ZERO).length();
        let across = (bounds.max - bounds.min).length();
        let is_blind = found.reachable.seen < HARDLY_ANYTHING;
        if is_blind || away > across {
            let digits = across + (bounds.min.abs().max(bounds.max.abs())).max_element();
            let corner = |at: DVec3| at.to_array().map(|value| metres(value, digits)).join(", ");
            notes.push(format!(
                "{}% of the surface is visible from the region, which is {} m from the scene ({} to {}): check \
                --region",
                percent(found.reachable.seen),
                plain(away),
                corner(bounds.min),
                corner(bounds.max)
            ));
        }
        notes
    }

    pub fn csv(&self) -> Result<String> {
        let rate_per_m = self.search.problem.rate_per_m;
        let asked = self.placements().flat_map(|placement| placement.rows(rate_per_m));
        let decays = self.decays.iter().flat_map(|decay| decay.placement.rows(decay.rate_per_m));
        csv::of_rows(&asked.chain(decays).collect::<Vec<_>>())
    }

    pub fn text(&self, files: &[PathBuf]) -> String {
        let mut text = String::new();
        for placement in self.placements() {
            let _ = writeln!(text, "{}\n{}", self.heading(placement), self.table(placement));
        }
        let placement = self.placement;
        let _ = writeln!(
            text,
            "{}, {} on surfaces, {}; k {} per metre, viewer distance at least {} m",
            counted(self.search.visible_sets.len() as u64, "candidate"),
            counted(self.search.sampled.point_count() as u64, "point"),
            match self.frames.len() {
                1 => "1 frame".to_owned(),
                count => format!("{count} frames of {}-{}", self.range[0], self.range[1]),
            },
            plain(self.search.problem.rate_per_m),
            plain(self.search.min_distance_m),
        );
        let _ = writeln!(
            text,
            "{} computed ({} by plain greedy search), {} estimated; {} refined; {:.2} s",
            counted(placement.objective_calls, "gain"),
            placement.plain_objective_calls,
            placement.bound_calls,
            counted(placement.refinement_calls, "position"),
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
            "{}: {of}{aside}. In percent of what is reachable, which is of all surfaces: coverage {}{within}",
            self.args.scene,
            percent(reachable.coverage)
        )
    }

    fn is_written(&self, placement: &Placement) -> bool {
        std::ptr::eq(placement, self.placement)
    }

    fn table(&self, placement: &Placement) -> Table {
        // For specular surfaces coverage counts directions; the next column is a fraction of the surface.
        let is_diffuse = placement.lighting == Lighting::Diffuse;
        let beside = if is_diffuse { ">Weighted|>Within" } else { ">Seen" };
        let mut table = Table::new(&format!("Camera|>x|>y|>z|>Gain|>Coverage|{beside}"));
        let reachable = placement.reachable;
        let share = |value: f64, of: f64| percent(value / of.max(f64::MIN_POSITIVE));
        let bounds = self.search.region.bounds();
        let diagonal_m = (bounds.max - bounds.min).length();
        for (at, placed) in placement.cameras.iter().enumerate() {
            let [x, y, z] = placed.position.to_array().map(|value| metres(value, diagonal_m));
            let Figures { coverage, seen, weighted, within } = placed.figures;
            let mark = if at < placement.started { " (given)" } else { "" };
            let name = if self.is_written(placement) { self.set.name_of(at) } else { at.to_string() };
            let beside = match is_diffuse {
                true => vec![share(weighted, reachable.weighted), share(within, reachable.within)],
                false => vec![share(seen, reachable.seen)],
            };
            let shares = [placed.gain, coverage].map(|value| share(value, reachable.coverage));
            table.row([format!("{name}{mark}"), x, y, z].into_iter().chain(shares).chain(beside));
        }
        table
    }

    pub fn json<'b>(&'b self, files: &'b [PathBuf]) -> Document<'b> {
        let placement = PlacementReport::new(self.search, self.placement, self.set, self.range);
        let mut placement = placement.compared(&self.placements().collect::<Vec<_>>(), &self.decays);
        placement.frames_looked_at = &self.frames;
        Document { placement, seconds: self.seconds, files }
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
