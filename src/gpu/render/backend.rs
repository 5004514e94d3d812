//! Decodes depth and colour of a playback on a device and keeps them there (CALF 6.2; GDC 5).
//!
//! Takes units to decode, and the parts of depth images to write; produces buffers from which textures are copied. Chunks are
//! uploaded after general-purpose decompression, with lists of jobs; nothing is read back.
//!
//! Each loaded probe has its own decoders, one per family of its streams, so that a probe is loaded and unloaded as a whole.

use std::collections::{BTreeMap, HashMap};
use std::ops::Add;
use std::time::{Duration, Instant};

use crate::decode::{self, UnitFrame};
use crate::family::{self, Family};
use crate::render::depth_planes::{self, DepthPlanes, ROW_WORDS, TexelWords, TilePart, TileParts};
use crate::render::scene::ImageId;
use crate::{Gpu, GpuDecoder};
use codec::decode::{Decoder, StreamInfo};
use codec::error::{Error, Result};
use codec::image::{DepthKind, StreamKind};
use codec::math::add_members;
use codec::streams::CodecHeader;
use kernels::layout::Unit;
use render::views::face_cache::{UnitId, units_under};
use render::views::{CachedUnit, DepthPart, FaceChanges, FaceUpdate, NewFace, Rect, TexelBackend, overlap};

/// Words of chunks that a decoder keeps in addition to those that the frame needs.
const KEPT_WORDS: usize = 16 << 20;
/// Range of depths in metres whose inverses remain normal floats after multiplication by a ray length.
const MULTIPLIED_M: [f32; 2] = [1e-15, 1e15];

/// Cost of decoding on the device. With [`GpuBackend::waits`], times include the device's work, otherwise only the host's.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct UnitCost {
    /// Stored bytes read from the container.
    pub bytes_read: u64,
    pub bytes_sent: u64,
    /// Time for reading, decompressing and checking chunks, and for sending them.
    pub fetching: Duration,
    pub decoding: Duration,
    /// Time for writing inverse depths.
    pub texels: Duration,
    pub pyramids: Duration,
}

pub struct GpuBackend<'a> {
    gpu: &'a Gpu,
    decoder: &'a Decoder,
    probes: HashMap<usize, ProbeUnits<'a>>,
    /// Cost of unloaded probes, and all cost other than decoding.
    cost: UnitCost,
    /// If true, waits for the device after each stage, so that times are measured per stage.
    pub waits: bool,
    /// Words of chunks that the decoders of newly loaded probes keep.
    pub kept_words: usize,
}

/// Parts of a face whose depths must be written.
struct FaceParts {
    face: usize,
    parts: Vec<DepthPart>,
}

struct ProbeUnits<'a> {
    decoders: Vec<GpuDecoder<'a>>,
    /// Index of the decoder and position in its streams, by stream index.
    places: HashMap<u32, [usize; 2]>,
    /// Indices of the depth and colour streams, by face number.
    streams: HashMap<usize, [u32; 2]>,
    planes: DepthPlanes,
}

impl ProbeUnits<'_> {
    fn cost(&self) -> UnitCost {
        let add = |sum: UnitCost, decoder: &GpuDecoder<'_>| {
            let cost = decoder.cost;
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

    fn find(&self, unit: UnitId, frame: u32) -> Option<(usize, UnitFrame)> {
        let [decoder, stream] = *self.places.get(&unit.stream)?;
        Some((decoder, UnitFrame { stream, unit: unit.unit, frame }))
    }

    /// Returns a unit of a stream, with its decoder and stream.
    fn unit(&self, stream: u32, unit: u32) -> Option<(&GpuDecoder<'_>, &StreamInfo, Unit)> {
        let [decoder, position] = *self.places.get(&stream)?;
        let decoder = self.decoders.get(decoder)?;
        Some((decoder, decoder.streams.get(position)?, *decoder.unit(position, unit)))
    }
}

fn by_family<'s>(streams: impl Iterator<Item = &'s StreamInfo>) -> Vec<Vec<&'s StreamInfo>> {
    family::groups(streams.map(|stream| (stream, Family::of(&stream.header), 0)), 0)
}

/// True if a device with buffers of at most `max_bytes` bytes can decode the depth and colour of a container for rendering:
/// every probe fits, colours are 8-bit codes, and products of inverse depths and ray lengths equal those of the CPU.
pub fn can_decode(decoder: &Decoder, max_bytes: u64) -> bool {
    let is_apt = |stream: &StreamInfo| match &stream.header {
        CodecHeader::Depth(header) => {
            let [min_m, max_m] = MULTIPLIED_M;
            header.kind == DepthKind::Planar || (header.range.near_m() >= min_m && header.range.far_m() <= max_m)
        }
        CodecHeader::Color(header) => !header.is_half(),
        CodecHeader::Material(_) => true,
        // Colour cells on the device have no alpha, so the CPU decodes these containers and the device only renders.
        CodecHeader::Alpha(_) => false,
    };
    decoder.streams().iter().all(is_apt) && buffer_bytes(decoder) <= max_bytes
}

/// Returns the size in bytes of the largest buffer that any probe of a container needs, with depth and colour of all its faces.
pub fn buffer_bytes(decoder: &Decoder) -> u64 {
    let is_decoded = |stream: &StreamInfo| stream.kind != StreamKind::Material;
    let mut probes: BTreeMap<usize, Vec<&StreamInfo>> = BTreeMap::new();
    for stream in decoder.streams().iter().filter(|stream| is_decoded(stream)) {
        probes.entry(stream.probe).or_default().push(stream);
    }
    let of_probe = |streams: &Vec<&StreamInfo>| {
        let depth = streams.iter().filter_map(|stream| match &stream.header {
            CodecHeader::Depth(header) => Some(([stream.entry.width, stream.entry.height], header.clone())),
            _ => None,
        });
        let faces: Vec<_> = depth.collect();
        let families = by_family(streams.iter().copied());
        let words = families.iter().map(|streams| decode::buffer_words(streams, ROW_WORDS));
        words.fold(depth_planes::buffer_words(&faces), u64::max)
    };
    let words = probes.values().map(of_probe).max().unwrap_or(0);
    // A blend between two chunks of colour needs both.
    let chunks = decoder.reader().index().chunks.iter();
    let chunks = chunks.filter(|chunk| decoder.streams().get(chunk.key.stream as usize).is_some_and(is_decoded));
    let chunk_bytes = chunks.map(|chunk| u64::from(chunk.raw_bytes)).max().unwrap_or(0);
    words.saturating_mul(4).max(2 * chunk_bytes)
}

impl<'a> GpuBackend<'a> {
    /// Creates a backend without loaded probes; [`can_decode`] must hold for the container.
    pub fn new(gpu: &'a Gpu, decoder: &'a Decoder) -> GpuBackend<'a> {
        let (probes, cost) = (HashMap::new(), UnitCost::default());
        GpuBackend { gpu, decoder, probes, cost, waits: false, kept_words: KEPT_WORDS }
    }

    pub fn cost(&self) -> UnitCost {
        self.probes.values().map(ProbeUnits::cost).fold(self.cost, UnitCost::add)
    }

    pub fn planes(&self, probe: usize) -> Option<&DepthPlanes> {
        self.probes.get(&probe).map(|units| &units.planes)
    }

    pub fn cells(&self, ImageId { probe, face }: ImageId, rect: Rect) -> Vec<TexelWords<'_>> {
        let Some(units) = self.probes.get(&probe) else { return Vec::new() };
        let Some([_, color]) = units.streams.get(&face) else { return Vec::new() };
        let entry = &self.decoder.streams()[*color as usize].entry;
        let part = |number: usize| {
            let (decoder, stream, unit) = units.unit(*color, number as u32)?;
            let [cell_left, cell_top, ..] = stream.entry.unit_rect(number as u32);
            let rect = overlap(rect, stream.entry.unit_rect(number as u32))?;
            let at = unit.picture + (rect[1] - cell_top) * unit.stride + rect[0] - cell_left;
            Some(TexelWords { buffer: decoder.pictures(), at, pitch: unit.stride, rect })
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

add_members!(UnitCost: bytes_read, bytes_sent, fetching, decoding, texels, pyramids);

impl<'a> GpuBackend<'a> {
    /// Creates the decoders and planes of a probe; returns them with the number of bytes sent.
    fn probe_units(&self, faces: &[NewFace<'_>]) -> Result<(ProbeUnits<'a>, u64)> {
        let streams = faces.iter().flat_map(|face| [face.depth, face.color]);
        let streams = streams.map(|stream| &self.decoder.streams()[stream as usize]);
        let (mut decoders, mut places) = (Vec::new(), HashMap::new());
        for streams in &by_family(streams) {
            for (position, stream) in streams.iter().enumerate() {
                places.insert(stream.index, [decoders.len(), position]);
            }
            let mut decoder = GpuDecoder::with_rows(self.gpu, self.decoder, streams, ROW_WORDS)?;
            decoder.kept_words = self.kept_words;
            decoders.push(decoder);
        }
        let (planes, sent) = DepthPlanes::new(self.gpu, faces)?;
        let streams = faces.iter().map(|face| (face.face, [face.depth, face.color])).collect();
        Ok((ProbeUnits { decoders, places, streams, planes }, sent))
    }
}

impl TexelBackend for GpuBackend<'_> {
    fn keeps_texels(&self) -> bool {
        true
    }

    fn load(&mut self, probe: usize, faces: &[NewFace<'_>]) -> Result<()> {
        let made = self.probe_units(faces);
        if made.is_err() {
            // Waiting frees the buffers that are dropped next as soon as no work uses them.
            self.gpu.wait()?;
        }
        let (units, sent) = made?;
        self.cost.bytes_sent += sent;
        self.probes.insert(probe, units);
        Ok(())
    }

    fn bytes(&self, probe: usize) -> u64 {
        let Some(ProbeUnits { decoders, planes, .. }) = self.probes.get(&probe) else { return 0 };
        decoders.iter().map(GpuDecoder::bytes).sum::<u64>() + planes.bytes()
    }

    fn unload(&mut self, probe: usize) {
        if let Some(units) = self.probes.remove(&probe) {
            self.cost = self.cost + units.cost();
        }
    }

    fn decode(&mut self, frame: u32, mut units: Vec<&mut CachedUnit<'_>>) -> Result<()> {
        let mut calls: BTreeMap<(usize, usize), Vec<(usize, UnitFrame)>> = BTreeMap::new();
        for (at, unit) in units.iter().enumerate() {
            let probe = unit.id.probe;
            let found = self.probes.get(&probe).and_then(|probe| probe.find(unit.id, frame));
            let (decoder, wanted) = found.ok_or_else(|| Error::invalid("a unit of a probe that is not loaded"))?;
            calls.entry((probe, decoder)).or_default().push((at, wanted));
        }
        for ((probe, decoder), wanted) in calls {
            let Some(decoder) = self.probes.get_mut(&probe).and_then(|units| units.decoders.get_mut(decoder)) else {
                continue;
            };
            decoder.decode_units(&wanted.iter().map(|(_, wanted)| *wanted).collect::<Vec<_>>())?;
            if self.waits {
                decoder.wait()?;
            }
            wanted.iter().for_each(|(at, wanted)| units[*at].set_decoded(decoder.written(*wanted)));
        }
        Ok(())
    }

    fn shows(&self, unit: &CachedUnit<'_>, frame: u32) -> bool {
        let Some(probe) = self.probes.get(&unit.id.probe) else { return false };
        probe.find(unit.id, frame).is_some_and(|(decoder, wanted)| probe.decoders[decoder].shows(wanted))
    }

    fn update(&mut self, faces: Vec<FaceUpdate<'_, '_>>) -> Result<Vec<FaceChanges>> {
        let mut by_probe: BTreeMap<usize, Vec<FaceParts>> = BTreeMap::new();
        let mut changes = Vec::new();
        for face in faces {
            let parts = face.cache.depth_parts();
            changes.push(face.cache.update_in_backend(&parts, face.texels));
            if !parts.is_empty() {
                by_probe.entry(face.probe).or_default().push(FaceParts { face: face.face, parts });
            }
        }
        for (probe, faces) in by_probe {
            // Removed from the map while it is written.
            let Some(mut units) = self.probes.remove(&probe) else { continue };
            let written = self.write_probe(&mut units, &faces);
            self.probes.insert(probe, units);
            written?;
        }
        Ok(changes)
    }

    fn bytes_read(&self) -> u64 {
        self.cost().bytes_read
    }
}

impl GpuBackend<'_> {
    fn write_probe(&mut self, probe: &mut ProbeUnits<'_>, faces: &[FaceParts]) -> Result<()> {
        let ProbeUnits { decoders, places, streams, planes } = probe;
        let mut tiles: Vec<TileParts<'_>> =
            decoders.iter().map(|decoder| TileParts { pictures: decoder.pictures(), parts: Vec::new() }).collect();
        for FaceParts { face, parts } in faces {
            let Some([depth, _]) = streams.get(face) else { continue };
            let Some(&[decoder, position]) = places.get(depth) else { continue };
            let stream = decoders[decoder].streams[position];
            debug_assert_eq!(stream.kind, StreamKind::Depth);
            for part in parts {
                let [left, top, ..] = stream.entry.unit_rect(part.unit);
                let unit = *decoders[decoder].unit(position, part.unit);
                tiles[decoder].parts.push(TilePart { face: *face, part: *part, unit, corner: [left, top] });
            }
        }
        let jobs = planes.list(&tiles);
        self.cost.bytes_sent += planes.send(self.gpu, &jobs)?;
        let start = Instant::now();
        planes.run(self.gpu, &kernels::TEXELS, &jobs.texels)?;
        self.cost.texels += self.after(start)?;
        let start = Instant::now();
        planes.run(self.gpu, &kernels::SQUARES, &jobs.squares)?;
        self.cost.pyramids += self.after(start)?;
        Ok(())
    }
}
