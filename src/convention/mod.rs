//! Checks a dataset against its manifest; changes nothing.
//!
//! Enters: an open [`Source`]. Leaves: [`Finding`]s, each a verdict, figures and a sentence for a person to judge.
//!
//! 1. `seams`: neighbouring faces of a cube show the same along their edge. The permutation and turns of the faces with the
//!    least mismatch is compared with the declared one. The whole cube may be turned or mirrored without any edge noticing;
//!    of the 48 ways the one nearest to the declared permutation is reported. Depth and colour are checked apart.
//! 2. `flatness`: 1/Z of a plane is linear along rows and columns where Z is planar depth. Collinear samples under one kind of
//!    depth and not under the other are a vote. One probe is enough, but a dome around it looks planar: where
//!    `between_probes` confirms the declared kind, a suspicion of this check becomes inconclusive.
//! 3. `between_probes`: a surface of one probe may be hidden from another, but not seen through. `hypotheses` lists common
//!    mistakes; up to three are undone one after the other, the best first. Planar depth and distance agree along seams;
//!    here they do not.
//! 4. `values` and `light`: values that are neither surface nor background, an undeclared background, near and far, depth in
//!    integers, codes declared as light.
//! 5. `duplicate_images`: images with equal pixels. Equal depth alone is no duplicate: walls look alike.

mod between_probes;
mod borders;
mod duplicate_images;
mod face_permutation;
mod finding;
mod flatness;
mod hypotheses;
mod light;
mod probe_samples;
mod read;
mod reproject;
mod seams;
mod values;

use crate::dataset::manifest::Manifest;
use crate::dataset::{Projection, Source, StreamKind};
use crate::error::Result;
use crate::image::ColorSpace;
use crate::monitor::Monitor;

pub use finding::{Finding, Verdict};
pub use read::Choice;

/// Default limit of probes to check.
pub const MAX_PROBES: usize = 16;

#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Report {
    /// Probes checked.
    pub probes: usize,
    /// Probes of the dataset.
    pub all_probes: usize,
    /// Face images read.
    pub images: u64,
    #[serde(rename = "checks")]
    pub findings: Vec<Finding>,
}

impl Report {
    pub fn suspects(&self) -> bool {
        self.findings.iter().any(|finding| finding.verdict == Verdict::Suspect)
    }
}

/// Files that [`check`] reads: the steps of its monitor.
pub fn steps(source: &Source, choice: &Choice) -> Result<u64> {
    Ok(read::jobs(source, choice)?.len() as u64)
}

/// Runs all checks. The result does not depend on the number of threads.
pub fn check(source: &Source, choice: &Choice, monitor: &dyn Monitor) -> Result<Report> {
    let manifest = source.manifest();
    let depth = manifest.and_then(|manifest| manifest.depth.as_ref());
    let near = depth.and_then(|depth| depth.near).unwrap_or(0.0);
    let far = depth.and_then(|depth| depth.far).unwrap_or(f64::INFINITY);
    let (background, scale, invalid) = (source.rules.background, source.rules.scale, source.rules.invalid);
    let stated = values::Stated { background, scale, range_m: [near, far], invalid };
    let footage = read::read(source, choice, &stated, monitor)?;
    let projection = manifest.map_or(Projection::Cubemap, |manifest| manifest.projection);
    let mut findings = Vec::new();
    // Faces cut from panoramas, crosses and strips have a fixed order.
    let own_faces = manifest.is_none_or(Manifest::has_face_files);
    let depth = seams::Stream { check: "seams.depth", cap: seams::DEPTH_CAP };
    let color = seams::Stream { check: "seams.color", cap: seams::COLOR_CAP };
    for (stream, borders) in [(depth, &footage.depth_borders), (color, &footage.color_borders)] {
        if own_faces && !borders.is_empty() {
            findings.extend(seams::check(stream, borders));
        }
    }
    if let Some(values) = &footage.depth {
        let kind = source.depth_kind;
        if footage.views.is_empty() {
            let says = "the intrinsics of the perspective views are unknown";
            findings.push(Finding::new("depth.kind.flatness", Verdict::CannotTell, says));
        } else {
            let between = between_probes::check(&footage.views, kind, projection, monitor)?;
            if projection != Projection::Equirect {
                let alone = flatness::check(&footage.views, kind);
                let confirms = |found: &Finding| found.check == between_probes::KIND && found.verdict == Verdict::Fine;
                let overruled = alone.verdict == Verdict::Suspect && between.iter().any(confirms);
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
        let space = source.color_space.unwrap_or(match files {
            light::Files::Integers => ColorSpace::Srgb,
            light::Files::Floats => ColorSpace::LinearRec709,
        });
        findings.push(light::check(values, space, files));
    }
    findings.extend(duplicate_images::check(&footage, source.depth_kind));
    let probes = read::chosen_probes(source, choice)?.len();
    Ok(Report { probes, all_probes: source.probes().len(), images: footage.images, findings })
}
