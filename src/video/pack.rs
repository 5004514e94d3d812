//! Joins the streams of several containers into one, without decoding them.

use std::io::Write;

use rayon::prelude::*;

use crate::container::{ChunkKey, Index, PackedChunk, Reader, Writer};
use crate::error::{Error, Result};
use crate::monitor::Monitor;

/// Chunks fetched and compressed together.
const BATCH_CHUNKS: usize = 64;

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
/// Probes of one name must agree; streams of one kind, probe and face must not occur twice. Name, frame rate and
/// projection are the first input's; a different projection is an error. The monitor advances by one for each chunk.
pub fn pack<W: Write>(inputs: &[Reader], repack: Repack, out: W, monitor: &dyn Monitor) -> Result<(W, u64)> {
    let Some(first) = inputs.first() else { return Err(Error::Usage("pack needs at least one input".into())) };
    let head = first.index();
    let mut writer = Writer::new(out, &head.name, head.fps, head.projection)?;
    let mut merged = Index::default();
    for reader in inputs {
        let index = reader.index();
        if index.projection != head.projection {
            return Err(Error::invalid("its projection is not that of the first input").in_file(reader.path()));
        }
        let mut stream_of = Vec::new();
        for stream in &index.streams {
            let mut stream = stream.clone();
            let probe = &index.probes[usize::from(stream.probe)];
            let known = merged.probes.iter().position(|other| other.name == probe.name);
            stream.probe = match known {
                Some(at) if merged.probes[at] == *probe => at as u16,
                Some(at) => {
                    // A probe may be known from another stretch of frames; where it stands must agree.
                    let mut same = merged.probes[at].clone();
                    same.frames = probe.frames;
                    if same != *probe {
                        let message = format!("probe '{}' stands elsewhere than in an earlier input", probe.name);
                        return Err(Error::invalid(message).in_file(reader.path()));
                    }
                    let [a, b] = [merged.probes[at].frames, probe.frames];
                    merged.probes[at].frames = [a[0].min(b[0]), a[1].max(b[1])];
                    at as u16
                }
                None => {
                    merged.probes.push(probe.clone());
                    u16::try_from(merged.probes.len() - 1).map_err(|_| Error::unsupported("more than 65536 probes"))?
                }
            };
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
        for batch in index.chunks.chunks(BATCH_CHUNKS) {
            monitor.check()?;
            let packed = batch
                .par_iter()
                .map(|chunk| {
                    let key = ChunkKey { stream: stream_of[chunk.key.stream as usize], ..chunk.key };
                    match repack {
                        Repack::Keep => PackedChunk::stored(chunk, key, reader.fetch_stored(chunk)?),
                        Repack::Lzma2(level) => PackedChunk::new(key, reader.fetch(chunk)?.into_vec(), Some(level)),
                        Repack::Raw => PackedChunk::new(key, reader.fetch(chunk)?.into_vec(), None),
                    }
                })
                .collect::<Result<Vec<_>>>()?;
            packed.iter().try_for_each(|chunk| writer.push(chunk))?;
            monitor.advance(batch.len() as u64);
        }
    }
    for probe in merged.probes {
        writer.add_probe(probe)?;
    }
    writer.finish()
}
