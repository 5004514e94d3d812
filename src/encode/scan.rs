//! Finds how near and how far the surfaces of a probe are, reading each frame once where memory allows.

use std::collections::HashMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use crate::dataset::source::{Source, SourceGroup};
use crate::depth::quantise::DepthRange;
use crate::error::Result;
use crate::image::plane::DepthPlane;
use crate::monitor::Monitor;
use crate::ordered::try_map_at_once;

/// Frames that a scan usually keeps so that encoding need not read them again.
pub const KEEP_BYTES: u64 = 512 << 20;

/// How much of a probe a scan holds.
#[derive(Debug, Clone, Copy)]
pub struct ScanLimits {
    /// Bytes of images that are kept.
    pub keep_bytes: u64,
    /// Frames that are read at once.
    pub frames_at_once: usize,
}

impl Default for ScanLimits {
    fn default() -> Self {
        ScanLimits { keep_bytes: KEEP_BYTES, frames_at_once: usize::MAX }
    }
}

/// What a scan found.
#[derive(Debug)]
pub struct ProbeScan {
    /// Nearest and farthest surface, if there is any.
    pub range: Option<DepthRange>,
    /// Whether there are invalid readings that are to be taken as near.
    pub taken_as_near: bool,
    /// Images kept, by index of the group and frame.
    pub kept: HashMap<(usize, u32), Vec<DepthPlane>>,
    /// Time that threads spent reading the images that were kept.
    pub reading: Duration,
    /// Time that threads spent reading images that encoding will have to read again.
    pub scanning: Duration,
}

/// Scans all depth `groups` (with their indices) of one probe.
///
/// # Errors
/// Of all images that cannot be read, the first in the order of groups and frames is named, whichever thread came
/// upon one first.
pub fn scan_probe(
    source: &Source,
    groups: &[(usize, &SourceGroup)],
    limits: ScanLimits,
    monitor: &dyn Monitor,
) -> Result<ProbeScan> {
    let budget = AtomicU64::new(0);
    let jobs: Vec<_> =
        groups.iter().flat_map(|&(at, group)| group.frames.iter().map(move |frame| (at, group, frame))).collect();
    let scanned = try_map_at_once(jobs, limits.frames_at_once, |(at, group, frame)| {
        monitor.check()?;
        let start = std::time::Instant::now();
        let planes = source.read_depth(group, frame)?;
        let reading = start.elapsed();
        let extent = planes.iter().filter_map(extent).reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)));
        let bytes: u64 = planes.iter().map(|plane| plane.data().len() as u64 * 4).sum();
        let keep = budget.fetch_add(bytes, Ordering::Relaxed) + bytes <= limits.keep_bytes;
        let taken_as_near = planes.iter().any(|plane| plane.data().contains(&0.0));
        Ok(Scanned { extent, taken_as_near, reading, kept: keep.then_some(((at, frame), planes)) })
    })?;
    let extent = scanned.iter().filter_map(|scanned| scanned.extent).reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)));
    let read = |kept: bool| {
        let frames = scanned.iter().filter(|scanned| scanned.kept.is_some() == kept);
        frames.map(|scanned| scanned.reading).sum::<Duration>()
    };
    let (reading, scanning) = (read(true), read(false));
    Ok(ProbeScan {
        range: extent.map(|(near, far)| DepthRange::new(near, far)).transpose()?,
        taken_as_near: scanned.iter().any(|scanned| scanned.taken_as_near),
        reading,
        scanning,
        kept: scanned.into_iter().filter_map(|scanned| scanned.kept).collect(),
    })
}

/// What one frame of one group held.
struct Scanned {
    extent: Option<(f32, f32)>,
    taken_as_near: bool,
    reading: Duration,
    kept: Option<((usize, u32), Vec<DepthPlane>)>,
}

/// Smallest and largest depth of the surfaces of an image; 0 marks an invalid reading and is none.
pub fn extent(plane: &DepthPlane) -> Option<(f32, f32)> {
    let (mut near, mut far) = (f32::INFINITY, 0.0f32);
    for &z in plane.data() {
        let surface = z > 0.0 && z < f32::INFINITY;
        near = if surface && z < near { z } else { near };
        far = if surface && z > far { z } else { far };
    }
    (near <= far).then_some((near, far))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dataset::source::{SequenceLayout, SourceOptions};
    use crate::dataset::stream::StreamKind;
    use crate::image::{Plane, exr};
    use crate::monitor::Silent;

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
        let limits = ScanLimits::default();
        for threads in [1, 2, 8, 8, 8, 8] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let error = pool.install(|| scan_probe(&source, &[(0, &source.groups()[0])], limits, &Silent)).unwrap_err();
            assert!(error.to_string().contains("z.11.exr"), "{error}");
        }
    }
}
