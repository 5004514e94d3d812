//! JSON report of a decoding run.

use serde::Serialize;

use codec::decode::{DamagedChunk, DecodeSummary, Decoded, Decoder, MissingImages};

#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct DecodeTimes {
    /// Seconds of one run, or the median of `runs_seconds`.
    pub seconds: f64,
    /// Seconds for reading the file into memory before the runs.
    pub reading_seconds: f64,
    /// True if the runs read the container from memory.
    pub container_in_memory: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub runs_seconds: Option<Vec<f64>>,
    /// Name of the graphics device, or `cpu`.
    pub device: String,
}

#[derive(Debug, Serialize)]
pub struct DecodeReport<'a> {
    frames: u64,
    pixels: u64,
    updated_pixels: u64,
    bytes_read: u64,
    bytes_out: u64,
    /// Number of half-float pixels clipped in PNG files.
    clipped_pixels: u64,
    fetching_thread_seconds: f64,
    applying_thread_seconds: f64,
    #[serde(flatten)]
    times: &'a DecodeTimes,
    pub megapixels_per_second: f64,
    updated_megapixels_per_second: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    damaged: Option<Vec<DamagedChunkReport<'a>>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    missing: Option<Vec<MissingImagesReport<'a>>>,
}

#[derive(Debug, Serialize)]
pub struct DamagedChunkReport<'a> {
    stream: u32,
    kind: &'static str,
    probe: &'a str,
    face: &'static str,
    unit: u32,
    frames: [u32; 2],
    offset: u64,
    reason: &'a str,
}

/// Missing images of one stream, in this report and in manifests.
#[derive(Debug, Serialize)]
pub struct MissingImagesReport<'a> {
    kind: &'static str,
    probe: &'a str,
    face: &'static str,
    frames: Vec<[u32; 2]>,
}

impl<'a> DecodeReport<'a> {
    pub fn new(decoded: &Decoded, times: &'a DecodeTimes) -> DecodeReport<'a> {
        let DecodeSummary { frames, pixels, bytes_out, cost } = decoded.summary;
        let per_second = |pixels: u64| pixels as f64 / 1e6 / times.seconds.max(1e-9);
        DecodeReport {
            frames,
            pixels,
            updated_pixels: cost.updated_pixels,
            bytes_read: cost.bytes_read,
            bytes_out,
            clipped_pixels: decoded.clipped_pixels,
            fetching_thread_seconds: cost.fetching.as_secs_f64(),
            applying_thread_seconds: cost.applying.as_secs_f64(),
            times,
            megapixels_per_second: per_second(pixels),
            updated_megapixels_per_second: per_second(cost.updated_pixels),
            damaged: None,
            missing: None,
        }
    }

    #[must_use]
    pub fn with_damage(mut self, decoder: &'a Decoder, decoded: &'a Decoded) -> DecodeReport<'a> {
        self.damaged = Some(decoded.damaged.iter().map(|chunk| DamagedChunkReport::new(chunk, decoder)).collect());
        self.missing = Some(decoded.missing.iter().map(|missing| MissingImagesReport::new(missing, decoder)).collect());
        self
    }
}

impl<'a> DamagedChunkReport<'a> {
    pub fn new(chunk: &'a DamagedChunk, decoder: &'a Decoder) -> DamagedChunkReport<'a> {
        let key = chunk.chunk.key;
        let stream = &decoder.streams()[key.stream as usize];
        let frames = chunk.frames();
        DamagedChunkReport {
            stream: key.stream,
            kind: stream.kind.name(),
            probe: &decoder.probe(stream).name,
            face: stream.face.name(),
            unit: key.unit,
            frames: [frames.first, frames.last],
            offset: chunk.chunk.offset,
            reason: &chunk.reason,
        }
    }
}

impl<'a> MissingImagesReport<'a> {
    pub fn new(missing: &MissingImages, decoder: &'a Decoder) -> MissingImagesReport<'a> {
        let stream = &decoder.streams()[missing.stream as usize];
        MissingImagesReport {
            kind: stream.kind.name(),
            probe: &decoder.probe(stream).name,
            face: stream.face.name(),
            frames: missing.frames.iter().map(|range| [range.first, range.last]).collect(),
        }
    }
}
