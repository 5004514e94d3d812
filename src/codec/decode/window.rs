//! Checks the window rule (depth.md 4) of whole streams, for `decode --verify`.

use crate::container::ChunkEntry;
use crate::decode::decoder::Decoder;
use crate::decode::selection::{Request, StreamFrames};
use crate::error::Result;
use crate::ordered::try_map_ordered;
use crate::streams::{CodecHeader, StreamChunk, StreamInfo};

/// Checks all chunks of depth and material that hold requested frames.
pub fn check_windows(decoder: &Decoder, request: &Request<'_>) -> Result<()> {
    let jobs: Vec<_> = request.streams.iter().flat_map(|part| chunks_of(decoder, part)).collect();
    try_map_ordered(jobs, |(stream, chunk)| {
        let reader = decoder.reader();
        let parsed = StreamChunk::parse(stream, reader.index(), &chunk, reader.fetch(&chunk)?);
        let checked = parsed.and_then(|parsed| parsed.check_window(stream, chunk.key.frame_count));
        checked.map_err(|error| reader.blame(&chunk, error))
    })?;
    Ok(())
}

fn chunks_of<'a>(
    decoder: &'a Decoder,
    StreamFrames { stream, frames }: &StreamFrames<'a>,
) -> impl Iterator<Item = (&'a StreamInfo, ChunkEntry)> + use<'a> {
    let (stream, frames) = (*stream, *frames);
    let window = match &stream.header {
        CodecHeader::Depth(header) => header.window(),
        CodecHeader::Material(header) => header.temporal.window,
        CodecHeader::Color(_) | CodecHeader::Alpha(_) => 1,
    };
    let chunks = decoder.reader().index().stream_chunks(stream.index).iter().filter(move |chunk| {
        window > 1 && chunk.key.first_frame <= frames.last && frames.first <= chunk.key.last_frame()
    });
    chunks.map(move |chunk| (stream, *chunk))
}
