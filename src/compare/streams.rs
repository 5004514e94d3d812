//! Compares two sides stream by stream: how far apart, and where most.
//!
//! Each pair of streams is brought into one domain ([`Domain`]): depth into 16-bit log codes, colour into the codes of
//! a transfer function or half floats, as the side that is a container codes them. One frame of each stream is in
//! memory at a time; streams are compared in parallel, and the result does not depend on how many at once.

use std::collections::HashMap;

use crate::color::quality::Pu21;
use crate::compare::comparison::{Comparison, Measured, Missing, StreamReport};
use crate::compare::difference::{BitErrors, SampleErrors, half_levels, half_peak};
use crate::compare::domain::{Converted, Converter, Domain, Origin, Values};
use crate::compare::side::{Coding, Image, Side, SideForm, SideReader, SideStream};
use crate::dataset::stream::StreamKind;
use crate::depth::quantise::DepthRange;
use crate::error::{Error, Result};
use crate::image::plane::Plane;
use crate::image::sequence::FrameRange;
use crate::memory::{Budget, Need};
use crate::metrics::depth_error::DepthErrors;
use crate::metrics::ssim::{SSIM_WINDOW, ssim_rgb8};
use crate::monitor::Monitor;
use crate::ordered::try_map_at_once;
use crate::streams::ColorFormat;
use crate::streams::convert::DepthExtent;

/// Bytes for each pixel of a pair of images. Each side is read as at most three floats (12) and converted to at most as many
/// (12), which makes 48; while a pair is measured there are two planes of doubles for the structural similarity (16).
const COMPARING_BYTES: u64 = 64;

/// What becomes of streams and frames that only one side has.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Coverage {
    /// They are a difference.
    #[default]
    Whole,
    /// They are left out.
    Common,
}

/// Whether bits are compared, too.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Measure {
    /// Codes alone.
    #[default]
    Codes,
    /// Codes, and the bits of metres, light and weights.
    Bits,
}

/// Which frames of a stream SSIM is computed for.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum SsimFrames {
    /// All.
    Every,
    /// The first, the middle and the last.
    #[default]
    Sampled,
    /// None.
    None,
}

/// How two sides are compared.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct CompareSettings {
    /// What only one side has.
    pub coverage: Coverage,
    /// Codes or bits.
    pub measure: Measure,
    /// SSIM.
    pub ssim: SsimFrames,
    /// Memory that images and decoders may take.
    pub memory: Budget,
}

/// Two streams that are compared.
#[derive(Debug, Clone, Copy)]
pub struct Pair<'a> {
    streams: [&'a SideStream; 2],
    /// Frames that both have, in the numbers of the first side.
    frames: FrameRange,
    /// What is added to a number for the second side.
    shift: i64,
}

/// Which streams of two sides belong together.
#[derive(Debug)]
pub struct Pairing<'a> {
    sides: &'a [Side; 2],
    pairs: Vec<Pair<'a>>,
    missing: Vec<Missing>,
}

impl<'a> Pairing<'a> {
    /// Matches streams by kind, probe and face; the only streams of a kind on both sides belong together whatever
    /// their names.
    ///
    /// # Errors
    /// When nothing belongs together, or what does cannot be compared: sizes differ, or what depth measures.
    pub fn new(sides: &'a [Side; 2], coverage: Coverage) -> Result<Pairing<'a>> {
        let [a, b] = sides;
        let by_id = |side: &'a Side| side.streams.iter().map(|stream| (&stream.id, stream)).collect::<HashMap<_, _>>();
        let (of_a, of_b) = (by_id(a), by_id(b));
        let mut matches: Vec<[Option<&SideStream>; 2]> =
            a.streams.iter().map(|stream| [Some(stream), of_b.get(&stream.id).copied()]).collect();
        matches.extend(b.streams.iter().filter(|stream| !of_a.contains_key(&stream.id)).map(|b| [None, Some(b)]));
        for kind in StreamKind::ALL {
            let only = |side: &'a Side| {
                let mut of_kind = side.streams.iter().filter(|stream| stream.id.kind == kind);
                of_kind.next().filter(|_| of_kind.next().is_none())
            };
            if let (Some(a), Some(b)) = (only(a), only(b))
                && a.id != b.id
            {
                matches.retain(|streams| streams.iter().flatten().all(|stream| stream.id.kind != kind));
                matches.push([Some(a), Some(b)]);
            }
        }
        let order = |streams: &[Option<&SideStream>; 2]| {
            let first = streams.iter().flatten().next();
            first.map(|stream| (stream.id.kind, stream.probe_order, stream.id.face))
        };
        matches.sort_by_key(order);
        let mut pairing = Pairing { sides, pairs: Vec::new(), missing: Vec::new() };
        for streams in matches {
            pairing.add(streams)?;
        }
        if pairing.pairs.is_empty() {
            return Err(pairing.nothing_in_common());
        }
        if coverage == Coverage::Common {
            pairing.missing.clear();
        }
        Ok(pairing)
    }

    fn add(&mut self, streams: [Option<&'a SideStream>; 2]) -> Result<()> {
        let [Some(a), Some(b)] = streams else {
            for (only_in, stream) in streams.iter().enumerate() {
                let lost = stream.map(|stream| Missing { only_in, id: stream.id.clone(), frames: stream.frames });
                self.missing.extend(lost);
            }
            return Ok(());
        };
        if a.size != b.size {
            let text = |stream: &SideStream| format!("{}x{} pixels", stream.size[0], stream.size[1]);
            return Err(Error::invalid(format!("{}: {} cannot be compared with {}", a.id, text(a), text(b))));
        }
        if a.id.kind == StreamKind::Depth && a.depth_kind != b.depth_kind {
            return Err(Error::Usage(format!(
                "{}: one side holds distances and the other planar depth; set `depth_kind`, and `intrinsics` for a \
                 perspective sequence",
                a.id
            )));
        }
        let single = self.sides.iter().all(|side| side.form == SideForm::Sequence)
            && [a, b].iter().all(|stream| stream.frames.count() == 1);
        let shift = if single { i64::from(b.frames.first) - i64::from(a.frames.first) } else { 0 };
        let common = if single { Some(a.frames) } else { a.frames.intersect(b.frames) };
        for (only_in, stream) in [a, b].into_iter().enumerate() {
            for frames in frames_outside(stream.frames, common.filter(|_| !single)) {
                if !single {
                    self.missing.push(Missing { only_in, id: stream.id.clone(), frames });
                }
            }
        }
        self.pairs.extend(common.map(|frames| Pair { streams: [a, b], frames, shift }));
        Ok(())
    }

    fn nothing_in_common(&self) -> Error {
        let list = |side: &Side| {
            let names: Vec<_> =
                side.streams.iter().take(3).map(|stream| format!("{} frames {}", stream.id, stream.frames)).collect();
            let more = if side.streams.len() > 3 { ", ..." } else { "" };
            format!("{} has {}{more}", side.path, names.join(", "))
        };
        let [a, b] = self.sides;
        let sequence = self.sides.iter().any(|side| side.form == SideForm::Sequence);
        let hint = if sequence { "; `probe` and `face` say what the sequence shows" } else { "" };
        Error::Usage(format!("the two have no stream and frame in common: {}; {}{hint}", list(a), list(b)))
    }

    /// The streams that belong together.
    pub fn pairs(&self) -> &[Pair<'a>] {
        &self.pairs
    }

    /// The images that will be compared, pairs of two counted once.
    pub fn images(&self) -> u64 {
        self.pairs.iter().map(|pair| pair.frames.count()).sum()
    }
}

/// The parts of a range before and after another.
fn frames_outside(all: FrameRange, inner: Option<FrameRange>) -> Vec<FrameRange> {
    let Some(inner) = inner else { return vec![all] };
    let before = (all.first < inner.first).then(|| FrameRange { first: all.first, last: inner.first - 1 });
    let after = (inner.last < all.last).then(|| FrameRange { first: inner.last + 1, last: all.last });
    before.into_iter().chain(after).collect()
}

/// Compares all pairs. The monitor advances by one for every pair of images.
///
/// # Errors
/// When an image cannot be read or decoded.
pub fn compare(pairing: &Pairing<'_>, settings: &CompareSettings, monitor: &dyn Monitor) -> Result<Comparison> {
    let at_once = streams_at_once(pairing, settings.memory)?;
    let domains = domains(pairing, at_once, monitor)?;
    let with_domains: Vec<(Pair<'_>, Domain)> = pairing.pairs.iter().copied().zip(domains).collect();
    let job = Job { sides: pairing.sides, settings, monitor };
    let jobs: Vec<_> = with_domains.chunk_by(|(one, _), (next, _)| one.shares_files(next)).collect();
    let reports = try_map_at_once(jobs, at_once, |pairs| job.run(pairs))?;
    Ok(Comparison { streams: reports.into_iter().flatten().collect(), missing: pairing.missing.clone() })
}

/// How many runs of pairs that share files may be compared at once.
fn streams_at_once(pairing: &Pairing<'_>, memory: Budget) -> Result<usize> {
    if memory.bytes().is_none() {
        return Ok(usize::MAX);
    }
    let of_pair = |pair: &Pair<'_>| {
        let pixels = u64::from(pair.streams[0].size[0]) * u64::from(pair.streams[0].size[1]);
        let decoding: u64 = pairing.sides.iter().zip(pair.streams).map(|(side, of)| side.stream_bytes(of)).sum();
        decoding + pixels * COMPARING_BYTES
    };
    let runs = pairing.pairs.chunk_by(Pair::shares_files);
    let each = runs.map(|pairs| pairs.iter().map(of_pair).sum()).max().unwrap_or(0);
    let fixed = pairing.sides.iter().map(Side::open_bytes).sum();
    memory.at_once(&Need { what: "comparing", fixed, each, instead: "" }, rayon::current_num_threads())
}

impl<'a> Pair<'a> {
    /// Whether files of either side are best read for both pairs at once.
    fn shares_files(&self, next: &Pair<'_>) -> bool {
        self.streams.iter().zip(next.streams).any(|(one, next)| one.shares_files(next))
    }

    /// The two streams.
    pub fn streams(&self) -> [&'a SideStream; 2] {
        self.streams
    }

    /// Frames that both have, in the numbers of the first side.
    pub fn frames(&self) -> FrameRange {
        self.frames
    }

    /// The frame's number on the second side.
    pub fn other_frame(&self, frame: u32) -> u32 {
        u32::try_from(i64::from(frame) + self.shift).unwrap_or(frame)
    }
}

/// Shows the images of some pairs, frame by frame.
fn visit(
    sides: &[Side; 2],
    pairs: &[Pair<'_>],
    monitor: &dyn Monitor,
    mut see: impl FnMut(usize, u32, [Image; 2]) -> Result<()>,
) -> Result<()> {
    let [mut first, mut second] =
        [0, 1].map(|at| SideReader::new(&sides[at], pairs.iter().map(|pair| pair.streams[at]).collect()));
    let ranges = pairs.iter().map(|pair| pair.frames);
    let all = ranges.reduce(FrameRange::hull);
    for frame in all.iter().flat_map(|range| range.iter()) {
        for (at, pair) in pairs.iter().enumerate().filter(|(_, pair)| pair.frames.contains(frame)) {
            monitor.check()?;
            let images = [first.image(at, frame)?, second.image(at, pair.other_frame(frame))?];
            see(at, frame, images).map_err(|error| error.context(format!("{}, frame {frame}", pair.streams[0].id)))?;
        }
    }
    Ok(())
}

/// The domain of each pair; ranges of depth that nobody knows are found by reading both sides.
fn domains(pairing: &Pairing<'_>, at_once: usize, monitor: &dyn Monitor) -> Result<Vec<Domain>> {
    let known: Vec<_> = pairing.pairs.iter().map(|pair| Domain::of_pair(pairing.sides, pair.streams)).collect();
    let unknown: Vec<Pair<'_>> =
        pairing.pairs.iter().zip(&known).filter(|(_, domain)| domain.is_none()).map(|(pair, _)| *pair).collect();
    let chunks: Vec<_> = unknown.chunk_by(|one, next| one.shares_files(next)).collect();
    let extents = try_map_at_once(chunks, at_once, |pairs| {
        let mut extents = vec![None; pairs.len()];
        visit(pairing.sides, pairs, monitor, |at, _, images| {
            for image in &images {
                if let Image::Depth(plane) = image {
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
        // One range for all faces of a probe, as a container has it.
        let probe = |pair: &Pair<'_>| pair.streams.map(|stream| stream.id.probe.clone());
        let same = scanned.iter().filter(|(other, _)| probe(other) == probe(pair)).map(|(_, extent)| *extent);
        match same.flatten().reduce(DepthExtent::union) {
            Some(extent) => DepthRange::new(extent.near_m, extent.far_m),
            None => Ok(DepthRange::empty()),
        }
    };
    pairing
        .pairs
        .iter()
        .zip(known)
        .map(|(pair, domain)| match domain {
            Some(domain) => Ok(domain),
            None => Ok(Domain { coding: Coding::Depth(range_of(pair)?), origin: Origin::Chosen }),
        })
        .collect()
}

struct Job<'a> {
    sides: &'a [Side; 2],
    settings: &'a CompareSettings,
    monitor: &'a dyn Monitor,
}

/// A pair of streams while it is compared.
struct Work {
    domain: Domain,
    frames: FrameRange,
    converters: [Converter; 2],
    metric: Option<Pu21>,
    measured: Measured,
    bits: Option<BitErrors>,
}

impl Job<'_> {
    fn run(&self, pairs: &[(Pair<'_>, Domain)]) -> Result<Vec<StreamReport>> {
        let mut work = pairs.iter().map(|(pair, domain)| self.prepare(pair, *domain)).collect::<Result<Vec<_>>>()?;
        let alone: Vec<Pair<'_>> = pairs.iter().map(|(pair, _)| *pair).collect();
        visit(self.sides, &alone, self.monitor, |at, frame, images| {
            work[at].see(frame, images, self.settings)?;
            self.monitor.advance(1);
            Ok(())
        })?;
        let report = |(pair, work): (Pair<'_>, Work)| {
            let [a, b] = pair.streams;
            StreamReport {
                id: a.id.clone(),
                other_id: (a.id != b.id).then(|| b.id.clone()),
                size: a.size,
                frames: pair.frames,
                domain: work.domain,
                measured: work.measured,
                bits: work.bits,
            }
        };
        Ok(alone.into_iter().zip(work).map(report).collect())
    }

    fn prepare(&self, pair: &Pair<'_>, domain: Domain) -> Result<Work> {
        let converter = |at: usize| Converter::new(domain.coding, &self.sides[at], pair.streams[at]);
        let metric = match domain.coding {
            Coding::Color(ColorFormat::Half { white_cd_m2 }, _) => Some(Pu21::new(white_cd_m2)?),
            _ => None,
        };
        let measured = match domain.coding {
            Coding::Depth(_) => Measured::Depth(DepthErrors::default()),
            Coding::Color(..) => Measured::Color(match &metric {
                Some(metric) => SampleErrors::empty(half_peak(metric)),
                None => SampleErrors::empty_8bit(),
            }),
            Coding::Material => Measured::Material(SampleErrors::empty_8bit()),
        };
        let bits = (self.settings.measure == Measure::Bits).then(BitErrors::default);
        Ok(Work { domain, frames: pair.frames, converters: [converter(0), converter(1)], metric, measured, bits })
    }
}

impl Work {
    fn see(&mut self, frame: u32, images: [Image; 2], settings: &CompareSettings) -> Result<()> {
        if let Some(bits) = &mut self.bits {
            let values: [Values; 2] = [0, 1].map(|at| self.converters[at].values(&images[at]));
            bits.add(frame, &values[0], &values[1])?;
        }
        let [a, b] = images;
        let ((a, clipped_a), (b, clipped_b)) = (self.converters[0].convert(a)?, self.converters[1].convert(b)?);
        let cell = match self.domain.coding {
            Coding::Color(_, cell) => cell,
            _ => u32::MAX,
        };
        match (&mut self.measured, &a, &b) {
            (Measured::Depth(errors), Converted::Depth(a), Converted::Depth(b)) => errors.add(frame, a, b),
            (Measured::Color(errors), Converted::Bytes(a), Converted::Bytes(b)) => {
                errors.add(frame, a, b, cell);
                errors.clipped_pixels += clipped_a + clipped_b;
                if wants_ssim(settings.ssim, frame, self.frames)
                    && let Some(ssim) = ssim(a, b)?
                {
                    errors.ssim_sum += ssim;
                    errors.ssim_frames += 1;
                }
            }
            (Measured::Color(errors), Converted::Half(a), Converted::Half(b)) => {
                if let Some(metric) = &self.metric {
                    errors.add(frame, &half_levels(a, metric), &half_levels(b, metric), cell);
                }
            }
            (Measured::Material(errors), Converted::Bytes(a), Converted::Bytes(b)) => errors.add(frame, a, b, cell),
            _ => return Err(Error::invalid("images of two kinds cannot be compared")),
        }
        Ok(())
    }
}

/// SSIM, at once where it is known; `None` for images that are too small.
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
