//! What comparing two sides has found, stream by stream and in all.

use crate::compare::difference::{BitErrors, Lowest, SampleErrors};
use crate::compare::domain::Domain;
use crate::compare::side::StreamId;
use crate::image::sequence::FrameRange;
use crate::metrics::depth_error::{DepthErrors, Spot};
use crate::metrics::psnr::SquaredError;

/// Frames of a stream that one side alone has.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Missing {
    /// The side that has them: 0 or 1.
    pub only_in: usize,
    /// The stream.
    pub id: StreamId,
    /// The frames.
    pub frames: FrameRange,
}

/// What was measured of a pair of streams.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Measured {
    /// Depth.
    Depth(DepthErrors),
    /// Colour.
    Color(SampleErrors),
    /// Material.
    Material(SampleErrors),
}

/// A pair of streams, compared.
#[derive(Debug, Clone, PartialEq)]
pub struct StreamReport {
    /// The stream, by its name on the first side.
    pub id: StreamId,
    /// Its name on the second side, where it is another.
    pub other_id: Option<StreamId>,
    /// Width and height.
    pub size: [u32; 2],
    /// Frames compared, in the numbers of the first side.
    pub frames: FrameRange,
    /// What they were compared in.
    pub domain: Domain,
    /// Errors in the domain.
    pub measured: Measured,
    /// Differences in bits, where they were asked for.
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

    /// The errors of a colour stream.
    pub fn color(&self) -> Option<&SampleErrors> {
        if let Measured::Color(errors) = &self.measured { Some(errors) } else { None }
    }

    /// The errors of a depth stream.
    pub fn depth(&self) -> Option<&DepthErrors> {
        if let Measured::Depth(errors) = &self.measured { Some(errors) } else { None }
    }

    /// The errors of a material stream.
    pub fn material(&self) -> Option<&SampleErrors> {
        if let Measured::Material(errors) = &self.measured { Some(errors) } else { None }
    }
}

/// Two sides, compared.
#[derive(Debug, Clone, PartialEq)]
pub struct Comparison {
    /// By kind, then probe, then face.
    pub streams: Vec<StreamReport>,
    /// What one side alone has.
    pub missing: Vec<Missing>,
}

/// All streams of colour or of material together.
#[derive(Debug, Clone, PartialEq)]
pub struct SampleTotal {
    /// Squared errors, one for each peak, as 8-bit and half-float streams have different ones.
    errors: Vec<SquaredError>,
    /// Index of the stream that has the frame of lowest PSNR, and that frame.
    pub lowest_frame: Option<(usize, Lowest)>,
    /// Index of the stream that has the cell of lowest PSNR, and that cell.
    pub lowest_cell: Option<(usize, Lowest)>,
    /// Index of the stream that has the largest error, relative to its peak.
    pub worst: Option<usize>,
    /// Largest error in the steps of that stream.
    pub max_error: u32,
    /// Sum of SSIM over frames.
    ssim_sum: f64,
    /// Frames that SSIM was computed for.
    pub ssim_frames: u64,
    /// Pixels that differ.
    pub differing_pixels: u64,
    /// Pixels clipped on their way into 8 bits.
    pub clipped_pixels: u64,
}

impl SampleTotal {
    /// PSNR over all samples; those of different peaks are put in proportion.
    pub fn psnr_db(&self) -> f64 {
        if let [only] = self.errors.as_slice() {
            return only.psnr_db();
        }
        let sum: f64 = self.errors.iter().map(|error| error.sum as f64 / (error.peak * error.peak)).sum();
        let samples: u64 = self.errors.iter().map(|error| error.samples).sum();
        if sum == 0.0 { f64::INFINITY } else { 10.0 * (samples as f64 / sum).log10() }
    }

    /// Mean SSIM of the frames that it was computed for.
    pub fn ssim(&self) -> Option<f64> {
        (self.ssim_frames > 0).then(|| self.ssim_sum / self.ssim_frames as f64)
    }
}

impl Comparison {
    /// Whether nothing differs, in bits where they were compared and else in codes, and nothing is missing.
    pub fn equal(&self) -> bool {
        let same = |stream: &StreamReport| match &stream.bits {
            Some(bits) => bits.differing_pixels == 0,
            None => stream.differing_pixels() == 0,
        };
        self.missing.is_empty() && self.streams.iter().all(same)
    }

    /// Depth errors of all streams, and the index of the one that has the worst pixel.
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

    /// Colour errors of all streams.
    pub fn color(&self) -> Option<SampleTotal> {
        self.samples(StreamReport::color)
    }

    /// Material errors of all streams.
    pub fn material(&self) -> Option<SampleTotal> {
        self.samples(StreamReport::material)
    }

    fn samples(&self, of: fn(&StreamReport) -> Option<&SampleErrors>) -> Option<SampleTotal> {
        let mut total: Option<SampleTotal> = None;
        let mut worst = 0.0;
        for (at, stream) in self.streams.iter().enumerate() {
            let Some(errors) = of(stream) else { continue };
            let total = total.get_or_insert_with(|| SampleTotal {
                errors: Vec::new(),
                lowest_frame: None,
                lowest_cell: None,
                worst: None,
                max_error: 0,
                ssim_sum: 0.0,
                ssim_frames: 0,
                differing_pixels: 0,
                clipped_pixels: 0,
            });
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

    /// The stream and pixel whose error is the largest part of its metric's peak.
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

    /// The first stream and pixel whose bits differ, and the number of pixels that do.
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
