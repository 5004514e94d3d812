//! The streams of an index, typed, and what decoding them takes of memory (container.md 2).

use crate::container::{Index, OpenLimits, StreamEntry};
use crate::dataset::stream::StreamKind;
use crate::error::{Error, Result};
use crate::image::cube::Face;
use crate::image::sequence::FrameRange;
use crate::streams::header::CodecHeader;

/// A stream of an open container, typed.
#[derive(Debug, Clone, PartialEq)]
pub struct StreamInfo {
    /// Index in the stream table.
    pub index: u32,
    /// What its pixels are.
    pub kind: StreamKind,
    /// Index in the probe table.
    pub probe: usize,
    /// The face.
    pub face: Face,
    /// Its frames.
    pub frames: FrameRange,
    /// The codec and its settings.
    pub header: CodecHeader,
    /// Size, units and the rest.
    pub entry: StreamEntry,
}

impl StreamInfo {
    /// The most bytes that decoding its images takes, one after the other: its units, their images and keyframes, the
    /// image that is made of them, and what one payload of each unit becomes (container.md 2).
    pub fn memory_bytes(&self, index: &Index) -> u64 {
        let pixels = u64::from(self.entry.width) * u64::from(self.entry.height);
        let payloads = index.held_payload_bytes(self.index, |bytes| self.header.held_payload_bytes(bytes));
        let units = u64::from(self.entry.unit_count()) * CodecHeader::HELD_UNIT_BYTES;
        (pixels * self.header.held_pixel_bytes() + units).saturating_add(payloads)
    }
}

/// All streams of an index.
///
/// # Errors
/// [`Error::Invalid`] for a codec, codec header or face that is not known.
pub fn streams(index: &Index) -> Result<Vec<StreamInfo>> {
    let streams = index.streams.iter().zip(0..).map(|(entry, at)| {
        let named = |error: Error| error.context(format!("stream {at}"));
        let header = CodecHeader::read(entry).map_err(named)?;
        let face = Face::from_index(entry.face).ok_or_else(|| named(Error::invalid("a face that is unknown")))?;
        Ok(StreamInfo {
            index: at,
            kind: header.kind(),
            probe: usize::from(entry.probe),
            face,
            frames: FrameRange { first: entry.first_frame, last: entry.end_frame() - 1 },
            header,
            entry: entry.clone(),
        })
    });
    streams.collect()
}

/// Refuses streams whose decoding would take more memory than a file of `file_bytes` justifies (container.md 2).
///
/// # Errors
/// [`Error::Invalid`] for the first stream that is too large by itself, or for all of them together.
pub fn check_memory(streams: &[StreamInfo], index: &Index, file_bytes: u64, limits: OpenLimits) -> Result<()> {
    let mut total = 0u64;
    for stream in streams {
        let bytes = stream.memory_bytes(index);
        if bytes > limits.stream_bytes(file_bytes) {
            return Err(Error::invalid(format!(
                "stream {} of {}x{} pixels would take {bytes} bytes to decode, more than a file of {file_bytes} bytes \
                 justifies",
                stream.index, stream.entry.width, stream.entry.height
            )));
        }
        total = total.saturating_add(bytes);
    }
    if total > limits.all_streams_bytes(file_bytes) {
        return Err(Error::invalid(format!(
            "{} streams would take {total} bytes to decode, more than a file of {file_bytes} bytes justifies",
            streams.len()
        )));
    }
    Ok(())
}

/// Refuses a container of `file_bytes` that its writer is about to finish and that [`crate::decode::decoder::Decoder`] would refuse.
/// Streams of unknown codecs, which can be copied, are passed over.
///
/// # Errors
/// As for [`check_memory`].
pub fn check_written(index: &Index, file_bytes: u64) -> Result<()> {
    match streams(index) {
        Ok(streams) => check_memory(&streams, index, file_bytes, OpenLimits::DEFAULT),
        Err(_) => Ok(()),
    }
}
