//! Decodes a selection on a graphics device, to measure its speed or to compare it with the CPU, and as a source of images.

use crate::decode::{UnitFrame, picture_words};
use crate::family::{self, Family};
use crate::{Gpu, GpuDecoder};
use codec::decode::{
    DecodeCost, DecodeSummary, Decoder, FaceDecoder, ImageSource, Images, Picture, Request, StreamFrames, StreamInfo,
    UnitFilter, check_windows, decoded_pixel_bytes,
};
use codec::error::{Error, Result};
use codec::image::FrameRange;
use codec::monitor::Monitor;
use kernels::pictures::mismatched_words;

/// Differences between two decoders.
#[derive(Debug, Clone, Default, PartialEq, serde::Serialize)]
pub struct Verification {
    pub mismatched_words: u64,
    #[serde(rename = "first_mismatch")]
    pub first: Option<String>,
}

/// Groups streams of one family whose pictures fit into one buffer.
fn groups<'a>(gpu: &Gpu, chosen: &[StreamFrames<'a>]) -> Vec<Vec<StreamFrames<'a>>> {
    let sized = |part: &StreamFrames<'a>| (*part, Family::of(&part.stream.header), picture_words(part.stream, 1));
    family::groups(chosen.iter().map(sized), gpu.info.max_binding_bytes / 4)
}

/// Decodes the requested frames, all streams of a family together, and discards them. The monitor advances by one per image.
pub fn decode_to_nothing(
    gpu: &Gpu,
    decoder: &Decoder,
    request: Request<'_>,
    monitor: &dyn Monitor,
) -> Result<DecodeSummary> {
    let mut summary = DecodeSummary::default();
    for group in groups(gpu, request.streams) {
        let part = Request { streams: &group, ..request };
        summary = summary + decode_group(gpu, decoder, part, monitor, |_, _, _| Ok(()))?;
    }
    Ok(summary)
}

/// Decodes the requested frames on the device and on the CPU, and compares all words. The monitor advances by one per image.
pub fn verify(
    gpu: &Gpu,
    decoder: &Decoder,
    request: Request<'_>,
    monitor: &dyn Monitor,
) -> Result<(DecodeSummary, Verification)> {
    check_windows(decoder, &request)?;
    let (mut summary, mut verification) = (DecodeSummary::default(), Verification::default());
    for group in groups(gpu, request.streams) {
        let mut on_cpu: Vec<FaceDecoder<'_>> = group.iter().map(|part| decoder.face(part.stream)).collect();
        let compare = |on_gpu: &mut GpuDecoder<'_>, now: &[usize], frame: u32| {
            let pictures = on_gpu.read_wanted(frame, request.filter)?;
            for &at in now {
                verification.compare(&pictures[at], &on_cpu[at].decode_filtered(frame, request.filter)?, || {
                    let (probe, face) = (&decoder.probe(group[at].stream).name, group[at].stream.face.name());
                    format!("frame {frame} of the {} stream of {probe}/{face}", group[at].stream.kind.name())
                });
            }
            Ok(())
        };
        let part = Request { streams: &group, ..request };
        summary = summary + decode_group(gpu, decoder, part, monitor, compare)?;
    }
    Ok((summary, verification))
}

impl Verification {
    /// Compares two pictures; `place` describes them in the report.
    pub fn compare(&mut self, one: &Picture, other: &Picture, place: impl FnOnce() -> String) {
        let words = mismatched_words(one, other);
        self.mismatched_words += words;
        if words > 0 {
            self.first.get_or_insert_with(place);
        }
    }
}

/// Decodes the streams of one group; calls `seen` for each frame, with the indices of the streams that have it.
fn decode_group(
    gpu: &Gpu,
    decoder: &Decoder,
    Request { streams: group, filter, .. }: Request<'_>,
    monitor: &dyn Monitor,
    mut seen: impl FnMut(&mut GpuDecoder<'_>, &[usize], u32) -> Result<()>,
) -> Result<DecodeSummary> {
    let streams: Vec<&StreamInfo> = group.iter().map(|part| part.stream).collect();
    let mut on_gpu = GpuDecoder::new(gpu, decoder, &streams)?.watched_by(monitor);
    let spans = group.iter().map(|part| part.frames);
    let span = spans.reduce(FrameRange::hull);
    for frame in span.into_iter().flat_map(FrameRange::iter) {
        monitor.check()?;
        let now: Vec<usize> = (0..group.len()).filter(|&at| group[at].frames.contains(frame)).collect();
        let units: Vec<UnitFrame> = now.iter().flat_map(|&stream| on_gpu.wanted(stream, frame, filter)).collect();
        on_gpu.decode_units(&units)?;
        on_gpu.wait()?;
        seen(&mut on_gpu, &now, frame)?;
        monitor.advance(now.len() as u64);
    }
    monitor.check()?;
    let cost = on_gpu.cost;
    Ok(DecodeSummary {
        frames: group.iter().map(|part| part.frames.count()).sum(),
        pixels: on_gpu.wanted_pixels,
        bytes_out: cost.updated_pixels * streams.first().map_or(0, |stream| decoded_pixel_bytes(&stream.header)),
        cost,
    })
}

impl ImageSource for Gpu {
    fn open<'a>(&'a self, decoder: &'a Decoder, stream: &'a StreamInfo) -> Result<Box<dyn Images + 'a>> {
        Ok(Box::new(GpuDecoder::new(self, decoder, &[stream])?))
    }
}

impl Images for GpuDecoder<'_> {
    fn decode_filtered(&mut self, frame: u32, filter: &dyn UnitFilter) -> Result<Picture> {
        let units = self.wanted(0, frame, filter);
        self.decode_units(&units)?;
        let pictures = self.read_wanted(frame, filter)?;
        pictures.into_iter().next().ok_or_else(|| Error::invalid("a decoder of no stream"))
    }

    fn selected_pixels(&self) -> u64 {
        self.wanted_pixels
    }

    fn cost(&self) -> DecodeCost {
        self.cost
    }
}
