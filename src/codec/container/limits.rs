//! Limits for files that claim more than their size justifies (container.md 2).

use crate::container::index::Index;
use crate::error::{Error, Result};

/// Maximum resources that a reader spends on an untrusted file (container.md 2, "What a reader spends").
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct OpenLimits {
    pub memory_floor_bytes: u64,
    /// Above the floor, memory is limited to this multiple of the file size.
    pub memory_ratio: u64,
    pub unit_frames_floor: u64,
    /// Unit frames that are allowed per byte of the file, in addition to the floor.
    pub unit_frames_ratio: u64,
    pub pixels_floor: u64,
    /// Pixels that are allowed per byte of the file, in addition to the floor.
    pub pixels_ratio: u64,
}

impl OpenLimits {
    /// Memory: 1 GiB, or 1,024 times the file size if that is more. Unit frames (units times frames): 2²⁶ plus 1,024 per byte
    /// of the file. Pixels in all frames: 2³⁸ plus 2²⁰ per byte.
    pub const DEFAULT: OpenLimits = OpenLimits {
        memory_floor_bytes: 1 << 30,
        memory_ratio: 1024,
        unit_frames_floor: 1 << 26,
        unit_frames_ratio: 1024,
        pixels_floor: 1 << 38,
        pixels_ratio: 1 << 20,
    };
    pub const NONE: OpenLimits = OpenLimits {
        memory_floor_bytes: u64::MAX,
        unit_frames_floor: u64::MAX,
        pixels_floor: u64::MAX,
        ..OpenLimits::DEFAULT
    };
    /// Memory of all streams together, as a multiple of that of one stream.
    const ALL_STREAMS: u64 = 4;

    pub fn stream_bytes(&self, file_bytes: u64) -> u64 {
        self.memory_floor_bytes.max(self.memory_ratio.saturating_mul(file_bytes))
    }

    pub fn all_streams_bytes(&self, file_bytes: u64) -> u64 {
        self.stream_bytes(file_bytes).saturating_mul(Self::ALL_STREAMS)
    }
}

impl Default for OpenLimits {
    fn default() -> Self {
        OpenLimits::DEFAULT
    }
}

/// Minimum bytes to decode one image of a stream: 3 bytes per pixel, which is the least of all codecs for an image that is
/// assembled from its units, and the largest payload of each unit.
fn min_bytes(index: &Index, at: u32) -> u64 {
    let stream = &index.streams[at as usize];
    let pixels = u64::from(stream.width) * u64::from(stream.height) * 3;
    pixels.saturating_add(index.held_payload_bytes(at, |chunk| chunk.raw_bytes.into()))
}

/// Fails if the images, payloads or frames of an index exceed `limits`. Decoders may have stricter limits.
pub fn check(index: &Index, file_bytes: u64, limits: OpenLimits) -> Result<()> {
    let (mut total, mut unit_frames, mut pixels) = (0u64, 0u64, 0u64);
    for (at, stream) in (0..).zip(&index.streams) {
        let bytes = min_bytes(index, at);
        if bytes > limits.stream_bytes(file_bytes) {
            return Err(Error::invalid(format!(
                "stream {at} claims {}x{} pixels and payloads of {} bytes, more than a file of {file_bytes} bytes justifies",
                stream.width,
                stream.height,
                index.held_payload_bytes(at, |chunk| chunk.raw_bytes.into())
            )));
        }
        total = total.saturating_add(bytes);
        let frames = u64::from(stream.frame_count);
        unit_frames = unit_frames.saturating_add(u64::from(stream.unit_count()) * frames);
        pixels = pixels.saturating_add(u64::from(stream.width) * u64::from(stream.height) * frames);
    }
    if total > limits.all_streams_bytes(file_bytes) {
        return Err(Error::invalid(format!(
            "{} streams claim images and payloads of {total} bytes, more than a file of {file_bytes} bytes justifies",
            index.streams.len()
        )));
    }
    let most = |floor: u64, ratio: u64| floor.saturating_add(ratio.saturating_mul(file_bytes));
    if unit_frames > most(limits.unit_frames_floor, limits.unit_frames_ratio)
        || pixels > most(limits.pixels_floor, limits.pixels_ratio)
    {
        return Err(Error::invalid(format!(
            "the streams claim {unit_frames} units and {pixels} pixels in all their frames, more than a file of \
             {file_bytes} bytes justifies"
        )));
    }
    Ok(())
}
