//! Error bound of the depth of each probe, and the few outlier pixels that widen the range and so loosen the bound for all
//! others.

use std::path::PathBuf;

use serde::Serialize;

use crate::depth_bound::DepthBound;
use crate::encode::source::FrameSource;
use crate::json::Number;
use codec::depth::DepthRange;
use codec::depth::spread::{PlacedDepth, Spread, Strays};
use codec::image::{Face, StreamKind};
use codec::streams::DepthHeader;

#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ProbePrecision {
    pub probe: String,
    #[serde(flatten)]
    pub bound: DepthBound,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub strays: Option<NamedStrays>,
}

/// Outlier pixels that take more than a quarter of the precision.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct NamedStrays {
    pub pixels: u64,
    pub of_pixels: u64,
    /// Examples of the nearest outliers, then of the farthest.
    pub first: Vec<NamedPixel>,
    /// Depth bound of all other pixels, with the same bound in codes.
    pub without: DepthBound,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct NamedPixel {
    /// Image file of the pixel; `None` for frames in memory.
    pub file: Option<PathBuf>,
    pub frame: u32,
    pub face: &'static str,
    pub x: u32,
    pub y: u32,
    pub depth_m: Number,
}

impl ProbePrecision {
    pub(super) fn new(
        source: &dyn FrameSource,
        probe: usize,
        header: &DepthHeader,
        strays: Option<&Strays>,
    ) -> ProbePrecision {
        let bound = DepthBound::of(header);
        // Levels are exact regardless of the range, so outliers do not matter.
        ProbePrecision::named(source, probe, bound, strays.filter(|_| header.levels() == 0))
    }

    fn named(source: &dyn FrameSource, probe: usize, bound: DepthBound, strays: Option<&Strays>) -> ProbePrecision {
        let named = |strays: &Strays| NamedStrays {
            pixels: strays.pixels,
            of_pixels: strays.of_pixels,
            first: strays.named.iter().map(|place| named(source, probe, place)).collect(),
            without: DepthBound { range: strays.without, ..bound },
        };
        ProbePrecision { probe: source.probes()[probe].name.clone(), bound, strays: strays.map(named) }
    }
}

/// Returns the outlier pixels of a probe that would take much of the precision of a lossless encode; `None` if there are none, or
/// if near and far are given.
pub fn strays_of(source: &dyn FrameSource, probe: usize, spread: &Spread) -> Option<ProbePrecision> {
    let ([given_near, given_far], found) = (source.stated_range(), spread.range()?);
    if given_near.is_some() && given_far.is_some() {
        return None;
    }
    let [near, far] = [given_near.unwrap_or(found.near_m()), given_far.unwrap_or(found.far_m())];
    let range = DepthRange::new(near, far).ok()?;
    let strays = spread.strays(range)?;
    Some(ProbePrecision::named(source, probe, DepthBound { range, codes: Some(0) }, Some(&strays)))
}

fn named(source: &dyn FrameSource, probe: usize, place: &PlacedDepth) -> NamedPixel {
    let PlacedDepth { frame, face, x, y, depth_m } = *place;
    let face = Face::from_index(face).unwrap_or(Face::View);
    let of_pixel = source.groups().iter().find(|group| {
        (group.kind, group.probe) == (StreamKind::Depth, probe)
            && group.faces.contains(&face)
            && group.frames.contains(frame)
    });
    let file = of_pixel.and_then(|group| source.files(group, frame).ok()?.into_iter().next());
    NamedPixel { file, frame, face: face.name(), x, y, depth_m: Number::shortest(depth_m) }
}
