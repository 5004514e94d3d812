//! Joins the streams of several containers into one without decoding them; with an error bound, trees are packed.

use std::collections::{HashMap, HashSet};
use std::io::Write;

use crate::pack::flatten::{FlattenSettings, Flattener, is_tree};
use codec::container::compression::DEFAULT_LZMA2_LEVEL;
use codec::container::{
    Attributes, ChunkEntry, ChunkKey, Compression, EncodedChunk, PackedChunk, Payload, PayloadKind, ProbeEntry, Reader,
    Storage, StreamEntry, Writer,
};
use codec::decode::memory;
use codec::error::{Error, Result};
use codec::memory::{Budget, Need};
use codec::monitor::Monitor;
use codec::ordered::try_map_at_once;
use codec::streams;
use codec::streams::shard::{SHARD, SHARD_FOOTAGE};
use codec::streams::{CodecHeader, FootageInfo, StreamKind};

/// Payload bytes that are fetched and compressed as one batch; a single chunk may have more.
const BATCH_BYTES: u64 = 256 << 20;
/// Batch size in bytes for chunks that are copied: no more than keeps a disk busy.
const COPIED_BATCH_BYTES: u64 = 16 << 20;

/// Bytes per pixel of a tile whose tree is packed, in addition to its chunk: the node encoder (24); known, changed and candidate
/// functions, each at most 4/3 per 16 pixels with 56 bytes, in maps that are half empty (3 times 10); codes of source and picture
/// (4); a reserve of 6.
const PACKING_BYTES: u64 = 64;

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Repack {
    #[default]
    Keep,
    /// Recompresses all chunks.
    As(Compression),
}

impl Repack {
    /// Returns the compression of the chunks that are made from `chunk`.
    fn of(self, chunk: &ChunkEntry) -> Compression {
        match (self, chunk.storage) {
            (Repack::As(compression), _) => compression,
            (Repack::Keep, Storage::Raw) => Compression::None,
            (Repack::Keep, Storage::Lzma2) => Compression::Lzma2(DEFAULT_LZMA2_LEVEL),
            (Repack::Keep, Storage::Zstd) => Compression::default(),
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PackSettings {
    pub repack: Repack,
    /// Packs trees at an error bound; if `None`, trees are copied as other streams are.
    pub flatten: Option<FlattenSettings>,
    /// Memory limit for chunks; the result does not depend on it.
    pub memory: Budget,
}

impl PackSettings {
    /// Returns true if chunks are copied unchanged.
    fn copies(&self) -> bool {
        self.repack == Repack::Keep && self.flatten.is_none()
    }
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, serde::Serialize)]
pub struct PackSummary {
    pub bytes: u64,
    /// Uncompressed size as in table 1 of CALF ([`CodecHeader::raw_pixel_bytes`]), without streams of unknown codecs.
    pub raw_bytes: u64,
    pub frames: u64,
    pub streams: u64,
    /// Number of tree streams that were converted to packed nodes.
    pub flattened_streams: u64,
    pub chunks: u64,
}

#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct PackReport {
    #[serde(flatten)]
    pub summary: PackSummary,
    pub input_bytes: u64,
    pub seconds: f64,
}

/// Writes all streams of `inputs`, none of which is a shard, to `out`. Probes with the same name must agree; streams of the same
/// kind, probe and face must not occur twice. Frame rate and projection must be the same in all inputs; the name is that of the
/// first. The monitor advances by one for each chunk.
pub(super) fn join<W: Write>(
    inputs: &[Reader],
    settings: &PackSettings,
    out: W,
    monitor: &dyn Monitor,
) -> Result<(W, PackSummary)> {
    let Some(first) = inputs.first() else { return Err(Error::Usage("pack needs at least one input".into())) };
    let head = first.index();
    let flatteners = inputs.iter().map(|reader| flatteners(reader, settings)).collect::<Result<Vec<_>>>()?;
    if settings.flatten.is_some() && flatteners.iter().flatten().all(Option::is_none) {
        return Err(Error::Usage(
            "`max_error` packs streams of the intermediate form, and no input has one: create it with lightfold \
            quadtree"
                .into(),
        ));
    }
    let (chunks_at_once, batch_bytes) = limits(inputs, settings)?;
    let mut summary = PackSummary::default();
    let mut writer = Writer::new(out, &head.name, head.fps, head.projection)?;
    let mut probes = Vec::new();
    let (mut known, mut taken) = (HashMap::new(), HashSet::new());
    for (reader, flatteners) in inputs.iter().zip(&flatteners) {
        let index = reader.index();
        if index.projection != head.projection {
            return Err(Error::invalid("its projection is not that of the first input").in_file(reader.path()));
        }
        if index.fps != head.fps {
            let message = format!(
                "its frame rate is {}, that of the first input, {}, is {}",
                index.fps,
                first.path().display(),
                head.fps
            );
            return Err(Error::invalid(message).in_file(reader.path()));
        }
        let mut probe_of = Vec::new();
        for probe in &index.probes {
            probe_of.push(merge_probe(&mut probes, &mut known, probe).map_err(|e| e.in_file(reader.path()))?);
        }
        let mut stream_of = Vec::new();
        for (stream, flattener) in index.streams.iter().zip(flatteners) {
            let mut stream = flattener.as_ref().map_or_else(|| stream.clone(), Flattener::entry);
            summary.count(&stream);
            summary.flattened_streams += u64::from(flattener.is_some());
            stream.probe = probe_of[usize::from(stream.probe)];
            if !taken.insert((stream.kind, stream.probe, stream.face)) {
                let message = format!(
                    "stream {} has the kind, probe and face of one in an earlier input: give one of them another \
                     `probe` or `face` when encoding",
                    stream_of.len()
                );
                return Err(Error::invalid(message).in_file(reader.path()));
            }
            stream_of.push(writer.add_stream(stream));
        }
        let mut left = index.chunks.as_slice();
        while !left.is_empty() {
            let (batch, rest) = left.split_at(batch_length(left, batch_bytes, |chunk| chunk));
            left = rest;
            let copier = Copier { reader, repack: settings.repack, monitor };
            let packed = try_map_at_once(batch.iter().collect(), chunks_at_once, |chunk| {
                monitor.check()?;
                let stream = stream_of[chunk.key.stream as usize];
                match &flatteners[chunk.key.stream as usize] {
                    Some(flattener) => copier.flatten(chunk, stream, flattener),
                    None => Ok(vec![copier.copy(chunk, stream)?]),
                }
            })?;
            for packed in &packed {
                packed.iter().try_for_each(|chunk| writer.push(chunk))?;
                summary.chunks += packed.len() as u64;
                monitor.advance(1);
            }
        }
    }
    for probe in probes {
        writer.add_probe(probe)?;
    }
    for (name, value) in merge_attributes(inputs.iter())?.iter() {
        writer.set_attribute(name, value.to_vec());
    }
    let (out, bytes) = writer.finish_checked(streams::check_written)?;
    Ok((out, PackSummary { bytes, ..summary }))
}

/// Returns the number of chunks to process at once, and the maximum bytes of chunks in a batch.
pub(super) fn limits(inputs: &[Reader], settings: &PackSettings) -> Result<(usize, u64)> {
    let most = if settings.copies() { COPIED_BATCH_BYTES } else { BATCH_BYTES };
    let Some(bytes) = settings.memory.bytes else { return Ok((usize::MAX, most)) };
    let of_chunk = |reader: &Reader, chunk: &ChunkEntry| {
        let stream = &reader.index().streams[chunk.key.stream as usize];
        let raw = u64::from(chunk.raw_bytes);
        let reading = match CodecHeader::read(stream) {
            Ok(header) if settings.flatten.is_some() => memory::chunk_bytes(&header, stream, chunk),
            _ => 3 * raw + u64::from(chunk.stored_bytes),
        };
        // Packing a tree needs its pictures, and the output may be as large as the input.
        let packing = match &settings.flatten {
            Some(_) if is_tree(stream) => {
                let [_, _, width, height] = stream.unit_rect(chunk.key.unit);
                raw + PACKING_BYTES * u64::from(width) * u64::from(height)
            }
            _ => raw,
        };
        reading + packing + memory::compressing_bytes(settings.repack.of(chunk), raw)
    };
    let chunks =
        inputs.iter().flat_map(|reader| reader.index().chunks.iter().map(move |chunk| of_chunk(reader, chunk)));
    let each = chunks.max().unwrap_or(0);
    // The new index is built while those of the inputs are in memory.
    let fixed = inputs.iter().map(|reader| 2 * memory::container_bytes(reader)).sum::<u64>();
    // A batch is written when all of it is packed.
    let batch_bytes = (bytes.saturating_sub(fixed + each) / 2).min(most);
    let need = Need { what: "packing", fixed: fixed + batch_bytes, each, instead: "" };
    Ok((settings.memory.at_once(&need, rayon::current_num_threads())?, batch_bytes))
}

impl PackSummary {
    pub(super) fn count(&mut self, stream: &StreamEntry) {
        let (frames, pixels) = (u64::from(stream.frame_count), u64::from(stream.width) * u64::from(stream.height));
        let raw_bytes = CodecHeader::read(stream).map_or(0, |header| header.raw_pixel_bytes());
        self.streams += 1;
        self.frames += frames;
        self.raw_bytes += frames * pixels * raw_bytes;
    }
}

fn flatteners(reader: &Reader, settings: &PackSettings) -> Result<Vec<Option<Flattener>>> {
    let streams = reader.index().streams.iter().enumerate();
    let flatteners = streams.map(|(at, stream)| match &settings.flatten {
        Some(flatten) if is_tree(stream) => Flattener::new(stream, flatten)
            .map(Some)
            .map_err(|error| error.context(format!("{}, stream {at}", reader.path().display()))),
        _ => Ok(None),
    });
    flatteners.collect()
}

pub(super) struct Copier<'a> {
    pub reader: &'a Reader,
    pub repack: Repack,
    pub monitor: &'a dyn Monitor,
}

impl Copier<'_> {
    pub fn copy(&self, chunk: &ChunkEntry, stream: u32) -> Result<PackedChunk> {
        let key = ChunkKey { stream, ..chunk.key };
        match self.repack {
            Repack::Keep => PackedChunk::stored(chunk, key, self.reader.fetch_stored(chunk)?),
            Repack::As(compression) => {
                let header = CodecHeader::read(&self.reader.index().streams[chunk.key.stream as usize]);
                let kind = header.map_or(PayloadKind::Mixed, |header| header.payload_kind());
                PackedChunk::new(key, self.reader.fetch(chunk)?.into_vec(), (compression, kind))
            }
        }
    }

    /// Copies chunks that are adjacent in the file, each to its new stream.
    pub fn copy_run(&self, chunks: &[(ChunkEntry, u32)]) -> Result<Vec<PackedChunk>> {
        if self.repack != Repack::Keep {
            return chunks.iter().map(|(chunk, stream)| self.copy(chunk, *stream)).collect();
        }
        let entries: Vec<ChunkEntry> = chunks.iter().map(|(chunk, _)| *chunk).collect();
        let stored = self.reader.fetch_stored_run(&entries)?.into_iter();
        let packed = |((chunk, stream), stored): (&(ChunkEntry, u32), Payload)| {
            PackedChunk::stored(chunk, ChunkKey { stream: *stream, ..chunk.key }, stored)
        };
        chunks.iter().zip(stored).map(packed).collect()
    }

    fn flatten(&self, chunk: &ChunkEntry, stream: u32, flattener: &Flattener) -> Result<Vec<PackedChunk>> {
        let compression = self.repack.of(chunk);
        let finished = flattener.flatten(self.reader, chunk, self.monitor)?;
        let packed = finished.into_iter().map(|EncodedChunk { first_frame, frame_count, payload }| {
            let key = ChunkKey { stream, unit: chunk.key.unit, first_frame, frame_count };
            PackedChunk::new(key, payload, (compression, PayloadKind::Unaligned))
        });
        packed.collect()
    }
}

/// Merges the attributes of all inputs, except those of shards.
pub(super) fn merge_attributes<'a>(inputs: impl Iterator<Item = &'a Reader>) -> Result<Attributes> {
    let mut merged = Attributes::default();
    let mut footage: Option<(FootageInfo, bool)> = None;
    for reader in inputs {
        let index = reader.index();
        let own_color = index.streams.iter().any(|stream| stream.kind == StreamKind::Color as u8);
        let own = FootageInfo::read(index).map_err(|error| error.in_file(reader.path()))?;
        footage = Some(match footage {
            None => (own, own_color),
            Some((mut joined, has_color)) => {
                joined.join(own, [has_color, own_color]).map_err(|error| error.in_file(reader.path()))?;
                (joined, has_color || own_color)
            }
        });
        let others = index
            .attributes
            .iter()
            .filter(|(name, _)| ![SHARD, SHARD_FOOTAGE].contains(name) && !FootageInfo::has(name));
        for (name, value) in others {
            match merged.get(name) {
                Some(earlier) if earlier != value => {
                    let message = format!("its attribute {name} is not that of an earlier input");
                    return Err(Error::invalid(message).in_file(reader.path()));
                }
                _ => merged.set(name, value.to_vec()),
            }
        }
    }
    let values = footage.map(|(footage, _)| footage.to_values()).unwrap_or_default();
    values.into_iter().for_each(|(name, value)| merged.set(name, value));
    Ok(merged)
}

/// Adds a probe, or extends the frames of the probe with its name; returns its index.
fn merge_probe(merged: &mut Vec<ProbeEntry>, known: &mut HashMap<String, u16>, probe: &ProbeEntry) -> Result<u16> {
    let Some(&at) = known.get(&probe.name) else {
        let at = u16::try_from(merged.len()).map_err(|_| Error::unsupported("more than 65536 probes"))?;
        merged.push(probe.clone());
        known.insert(probe.name.clone(), at);
        return Ok(at);
    };
    // Only the frames may differ.
    let earlier = &mut merged[usize::from(at)];
    if (ProbeEntry { frames: probe.frames, ..earlier.clone() }) != *probe {
        return Err(Error::invalid(format!(
            "probe '{}' has another position, orientation or other intrinsics than in an earlier input",
            probe.name
        )));
    }
    earlier.frames = [earlier.frames[0].min(probe.frames[0]), earlier.frames[1].max(probe.frames[1])];
    Ok(at)
}

/// Returns the number of next chunks that have at most `limit` bytes in total; at least one, if there are chunks.
pub(super) fn batch_length<T>(chunks: &[T], limit: u64, entry: impl Fn(&T) -> &ChunkEntry) -> usize {
    let mut bytes = 0;
    let fits = |chunk: &&T| {
        let chunk = entry(chunk);
        bytes += u64::from(chunk.raw_bytes.max(chunk.stored_bytes));
        bytes <= limit
    };
    chunks.iter().take_while(fits).count().max(1).min(chunks.len())
}

#[cfg(test)]
mod tests {
    use super::*;
    use codec::container::Storage;
    use codec::monitor::Silent;

    fn input(fps: f64, probe: &str, frames: [u32; 2]) -> Reader {
        let mut writer = Writer::new(Vec::new(), "sample", fps, 0).unwrap();
        let orientation = [0.0, 0.0, 0.0, 1.0];
        let (position, intrinsics) = ([0.0; 3], [0.0; 4]);
        writer.add_probe(ProbeEntry { name: probe.into(), position, orientation, frames, intrinsics }).unwrap();
        Reader::from_memory(writer.finish().unwrap().0).unwrap()
    }

    #[test]
    fn probes_without_streams_are_kept_and_frame_rates_must_agree() {
        let inputs = [input(24.0, "a", [0, 4]), input(24.0, "b", [0, 1]), input(24.0, "a", [3, 9])];
        let (file, _) = join(&inputs, &PackSettings::default(), Vec::new(), &Silent).unwrap();
        let packed = Reader::from_memory(file).unwrap();
        let probes: Vec<_> = packed.index().probes.iter().map(|probe| (probe.name.as_str(), probe.frames)).collect();
        assert_eq!(probes, [("a", [0, 9]), ("b", [0, 1])]);
        let inputs = [input(24.0, "a", [0, 1]), input(30.0, "b", [0, 1])];
        let error = join(&inputs, &PackSettings::default(), Vec::new(), &Silent);
        let message = error.unwrap_err().to_string();
        assert!(message.contains("its frame rate is 30") && message.ends_with("is 24"), "{message}");
    }

    #[test]
    fn batches_are_cut_by_bytes_and_never_empty() {
        let chunk = |raw_bytes| ChunkEntry {
            key: ChunkKey { stream: 0, unit: 0, first_frame: 0, frame_count: 1 },
            offset: 16,
            stored_bytes: 1,
            raw_bytes,
            crc32: 0,
            storage: Storage::Lzma2,
        };
        let chunks = [30, 30, 50, 1].map(chunk);
        assert_eq!([20, 30, 60, 110, 111].map(|limit| batch_length(&chunks, limit, |chunk| chunk)), [1, 1, 2, 3, 4]);
    }
}
