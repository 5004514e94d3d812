//! The result of a comparison, by stream and in total.

use crate::compare::difference::{BitErrors, Lowest, SampleErrors};
use crate::compare::domain::Domain;
use crate::compare::side::StreamId;
use crate::image::FrameRange;
use crate::metrics::depth_error::{DepthErrors, Spot};
use crate::metrics::psnr::SquaredError;

/// Frames of a stream that only one side has.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Missing {
    /// The side that has them, 0 or 1.
    pub only_in: usize,
    pub id: StreamId,
    pub frames: FrameRange,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Measured {
    Depth(DepthErrors),
    Color(SampleErrors),
    Material(SampleErrors),
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
    /// Pixels that differ in the domain.
    pub fn differing_pixels(&self) -> u64 {
        match &self.measured {
            Measured::Depth(errors) => errors.differing_pixels,
            Measured::Color(errors) | Measured::Material(errors) => errors.differing_pixels,
        }
    }

    /// The worst pixel, and its error as a fraction of the metric's peak.
    pub fn worst(&self) -> Option<(Spot, f64)> {
        match &self.measured {
            Measured::Depth(errors) => {
                errors.worst.map(|spot| (spot, f64::from(errors.max_error_codes) / errors.error.peak))
            }
            Measured::Color(errors) | Measured::Material(errors) => {
                errors.worst.map(|spot| (spot, f64::from(errors.max_error) / errors.error.peak))
            }
        }
    }

    pub fn color(&self) -> Option<&SampleErrors> {
        if let Measured::Color(errors) = &self.measured { Some(errors) } else { None }
    }

    pub fn depth(&self) -> Option<&DepthErrors> {
        if let Measured::Depth(errors) = &self.measured { Some(errors) } else { None }
    }

    pub fn material(&self) -> Option<&SampleErrors> {
        if let Measured::Material(errors) = &self.measured { Some(errors) } else { None }
    }
}

#[derive(Debug, Clone, PartialEq)]
pub struct Comparison {
    /// By kind, then probe, then face.
    pub streams: Vec<StreamReport>,
    /// What only one side has.
    pub missing: Vec<Missing>,
}

#[derive(Debug, Clone, Default, PartialEq)]
pub struct SampleTotal {
    /// One for each peak: 8-bit and half-float streams have different ones.
    errors: Vec<SquaredError>,
    /// With the index of the stream.
    pub lowest_frame: Option<(usize, Lowest)>,
    /// With the index of the stream.
    pub lowest_cell: Option<(usize, Lowest)>,
    /// Index of the stream with the largest error relative to its peak.
    pub worst: Option<usize>,
    /// Largest error in the steps of that stream.
    pub max_error: u32,
    ssim_sum: f64,
    /// Frames of which SSIM was computed.
    pub ssim_frames: u64,
    pub differing_pixels: u64,
    /// Pixels that 8 bits clipped.
    pub clipped_pixels: u64,
}

impl SampleTotal {
    /// PSNR over all samples, relative to their peaks.
    pub fn psnr_db(&self) -> f64 {
        if let [only] = self.errors.as_slice() {
            return only.psnr_db();
        }
        let sum: f64 = self.errors.iter().map(|error| error.sum as f64 / (error.peak * error.peak)).sum();
        let samples: u64 = self.errors.iter().map(|error| error.samples).sum();
        if sum == 0.0 { f64::INFINITY } else { 10.0 * (samples as f64 / sum).log10() }
    }

    pub fn ssim(&self) -> Option<f64> {
        (self.ssim_frames > 0).then(|| self.ssim_sum / self.ssim_frames as f64)
    }
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
        self.samples(StreamReport::color)
    }

    pub fn material(&self) -> Option<SampleTotal> {
        self.samples(StreamReport::material)
    }

    fn samples(&self, of: fn(&StreamReport) -> Option<&SampleErrors>) -> Option<SampleTotal> {
        let mut total: Option<SampleTotal> = None;
        let mut worst = 0.0;
        for (at, stream) in self.streams.iter().enumerate() {
            let Some(errors) = of(stream) else { continue };
            let total = total.get_or_insert_default();
            match total.errors.iter_mut().find(|error| error.peak == errors.error.peak) {
                Some(error) => {
                    error.sum += errors.error.sum;
                    error.samples += errors.error.samples;
                }
                None => total.errors.push(errors.error),
            }
            keep_lowest(&mut total.lowest_frame, at, errors.lowest_frame);
            keep_lowest(&mut total.lowest_cell, at, errors.lowest_cell);
            if let Some((_, relative)) = stream.worst()
                && (total.worst.is_none() || relative > worst)
            {
                (total.worst, total.max_error, worst) = (Some(at), errors.max_error, relative);
            }
            total.ssim_sum += errors.ssim_sum;
            total.ssim_frames += errors.ssim_frames;
            total.differing_pixels += errors.differing_pixels;
            total.clipped_pixels += errors.clipped_pixels;
        }
        total
    }

    /// The pixel with the largest error relative to its metric's peak, with the index of its stream.
    pub fn worst(&self) -> Option<(usize, Spot)> {
        let mut worst: Option<(usize, Spot, f64)> = None;
        for (at, stream) in self.streams.iter().enumerate() {
            if let Some((spot, relative)) = stream.worst()
                && worst.is_none_or(|(_, _, largest)| relative > largest)
            {
                worst = Some((at, spot, relative));
            }
        }
        worst.map(|(at, spot, _)| (at, spot))
    }

    /// Number of pixels whose bits differ, and the first with the index of its stream; `None` where bits were not compared.
    pub fn bits(&self) -> Option<(u64, Option<(usize, Spot)>)> {
        let mut streams = self.streams.iter().enumerate().filter_map(|(at, stream)| Some((at, stream.bits?)));
        let count = streams.clone().map(|(_, bits)| bits.differing_pixels).sum();
        let measured = streams.clone().next().is_some();
        measured.then(|| (count, streams.find_map(|(at, bits)| Some((at, bits.first?)))))
    }
}

fn keep_lowest(lowest: &mut Option<(usize, Lowest)>, at: usize, other: Option<Lowest>) {
    if let Some(other) = other
        && lowest.is_none_or(|(_, lowest)| other.psnr_db < lowest.psnr_db)
    {
        *lowest = Some((at, other));
    }
}
