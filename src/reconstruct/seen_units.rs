//! The units of a container that cameras see, as a filter for decoding (CALF 6.2).

use std::collections::HashMap;

use rayon::prelude::*;

use crate::image::cube::Face;
use crate::image::sequence::FrameRange;
use crate::math::Viewer;
use crate::reconstruct::camera_file::TimedCamera;
use crate::reconstruct::face_image::{DepthSpan, FaceImage};
use crate::reconstruct::visibility::{UnitGrid, cull};
use crate::video::codec::CodecHeader;
use crate::video::decode::{Decoder, StreamInfo};
use crate::video::export::Chosen;
use crate::video::unit_filter::UnitFilter;

/// What finding them came to.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct SeenCounts {
    /// Cameras.
    pub cameras: u64,
    /// Units of the streams that were asked for.
    pub units: u64,
    /// Those that a camera sees in a frame that was asked for.
    pub visible_units: u64,
    /// Tests of a unit against a camera, were each made.
    pub regular_tests: u64,
    /// Tests that were made.
    pub hierarchical_tests: u64,
}

/// The units that cameras see, of some streams; of the others all.
#[derive(Debug, Clone, Default)]
pub struct SeenUnits {
    /// Of streams by their number, for each unit the frames in which it is seen: ranges in order, with gaps between.
    streams: HashMap<u32, Vec<Vec<FrameRange>>>,
    counts: SeenCounts,
}

impl SeenUnits {
    /// What `cameras` see of what was chosen.
    ///
    /// Near and far are those of the depth stream of the same probe and face; where there is none, or none of all the
    /// frames, a unit is seen where anything in its directions could be. Images of which no directions are known are
    /// seen always.
    pub fn find(decoder: &Decoder, chosen: &[Chosen<'_>], cameras: &[TimedCamera]) -> SeenUnits {
        let viewers: Vec<Viewer> = cameras.iter().map(|timed| Viewer::new(timed.camera.frustum())).collect();
        let spans = depth_spans(decoder);
        let of_stream = |&(stream, frames): &Chosen<'_>| {
            let span = match spans.get(&(stream.probe, stream.face)) {
                Some((covered, span)) if covered.intersect(frames) == Some(frames) => *span,
                _ => DepthSpan::unknown(),
            };
            let entry = &stream.entry;
            let size = [entry.width, entry.height];
            let units = u64::from(entry.unit_count());
            let mut counts = SeenCounts { units, ..SeenCounts::default() };
            let seen = match FaceImage::new(decoder.probe(stream), stream.face, size, span) {
                None => vec![vec![frames]; units as usize],
                Some(image) => {
                    let grid = UnitGrid { size, unit: [entry.unit_width, entry.unit_height] };
                    let culled = cull(&image, grid, &viewers);
                    counts.regular_tests = units * viewers.len() as u64;
                    counts.hierarchical_tests = culled.tests;
                    culled.seen_by.iter().map(|seen_by| seen_frames(seen_by, cameras, frames)).collect()
                }
            };
            counts.visible_units = seen.iter().filter(|frames| !frames.is_empty()).count() as u64;
            (stream.index, seen, counts)
        };
        let mut all = SeenUnits::default();
        all.counts.cameras = cameras.len() as u64;
        for (stream, seen, counts) in chosen.par_iter().map(of_stream).collect::<Vec<_>>() {
            all.counts.units += counts.units;
            all.counts.visible_units += counts.visible_units;
            all.counts.regular_tests += counts.regular_tests;
            all.counts.hierarchical_tests += counts.hierarchical_tests;
            all.streams.insert(stream, seen);
        }
        all
    }

    /// What finding them came to.
    pub fn counts(&self) -> SeenCounts {
        self.counts
    }
}

impl UnitFilter for SeenUnits {
    fn wants(&self, stream: &StreamInfo, unit: u32, frame: u32) -> bool {
        let Some(seen) = self.streams.get(&stream.index).and_then(|units| units.get(unit as usize)) else {
            return true;
        };
        let after = seen.partition_point(|frames| frames.first <= frame);
        after.checked_sub(1).is_some_and(|at| frame <= seen[at].last)
    }
}

/// Frames, near and far of the depth stream of each probe and face that has one.
fn depth_spans(decoder: &Decoder) -> HashMap<(usize, Face), (FrameRange, DepthSpan)> {
    let span = |stream: &StreamInfo| match stream.header {
        CodecHeader::Depth(header) => {
            let (near_m, far_m) = (f64::from(header.range.near_m()), f64::from(header.range.far_m()));
            let span = DepthSpan { near_m, far_m, kind: header.kind };
            Some(((stream.probe, stream.face), (stream.frames, span)))
        }
        _ => None,
    };
    decoder.streams().iter().filter_map(span).collect()
}

/// The frames of `wanted` in which one of some cameras looks, as ranges in order, joined where they touch.
fn seen_frames(seen_by: &[u32], cameras: &[TimedCamera], wanted: FrameRange) -> Vec<FrameRange> {
    let looks = |camera: &u32| cameras[*camera as usize].frames.map_or(Some(wanted), |frames| frames.intersect(wanted));
    let mut ranges: Vec<FrameRange> = seen_by.iter().filter_map(looks).collect();
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
    use crate::math::{Camera, Lens};

    #[test]
    fn frames_of_cameras_are_joined() {
        let camera = Camera::look_at(DVec3::ZERO, DVec3::X, DVec3::Y, Lens::new(60.0)).unwrap();
        let timed = |frames: Option<[u32; 2]>| TimedCamera {
            camera,
            frames: frames.map(|[first, last]| FrameRange { first, last }),
        };
        let cameras = [[5, 7], [0, 2], [3, 3], [9, 20], [6, 6], [30, 40]].map(|frames| timed(Some(frames)));
        let wanted = FrameRange { first: 1, last: 12 };
        let joined = seen_frames(&[0, 1, 2, 3, 4, 5], &cameras, wanted);
        let ranges: Vec<_> = joined.iter().map(|frames| [frames.first, frames.last]).collect();
        assert_eq!(ranges, [[1, 3], [5, 7], [9, 12]]);
        assert!(seen_frames(&[5], &cameras, wanted).is_empty());
        assert!(seen_frames(&[], &cameras, wanted).is_empty());
        assert_eq!(seen_frames(&[0, 1], &[timed(Some([2, 2])), timed(None)], wanted), [wanted]);
    }
}
