//! The units that rays from cameras can ask for (CALF 6.2).
//!
//! A ray asks a view about points before the surfaces that it sees, and behind them. Nearer to its centre than its near
//! plane, the answer is known without a texel ([`crate::march::active_views`]); from there on, up to any distance, the unit must
//! be there into which a point falls. So units are cut off at near, but, other than in [`crate::views::seen_units`], not at far. With
//! that, and a margin of a pixel for the four texels that a colour is from, pictures are the same as with all units.

use std::collections::HashMap;

use rayon::prelude::*;

use crate::dataset::stream::DepthKind;
use crate::decode::{Decoder, StreamInfo, UnitFilter};
use crate::math::{Camera, Viewer};
use crate::streams::CodecHeader;
use crate::views::face_frustum::{DepthSpan, FaceImage};
use crate::views::visibility::{UnitGrid, cull};

/// Pixels around a unit that count as its own: half a pixel for colours between pixels, the rest for rounding.
const MARGIN_PIXELS: f64 = 1.0;
/// Part of near at which units begin, as rays compute distances in single precision.
const NEAR_PART: f64 = 0.99;

/// Units in the sight of cameras.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct UnitsInSight {
    /// Of streams by their number, whether each unit is seen.
    streams: HashMap<u32, Vec<bool>>,
}

impl UnitFilter for UnitsInSight {
    /// Units of streams that were not asked for are not wanted.
    fn wants(&self, stream: &StreamInfo, unit: u32, _frame: u32) -> bool {
        self.streams.get(&stream.index).and_then(|units| units.get(unit as usize)).is_some_and(|seen| *seen)
    }
}

/// Finds units in sight, shot by shot.
#[derive(Debug)]
pub struct SightLines<'a> {
    decoder: &'a Decoder,
    /// The nearest surface of each probe, in metres of distance.
    near_m: HashMap<usize, f64>,
    cameras: Vec<Camera>,
    seen: UnitsInSight,
}

impl<'a> SightLines<'a> {
    /// For the streams of a container.
    pub fn new(decoder: &'a Decoder) -> SightLines<'a> {
        let mut near_m = HashMap::new();
        for stream in decoder.streams() {
            if let CodecHeader::Depth(header) = stream.header {
                let nearest = near_m.entry(stream.probe).or_insert(f64::INFINITY);
                *nearest = f64::from(header.range.near_m()).min(*nearest);
            }
        }
        SightLines { decoder, near_m, cameras: Vec::new(), seen: UnitsInSight::default() }
    }

    /// The units of `streams` that `cameras` see. What was found for the same cameras is not found again.
    pub fn seen(&mut self, streams: &[&StreamInfo], cameras: &[Camera]) -> &UnitsInSight {
        if self.cameras != cameras {
            self.cameras = cameras.to_vec();
            self.seen.streams.clear();
        }
        let viewers: Vec<Viewer> = cameras.iter().map(|camera| Viewer::new(camera.sight_lines())).collect();
        let new: Vec<&&StreamInfo> =
            streams.iter().filter(|stream| !self.seen.streams.contains_key(&stream.index)).collect();
        let found: Vec<_> = new.par_iter().map(|stream| (stream.index, self.find(stream, &viewers))).collect();
        self.seen.streams.extend(found);
        &self.seen
    }

    fn find(&self, stream: &StreamInfo, viewers: &[Viewer]) -> Vec<bool> {
        let entry = &stream.entry;
        let near_m = self.near_m.get(&stream.probe).copied().unwrap_or(0.0);
        // As a distance, whatever the stream has: a point whose planar depth is less than near may be farther off.
        let span = DepthSpan { near_m: NEAR_PART * near_m, far_m: f64::INFINITY, kind: DepthKind::Distance };
        let size = [entry.width, entry.height];
        match FaceImage::new(self.decoder.probe(stream), stream.face, size, span) {
            None => vec![true; entry.unit_count() as usize],
            Some(image) => {
                let grid = UnitGrid { size, unit: [entry.unit_width, entry.unit_height] };
                let culled = cull(&image.with_margin(MARGIN_PIXELS), grid, viewers);
                culled.seen_by.iter().map(Option::is_some).collect()
            }
        }
    }
}
