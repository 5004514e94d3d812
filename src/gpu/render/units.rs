//! Tiles and cells of a playback on a device: they are decoded there, and become texels there (CALF 6.2; GDC 5).
//!
//! Enters: which units show which frame, and which of their texels are known. Leaves: buffers that textures are copied of. What
//! goes to the device is chunks, as they are stored but for LZMA2, and lists of work; nothing comes back.
//!
//! Each probe that is shown has decoders of its own, one for each family of its streams, so that it comes and goes as one.

use std::collections::{BTreeMap, HashMap};
use std::time::{Duration, Instant};

use crate::dataset::stream::{DepthKind, StreamKind};
use crate::decode::{Decoder, StreamInfo};
use crate::error::{Error, Result};
use crate::gpu::decode::{self, GpuDecoder, Wanted};
use crate::gpu::device::Gpu;
use crate::gpu::family::{Family, PixelWords};
use crate::gpu::layout::Unit;
use crate::gpu::render::depth_planes::{self, DepthPlanes, ROW_WORDS, TileParts};
use crate::streams::CodecHeader;
use crate::views::face_cache::units_under;
use crate::views::rects::{Rect, overlap};
use crate::views::units_on_device::{FaceParts, NewFace, UnitId, UnitsOnDevice};

/// Words of chunks that a decoder keeps from frame to frame, beside those that the frame needs.
const KEPT_WORDS: usize = 16 << 20;
/// Depths in metres whose inverse is a number that devices multiply without loss.
const MULTIPLIED_M: [f32; 2] = [1e-15, 1e15];

/// What decoding on the device has cost so far. Times are of waiting only where [`DeviceUnits::wait_for_parts`] was asked for;
/// else the device works on while they are taken.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct UnitCost {
    /// Stored bytes that were read.
    pub bytes_read: u64,
    /// Bytes that went to the device.
    pub bytes_sent: u64,
    /// Time for reading, unpacking and checking chunks, and for sending them.
    pub fetching: Duration,
    /// Time for decoding.
    pub decoding: Duration,
    /// Time for writing inverse depths.
    pub texels: Duration,
    /// Time for pyramids.
    pub pyramids: Duration,
}

/// A rectangle of a cell as it lies in a buffer of pictures.
#[derive(Debug)]
pub struct CellPart<'p> {
    /// The buffer.
    pub pictures: &'p wgpu::Buffer,
    /// Word of the first texel.
    pub at: u32,
    /// Words from row to row.
    pub pitch: u32,
    /// Left, top, width and height in the face.
    pub rect: Rect,
}

/// Units of all probes that are shown.
#[derive(Debug)]
pub struct DeviceUnits<'a> {
    gpu: &'a Gpu,
    decoder: &'a Decoder,
    probes: HashMap<usize, ProbeUnits<'a>>,
    /// What probes have cost that were given up, and all but decoding.
    cost: UnitCost,
    waits: bool,
    /// Words of chunks that a decoder keeps from frame to frame, beside those that the frame needs.
    kept_words: usize,
}

/// Units of a probe.
#[derive(Debug)]
struct ProbeUnits<'a> {
    decoders: Vec<GpuDecoder<'a>>,
    /// Of streams by their index, the decoder and the position there.
    places: HashMap<u32, [usize; 2]>,
    /// Of faces by their number, the streams of depth and of colour.
    streams: HashMap<usize, [u32; 2]>,
    planes: DepthPlanes,
}

impl ProbeUnits<'_> {
    fn cost(&self) -> UnitCost {
        let add = |sum: UnitCost, decoder: &GpuDecoder<'_>| {
            let cost = decoder.cost();
            UnitCost {
                bytes_read: sum.bytes_read + cost.bytes_read,
                bytes_sent: sum.bytes_sent + decoder.bytes_sent(),
                fetching: sum.fetching + cost.fetching,
                decoding: sum.decoding + cost.applying,
                ..sum
            }
        };
        self.decoders.iter().fold(UnitCost::default(), add)
    }

    fn find(&self, unit: UnitId, frame: u32) -> Option<(usize, Wanted)> {
        let [decoder, stream] = *self.places.get(&unit.stream)?;
        Some((decoder, Wanted { stream, unit: unit.unit, frame }))
    }

    /// A unit of a stream as it lies in its buffer.
    fn unit(&self, stream: u32, unit: u32) -> Option<(&GpuDecoder<'_>, &StreamInfo, Unit)> {
        let [decoder, position] = *self.places.get(&stream)?;
        let decoder = self.decoders.get(decoder)?;
        Some((decoder, decoder.streams().get(position)?, *decoder.unit(position, unit)))
    }
}

/// Streams by their families, in the order in which they come.
fn by_family<'s>(streams: impl Iterator<Item = &'s StreamInfo>) -> Vec<Vec<&'s StreamInfo>> {
    let mut families: Vec<(Family, Vec<&StreamInfo>)> = Vec::new();
    for stream in streams {
        let family = Family::of(&stream.header);
        match families.iter_mut().find(|(other, _)| *other == family) {
            Some((_, streams)) => streams.push(stream),
            None => families.push((family, vec![stream])),
        }
    }
    families.into_iter().map(|(_, streams)| streams).collect()
}

/// Whether a device can decode the depth and colour of a container for rendering, where a buffer takes at most `most_bytes`
/// bytes: what each probe takes fits, colours are 8-bit codes, and depths that are multiplied are numbers that it multiplies as
/// the CPU does.
pub fn can_decode(decoder: &Decoder, most_bytes: u64) -> bool {
    let is_apt = |stream: &StreamInfo| match stream.header {
        CodecHeader::Depth(header) => {
            let [least_m, most_m] = MULTIPLIED_M;
            header.kind == DepthKind::Planar || (header.range.near_m() >= least_m && header.range.far_m() <= most_m)
        }
        CodecHeader::Color(_) => Family::of(&stream.header).words() == PixelWords::Bytes,
        CodecHeader::Material(_) => true,
    };
    decoder.streams().iter().all(is_apt) && buffer_bytes(decoder) <= most_bytes
}

/// Bytes of the largest buffer that any probe of a container takes, where depth and colour of all its faces are shown.
pub fn buffer_bytes(decoder: &Decoder) -> u64 {
    let is_decoded = |stream: &StreamInfo| stream.kind != StreamKind::Material;
    let mut probes: BTreeMap<usize, Vec<&StreamInfo>> = BTreeMap::new();
    for stream in decoder.streams().iter().filter(|stream| is_decoded(stream)) {
        probes.entry(stream.probe).or_default().push(stream);
    }
    let of_probe = |streams: &Vec<&StreamInfo>| {
        let faces: Vec<_> = streams
            .iter()
            .filter_map(|stream| match stream.header {
                CodecHeader::Depth(header) => {
                    Some(([stream.entry.width, stream.entry.height], (header.range, header.kind)))
                }
                _ => None,
            })
            .collect();
        let families = by_family(streams.iter().copied());
        let words = families.iter().map(|streams| decode::buffer_words(streams, ROW_WORDS));
        words.fold(depth_planes::buffer_words(&faces), u64::max)
    };
    let words = probes.values().map(of_probe).max().unwrap_or(0);
    // What lies between two chunks of colour takes both.
    let chunks = decoder.reader().index().chunks.iter();
    let chunks = chunks.filter(|chunk| decoder.streams().get(chunk.key.stream as usize).is_some_and(is_decoded));
    let chunk_bytes = chunks.map(|chunk| u64::from(chunk.raw_bytes)).max().unwrap_or(0);
    words.saturating_mul(4).max(2 * chunk_bytes)
}

impl<'a> DeviceUnits<'a> {
    /// No units yet, of a container that [`can_decode`] allows.
    pub fn new(gpu: &'a Gpu, decoder: &'a Decoder) -> DeviceUnits<'a> {
        let (probes, cost) = (HashMap::new(), UnitCost::default());
        DeviceUnits { gpu, decoder, probes, cost, waits: false, kept_words: KEPT_WORDS }
    }

    /// From now on the device is waited for after each part of the work, so that times are those of the parts.
    pub fn wait_for_parts(&mut self) {
        self.waits = true;
    }

    /// Decoders of probes that begin from now on keep so many words of chunks: for tests of what then happens.
    pub fn limit_kept(&mut self, words: usize) {
        self.kept_words = words;
    }

    /// What it has cost so far.
    pub fn cost(&self) -> UnitCost {
        self.probes.values().map(ProbeUnits::cost).fold(self.cost, UnitCost::plus)
    }

    /// Planes of a probe; none of one that is not shown.
    pub fn planes(&self, probe: usize) -> Option<&DepthPlanes> {
        self.probes.get(&probe).map(|units| &units.planes)
    }

    /// The cells that a rectangle of a face lies in, each with what they have in common.
    pub fn cells(&self, (probe, face): (usize, usize), rect: Rect) -> Vec<CellPart<'_>> {
        let Some(units) = self.probes.get(&probe) else { return Vec::new() };
        let Some([_, color]) = units.streams.get(&face) else { return Vec::new() };
        let entry = &self.decoder.streams()[*color as usize].entry;
        let part = |number: usize| {
            let (decoder, stream, unit) = units.unit(*color, number as u32)?;
            let [cell_left, cell_top, ..] = stream.entry.unit_rect(number as u32);
            let rect = overlap(rect, stream.entry.unit_rect(number as u32))?;
            let at = unit.picture + (rect[1] - cell_top) * unit.stride + rect[0] - cell_left;
            Some(CellPart { pictures: decoder.pictures(), at, pitch: unit.stride, rect })
        };
        units_under(entry, rect).filter_map(part).collect()
    }

    fn after(&self, start: Instant) -> Result<Duration> {
        if self.waits {
            self.gpu.wait()?;
        }
        Ok(start.elapsed())
    }
}

impl UnitCost {
    /// The sum of two.
    #[must_use]
    pub fn plus(self, other: UnitCost) -> UnitCost {
        UnitCost {
            bytes_read: self.bytes_read + other.bytes_read,
            bytes_sent: self.bytes_sent + other.bytes_sent,
            fetching: self.fetching + other.fetching,
            decoding: self.decoding + other.decoding,
            texels: self.texels + other.texels,
            pyramids: self.pyramids + other.pyramids,
        }
    }
}

impl<'a> DeviceUnits<'a> {
    /// The units of a probe that comes to be shown, and the bytes that were sent for them.
    fn units_of(&self, faces: &[NewFace<'_>]) -> Result<(ProbeUnits<'a>, u64)> {
        let streams = faces.iter().flat_map(|face| [face.depth, face.color]);
        let streams = streams.map(|stream| &self.decoder.streams()[stream as usize]);
        let (mut decoders, mut places) = (Vec::new(), HashMap::new());
        for streams in &by_family(streams) {
            for (position, stream) in streams.iter().enumerate() {
                places.insert(stream.index, [decoders.len(), position]);
            }
            let mut decoder = GpuDecoder::with_rows(self.gpu, self.decoder, streams, ROW_WORDS)?;
            decoder.limit_kept(self.kept_words);
            decoders.push(decoder);
        }
        let (planes, sent) = DepthPlanes::new(self.gpu, faces)?;
        let streams = faces.iter().map(|face| (face.face, [face.depth, face.color])).collect();
        Ok((ProbeUnits { decoders, places, streams, planes }, sent))
    }
}

impl UnitsOnDevice for DeviceUnits<'_> {
    fn begin(&mut self, probe: usize, faces: &[NewFace<'_>]) -> Result<()> {
        let made = self.units_of(faces);
        if made.is_err() {
            // What is given up next is free at once where no work needs it any more.
            self.gpu.wait()?;
        }
        let (units, sent) = made?;
        self.cost.bytes_sent += sent;
        self.probes.insert(probe, units);
        Ok(())
    }

    fn bytes(&self, probe: usize) -> u64 {
        let of =
            |units: &ProbeUnits<'_>| units.decoders.iter().map(GpuDecoder::bytes).sum::<u64>() + units.planes.bytes();
        self.probes.get(&probe).map_or(0, of)
    }

    fn give_up(&mut self, probe: usize) {
        if let Some(units) = self.probes.remove(&probe) {
            self.cost = self.cost.plus(units.cost());
        }
    }

    fn decode(&mut self, frame: u32, units: &[UnitId]) -> Result<Vec<u64>> {
        let mut calls: BTreeMap<(usize, usize), Vec<(usize, Wanted)>> = BTreeMap::new();
        for (at, unit) in units.iter().enumerate() {
            let found = self.probes.get(&unit.probe).and_then(|probe| probe.find(*unit, frame));
            let (decoder, wanted) = found.ok_or_else(|| Error::invalid("a unit of a probe that is not shown"))?;
            calls.entry((unit.probe, decoder)).or_default().push((at, wanted));
        }
        let mut written = vec![0; units.len()];
        for ((probe, decoder), wanted) in calls {
            let Some(decoder) = self.probes.get_mut(&probe).and_then(|units| units.decoders.get_mut(decoder)) else {
                continue;
            };
            decoder.decode_units(&wanted.iter().map(|(_, wanted)| *wanted).collect::<Vec<_>>())?;
            if self.waits {
                decoder.wait()?;
            }
            wanted.iter().for_each(|(at, wanted)| written[*at] = decoder.written(*wanted));
        }
        Ok(written)
    }

    fn shows(&self, unit: UnitId, frame: u32) -> bool {
        let Some(probe) = self.probes.get(&unit.probe) else { return false };
        probe.find(unit, frame).is_some_and(|(decoder, wanted)| probe.decoders[decoder].shows(wanted))
    }

    fn write_depths(&mut self, faces: &[FaceParts]) -> Result<()> {
        let mut by_probe: BTreeMap<usize, Vec<&FaceParts>> = BTreeMap::new();
        faces.iter().for_each(|face| by_probe.entry(face.probe).or_default().push(face));
        for (probe, faces) in by_probe {
            // Taken out for as long as it is written.
            let Some(mut units) = self.probes.remove(&probe) else { continue };
            let done = self.write_probe(&mut units, &faces);
            self.probes.insert(probe, units);
            done?;
        }
        Ok(())
    }

    fn bytes_read(&self) -> u64 {
        self.cost().bytes_read
    }
}

impl DeviceUnits<'_> {
    fn write_probe(&mut self, probe: &mut ProbeUnits<'_>, faces: &[&FaceParts]) -> Result<()> {
        let ProbeUnits { decoders, places, streams, planes } = probe;
        let mut tiles: Vec<TileParts<'_>> =
            decoders.iter().map(|decoder| TileParts { pictures: decoder.pictures(), parts: Vec::new() }).collect();
        for face in faces {
            let Some([depth, _]) = streams.get(&face.face) else { continue };
            let Some(&[decoder, position]) = places.get(depth) else { continue };
            let stream = decoders[decoder].streams()[position];
            debug_assert_eq!(stream.kind, StreamKind::Depth);
            for part in &face.parts {
                let [left, top, ..] = stream.entry.unit_rect(part.unit);
                let unit = *decoders[decoder].unit(position, part.unit);
                tiles[decoder].parts.push((face.face, *part, unit, [left, top]));
            }
        }
        let (mut start, mut took) = (Instant::now(), Vec::new());
        let sent = planes.write(self.gpu, &tiles, || {
            took.push(self.after(start)?);
            start = Instant::now();
            Ok(())
        })?;
        self.cost.bytes_sent += sent;
        self.cost.texels += took.first().copied().unwrap_or_default();
        self.cost.pyramids += took.get(1).copied().unwrap_or_default();
        Ok(())
    }
}
