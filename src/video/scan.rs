//! Finds how near and how far the surfaces of a probe are, reading each frame once where memory allows.

use std::collections::HashMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use rayon::prelude::*;

use crate::dataset::source::{Source, SourceGroup};
use crate::depth::quantise::DepthRange;
use crate::error::Result;
use crate::image::plane::DepthPlane;
use crate::monitor::Monitor;

/// Frames that the scan may keep so that encoding need not read them again.
const KEEP_BYTES: u64 = 512 << 20;

/// What a scan found.
#[derive(Debug)]
pub struct ProbeScan {
    /// Nearest and farthest surface; empty range where there is none.
    pub range: DepthRange,
    /// Images kept, by index of the group and frame.
    pub kept: HashMap<(usize, u32), Vec<DepthPlane>>,
    /// Time that threads spent reading.
    pub reading: Duration,
}

/// Scans all depth `groups` (with their indices) of one probe.
pub fn scan_probe(source: &Source, groups: &[(usize, &SourceGroup)], monitor: &dyn Monitor) -> Result<ProbeScan> {
    let budget = AtomicU64::new(0);
    let jobs: Vec<_> =
        groups.iter().flat_map(|&(at, group)| group.frames.iter().map(move |frame| (at, group, frame))).collect();
    let scanned: Vec<_> = jobs
        .into_par_iter()
        .map(|(at, group, frame)| {
            monitor.check()?;
            let start = std::time::Instant::now();
            let planes = source.read_depth(group, frame)?;
            let reading = start.elapsed();
            let extent = planes.iter().filter_map(extent).reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)));
            let bytes: u64 = planes.iter().map(|plane| plane.data().len() as u64 * 4).sum();
            let keep = budget.fetch_add(bytes, Ordering::Relaxed) + bytes <= KEEP_BYTES;
            Ok((extent, reading, keep.then_some(((at, frame), planes))))
        })
        .collect::<Result<_>>()?;
    let reading = scanned.iter().map(|(_, reading, _)| *reading).sum();
    let extent = scanned.iter().filter_map(|(extent, ..)| *extent).reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)));
    let range = match extent {
        Some((near, far)) => DepthRange::new(near, far)?,
        None => DepthRange::empty(),
    };
    Ok(ProbeScan { range, kept: scanned.into_iter().filter_map(|(.., kept)| kept).collect(), reading })
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
