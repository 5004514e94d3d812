//! The result of a comparison, per stream and in total.

use serde::{Serialize, Serializer};

use crate::compare::difference::{BitErrors, Lowest, SampleErrors};
use crate::compare::domain::{Domain, Origin};
use crate::compare::side::StreamId;
use crate::metrics::depth_error::{DepthErrors, Spot, finite_or_nan};
use crate::metrics::{EyeScores, HvsError};
use codec::image::{FrameRange, StreamKind};
use codec::metrics::SquaredError;

/// Frames of a stream that only one side has.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Missing {
    #[serde(flatten)]
    pub id: StreamId,
    /// The side that has the frames, 0 or 1.
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
    /// Records that bits differ, so that equal codes are not reported as equal values.
    pub(super) fn note_bits(&mut self, differ: bool) {
        match self {
            Measured::Depth(errors) => errors.has_other_bits |= differ,
            Measured::Color(errors) | Measured::Bytes(errors) => errors.has_other_bits |= differ,
        }
    }

    /// Returns the PSNR in dB; NaN if codes are equal but bits differ.
    pub fn psnr_db(&self) -> f64 {
        match self {
            Measured::Depth(errors) => errors.psnr_db(),
            Measured::Color(errors) | Measured::Bytes(errors) => errors.psnr_db(),
        }
    }
}

#[derive(Debug, Clone, PartialEq)]
pub struct StreamReport {
    /// Identity of the stream on the first side.
    pub id: StreamId,
    /// Identity of the stream on the second side, if it differs.
    pub other_id: Option<StreamId>,
    pub size: [u32; 2],
    /// Compared frames, as numbered on the first side.
    pub frames: FrameRange,
    pub domain: Domain,
    pub measured: Measured,
    /// Bit errors; measured with [`crate::compare::Measure::Bits`].
    pub bits: Option<BitErrors>,
}

impl StreamReport {
    pub fn differing_pixels(&self) -> u64 {
        match &self.measured {
            Measured::Depth(errors) => errors.differing_pixels,
            Measured::Color(errors) | Measured::Bytes(errors) => errors.differing_pixels,
        }
    }

    /// Returns the worst pixel, and its error as a fraction of the peak of the metric.
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

    /// Returns the sample errors of a stream of any kind but depth.
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
    /// Number of colour pixels that encoding clipped, by side, over all streams and frames; 0 if a side does not state it.
    pub clipped_in_containers: [u64; 2],
}

#[derive(Debug, Clone, PartialEq)]
pub struct SampleTotal {
    /// PSNR over all samples relative to their peaks; 8-bit and half-float streams have different peaks.
    pub psnr_db: f64,
    /// Index of the stream, and the minimum PSNR of a frame.
    pub lowest_frame: Option<(usize, Lowest)>,
    pub lowest_cell: Option<(usize, Lowest)>,
    pub lowest_quality: Option<(usize, Lowest)>,
    /// Index of the stream with the largest error relative to its peak.
    pub worst: Option<usize>,
    /// Maximum error in steps of that stream.
    pub max_error: u32,
    /// Mean SSIM of the frames for which it was computed.
    pub ssim: Option<f64>,
    pub ssim_frames: u64,
    /// PSNR-HVS-M in dB of the same frames.
    pub psnr_hvs_m_db: Option<f64>,
    pub eye: EyeScores,
    pub differing_pixels: u64,
    /// Number of pixels that 8 bits clip.
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
    /// Returns true if nothing is missing and nothing differs, in bits if these were compared, else in codes.
    pub fn equal(&self) -> bool {
        let same = |stream: &StreamReport| match &stream.bits {
            Some(bits) => bits.differing_pixels == 0,
            None => stream.differing_pixels() == 0,
        };
        self.missing.is_empty() && self.streams.iter().all(same)
    }

    /// Returns the depth errors of all streams, and the index of the stream with the worst pixel.
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

    /// Returns the sum over streams of a kind other than depth; `None` if there are none.
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

    /// Returns the colour stream with the most pixels that the codes of a container or decoded dataset clip, and the number of
    /// these pixels in all streams. If there are none, returns the first colour stream and the larger number of pixels that
    /// encoding of a side clipped; `None` if that is 0.
    pub fn clipped(&self) -> Option<(usize, u64)> {
        let colors = self.streams.iter().enumerate().filter_map(|(at, stream)| Some((at, stream, stream.color()?)));
        let coded = colors.clone().filter(|(_, stream, _)| stream.domain.origin != Origin::Default);
        let pixels = coded.clone().map(|(_, _, errors)| errors.clipped_pixels).sum::<u64>();
        let most = coded.max_by_key(|(at, _, errors)| (errors.clipped_pixels, std::cmp::Reverse(*at)));
        let known = self.clipped_in_containers.into_iter().max().unwrap_or(0);
        let (at, ..) = most.filter(|_| pixels > 0).or_else(|| colors.clone().next().filter(|_| known > 0))?;
        Some((at, if pixels > 0 { pixels } else { known }))
    }

    /// Returns the index of the stream and the pixel with the largest error relative to the peak of its metric.
    pub fn worst(&self) -> Option<(usize, Spot)> {
        self.worst_where(|_| true)
    }

    fn worst_where(&self, is_wanted: impl Fn(&StreamReport) -> bool) -> Option<(usize, Spot)> {
        let wanted = self.streams.iter().enumerate().filter(|(_, stream)| is_wanted(stream));
        let known = wanted.filter_map(|(at, stream)| Some((at, stream.worst()?)));
        let worst = known.reduce(|worst, next| if next.1.1 > worst.1.1 { next } else { worst });
        worst.map(|(at, (spot, _))| (at, spot))
    }

    /// Returns the number of pixels whose bits differ, and the first of them with the index of its stream; `None` if bits were
    /// not compared.
    pub fn bits(&self) -> Option<(u64, Option<(usize, Spot)>)> {
        let mut streams = self.streams.iter().enumerate().filter_map(|(at, stream)| Some((at, stream.bits?)));
        let count = streams.clone().map(|(_, bits)| bits.differing_pixels).sum();
        let measured = streams.clone().next().is_some();
        measured.then(|| (count, streams.find_map(|(at, bits)| Some((at, bits.first?)))))
    }
}
