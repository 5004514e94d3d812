//! Near and far of a probe, given or found in its depth images. Images that were scanned are kept for the encoder if memory
//! permits.

use std::collections::HashMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use crate::dataset::{Source, SourceGroup};
use crate::encode::EncodeSettings;
use crate::encode::budget::ScanLimits;
use crate::encode::plan::{GroupPlan, Plan, given_range};
use crate::encode::scan::{Distances, FoundDepth, Scan};
use crate::encode::source::{FrameSource, selected_groups};
use codec::depth::DepthRange;
use codec::depth::predictive::Levels;
use codec::depth::quantise::metres_in_words;
use codec::depth::spread::{Spread, Strays};
use codec::error::{Error, Result};
use codec::image::{DepthPlane, StreamKind};
use codec::monitor::Monitor;
use codec::ordered::try_map_at_once;
use codec::streams::convert::DepthExtent;

/// Near and far of a probe, with the scan of its images if this call scanned them.
#[derive(Debug)]
pub(super) struct ProbeDepth {
    pub range: DepthRange,
    /// Codes that occur, if the images were scanned and have few distinct ones.
    pub levels: Levels,
    /// Outlier pixels that cost much of the precision, if the images were scanned.
    pub strays: Option<Strays>,
    pub scanned: Option<ScannedProbe>,
}

/// Determines near and far of a probe. `groups` holds all depth groups of the probe; `known` is an earlier scan of the same
/// images.
pub(super) fn depth_of_probe(
    plan: &Plan<'_>,
    groups: &[GroupPlan<'_>],
    known: Option<&Scan>,
    monitor: &dyn Monitor,
) -> Result<ProbeDepth> {
    let given = plan.given_range;
    if let [Some(near), Some(far)] = given {
        let range = DepthRange::new(near, far)?;
        return Ok(ProbeDepth { range, levels: Levels::default(), strays: None, scanned: None });
    }
    let probe = groups.first().map_or("", |group| plan.source.probes()[group.group.probe].name.as_str());
    let scanned = if known.is_none() { Some(scan_in_stage(plan, groups, monitor)?) } else { None };
    let scan = scanned.as_ref().map(|scanned| scanned.found.scan()).or_else(|| known.cloned()).unwrap_or_default();
    let range = found_range(probe, given, &scan)?;
    Ok(ProbeDepth { range, levels: scan.levels(range), strays: scan.spread.strays(range), scanned })
}

/// Keeps the planar depth of perspective views unconverted if a sensor recorded few distinct values: converted to distance along
/// the ray they would be many, so that levels could not be used. Checks the first frame of each group.
pub fn keep_few_planar_depths(source: &mut Source, settings: &EncodeSettings) {
    if !settings.finds_levels() || !source.converts_views() || !given_range(source, settings).contains(&None) {
        return;
    }
    let groups = selected_groups(source, settings);
    let mut depths = groups.into_iter().filter(|group| group.kind == StreamKind::Depth).peekable();
    let has_few = |group: &SourceGroup| {
        // A read error counts as no depth; the encoder reports it.
        let planes = source.read_depth_as_stored(group, group.frames.first).unwrap_or_default();
        let distances = Distances::new(true);
        distances.add(planes.iter().flat_map(|plane| plane.data().iter().copied()));
        distances.into_found().scan().distances_m.is_some_and(|found| !found.is_empty())
    };
    if depths.peek().is_some() && depths.all(has_few) {
        source.keep_kind_of_views();
    }
}

/// Combines the given bounds, at most one of near and far, with the extent found by a scan.
fn found_range(probe: &str, given: [Option<f32>; 2], found: &Scan) -> Result<DepthRange> {
    let Some(extent) = found.extent else {
        return match given[0].or(given[1]) {
            Some(bound) => DepthRange::new(bound, bound),
            None if found.has_invalid => Err(Error::invalid(format!(
                "probe {probe} has no valid depth, so invalid depth cannot be replaced by the nearest distance: set \
                `near`"
            ))),
            None => Ok(DepthRange::empty()),
        };
    };
    let (near, far) = (given[0].unwrap_or(extent.near_m), given[1].unwrap_or(extent.far_m));
    DepthRange::new(near, far).map_err(|_| {
        Error::Usage(format!(
            "probe {probe}: near {} m and far {} m hold no depth; values that were not given were measured, and \
            surfaces lie from {} m to {} m",
            metres_in_words(near),
            metres_in_words(far),
            metres_in_words(extent.near_m),
            metres_in_words(extent.far_m)
        ))
    })
}

#[derive(Debug)]
pub(super) struct ScannedProbe {
    pub found: FoundDepth,
    /// Planes by group index and frame.
    pub kept: HashMap<(usize, u32), Vec<DepthPlane>>,
    /// Total time over all threads of reading the kept images.
    pub reading: Duration,
    /// Total time over all threads of reading images that were not kept.
    pub scanning: Duration,
}

/// Runs [`scan_probe`] as its own stage of the monitor.
pub(super) fn scan_in_stage(plan: &Plan<'_>, groups: &[GroupPlan<'_>], monitor: &dyn Monitor) -> Result<ScannedProbe> {
    let limits = plan.scan_limits(groups)?;
    monitor.begin_stage("finding near and far", groups.iter().map(GroupPlan::images).sum());
    let scanned = scan_probe(plan.source, groups, limits, monitor);
    monitor.end_stage();
    scanned
}

/// Reads all depth images of a probe. The monitor advances by one per image.
pub(super) fn scan_probe(
    source: &dyn FrameSource,
    groups: &[GroupPlan<'_>],
    limits: ScanLimits,
    monitor: &dyn Monitor,
) -> Result<ScannedProbe> {
    struct ScannedFrame {
        extent: Option<DepthExtent>,
        has_invalid: bool,
        spread: Spread,
        reading: Duration,
        kept: Option<((usize, u32), Vec<DepthPlane>)>,
    }
    let (kept_bytes, distances) = (AtomicU64::new(0), Distances::new(limits.finds_levels));
    let jobs: Vec<_> =
        groups.iter().flat_map(|&group| group.group.frames.iter().map(move |frame| (group, frame))).collect();
    let frames = try_map_at_once(jobs, limits.frames_at_once, |(GroupPlan { at, group, .. }, frame)| {
        monitor.check()?;
        let start = Instant::now();
        let planes = source.read_depth(group, frame)?;
        let reading = start.elapsed();
        let extent = planes.iter().filter_map(DepthExtent::of).reduce(DepthExtent::union);
        let has_invalid = planes.iter().any(|plane| plane.data().contains(&0.0));
        distances.add(planes.iter().flat_map(|plane| plane.data().iter().copied()));
        let of_faces = planes.iter().zip(&group.faces).map(|(plane, &face)| Spread::of(plane, frame, face));
        let spread = of_faces.fold(Spread::default(), |all, of_face| all.union(&of_face));
        let bytes: u64 = planes.iter().map(|plane| plane.data().len() as u64 * 4).sum();
        let keep = kept_bytes.fetch_add(bytes, Ordering::Relaxed) + bytes <= limits.keep_bytes;
        monitor.advance(planes.len() as u64);
        let kept = keep.then_some(((at, frame), planes));
        Ok(ScannedFrame { extent, has_invalid, spread, reading, kept })
    })?;
    let time = |kept: bool| frames.iter().filter(|frame| frame.kept.is_some() == kept).map(|frame| frame.reading).sum();
    let (reading, scanning) = (time(true), time(false));
    let extent = frames.iter().filter_map(|frame| frame.extent).reduce(DepthExtent::union);
    if let Some(extent) = extent {
        DepthRange::new(extent.near_m, extent.far_m)?;
    }
    let has_invalid = frames.iter().any(|frame| frame.has_invalid);
    let spread = frames.iter().fold(Spread::default(), |all, frame| all.union(&frame.spread));
    let found = FoundDepth { extent, has_invalid, spread, ..distances.into_found() };
    let kept = frames.into_iter().filter_map(|frame| frame.kept).collect();
    Ok(ScannedProbe { found, kept, reading, scanning })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dataset::{SequenceLayout, SourceOptions};
    use crate::encode::DepthCodec;
    use crate::image_files::exr;
    use codec::image::Plane;
    use codec::monitor::Silent;

    #[test]
    fn the_first_bad_frame_is_named() {
        let folder = tempfile::tempdir().unwrap();
        for frame in 0..40 {
            let value = if [11, 12, 25, 39].contains(&frame) { -1.0 } else { 1.0 };
            exr::write_depth(&folder.path().join(format!("z.{frame}.exr")), &Plane::filled(2, 2, value)).unwrap();
        }
        let spec = folder.path().join("z.%d.exr");
        let (layout, options) = (SequenceLayout::default(), SourceOptions::default());
        let source = Source::from_sequence(StreamKind::Depth, spec.to_str().unwrap(), &layout, &options).unwrap();
        let settings = EncodeSettings::default();
        let plan = Plan::new(&source, &settings);
        for threads in [1, 2, 8, 8, 8, 8] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let scan = || scan_probe(&source, &plan.groups, ScanLimits::default(), &Silent);
            let error = pool.install(scan).unwrap_err();
            assert!(error.to_string().contains("z.11.exr"), "{error}");
        }
    }

    #[test]
    fn distances_are_looked_for_only_where_levels_are_of_use() {
        let folder = tempfile::tempdir().unwrap();
        exr::write_depth(&folder.path().join("z.0.exr"), &Plane::filled(16, 8, 2.0)).unwrap();
        let spec = folder.path().join("z.%d.exr");
        let (layout, options) = (SequenceLayout::default(), SourceOptions::default());
        let source = Source::from_sequence(StreamKind::Depth, spec.to_str().unwrap(), &layout, &options).unwrap();
        let found = |codec, epsilon| {
            let mut settings = EncodeSettings::default();
            (settings.depth.codec, settings.temporal.epsilon) = (codec, epsilon);
            let plan = Plan::new(&source, &settings);
            let limits = plan.scan_limits(&plan.groups).unwrap();
            scan_probe(&source, &plan.groups, limits, &Silent).unwrap().found.scan().distances_m
        };
        assert_eq!(found(DepthCodec::Predictive, 0), Some(vec![2.0]));
        assert_eq!(found(DepthCodec::Predictive, 1), None);
        assert_eq!(found(DepthCodec::Quadtree, 0), None);
    }
}
