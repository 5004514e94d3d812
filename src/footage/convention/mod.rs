//! Checks a dataset against its manifest, without changing it.
//!
//! Input: an open [`Source`]. Output: [`Finding`]s, each with a verdict, figures and a sentence for the user. Mistakes come before
//! the checks that fail because of them.
//!
//! 1. `positions` finds probes at one place, `duplicate_images` images with equal pixels, and `values` invalid depth and an undeclared
//!    background.
//! 2. `seams` checks order and orientation of cube faces by comparing their edges, for depth and colour separately. Edges are
//!    invariant under the 48 rotations and mirrorings of the whole cube; the one closest to the declared permutation is reported.
//! 3. `flatness` distinguishes planar depth from distance by planes in the images of one probe. If `between_probes` confirms the
//!    declared kind, a suspicion of this check becomes inconclusive, because a dome around the probe looks planar.
//! 4. `between_probes` checks kind and scale of depth, positions and orientations. `hypotheses` lists common mistakes; up to
//!    three are corrected one after the other, starting with the best fit.
//! 5. `values` and `light` look for depth outside near and far, and sRGB codes declared as linear.

mod between_probes;
mod borders;
mod duplicate_images;
mod face_permutation;
mod finding;
mod flatness;
mod hypotheses;
mod light;
mod positions;
mod probe_samples;
mod read;
mod reproject;
mod seams;
pub mod settle;
mod values;

use std::collections::BTreeMap;

use crate::dataset::manifest::DepthInfo;
use crate::dataset::manifest::Manifest;
use crate::dataset::{Projection, Source, StreamKind};
use crate::image_files::ColorSpace;
use codec::depth::spread::Spread;
use codec::error::{Result, counted};
use codec::monitor::Monitor;

pub use finding::{Finding, Verdict};
pub use read::Choice;

/// Default limit of the number of probes to check.
pub const MAX_PROBES: usize = 16;

#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Report {
    /// Number of probes checked.
    pub probes: usize,
    /// Number of probes of the dataset.
    pub all_probes: usize,
    /// Number of face images read.
    pub images: u64,
    /// Number of face images of depth and colour in all frames of all probes.
    pub all_images: u64,
    #[serde(rename = "checks")]
    pub findings: Vec<Finding>,
    /// Histogram of distances, by probe index.
    #[serde(skip)]
    pub spreads: BTreeMap<usize, Spread>,
}

impl Report {
    pub fn suspects(&self) -> bool {
        self.suspected().next().is_some()
    }

    /// Extent of the checks, such as "2 of 2 probes, 24 of 72 images".
    pub fn extent(&self) -> String {
        format!(
            "{} of {}, {} of {}",
            self.probes,
            counted(self.all_probes as u64, "probe"),
            self.images,
            counted(self.all_images, "image")
        )
    }

    /// Findings with the verdict [`Verdict::Suspect`].
    pub fn suspected(&self) -> impl Iterator<Item = &Finding> {
        self.findings.iter().filter(|finding| finding.verdict == Verdict::Suspect)
    }
}

/// Number of files that [`check`] reads, which is the number of steps of its monitor.
pub fn steps(source: &Source, choice: &Choice) -> Result<u64> {
    Ok(read::jobs(source, choice)?.len() as u64)
}

/// Runs only the checks of values: depth, colour encoding, and equal positions of probes.
pub fn check_values(source: &Source, choice: &Choice, monitor: &dyn Monitor) -> Result<Vec<Finding>> {
    let stated = stated(source);
    let footage = read::read_values(source, choice, &stated, monitor)?;
    let mut findings = footage.depth.map_or_else(Vec::new, |values| values::check(&values, &stated));
    findings.extend(footage.color.map(|values| check_light(source, &values)));
    findings.extend(positions::check(source.probes()));
    Ok(findings)
}

/// Returns the depth rules of the source, and near and far of the manifest.
fn stated(source: &Source) -> values::Stated {
    let depth = source.manifest.as_ref().and_then(|manifest| manifest.depth.as_ref());
    let [near, far] = depth.map_or([None; 2], DepthInfo::stated_range);
    values::Stated { rules: source.depth_rules(), range_m: [near.unwrap_or(0.0), far.unwrap_or(f64::INFINITY)] }
}

fn check_light(source: &Source, values: &light::ColorValues) -> Finding {
    let pattern = source.manifest.as_ref().and_then(|manifest| manifest.files.get(StreamKind::Color));
    let png = pattern.is_some_and(|pattern| pattern.to_ascii_lowercase().ends_with(".png"));
    let (files, usual) = match png {
        true => (light::Files::Integers, ColorSpace::Srgb),
        false => (light::Files::Floats, ColorSpace::LinearRec709),
    };
    light::check(values, source.color_space.unwrap_or(usual), files)
}

/// Runs all checks. The result does not depend on the number of threads.
pub fn check(source: &Source, choice: &Choice, monitor: &dyn Monitor) -> Result<Report> {
    let manifest = source.manifest.as_ref();
    let stated = stated(source);
    let footage = read::read(source, choice, &stated, monitor)?;
    let projection = manifest.map_or(Projection::Cubemap, |manifest| manifest.projection);
    let mut findings = Vec::new();
    if choice.probes.is_empty() {
        findings.extend(positions::check(source.probes()));
    }
    findings.extend(duplicate_images::check(&footage, source.depth_in_files));
    let of_values = footage.depth.as_ref().map(|values| values::check(values, &stated));
    // Near and far are also exceeded where the kind or the scale of depth is wrong.
    let (near_far, of_values): (Vec<_>, Vec<_>) =
        of_values.into_iter().flatten().partition(|finding| finding.check == values::NEAR_FAR);
    findings.extend(of_values);
    // Faces cut from panoramas, crosses and strips have a fixed order.
    let own_faces = manifest.is_none_or(Manifest::has_face_files);
    for (stream, borders) in [(seams::DEPTH, &footage.depth_borders), (seams::COLOR, &footage.color_borders)] {
        if own_faces && !borders.is_empty() {
            findings.extend(seams::check(stream, borders));
        }
    }
    if footage.depth.is_some() {
        let kind = source.depth_in_files;
        if footage.views.is_empty() {
            let says = "the intrinsics of the perspective views are unknown";
            findings.push(Finding::new("depth.kind.flatness", Verdict::CannotTell, says));
        } else {
            let between = between_probes::check(&footage.views, kind, projection, monitor)?;
            if projection != Projection::Equirect {
                let mut alone = flatness::check(&footage.views, kind);
                let confirms = |found: &Finding| found.check == between_probes::KIND && found.verdict == Verdict::Fine;
                // Curved surfaces may look planar, so a fit between probes overrides the suspicion.
                if alone.verdict == Verdict::Suspect && between.iter().any(confirms) {
                    alone.verdict = Verdict::CannotTell;
                    alone.says += ", but reprojection between probes fits the declared kind";
                }
                findings.push(alone);
            }
            findings.extend(between);
        }
    }
    findings.extend(near_far);
    findings.extend(footage.color.as_ref().map(|values| check_light(source, values)));
    let probes = read::chosen_probes(source, choice)?.len();
    Ok(Report {
        probes,
        all_probes: source.probes().len(),
        images: footage.images,
        all_images: read::all_images(source),
        findings,
        spreads: footage.spreads,
    })
}
