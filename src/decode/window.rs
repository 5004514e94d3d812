//! Checks the window rule (depth.md 4) of whole streams, for `decode --verify`.

use crate::container::{ChunkEntry, Payload};
use crate::decode::decoder::Decoder;
use crate::decode::selection::{Request, StreamFrames};
use crate::error::Result;
use crate::ordered::try_map_ordered;
use crate::streams::{CodecHeader, DepthChunk, MaterialChunk, PictureChunk, StreamInfo};

/// Checks all chunks of depth and material that hold requested frames.
///
/// # Errors
/// [`crate::Error::Invalid`] for the first chunk that is damaged or breaks the rule.
pub fn check_windows(decoder: &Decoder, request: &Request<'_>) -> Result<()> {
    let jobs: Vec<_> = request.streams.iter().flat_map(|part| chunks_of(decoder, part)).collect();
    try_map_ordered(jobs, |(stream, chunk)| {
        let reader = decoder.reader();
        let payload = reader.fetch(&chunk)?;
        check(stream, &chunk, payload).map_err(|error| reader.blame(&chunk, error))
    })?;
    Ok(())
}

fn chunks_of<'a>(
    decoder: &'a Decoder,
    StreamFrames { stream, frames }: &StreamFrames<'a>,
) -> impl Iterator<Item = (&'a StreamInfo, ChunkEntry)> + use<'a> {
    let (stream, frames) = (*stream, *frames);
    let window = match stream.header {
        CodecHeader::Depth(header) => header.window(),
        CodecHeader::Material(header) => header.temporal.window,
        CodecHeader::Color(_) => 1,
    };
    let chunks = decoder.reader().index().stream_chunks(stream.index).iter().filter(move |chunk| {
        let first = chunk.key.first_frame;
        window > 1 && first <= frames.last && frames.first <= first + (chunk.key.frame_count - 1)
    });
    chunks.map(move |chunk| (stream, *chunk))
}

fn check(stream: &StreamInfo, chunk: &ChunkEntry, payload: Payload) -> Result<()> {
    let ([_, _, width, height], frames) = (stream.entry.unit_rect(chunk.key.unit), chunk.key.frame_count);
    match &stream.header {
        CodecHeader::Depth(header) => {
            DepthChunk::parse(header, payload, [width, height], frames)?.check_window(header.window(), frames)
        }
        CodecHeader::Material(header) => {
            MaterialChunk::parse(header, payload, [width, height], frames)?.check_window(header.temporal.window, frames)
        }
        CodecHeader::Color(_) => Ok(()),
    }
}
