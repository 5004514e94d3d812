//! Joins the streams of several containers into one, without decoding them.

use std::collections::HashMap;
use std::io::Write;

use crate::container::{ChunkEntry, ChunkKey, Index, PackedChunk, ProbeEntry, Reader, Writer};
use crate::error::{Error, Result};
use crate::monitor::Monitor;
use crate::ordered::try_map_ordered;

/// Payload bytes fetched and compressed together, unless a single chunk has more.
const BATCH_BYTES: u64 = 256 << 20;

/// How chunks are stored in the result.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Repack {
    /// As the input stored them.
    #[default]
    Keep,
    /// LZMA2 at this preset where it helps.
    Lzma2(u32),
    /// Without compression.
    Raw,
}

/// Writes all streams of `inputs` into `out`; answers the sink and the file's size.
///
/// Probes of one name must agree; streams of one kind, probe and face must not occur twice. All
/// probes are kept, also those without streams. Name, frame rate and projection are the first input's; another frame
/// rate or projection is an error. The monitor advances by one for each chunk.
pub fn pack<W: Write>(inputs: &[Reader], repack: Repack, out: W, monitor: &dyn Monitor) -> Result<(W, u64)> {
    let Some(first) = inputs.first() else { return Err(Error::Usage("pack needs at least one input".into())) };
    let head = first.index();
    let mut writer = Writer::new(out, &head.name, head.fps, head.projection)?;
    let mut merged = Index::default();
    let mut known = HashMap::new();
    for reader in inputs {
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
            probe_of.push(merge_probe(&mut merged.probes, &mut known, probe).map_err(|e| e.in_file(reader.path()))?);
        }
        let mut stream_of = Vec::new();
        for stream in &index.streams {
            let mut stream = stream.clone();
            stream.probe = probe_of[usize::from(stream.probe)];
            let twice = |other: &&crate::container::StreamEntry| {
                (other.kind, other.probe, other.face) == (stream.kind, stream.probe, stream.face)
            };
            if merged.streams.iter().find(twice).is_some() {
                let message = format!(
                    "stream {} has the kind, probe and face of one in an earlier input: give one of them another \
                     --probe or --face when encoding",
                    stream_of.len()
                );
                return Err(Error::invalid(message).in_file(reader.path()));
            }
            merged.streams.push(stream.clone());
            stream_of.push(writer.add_stream(stream));
        }
        let mut left = index.chunks.as_slice();
        while !left.is_empty() {
            let (batch, rest) = left.split_at(batch_length(left, BATCH_BYTES));
            left = rest;
            let packed = try_map_ordered(batch.iter().collect(), |chunk| {
                monitor.check()?;
                let key = ChunkKey { stream: stream_of[chunk.key.stream as usize], ..chunk.key };
                match repack {
                    Repack::Keep => PackedChunk::stored(chunk, key, reader.fetch_stored(chunk)?),
                    Repack::Lzma2(level) => PackedChunk::new(key, reader.fetch(chunk)?.into_vec(), Some(level)),
                    Repack::Raw => PackedChunk::new(key, reader.fetch(chunk)?.into_vec(), None),
                }
            })?;
            for chunk in &packed {
                writer.push(chunk)?;
                monitor.advance(1);
            }
        }
    }
    for probe in merged.probes {
        writer.add_probe(probe)?;
    }
    writer.finish()
}

/// Adds a probe to those of the inputs before, or widens the one of its name; answers its index.
fn merge_probe(merged: &mut Vec<ProbeEntry>, known: &mut HashMap<String, u16>, probe: &ProbeEntry) -> Result<u16> {
    let Some(&at) = known.get(&probe.name) else {
        let at = u16::try_from(merged.len()).map_err(|_| Error::unsupported("more than 65536 probes"))?;
        merged.push(probe.clone());
        known.insert(probe.name.clone(), at);
        return Ok(at);
    };
    // A probe may be known from another stretch of frames; where it stands must agree.
    let earlier = &mut merged[usize::from(at)];
    if (ProbeEntry { frames: probe.frames, ..earlier.clone() }) != *probe {
        return Err(Error::invalid(format!("probe '{}' stands elsewhere than in an earlier input", probe.name)));
    }
    earlier.frames = [earlier.frames[0].min(probe.frames[0]), earlier.frames[1].max(probe.frames[1])];
    Ok(at)
}

/// How many of the next chunks have at most `limit` bytes together; at least one.
fn batch_length(chunks: &[ChunkEntry], limit: u64) -> usize {
    let mut bytes = 0;
    let fits = |chunk: &&ChunkEntry| {
        bytes += u64::from(chunk.raw_bytes.max(chunk.stored_bytes));
        bytes <= limit
    };
    chunks.iter().take_while(fits).count().max(1).min(chunks.len())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::container::Storage;
    use crate::monitor::Silent;

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
        let (file, _) = pack(&inputs, Repack::Keep, Vec::new(), &Silent).unwrap();
        let packed = Reader::from_memory(file).unwrap();
        let probes: Vec<_> = packed.index().probes.iter().map(|probe| (probe.name.as_str(), probe.frames)).collect();
        assert_eq!(probes, [("a", [0, 9]), ("b", [0, 1])]);
        let error = pack(&[input(24.0, "a", [0, 1]), input(30.0, "b", [0, 1])], Repack::Keep, Vec::new(), &Silent);
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
        assert_eq!([20, 30, 60, 110, 111].map(|limit| batch_length(&chunks, limit)), [1, 1, 2, 3, 4]);
    }
}
