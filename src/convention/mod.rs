//! Whether a dataset is what its manifest says.
//!
//! Enters: an open [`Source`]. Leaves: [`Finding`]s about the order and orientation of cube faces (`seams`), planar depth
//! or distance (`flatness`, `between_probes`), scale, positions and orientations (`between_probes`), near, far and background
//! (`values`), light or codes (`light`), images twice (`copies`). Nothing is changed; a suspicion is a figure and a sentence, for a person to judge.

mod arrangement;
mod between_probes;
mod borders;
mod copies;
mod finding;
mod flatness;
mod light;
mod read;
mod readings;
mod reproject;
mod seams;
mod values;
mod views;

use crate::dataset::manifest::Manifest;
use crate::dataset::{Projection, Source, StreamKind};
use crate::error::Result;
use crate::image::ColorSpace;
use crate::monitor::Monitor;

pub use finding::{Finding, Verdict};
pub use read::Choice;

/// Probes that are looked at where nobody says which: enough to tell, few enough to wait for.
pub const MAX_PROBES: usize = 16;

/// What was looked at, and what was found.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Report {
    /// Probes that were looked at.
    pub probes: usize,
    /// Of so many.
    pub all_probes: usize,
    /// Images of faces that were read.
    pub images: u64,
    /// One for each check.
    #[serde(rename = "checks")]
    pub findings: Vec<Finding>,
}

impl Report {
    /// Whether anything is suspected.
    pub fn suspects(&self) -> bool {
        self.findings.iter().any(|finding| finding.verdict == Verdict::Suspect)
    }
}

/// Files that [`check`] reads, each a step of its monitor.
///
/// # Errors
/// When no probe has the frame asked for, or one is not there.
pub fn steps(source: &Source, choice: &Choice) -> Result<u64> {
    Ok(read::jobs(source, choice)?.len() as u64)
}

/// Looks for wrong conventions. The result does not depend on the number of threads.
///
/// # Errors
/// When a file cannot be read, no probe has the frame asked for, or the monitor is interrupted.
pub fn check(source: &Source, choice: &Choice, monitor: &dyn Monitor) -> Result<Report> {
    let manifest = source.manifest();
    let depth = manifest.and_then(|manifest| manifest.depth.as_ref());
    let stated = values::Stated {
        invalid: source.invalid_depth(),
        ..values::Stated::new(depth, source.background(), source.depth_scale())
    };
    let footage = read::read(source, choice, &stated, monitor)?;
    let projection = manifest.map_or(Projection::Cubemap, |manifest| manifest.projection);
    let mut findings = Vec::new();
    // Faces that are cut from panoramas, crosses and strips are where they should be, or all of them are not.
    let own_faces = manifest.is_none_or(Manifest::has_face_files);
    if own_faces && !footage.depth_borders.is_empty() {
        let stream = seams::Stream { check: "seams.depth", cap: seams::DEPTH_CAP };
        findings.extend(seams::check(stream, &footage.depth_borders));
    }
    if own_faces && !footage.color_borders.is_empty() {
        let stream = seams::Stream { check: "seams.color", cap: seams::COLOR_CAP };
        findings.extend(seams::check(stream, &footage.color_borders));
    }
    if let Some(values) = &footage.depth {
        let kind = source.depth_kind();
        if footage.views.is_empty() {
            let says = "the lens of the perspective views is not known";
            findings.push(Finding::new("depth.kind.flatness", Verdict::CannotTell, says));
        } else {
            let between = between_probes::check(&footage.views, kind, projection, monitor)?;
            if projection != Projection::Equirect {
                let alone = flatness::check(&footage.views, kind);
                let confirmed = between
                    .iter()
                    .any(|finding| finding.check == between_probes::KIND && finding.verdict == Verdict::Fine);
                let overruled = alone.verdict == Verdict::Suspect && confirmed;
                findings.push(if overruled { flatness::overruled(alone) } else { alone });
            }
            findings.extend(between);
        }
        findings.extend(values::check(values, &stated));
    }
    if let Some(values) = &footage.color {
        let pattern = manifest.and_then(|manifest| manifest.files.get(StreamKind::Color));
        let png = pattern.is_some_and(|pattern| pattern.to_ascii_lowercase().ends_with(".png"));
        let files = if png { light::Files::Integers } else { light::Files::Floats };
        let space = source.color_space().unwrap_or(match files {
            light::Files::Integers => ColorSpace::Srgb,
            light::Files::Floats => ColorSpace::LinearRec709,
        });
        findings.push(light::check(values, space, files));
    }
    findings.extend(copies::check(&footage, source.depth_kind()));
    let probes = read::chosen_probes(source, choice)?.len();
    Ok(Report { probes, all_probes: source.probes().len(), images: footage.images, findings })
}
