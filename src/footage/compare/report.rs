//! JSON report of a comparison.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::compare::bounds::{Bound, Judgement, Violation};
use crate::compare::comparison::{
    Comparison, Measured, Missing, SampleTotal, StreamReport, serialize_frames, side_name,
};
use crate::compare::difference::{BitErrors, SampleErrors};
use crate::compare::domain::{Domain, Origin};
use crate::compare::side::{Coding, Side, StreamId};
use crate::json::Number;
use crate::metrics::EyeScores;
use crate::metrics::depth_error::{DepthErrors, Spot};
use codec::color::quality::PU_STEPS;
use codec::image::{FrameRange, StreamKind};
use codec::streams::ColorFormat;

/// Report of a whole comparison. Streams are sorted by kind, then probe, then face.
#[derive(Debug, Serialize)]
pub struct ComparisonReport<'a> {
    equal: bool,
    within_bounds: bool,
    broken: Vec<ViolationReport<'a>>,
    /// The pixel with the largest error relative to the peak of its metric.
    worst: Option<Place<'a>>,
    domains: BTreeMap<&'static str, Vec<DomainReport<'a>>>,
    missing: &'a [Missing],
    sides: &'a [Side; 2],
    streams: Vec<StreamErrors<'a>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    depth: Option<DepthTotal<'a>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    color: Option<ColorTotal<'a>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    material: Option<BytesTotal<'a>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    alpha: Option<BytesTotal<'a>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    exact: Option<BitsTotal<'a>>,
}

#[derive(Debug, Serialize)]
struct Place<'a> {
    #[serde(flatten)]
    stream: &'a StreamId,
    #[serde(flatten)]
    spot: Option<Spot>,
}

#[derive(Debug, Serialize)]
struct ViolationReport<'a> {
    #[serde(flatten)]
    place: Place<'a>,
    bound: Bound,
    limit: Number,
    measured: Number,
}

#[derive(Debug, Serialize)]
struct DepthTotal<'a> {
    #[serde(flatten)]
    errors: DepthErrors,
    worst: Option<Place<'a>>,
}

#[derive(Debug, Serialize)]
struct Eye {
    ssimulacra2: Option<f64>,
    ssimulacra2_p10: Option<f64>,
    butteraugli_3norm: Option<f64>,
}

#[derive(Debug, Serialize)]
struct ColorTotal<'a> {
    psnr_db: Number,
    min_psnr_db: Option<Number>,
    min_psnr_at: Option<Place<'a>>,
    min_cell_psnr_db: Option<Number>,
    min_cell_psnr_at: Option<Place<'a>>,
    min_quality: Option<Number>,
    min_quality_at: Option<Place<'a>>,
    ssim: Option<f64>,
    ssim_frames: u64,
    psnr_hvs_m_db: Option<Number>,
    #[serde(flatten)]
    eye: Eye,
    differing_pixels: u64,
    clipped_pixels: u64,
    worst: Option<Place<'a>>,
}

#[derive(Debug, Serialize)]
struct BytesTotal<'a> {
    max_error_codes: u32,
    psnr_db: Number,
    differing_pixels: u64,
    worst: Option<Place<'a>>,
}

#[derive(Debug, Serialize)]
struct BitsTotal<'a> {
    differing_pixels: u64,
    first: Option<Place<'a>>,
}

#[derive(Debug, Serialize)]
struct StreamErrors<'a> {
    #[serde(flatten)]
    id: &'a StreamId,
    #[serde(skip_serializing_if = "Option::is_none")]
    stream_in_b: Option<String>,
    #[serde(flatten)]
    errors: Errors,
    #[serde(skip_serializing_if = "Option::is_none")]
    exact: Option<BitErrors>,
    width: u32,
    height: u32,
    #[serde(serialize_with = "serialize_frames")]
    frames: FrameRange,
    worst: Option<Spot>,
    domain: DomainReport<'a>,
}

#[derive(Debug, Serialize)]
#[serde(untagged)]
enum Errors {
    Depth(DepthErrors),
    Color(ColorErrors),
    Bytes(LevelErrors),
}

#[derive(Debug, Serialize)]
struct LevelErrors {
    psnr_db: Number,
    differing_pixels: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    max_error_pu21: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    max_error_codes: Option<u32>,
}

#[derive(Debug, Serialize)]
struct ColorErrors {
    #[serde(flatten)]
    levels: LevelErrors,
    min_psnr_db: Option<Number>,
    min_psnr_frame: Option<u32>,
    min_cell_psnr_db: Option<Number>,
    min_cell_psnr_at: Option<Spot>,
    min_quality: Option<Number>,
    min_quality_at: Option<Spot>,
    ssim: Option<f64>,
    ssim_frames: u64,
    psnr_hvs_m_db: Option<Number>,
    #[serde(flatten)]
    eye: Eye,
    clipped_pixels: u64,
}

#[derive(Debug, PartialEq, Serialize)]
struct DomainReport<'a> {
    #[serde(flatten)]
    codes: Codes,
    of: Option<&'static str>,
    from: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    probe: Option<&'a str>,
}

#[derive(Debug, PartialEq, Serialize)]
#[serde(tag = "codes")]
enum Codes {
    #[serde(rename = "16bit-log")]
    Depth { near_m: f64, far_m: f64 },
    #[serde(rename = "8bit")]
    EightBit { transfer: &'static str, exposure_ev: f64, cell: u32 },
    #[serde(rename = "half")]
    Half { metric: &'static str, white_cd_m2: f64, cell: u32 },
    #[serde(rename = "8bit")]
    Bytes,
}

impl Comparison {
    pub fn report<'a>(&'a self, sides: &'a [Side; 2], judgement: &Judgement) -> ComparisonReport<'a> {
        let broken = |violation: &Violation| ViolationReport {
            place: Place { stream: &self.streams[violation.stream].id, spot: violation.spot },
            bound: violation.bound,
            limit: Number(violation.limit),
            measured: Number(violation.measured),
        };
        ComparisonReport {
            equal: judgement.equal,
            within_bounds: judgement.within_bounds,
            broken: judgement.violations.iter().map(broken).collect(),
            worst: self.worst().map(|(at, spot)| self.place(at, spot)),
            domains: self.domains(),
            missing: &self.missing,
            sides,
            streams: self.streams.iter().map(StreamErrors::new).collect(),
            depth: self.depth().map(|(errors, worst)| DepthTotal {
                errors,
                worst: worst.zip(errors.worst).map(|(at, spot)| self.place(at, spot)),
            }),
            color: self.color().map(|total| self.color_total(&total)),
            material: self.bytes_total(StreamKind::Material),
            alpha: self.bytes_total(StreamKind::Alpha),
            exact: self.bits().map(|(differing_pixels, first)| BitsTotal {
                differing_pixels,
                first: first.map(|(at, spot)| self.place(at, spot)),
            }),
        }
    }

    fn place(&self, stream: usize, spot: Spot) -> Place<'_> {
        Place { stream: &self.streams[stream].id, spot: Some(spot) }
    }

    fn worst_of(&self, total: &SampleTotal) -> Option<Place<'_>> {
        let (at, (spot, _)) = total.worst.and_then(|at| Some((at, self.streams[at].worst()?)))?;
        Some(self.place(at, spot))
    }

    fn bytes_total(&self, kind: StreamKind) -> Option<BytesTotal<'_>> {
        let total = self.samples(kind)?;
        Some(BytesTotal {
            max_error_codes: total.max_error,
            psnr_db: Number(total.psnr_db),
            differing_pixels: total.differing_pixels,
            worst: self.worst_of(&total),
        })
    }

    fn color_total(&self, total: &SampleTotal) -> ColorTotal<'_> {
        let (frame, cell, quality) = (total.lowest_frame, total.lowest_cell, total.lowest_quality);
        ColorTotal {
            psnr_db: Number(total.psnr_db),
            min_psnr_db: frame.map(|(_, lowest)| Number(lowest.value)),
            min_psnr_at: frame.map(|(at, lowest)| self.place(at, lowest.spot)),
            min_cell_psnr_db: cell.map(|(_, lowest)| Number(lowest.value)),
            min_cell_psnr_at: cell.map(|(at, lowest)| self.place(at, lowest.spot)),
            min_quality: quality.map(|(_, lowest)| Number(lowest.value)),
            min_quality_at: quality.map(|(at, lowest)| self.place(at, lowest.spot)),
            ssim: total.ssim,
            ssim_frames: total.ssim_frames,
            psnr_hvs_m_db: total.psnr_hvs_m_db.map(Number),
            eye: Eye::new(&total.eye),
            differing_pixels: total.differing_pixels,
            clipped_pixels: total.clipped_pixels,
            worst: self.worst_of(total),
        }
    }

    fn domains(&self) -> BTreeMap<&'static str, Vec<DomainReport<'_>>> {
        let mut domains = BTreeMap::<_, Vec<_>>::new();
        for stream in &self.streams {
            let mut domain = DomainReport::new(&stream.domain);
            domain.probe = (stream.id.kind == StreamKind::Depth).then_some(&stream.id.probe);
            let known = domains.entry(stream.id.kind.name()).or_default();
            if !known.contains(&domain) {
                known.push(domain);
            }
        }
        domains
    }
}

impl<'a> StreamErrors<'a> {
    fn new(stream: &'a StreamReport) -> StreamErrors<'a> {
        StreamErrors {
            id: &stream.id,
            stream_in_b: stream.other_id.as_ref().map(ToString::to_string),
            errors: match &stream.measured {
                Measured::Depth(errors) => Errors::Depth(*errors),
                Measured::Color(errors) => Errors::Color(ColorErrors::new(errors, &stream.domain)),
                Measured::Bytes(errors) => Errors::Bytes(LevelErrors::new(errors, &stream.domain)),
            },
            exact: stream.bits,
            width: stream.size[0],
            height: stream.size[1],
            frames: stream.frames,
            worst: stream.worst().map(|(spot, _)| spot),
            domain: DomainReport::new(&stream.domain),
        }
    }
}

impl Eye {
    fn new(scores: &EyeScores) -> Eye {
        Eye {
            ssimulacra2: scores.ssimulacra2(),
            ssimulacra2_p10: scores.ssimulacra2_p10(),
            butteraugli_3norm: scores.butteraugli_3norm(),
        }
    }
}

impl LevelErrors {
    fn new(errors: &SampleErrors, domain: &Domain) -> LevelErrors {
        let is_half = matches!(domain.coding, Coding::Color(ColorFormat::Half { .. }, _));
        LevelErrors {
            psnr_db: Number(errors.psnr_db()),
            differing_pixels: errors.differing_pixels,
            max_error_pu21: is_half.then(|| f64::from(errors.max_error) / PU_STEPS),
            max_error_codes: (!is_half).then_some(errors.max_error),
        }
    }
}

impl ColorErrors {
    fn new(errors: &SampleErrors, domain: &Domain) -> ColorErrors {
        let [frame, cell, quality] = errors.lowest();
        ColorErrors {
            levels: LevelErrors::new(errors, domain),
            min_psnr_db: frame.map(|lowest| Number(lowest.value)),
            min_psnr_frame: frame.map(|lowest| lowest.spot.frame),
            min_cell_psnr_db: cell.map(|lowest| Number(lowest.value)),
            min_cell_psnr_at: cell.map(|lowest| lowest.spot),
            min_quality: quality.map(|lowest| Number(lowest.value)),
            min_quality_at: quality.map(|lowest| lowest.spot),
            ssim: errors.ssim(),
            ssim_frames: errors.ssim_frames,
            psnr_hvs_m_db: errors.hvs.psnr_db().map(Number),
            eye: Eye::new(&errors.eye),
            clipped_pixels: errors.clipped_pixels,
        }
    }
}

impl DomainReport<'_> {
    fn new(domain: &Domain) -> Self {
        let codes = match domain.coding {
            Coding::Depth(range) => Codes::Depth { near_m: range.near_m().into(), far_m: range.far_m().into() },
            Coding::Color(ColorFormat::EightBit(tone), cell) => {
                Codes::EightBit { transfer: tone.transfer.name(), exposure_ev: tone.exposure_ev.into(), cell }
            }
            Coding::Color(ColorFormat::Half { white_cd_m2 }, cell) => {
                Codes::Half { metric: "pu21 in 64ths", white_cd_m2, cell }
            }
            Coding::Bytes => Codes::Bytes,
        };
        let (of, from) = match domain.origin {
            Origin::Container(side) => (Some(side_name(side)), "container"),
            Origin::Manifest(side) => (Some(side_name(side)), "manifest"),
            Origin::Default => (None, "default"),
        };
        DomainReport { codes, of, from, probe: None }
    }
}
