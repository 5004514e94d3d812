//! Compares two sides stream by stream.
//!
//! Both streams of a pair are converted to one [`Domain`]: depth to 16-bit log codes, colour to the codes of a transfer function
//! or to half floats, as the side that is a container codes them. One frame of each stream is in memory at a time. Streams are
//! compared in parallel; the result does not depend on how many run at once.

use std::borrow::Cow;

use crate::compare::comparison::{Comparison, Measured, StreamReport};
use crate::compare::difference::{BitErrors, SampleErrors, half_levels};
use crate::compare::domain::{ColorDomain, ComparedColor, Converted, Converter, Domain, Origin};
use crate::compare::pairing::{Coverage, Pair, Pairing};
use crate::compare::side::{Coding, Image, Side, SideForm, SideReader, SideStream, Values};
use crate::metrics::{DepthErrors, HvsError, SSIM_WINDOW, scoring_bytes, ssim_rgb8};
use codec::color::quality::{Pu21, Quality};
use codec::depth::DepthRange;
use codec::error::{Error, Result};
use codec::image::primaries::Primaries;
use codec::image::transfer::Transfer;
use codec::image::{FrameRange, Plane, StreamKind};
use codec::memory::{Budget, Need};
use codec::metrics::U8_PEAK;
use codec::monitor::Monitor;
use codec::ordered::try_map_at_once;
use codec::streams::ColorFormat;
use codec::streams::convert::DepthExtent;

/// Returns the bytes per pixel of both converted images of a pair, in addition to the images as read.
fn comparing_bytes(pair: &Pair<'_>, settings: &CompareSettings) -> u64 {
    let is_half = |stream: &&SideStream| matches!(stream.coding, Some(Coding::Color(ColorFormat::Half { .. }, _)));
    let (converted, values) = match pair.streams[0].id.kind {
        // 32-bit codes and metres.
        StreamKind::Depth => (2 * (4 + 4), 2 * 4),
        // Half floats: linear RGB and its PU21 levels of both sides. Else: 8-bit codes of both sides, linear RGB of the side that
        // is being converted, and without `allow_clipping` 32-bit codes of both sides.
        StreamKind::Color if settings.color != ColorDomain::AsCoded || pair.streams.iter().any(is_half) => {
            (2 * (6 + 12), 2 * 6)
        }
        StreamKind::Color => (2 * 3 + 6 + if settings.allow_clipping { 0 } else { 2 * 12 }, 2 * 6),
        StreamKind::Material => (2 * 3, 2 * 12),
        StreamKind::Alpha => (2 * 3, 2 * 4),
    };
    converted.max(if settings.measure == Measure::Bits { values } else { 0 })
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Measure {
    #[default]
    Codes,
    /// Codes, and the bits of metres, linear RGB, weights and alpha.
    Bits,
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum SsimFrames {
    Every,
    /// The first, middle and last frame.
    #[default]
    Sampled,
    None,
}

#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct CompareSettings {
    pub coverage: Coverage,
    pub measure: Measure,
    pub color: ColorDomain,
    pub ssim: SsimFrames,
    /// Also computes SSIMULACRA2 and butteraugli for the same frames.
    pub ssimulacra2: bool,
    /// Compares clipped codes if colour does not fit 8 bits. If false, codes extend above 255 and below 0; SSIM and PSNR-HVS-M
    /// always use clipped codes.
    pub allow_clipping: bool,
    pub memory: Budget,
}

/// Compares all pairs. The monitor advances by one for each pair of images.
pub fn compare(pairing: &Pairing<'_>, settings: &CompareSettings, monitor: &dyn Monitor) -> Result<Comparison> {
    let at_once = streams_at_once(pairing, settings)?;
    let domains = domains(pairing, settings.color, at_once, monitor)?;
    let with_domains: Vec<(Pair<'_>, Domain)> = pairing.pairs.iter().copied().zip(domains).collect();
    let jobs: Vec<_> = with_domains.chunk_by(|(one, _), (next, _)| one.shares_files(next)).collect();
    let reports = try_map_at_once(jobs, at_once, |pairs| {
        let mut work = pairs
            .iter()
            .map(|(pair, domain)| PairComparison::new(pairing.sides, pair, *domain, settings))
            .collect::<Result<Vec<_>>>()?;
        let alone: Vec<Pair<'_>> = pairs.iter().map(|(pair, _)| *pair).collect();
        visit(pairing.sides, &alone, monitor, |at, frame, images| {
            work[at].add(frame, images, settings)?;
            monitor.advance(1);
            Ok(())
        })?;
        Ok(work.into_iter().map(|work| work.report).collect::<Vec<_>>())
    })?;
    Ok(Comparison {
        streams: reports.into_iter().flatten().collect(),
        missing: pairing.missing.clone(),
        clipped_in_containers: [0, 1].map(|at| pairing.sides[at].clipped_pixels.unwrap_or(0)),
    })
}

fn streams_at_once(pairing: &Pairing<'_>, settings: &CompareSettings) -> Result<usize> {
    let memory = settings.memory;
    if memory.bytes.is_none() {
        return Ok(usize::MAX);
    }
    // Files that several pairs share are read once, so these pairs are compared one after the other.
    let of_run = |pairs: &[Pair<'_>]| {
        let of_side = |at: usize| {
            let bytes = pairs.iter().map(|pair| pairing.sides[at].stream_bytes(pair.streams[at]));
            if pairing.sides[at].form == SideForm::Container { bytes.sum() } else { bytes.max().unwrap_or(0) }
        };
        let of_pair = |pair: &Pair<'_>| {
            let stream = pair.streams[0];
            let [width, height] = stream.size.map(u64::from);
            let scores = settings.ssimulacra2 && stream.id.kind == StreamKind::Color;
            width * height * comparing_bytes(pair, settings) + if scores { scoring_bytes(stream.size) } else { 0 }
        };
        of_side(0) + of_side(1) + pairs.iter().map(of_pair).max().unwrap_or(0)
    };
    let each = pairing.pairs.chunk_by(Pair::shares_files).map(of_run).max().unwrap_or(0);
    let fixed = pairing.sides.iter().map(Side::open_bytes).sum();
    memory.at_once(
        &Need {
            what: "comparing",
            fixed,
            each,
            instead: if settings.ssimulacra2 { "leave out `ssimulacra2`" } else { "" },
        },
        rayon::current_num_threads(),
    )
}

fn visit(
    sides: &[Side; 2],
    pairs: &[Pair<'_>],
    monitor: &dyn Monitor,
    mut compare: impl FnMut(usize, u32, [Image; 2]) -> Result<()>,
) -> Result<()> {
    let [mut first, mut second] =
        [0, 1].map(|at| SideReader::new(&sides[at], pairs.iter().map(|pair| pair.streams[at]).collect()));
    let ranges = pairs.iter().map(|pair| pair.frames);
    let all = ranges.reduce(FrameRange::hull);
    for frame in all.iter().flat_map(|range| range.iter()) {
        for (at, pair) in pairs.iter().enumerate().filter(|(_, pair)| pair.frames.contains(frame)) {
            monitor.check()?;
            let images = [first.image(at, frame)?, second.image(at, pair.other_frame(frame))?];
            compare(at, frame, images)
                .map_err(|error| error.context(format!("{}, frame {frame}", pair.streams[0].id)))?;
        }
    }
    Ok(())
}

/// Returns the domain of each pair; unknown depth ranges are found by reading both sides.
fn domains(pairing: &Pairing<'_>, color: ColorDomain, at_once: usize, monitor: &dyn Monitor) -> Result<Vec<Domain>> {
    let known: Vec<_> = pairing.pairs.iter().map(|pair| Domain::of_pair(pairing.sides, pair.streams, color)).collect();
    let unknown: Vec<Pair<'_>> =
        pairing.pairs.iter().zip(&known).filter(|(_, domain)| domain.is_none()).map(|(pair, _)| *pair).collect();
    let chunks: Vec<_> = unknown.chunk_by(|one, next| one.shares_files(next)).collect();
    let extents = try_map_at_once(chunks, at_once, |pairs| {
        let mut extents = vec![None; pairs.len()];
        visit(pairing.sides, pairs, monitor, |at, _, images| {
            for image in &images {
                if let Image::File(Values::Metres(plane)) = image {
                    let found = DepthExtent::of(plane);
                    extents[at] = [extents[at], found].into_iter().flatten().reduce(DepthExtent::union);
                }
            }
            Ok(())
        })?;
        Ok(extents)
    })?;
    let scanned: Vec<_> = unknown.iter().zip(extents.into_iter().flatten()).collect();
    let range_of = |pair: &Pair<'_>| {
        // All faces of a probe have one range, as in a container.
        let probe = |pair: &Pair<'_>| pair.streams.map(|stream| stream.id.probe.clone());
        let same = scanned.iter().filter(|(other, _)| probe(other) == probe(pair)).map(|(_, extent)| *extent);
        match same.flatten().reduce(DepthExtent::union) {
            Some(extent) => DepthRange::new(extent.near_m, extent.far_m),
            None => Ok(DepthRange::empty()),
        }
    };
    let domain = |(pair, known): (&Pair<'_>, Option<Domain>)| match known {
        Some(domain) => Ok(domain),
        None => Ok(Domain { coding: Coding::Depth(range_of(pair)?), origin: Origin::Default }),
    };
    pairing.pairs.iter().zip(known).map(domain).collect()
}

struct PairComparison {
    report: StreamReport,
    converters: [Converter; 2],
    metric: Option<Pu21>,
    /// True if codes are sRGB in Rec. 709 primaries.
    is_srgb: bool,
}

impl PairComparison {
    fn new(sides: &[Side; 2], pair: &Pair<'_>, domain: Domain, settings: &CompareSettings) -> Result<PairComparison> {
        let [a, b] = pair.streams;
        let metric = match domain.coding {
            Coding::Color(ColorFormat::Half { white_cd_m2 }, _) => Some(Pu21::new(white_cd_m2)?),
            _ => None,
        };
        let report = StreamReport {
            id: a.id.clone(),
            other_id: (a.id != b.id).then(|| b.id.clone()),
            size: a.size,
            frames: pair.frames,
            domain,
            measured: match domain.coding {
                Coding::Depth(_) => Measured::Depth(DepthErrors::default()),
                Coding::Color(..) => {
                    Measured::Color(SampleErrors::empty(metric.as_ref().map_or(U8_PEAK, Quality::peak)))
                }
                Coding::Bytes => Measured::Bytes(SampleErrors::empty(U8_PEAK)),
            },
            bits: (settings.measure == Measure::Bits).then(BitErrors::default),
        };
        let primaries = domain.primaries(sides);
        let is_srgb = match domain.coding {
            Coding::Color(ColorFormat::EightBit(tone), _) => {
                tone.transfer == Transfer::Srgb && primaries == Primaries::REC709
            }
            _ => false,
        };
        let color = ComparedColor { primaries, allows_clipping: settings.allow_clipping };
        let converters = [0, 1].map(|at| Converter::new(domain.coding, &sides[at], pair.streams[at], color));
        Ok(PairComparison { report, converters, metric, is_srgb })
    }

    fn add(&mut self, frame: u32, images: [Image; 2], settings: &CompareSettings) -> Result<()> {
        if let Some(bits) = &mut self.report.bits {
            let values: [Values; 2] = [0, 1].map(|at| self.converters[at].values(&images[at]));
            bits.add(frame, &values[0], &values[1])?;
            self.report.measured.note_bits(bits.differing_pixels > 0);
        }
        if let [Image::File(Values::Light(a)), Image::File(Values::Light(b))] = &images {
            let [a, b] = [a, b].map(|plane| plane.data().as_flattened().iter().map(|half| half.to_bits()));
            self.report.measured.note_bits(!a.eq(b));
        }
        let [a, b] = images;
        let (a, b) = (self.converters[0].convert(a)?, self.converters[1].convert(b)?);
        let cell = match self.report.domain.coding {
            Coding::Color(_, cell) => cell,
            _ => u32::MAX,
        };
        match (&mut self.report.measured, &a.image, &b.image) {
            (Measured::Depth(errors), Converted::Depth(a), Converted::Depth(b)) => errors.add(frame, a, b),
            (Measured::Color(errors), Converted::Bytes(plane), Converted::Bytes(other)) => {
                match (&a.unclipped, &b.unclipped) {
                    (None, None) => {
                        errors.add(frame, plane, other, cell);
                        errors.add_quality(frame, [plane, other], cell);
                    }
                    (a, b) => {
                        fn wide<'a>(
                            beyond: &'a Option<Plane<[i32; 3]>>,
                            codes: &Plane<[u8; 3]>,
                        ) -> Cow<'a, Plane<[i32; 3]>> {
                            match beyond {
                                Some(beyond) => Cow::Borrowed(beyond),
                                None => Cow::Owned(codes.map(|pixel| pixel.map(i32::from))),
                            }
                        }
                        let (a, b) = (wide(a, plane), wide(b, other));
                        errors.add(frame, &a, &b, cell);
                        errors.add_quality(frame, [&a, &b], cell);
                    }
                }
                errors.clipped_pixels += a.clipped_pixels + b.clipped_pixels;
                if wants_ssim(settings.ssim, frame, self.report.frames) {
                    if let Some(ssim) = ssim(plane, other)? {
                        errors.ssim_sum += ssim;
                        errors.ssim_frames += 1;
                    }
                    errors.hvs.merge(&HvsError::of_rgb8(plane, other)?);
                    if settings.ssimulacra2 && self.is_srgb {
                        errors.eye.add(plane, other)?;
                    }
                }
            }
            (Measured::Color(errors), Converted::Half(a), Converted::Half(b)) => {
                if let Some(metric) = &self.metric {
                    let (a, b) = (half_levels(a, metric), half_levels(b, metric));
                    errors.add(frame, &a, &b, cell);
                    errors.add_quality(frame, [&a, &b], cell);
                }
            }
            (Measured::Bytes(errors), Converted::Bytes(a), Converted::Bytes(b)) => errors.add(frame, a, b, cell),
            _ => return Err(Error::invalid("images of two kinds cannot be compared")),
        }
        Ok(())
    }
}

/// Returns the SSIM, without computing it for equal images; `None` if the images are too small.
fn ssim(a: &Plane<[u8; 3]>, b: &Plane<[u8; 3]>) -> Result<Option<f64>> {
    let large = a.width().min(a.height()) >= SSIM_WINDOW;
    if large && a == b { Ok(Some(1.0)) } else { ssim_rgb8(a, b) }
}

fn wants_ssim(which: SsimFrames, frame: u32, frames: FrameRange) -> bool {
    match which {
        SsimFrames::Every => true,
        SsimFrames::None => false,
        SsimFrames::Sampled => {
            let middle = frames.first + (frames.last - frames.first) / 2;
            [frames.first, middle, frames.last].contains(&frame)
        }
    }
}
