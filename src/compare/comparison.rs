//! The result of a comparison, by stream and in total.

use serde::{Serialize, Serializer};

use crate::compare::difference::{BitErrors, Lowest, SampleErrors};
use crate::compare::domain::{Domain, Origin};
use crate::compare::side::StreamId;
use crate::image::{FrameRange, StreamKind};
use crate::metrics::depth_error::{DepthErrors, Spot, finite_or_nan};
use crate::metrics::{EyeScores, HvsError, SquaredError};

/// Frames of a stream that only one side has.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Missing {
    #[serde(flatten)]
    pub id: StreamId,
    /// The side that has them, 0 or 1.
    #[serde(serialize_with = "serialize_side")]
    pub only_in: usize,
    #[serde(serialize_with = "serialize_frames")]
    pub frames: FrameRange,
}

fn serialize_side<S: Serializer>(side: &usize, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(side_name(*side))
}

pub(super) fn serialize_frames<S: Serializer>(frames: &FrameRange, serializer: S) -> Result<S::Ok, S::Error> {
    [frames.first, frames.last].serialize(serializer)
}

pub fn side_name(side: usize) -> &'static str {
    if side == 0 { "A" } else { "B" }
}

#[derive(Debug, Clone, PartialEq)]
pub enum Measured {
    Depth(DepthErrors),
    Color(SampleErrors),
    /// Material or alpha.
    Bytes(SampleErrors),
}

impl Measured {
    /// Notes whether bits differ, so that equal codes are not taken for equal values.
    pub(super) fn note_bits(&mut self, differ: bool) {
        match self {
            Measured::Depth(errors) => errors.has_other_bits |= differ,
            Measured::Color(errors) | Measured::Bytes(errors) => errors.has_other_bits |= differ,
        }
    }

    /// PSNR in dB; NaN where bits differ that codes do not tell apart.
    pub fn psnr_db(&self) -> f64 {
        match self {
            Measured::Depth(errors) => errors.psnr_db(),
            Measured::Color(errors) | Measured::Bytes(errors) => errors.psnr_db(),
        }
    }
}

#[derive(Debug, Clone, PartialEq)]
pub struct StreamReport {
    /// On the first side.
    pub id: StreamId,
    /// On the second side, where it is another.
    pub other_id: Option<StreamId>,
    pub size: [u32; 2],
    /// In the numbers of the first side.
    pub frames: FrameRange,
    pub domain: Domain,
    pub measured: Measured,
    /// With [`crate::compare::Measure::Bits`].
    pub bits: Option<BitErrors>,
}

impl StreamReport {
    pub fn differing_pixels(&self) -> u64 {
        match &self.measured {
            Measured::Depth(errors) => errors.differing_pixels,
            Measured::Color(errors) | Measured::Bytes(errors) => errors.differing_pixels,
        }
    }

    /// The worst pixel, and its error as a fraction of the metric's peak.
    pub fn worst(&self) -> Option<(Spot, f64)> {
        let (spot, error, peak) = match &self.measured {
            Measured::Depth(errors) => (errors.worst, errors.max_error_codes.into(), errors.error.peak),
            Measured::Color(errors) | Measured::Bytes(errors) => {
                (errors.worst, f64::from(errors.max_error), errors.error.peak)
            }
        };
        spot.map(|spot| (spot, error / peak))
    }

    pub fn color(&self) -> Option<&SampleErrors> {
        if let Measured::Color(errors) = &self.measured { Some(errors) } else { None }
    }

    pub fn depth(&self) -> Option<&DepthErrors> {
        if let Measured::Depth(errors) = &self.measured { Some(errors) } else { None }
    }

    /// Of a stream of any other kind than depth.
    fn samples(&self) -> Option<&SampleErrors> {
        match &self.measured {
            Measured::Color(errors) | Measured::Bytes(errors) => Some(errors),
            Measured::Depth(_) => None,
        }
    }
}

#[derive(Debug, Clone, PartialEq)]
pub struct Comparison {
    pub streams: Vec<StreamReport>,
    pub missing: Vec<Missing>,
    /// Colour pixels of each side that encoding clipped, in all of its streams and frames, as far as its container knows.
    pub clipped_in_containers: [u64; 2],
}

#[derive(Debug, Clone, PartialEq)]
pub struct SampleTotal {
    /// PSNR over all samples, relative to their peaks: 8-bit and half-float streams have different ones.
    pub psnr_db: f64,
    /// With the index of the stream.
    pub lowest_frame: Option<(usize, Lowest)>,
    pub lowest_cell: Option<(usize, Lowest)>,
    pub lowest_quality: Option<(usize, Lowest)>,
    /// Index of the stream with the largest error relative to its peak.
    pub worst: Option<usize>,
    /// Largest error in the steps of that stream.
    pub max_error: u32,
    /// Mean of the frames of which it was computed.
    pub ssim: Option<f64>,
    pub ssim_frames: u64,
    /// Of the same frames.
    pub psnr_hvs_m_db: Option<f64>,
    pub eye: EyeScores,
    pub differing_pixels: u64,
    /// Pixels that 8 bits clipped.
    pub clipped_pixels: u64,
}

fn psnr_of_all(errors: impl Iterator<Item = SquaredError>) -> f64 {
    let mut by_peak: Vec<SquaredError> = Vec::new();
    for error in errors {
        match by_peak.iter_mut().find(|known| known.peak == error.peak) {
            Some(known) => {
                known.sum += error.sum;
                known.samples += error.samples;
            }
            None => by_peak.push(error),
        }
    }
    if let [only] = by_peak.as_slice() {
        return only.psnr_db();
    }
    let sum: f64 = by_peak.iter().map(|error| error.sum as f64 / (error.peak * error.peak)).sum();
    let samples: u64 = by_peak.iter().map(|error| error.samples).sum();
    if sum == 0.0 { f64::INFINITY } else { 10.0 * (samples as f64 / sum).log10() }
}

impl Comparison {
    /// Whether nothing is missing or differs, in bits where these were compared, else in codes.
    pub fn equal(&self) -> bool {
        let same = |stream: &StreamReport| match &stream.bits {
            Some(bits) => bits.differing_pixels == 0,
            None => stream.differing_pixels() == 0,
        };
        self.missing.is_empty() && self.streams.iter().all(same)
    }

    /// Depth errors of all streams, and the index of the stream with the worst pixel.
    pub fn depth(&self) -> Option<(DepthErrors, Option<usize>)> {
        let mut total: Option<(DepthErrors, Option<usize>)> = None;
        for (at, errors) in self.streams.iter().enumerate().filter_map(|(at, stream)| Some((at, stream.depth()?))) {
            let (sum, worst) = total.get_or_insert_default();
            if sum.merge(errors) {
                *worst = Some(at);
            }
        }
        total
    }

    pub fn color(&self) -> Option<SampleTotal> {
        self.samples(StreamKind::Color)
    }

    /// Of a kind other than depth.
    pub fn samples(&self, kind: StreamKind) -> Option<SampleTotal> {
        let of_kind = self.streams.iter().enumerate().filter(|(_, stream)| stream.id.kind == kind);
        let all: Vec<(usize, &SampleErrors)> =
            of_kind.filter_map(|(at, stream)| Some((at, stream.samples()?))).collect();
        let has_other_bits = all.iter().any(|(_, errors)| errors.has_other_bits);
        let lowest = |of: fn(&SampleErrors) -> Option<Lowest>| {
            let known = all.iter().filter_map(|(at, errors)| Some((*at, of(errors)?)));
            let lowest = known.reduce(|lowest, next| if next.1.value < lowest.1.value { next } else { lowest });
            lowest.map(|(at, found)| (at, Lowest { value: finite_or_nan(found.value, has_other_bits), ..found }))
        };
        let sum = |of: fn(&SampleErrors) -> u64| all.iter().map(|(_, errors)| of(errors)).sum::<u64>();
        let worst = self.worst_where(|stream| stream.id.kind == kind).map(|(at, _)| at);
        let ssim_frames = sum(|errors| errors.ssim_frames);
        let ssim_sum: f64 = all.iter().map(|(_, errors)| errors.ssim_sum).sum();
        let mut hvs = HvsError::default();
        let mut eye = EyeScores::default();
        for (_, errors) in &all {
            hvs.merge(&errors.hvs);
            eye.merge(&errors.eye);
        }
        (!all.is_empty()).then(|| SampleTotal {
            psnr_db: finite_or_nan(psnr_of_all(all.iter().map(|(_, errors)| errors.error)), has_other_bits),
            lowest_frame: lowest(|errors| errors.lowest_frame),
            lowest_cell: lowest(|errors| errors.lowest_cell),
            lowest_quality: lowest(|errors| errors.lowest_quality),
            worst,
            max_error: worst.and_then(|at| self.streams[at].samples()).map_or(0, |errors| errors.max_error),
            ssim: (ssim_frames > 0).then(|| ssim_sum / ssim_frames as f64),
            ssim_frames,
            psnr_hvs_m_db: hvs.psnr_db(),
            eye,
            differing_pixels: sum(|errors| errors.differing_pixels),
            clipped_pixels: sum(|errors| errors.clipped_pixels),
        })
    }

    /// The colour stream with the most pixels that codes of a container, or of what was decoded from one, do not hold, and their
    /// number in all streams; else those that encoding of a side clipped.
    pub fn clipped(&self) -> Option<(usize, u64)> {
        let colors = self.streams.iter().enumerate().filter_map(|(at, stream)| Some((at, stream, stream.color()?)));
        let coded = colors.clone().filter(|(_, stream, _)| stream.domain.origin != Origin::Default);
        let pixels = coded.clone().map(|(_, _, errors)| errors.clipped_pixels).sum::<u64>();
        let most = coded.max_by_key(|(at, _, errors)| (errors.clipped_pixels, std::cmp::Reverse(*at)));
        let known = self.clipped_in_containers.into_iter().max().unwrap_or(0);
        let (at, ..) = most.filter(|_| pixels > 0).or_else(|| colors.clone().next().filter(|_| known > 0))?;
        Some((at, if pixels > 0 { pixels } else { known }))
    }

    /// The pixel with the largest error relative to its metric's peak, with the index of its stream.
    pub fn worst(&self) -> Option<(usize, Spot)> {
        self.worst_where(|_| true)
    }

    fn worst_where(&self, is_wanted: impl Fn(&StreamReport) -> bool) -> Option<(usize, Spot)> {
        let wanted = self.streams.iter().enumerate().filter(|(_, stream)| is_wanted(stream));
        let known = wanted.filter_map(|(at, stream)| Some((at, stream.worst()?)));
        let worst = known.reduce(|worst, next| if next.1.1 > worst.1.1 { next } else { worst });
        worst.map(|(at, (spot, _))| (at, spot))
    }

    /// Number of pixels whose bits differ, and the first with the index of its stream; `None` where bits were not compared.
    pub fn bits(&self) -> Option<(u64, Option<(usize, Spot)>)> {
        let mut streams = self.streams.iter().enumerate().filter_map(|(at, stream)| Some((at, stream.bits?)));
        let count = streams.clone().map(|(_, bits)| bits.differing_pixels).sum();
        let measured = streams.clone().next().is_some();
        measured.then(|| (count, streams.find_map(|(at, bits)| Some((at, bits.first?)))))
    }
}
