//! Units in the frusta of cameras, as a filter for decoding (CALF 6.2).
//!
//! The frustum of a unit passes through the corners of its rectangle, from near to far of the depth stream of the same face;
//! without a depth stream, from the probe to infinity. Tests are conservative: a visible unit is never missed.

use std::collections::HashMap;

use rayon::prelude::*;

use serde::Serialize;

use crate::camera_path::TimedCamera;
use crate::views::{DepthSpan, FaceImage, UnitGrid, cull};
use codec::decode::{Decoder, StreamFrames, StreamInfo, UnitFilter};
use codec::image::{Face, FrameRange};
use codec::math::{Viewer, add_members};
use codec::streams::CodecHeader;

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct CameraUnitCounts {
    pub cameras: u64,
    /// Units of the chosen streams.
    pub units: u64,
    /// Units that a camera sees in a chosen frame.
    pub visible_units: u64,
    /// Number of frustum tests without the quadtree: each unit is tested up to the first camera that sees it.
    #[serde(skip)]
    pub regular_tests: u64,
    #[serde(skip)]
    pub hierarchical_tests: u64,
}

/// Visibility of a container's units from cameras, as a JSON report.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CameraUnitsReport {
    #[serde(flatten)]
    counts: CameraUnitCounts,
    pub visible_fraction: f64,
    frustum_tests: FrustumTests,
    /// Stored bytes of all units.
    pub bytes_total: u64,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
struct FrustumTests {
    regular: u64,
    hierarchical: u64,
}

add_members!(CameraUnitCounts: cameras, units, visible_units, regular_tests, hierarchical_tests);

impl CameraUnitCounts {
    pub fn report(&self, bytes_total: u64) -> CameraUnitsReport {
        CameraUnitsReport {
            counts: *self,
            visible_fraction: self.visible_units as f64 / self.units.max(1) as f64,
            frustum_tests: FrustumTests { regular: self.regular_tests, hierarchical: self.hierarchical_tests },
            bytes_total,
        }
    }
}

/// Units that cameras see, for some streams; all units of other streams are wanted.
#[derive(Debug, Clone, Default)]
pub struct CameraUnits {
    /// For each stream index and unit, the frames in which the unit is seen: ordered ranges with gaps between them.
    streams: HashMap<u32, Vec<Vec<FrameRange>>>,
    pub counts: CameraUnitCounts,
}

impl CameraUnits {
    /// Returns the units of the chosen streams and frames that `cameras` see.
    ///
    /// Near and far are those of the depth stream of the same probe and face. If there is none, or it does not have all the
    /// frames, a unit counts as seen if anything in its directions could be seen. Images without known directions are always
    /// seen.
    pub fn find(decoder: &Decoder, chosen: &[StreamFrames<'_>], cameras: &[TimedCamera]) -> CameraUnits {
        let groups = groups(cameras);
        let spans = depth_spans(decoder);
        let of_stream = |&StreamFrames { stream, frames }: &StreamFrames<'_>| {
            let span = match spans.get(&(stream.probe, stream.face)) {
                Some((covered, span)) if covered.intersect(frames) == Some(frames) => *span,
                _ => DepthSpan::unknown(),
            };
            let entry = &stream.entry;
            let size = [entry.width, entry.height];
            let units = u64::from(entry.unit_count());
            let mut counts = CameraUnitCounts { units, ..CameraUnitCounts::default() };
            let image = FaceImage::new(decoder.probe(stream), stream.face, size, span);
            // The directions of a moving probe differ from frame to frame, so all its units count as seen.
            let seen = match image.filter(|_| !decoder.moves(stream)) {
                None => vec![vec![frames]; units as usize],
                Some(image) => {
                    let grid = UnitGrid { size, unit: [entry.unit_width, entry.unit_height] };
                    let mut seen = vec![Vec::new(); units as usize];
                    for (looking, viewers) in &groups {
                        let Some(looking) = looking.map_or(Some(frames), |looking| looking.intersect(frames)) else {
                            continue;
                        };
                        let culled = cull(&image, grid, viewers);
                        counts.regular_tests += culled.regular_tests(viewers.len());
                        counts.hierarchical_tests += culled.tests;
                        let units = seen.iter_mut().zip(&culled.seen_by).filter(|(_, first)| first.is_some());
                        units.for_each(|(seen, _)| seen.push(looking));
                    }
                    seen.into_iter().map(joined).collect()
                }
            };
            counts.visible_units = seen.iter().filter(|frames| !frames.is_empty()).count() as u64;
            (stream.index, seen, counts)
        };
        let mut all = CameraUnits::default();
        all.counts.cameras = cameras.len() as u64;
        for (stream, seen, counts) in chosen.par_iter().map(of_stream).collect::<Vec<_>>() {
            all.counts = all.counts + counts;
            all.streams.insert(stream, seen);
        }
        all
    }
}

impl UnitFilter for CameraUnits {
    fn wants(&self, stream: &StreamInfo, unit: u32, frame: u32) -> bool {
        let Some(seen) = self.streams.get(&stream.index).and_then(|units| units.get(unit as usize)) else {
            return true;
        };
        let after = seen.partition_point(|frames| frames.first <= frame);
        after.checked_sub(1).is_some_and(|at| frame <= seen[at].last)
    }
}

/// Returns the frames, near and far of the depth stream of each probe and face that has one.
fn depth_spans(decoder: &Decoder) -> HashMap<(usize, Face), (FrameRange, DepthSpan)> {
    let span = |stream: &StreamInfo| match &stream.header {
        CodecHeader::Depth(header) => {
            let (near_m, far_m) = (f64::from(header.range.near_m()), f64::from(header.range.far_m()));
            let span = DepthSpan { near_m, far_m, kind: header.kind };
            Some(((stream.probe, stream.face), (stream.frames, span)))
        }
        _ => None,
    };
    decoder.streams().iter().filter_map(span).collect()
}

/// Groups cameras with the same frames, in the order of their first camera.
fn groups(cameras: &[TimedCamera]) -> Vec<(Option<FrameRange>, Vec<Viewer>)> {
    let mut groups: Vec<(Option<FrameRange>, Vec<Viewer>)> = Vec::new();
    let mut places = HashMap::new();
    for timed in cameras {
        let at = *places.entry(timed.frames).or_insert_with(|| {
            groups.push((timed.frames, Vec::new()));
            groups.len() - 1
        });
        groups[at].1.push(Viewer::new(timed.camera.frustum()));
    }
    groups
}

/// Returns frame ranges in order, joined if they overlap or touch.
fn joined(mut ranges: Vec<FrameRange>) -> Vec<FrameRange> {
    ranges.sort_unstable_by_key(|frames| frames.first);
    let mut joined: Vec<FrameRange> = Vec::new();
    for frames in ranges {
        match joined.last_mut() {
            Some(last) if frames.first <= last.last.saturating_add(1) => last.last = last.last.max(frames.last),
            _ => joined.push(frames),
        }
    }
    joined
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use codec::math::{Camera, Lens};

    #[test]
    fn ranges_are_joined() {
        let range = |[first, last]: [u32; 2]| FrameRange { first, last };
        let ranges = [[5, 7], [1, 2], [3, 3], [9, 12], [6, 6]].map(range);
        assert_eq!(joined(ranges.to_vec()), [[1, 3], [5, 7], [9, 12]].map(range));
        assert!(joined(Vec::new()).is_empty());
        let end = range([4, u32::MAX]);
        assert_eq!(joined(vec![end, end]), [end]);
    }

    #[test]
    fn cameras_of_the_same_frames_are_grouped() {
        let frames = [None, Some(FrameRange { first: 2, last: 3 }), None];
        let cameras = frames.map(|frames| {
            let camera = Camera::look_at(DVec3::ZERO, DVec3::X, DVec3::Y, Lens::new(60.0)).unwrap();
            TimedCamera { camera, frames }
        });
        let groups: Vec<_> = groups(&cameras).iter().map(|(frames, viewers)| (*frames, viewers.len())).collect();
        assert_eq!(groups, [(frames[0], 2), (frames[1], 1)]);
    }
}
