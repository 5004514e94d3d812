//! Units that rays from cameras can look up (CALF 6.2).
//!
//! A ray looks up points in front of and behind the surfaces of a view. Points nearer to the centre of the view than its near
//! distance need no texel; beyond it, the unit under a point is needed at any distance. Therefore the frusta of units begin at
//! near but do not end at far, unlike those of [`crate::views::camera_units`]. With these frusta, and a margin for lookups around
//! a point, rendering gives the same images as with all units.

use std::collections::HashMap;

use rayon::prelude::*;

use crate::views::{DepthSpan, FaceImage, UnitGrid, cull};
use codec::container::ProbeEntry;
use codec::decode::{Decoder, StreamInfo, UnitFilter};
use codec::image::{DepthKind, Face};
use codec::math::{Camera, Viewer};
use codec::streams::CodecHeader;

/// Margin around a unit in pixels: half a pixel for bilinear lookups, one more for the texels next to these, and the rest for
/// rounding.
const MARGIN_PIXELS: f64 = 2.0;
/// Fraction of near at which frusta begin, because rays compute distances in single precision.
const NEAR_PART: f64 = 0.99;

#[derive(Debug, Clone, Default, PartialEq)]
pub struct VisibleSet {
    /// For each stream index, whether each unit is visible.
    streams: HashMap<u32, Vec<bool>>,
}

impl UnitFilter for VisibleSet {
    /// Streams outside the request have no visible units.
    fn wants(&self, stream: &StreamInfo, unit: u32, _frame: u32) -> bool {
        self.streams.get(&stream.index).and_then(|units| units.get(unit as usize)).is_some_and(|seen| *seen)
    }
}

/// Finds visible sets, and caches the last one.
#[derive(Debug)]
pub struct VisibleSets<'a> {
    decoder: &'a Decoder,
    /// Minimum distance of a surface of each probe, in metres.
    near_m: HashMap<usize, f64>,
    cameras: Vec<Camera>,
    seen: VisibleSet,
}

impl<'a> VisibleSets<'a> {
    pub fn new(decoder: &'a Decoder) -> VisibleSets<'a> {
        let mut near_m = HashMap::new();
        for stream in decoder.streams() {
            if let CodecHeader::Depth(header) = &stream.header {
                let nearest = near_m.entry(stream.probe).or_insert(f64::INFINITY);
                *nearest = f64::from(header.range.near_m()).min(*nearest);
            }
        }
        VisibleSets { decoder, near_m, cameras: Vec::new(), seen: VisibleSet::default() }
    }

    /// Returns the visible set of `streams`. Results for the same cameras are reused.
    pub fn find(&mut self, streams: &[&StreamInfo], cameras: &[Camera]) -> &VisibleSet {
        if self.cameras != cameras {
            self.cameras = cameras.to_vec();
            self.seen.streams.clear();
        }
        let viewers: Vec<Viewer> = cameras.iter().map(|camera| Viewer::new(camera.sight_lines())).collect();
        let new: Vec<&&StreamInfo> =
            streams.iter().filter(|stream| !self.seen.streams.contains_key(&stream.index)).collect();
        let found: Vec<_> = new.par_iter().map(|stream| (stream.index, self.units(stream, &viewers))).collect();
        self.seen.streams.extend(found);
        &self.seen
    }

    fn units(&self, stream: &StreamInfo, viewers: &[Viewer]) -> Vec<bool> {
        let entry = &stream.entry;
        // The directions of a moving probe differ from frame to frame, so all its units are visible.
        if self.decoder.moves(stream) {
            return vec![true; entry.unit_count() as usize];
        }
        let near_m = self.near_m.get(&stream.probe).copied().unwrap_or(0.0);
        let grid = UnitGrid { size: [entry.width, entry.height], unit: [entry.unit_width, entry.unit_height] };
        visible_units(self.decoder.probe(stream), near_m, stream.face, grid, viewers)
    }
}

/// Returns whether each unit of a face is visible; all are if its directions are unknown. `near_m` is the minimum distance of a
/// surface of the probe, in metres.
pub fn visible_units(probe: &ProbeEntry, near_m: f64, face: Face, grid: UnitGrid, viewers: &[Viewer]) -> Vec<bool> {
    // Near is a distance for both kinds of depth: a point may have a planar depth below near, but be farther away.
    let span = DepthSpan { near_m: NEAR_PART * near_m, far_m: f64::INFINITY, kind: DepthKind::Distance };
    match FaceImage::new(probe, face, grid.size, span) {
        None => vec![true; grid.shape().map(|side| side as usize).iter().product()],
        Some(image) => {
            let culled = cull(&image.with_margin(MARGIN_PIXELS), grid, viewers);
            culled.seen_by.iter().map(Option::is_some).collect()
        }
    }
}
