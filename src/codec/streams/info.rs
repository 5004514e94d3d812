//! Typed streams of an index, and the memory that their decoders need (container.md 2).

use std::collections::HashMap;

use crate::container::{ChunkEntry, Index, OpenLimits, StreamEntry};
use crate::depth::DepthRange;
use crate::depth::predictive::UnitArea;
use crate::error::{Error, Result};
use crate::image::{Face, FrameRange, StreamKind};
use crate::streams::header::CodecHeader;

/// A stream: the images of one kind, of one face of one probe, over a range of frames.
#[derive(Debug, Clone, PartialEq)]
pub struct StreamInfo {
    /// Index in the stream table.
    pub index: u32,
    /// Colour, depth, material or alpha.
    pub kind: StreamKind,
    /// Index in the probe table.
    pub probe: usize,
    /// Face of the probe's cube map, or its single view.
    pub face: Face,
    /// Frames, numbered as in the source.
    pub frames: FrameRange,
    #[doc(hidden)]
    pub header: CodecHeader,
    #[doc(hidden)]
    pub entry: StreamEntry,
}

impl StreamInfo {
    /// Width and height of an image in pixels.
    pub fn size(&self) -> [u32; 2] {
        [self.entry.width, self.entry.height]
    }

    #[doc(hidden)]
    pub fn unit_area(&self, unit: u32) -> UnitArea {
        UnitArea { rect: self.entry.unit_rect(unit), image: self.size() }
    }

    /// Number of tiles or cells of an image; they are numbered row by row.
    pub fn unit_count(&self) -> u32 {
        self.entry.unit_count()
    }

    /// Name of the codec, such as `quadtree` or `cells-8bit`.
    pub fn codec(&self) -> &'static str {
        self.header.codec_name()
    }

    /// Near and far of a depth stream: the depths in metres of codes 0 and 65534.
    pub fn depth_range(&self) -> Option<DepthRange> {
        if let CodecHeader::Depth(header) = &self.header { Some(header.range) } else { None }
    }

    /// Maximum error of a decoded depth in codes; `None` if the codec has no bound.
    pub fn error_bound_codes(&self) -> Option<u16> {
        if let CodecHeader::Depth(header) = &self.header { header.error_bound() } else { None }
    }

    /// True if a colour stream has half floats, false for 8 bits; `None` for other streams.
    pub fn is_half_float(&self) -> Option<bool> {
        if let CodecHeader::Color(header) = &self.header { Some(header.is_half()) } else { None }
    }

    /// Upper bound of the bytes that are needed to decode its images one after the other: units with pictures and keyframes,
    /// the assembled image, and one payload of each unit (container.md 2).
    #[doc(hidden)]
    pub fn memory_bytes(&self, index: &Index) -> u64 {
        self.bytes_with_chunks(index, |chunk| self.header.held_chunk_bytes(&self.entry, chunk))
    }

    /// As [`StreamInfo::memory_bytes`], for memory budgets: with a tighter bound of chunks, which are not read or parsed.
    #[doc(hidden)]
    pub fn parsed_bytes(&self, index: &Index) -> u64 {
        self.bytes_with_chunks(index, |chunk| self.header.parsed_chunk_bytes(&self.entry, chunk))
    }

    fn bytes_with_chunks(&self, index: &Index, held: impl Fn(&ChunkEntry) -> u64) -> u64 {
        let pixels = u64::from(self.entry.width) * u64::from(self.entry.height);
        let payloads = index.held_payload_bytes(self.index, held);
        let units = u64::from(self.entry.unit_count()) * CodecHeader::HELD_UNIT_BYTES;
        (pixels * self.header.held_pixel_bytes() + units).saturating_add(payloads)
    }
}

pub fn streams(index: &Index) -> Result<Vec<StreamInfo>> {
    // Streams with equal headers share their entropy tables.
    let mut with_tables: HashMap<([u8; 4], u8, &[u8]), CodecHeader> = HashMap::new();
    let streams = index.streams.iter().zip(0..).map(|(entry, at)| {
        let named = |error: Error| error.context(format!("stream {at}"));
        let key = (entry.codec, entry.kind, entry.codec_header.as_slice());
        let header = match with_tables.get(&key) {
            Some(header) => header.clone(),
            None => CodecHeader::read(entry).map_err(named)?,
        };
        if matches!(&header, CodecHeader::Color(color) if color.tables().is_some()) {
            with_tables.entry(key).or_insert_with(|| header.clone());
        }
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

/// Fails if decoding the streams needs more memory than a file of `file_bytes` bytes justifies (container.md 2).
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

/// [`check_memory`] for a writer that is about to finish a container. Nothing is checked if a codec header cannot be read,
/// because streams of unknown codecs can be copied.
pub fn check_written(index: &Index, file_bytes: u64) -> Result<()> {
    match streams(index) {
        Ok(streams) => check_memory(&streams, index, file_bytes, OpenLimits::DEFAULT),
        Err(_) => Ok(()),
    }
}
