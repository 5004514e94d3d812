//! Uses the checks to decide properties of a proposed manifest that the images alone do not determine.

use std::path::Path;

use super::{Choice, MAX_PROBES, Report, check};
use crate::dataset::manifest::{FileDepth, Manifest};
use crate::dataset::{Projection, Source, SourceOptions};
use codec::error::Result;
use codec::monitor::Monitor;

/// Returns the manifest with the kind of depth that raises fewer suspicions, and the report of its checks. `file` is the future
/// path of the manifest.
pub fn settle(manifest: Manifest, file: &Path, monitor: &dyn Monitor) -> Result<(Manifest, Report)> {
    let checked = |manifest: &Manifest| {
        let source = Source::of_manifest(manifest.clone(), file, &SourceOptions::default())?;
        check(&source, &choice(&source), monitor)
    };
    let report = checked(&manifest)?;
    let doubts = |report: &Report| report.suspected().count();
    let is_doubted = report.suspected().any(|finding| finding.check.starts_with("depth.kind"));
    let mut other = manifest.clone();
    let Some(depth) = other.depth.as_mut().filter(|_| is_doubted && manifest.projection != Projection::Equirect) else {
        return Ok((manifest, report));
    };
    depth.kind = match depth.kind {
        FileDepth::Distance => FileDepth::Planar,
        FileDepth::Planar => FileDepth::Distance,
        FileDepth::Disparity => return Ok((manifest, report)),
    };
    let other_report = checked(&other)?;
    Ok(if doubts(&other_report) < doubts(&report) { (other, other_report) } else { (manifest, report) })
}

/// Selects all probes, or only the first if two consecutive probes have the same position, because positions are then unknown.
fn choice(source: &Source) -> Choice {
    let probes = source.probes();
    let is_known = probes.windows(2).all(|pair| pair[0].position != pair[1].position);
    let first = probes.first().map(|probe| probe.name.clone());
    let probes = if is_known { Vec::new() } else { first.into_iter().collect() };
    Choice { probes, max_probes: MAX_PROBES, frame: None }
}
