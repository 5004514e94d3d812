//! Error bounds of a comparison, and the bounds that are exceeded.

use serde::Serialize;

use crate::compare::comparison::Comparison;
use crate::compare::difference::Lowest;
use crate::compare::pairing::Pairing;
use crate::metrics::depth_error::Spot;
use codec::error::{Error, Result};
use codec::image::StreamKind;

#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Bounds {
    /// Maximum error: codes of depth, 8-bit codes of material and alpha.
    pub max_error: Option<u16>,
    /// Minimum PSNR of a frame of a colour stream, in dB.
    pub min_psnr_db: Option<f64>,
    /// Minimum PSNR of a colour cell in one frame, in dB.
    pub min_cell_psnr_db: Option<f64>,
    /// Minimum quality of a colour cell in one frame.
    pub min_quality: Option<f64>,
    pub exact: bool,
    /// Accepts colour values that 8 bits clip.
    pub allow_clipping: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Bound {
    MaxError,
    MinPsnr,
    MinCellPsnr,
    MinQuality,
    /// No pixel may be clipped.
    Clipping,
}

/// An exceeded bound, at its largest excess.
#[derive(Debug, Clone, PartialEq)]
pub struct Violation {
    pub bound: Bound,
    /// Value of the bound: codes, dB, quality or pixels.
    pub limit: f64,
    pub measured: f64,
    pub stream: usize,
    /// The pixel, or the frame and the upper left corner of the cell.
    pub spot: Option<Spot>,
}

#[derive(Debug, Clone, PartialEq)]
pub struct Judgement {
    pub equal: bool,
    /// True if all bounds hold and no stream or frame is missing.
    pub within_bounds: bool,
    /// True if a bound is exceeded, if streams or frames are missing although there is a bound, or if `exact` is required and the
    /// sides are not equal.
    pub failed: bool,
    /// True if there are bounds other than `exact`.
    pub bounded: bool,
    pub violations: Vec<Violation>,
}

impl Bounds {
    /// Fails if a bound applies to no stream of either side.
    pub fn check(&self, pairing: &Pairing<'_>) -> Result<()> {
        let missing = pairing.missing.iter().map(|missing| missing.id.kind);
        let kinds: Vec<StreamKind> = pairing.pairs.iter().map(|pair| pair.streams[0].id.kind).chain(missing).collect();
        let [has_color, has_codes] =
            [true, false].map(|is_color| kinds.iter().any(|kind| (*kind == StreamKind::Color) == is_color));
        let of_color = ["min_psnr", "min_cell_psnr", "min_quality"].into_iter().zip(self.of_color());
        let color = of_color.filter(|(_, bound)| bound.is_some() && !has_color).map(|(name, _)| (name, "colour"));
        let codes = self.max_error.filter(|_| !has_codes).map(|_| ("max_error", "depth, material or alpha"));
        match codes.into_iter().chain(color).next() {
            Some((name, kind)) => Err(Error::Usage(format!("`{name}`: no stream of {kind} is compared: leave it out"))),
            None => Ok(()),
        }
    }

    pub fn judge(&self, comparison: &Comparison) -> Judgement {
        let mut violations = self.errors_beyond(comparison);
        violations.extend(self.color_below(comparison));
        let clipped = comparison.clipped().filter(|_| !self.allow_clipping);
        violations.extend(clipped.map(|(stream, pixels)| Violation {
            bound: Bound::Clipping,
            limit: 0.0,
            measured: pixels as f64,
            stream,
            spot: None,
        }));
        let bounded = self.max_error.is_some() || self.of_color().into_iter().any(|bound| bound.is_some());
        let (equal, complete) = (comparison.equal(), comparison.missing.is_empty());
        Judgement {
            equal,
            within_bounds: violations.is_empty() && complete,
            failed: !violations.is_empty() || (bounded && !complete) || (self.exact && !equal),
            bounded,
            violations,
        }
    }

    fn errors_beyond(&self, comparison: &Comparison) -> Vec<Violation> {
        let Some(limit) = self.max_error else { return Vec::new() };
        let depth = comparison.depth().map(|(errors, stream)| (u32::from(errors.max_error_codes), stream));
        let bytes = [StreamKind::Material, StreamKind::Alpha].into_iter().filter_map(|kind| comparison.samples(kind));
        let bytes = bytes.map(|total| (total.max_error, total.worst));
        let beyond = depth.into_iter().chain(bytes).filter(|(measured, _)| *measured > u32::from(limit));
        let violation = |(measured, stream): (u32, Option<usize>)| {
            let (stream, measured, limit) = (stream?, f64::from(measured), f64::from(limit));
            let spot = comparison.streams[stream].worst().map(|(spot, _)| spot);
            Some(Violation { bound: Bound::MaxError, limit, measured, stream, spot })
        };
        beyond.filter_map(violation).collect()
    }

    fn of_color(&self) -> [Option<f64>; 3] {
        [self.min_psnr_db, self.min_cell_psnr_db, self.min_quality]
    }

    fn color_below(&self, comparison: &Comparison) -> Vec<Violation> {
        let Some(total) = comparison.color() else { return Vec::new() };
        let violation = |bound, limit: Option<f64>, lowest: Option<(usize, Lowest)>| {
            let (limit, (stream, Lowest { value: measured, spot })) = limit.zip(lowest)?;
            (measured < limit).then_some(Violation { bound, limit, measured, stream, spot: Some(spot) })
        };
        let bounds = [Bound::MinPsnr, Bound::MinCellPsnr, Bound::MinQuality].into_iter().zip(self.of_color());
        let lowest = [total.lowest_frame, total.lowest_cell, total.lowest_quality];
        bounds.zip(lowest).filter_map(|((bound, limit), lowest)| violation(bound, limit, lowest)).collect()
    }
}
