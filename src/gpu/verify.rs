//! Decodes what was chosen on a graphics device: into nothing, beside the CPU, or as images.

use crate::error::{Error, Result};
use crate::gpu::decode::{GpuDecoder, Wanted, picture_words};
use crate::gpu::device::Gpu;
use crate::gpu::family::Family;
use crate::gpu::pictures::mismatched_words;
use crate::image::sequence::FrameRange;
use crate::monitor::Monitor;
use crate::video::decode::{DecodeCost, Decoder, FaceDecoder, Picture, StreamInfo};
use crate::video::export::{Chosen, DecodeSummary, ImageSource, Images, decoded_pixel_bytes};

/// What came of decoding on two devices.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Verification {
    /// Words that differ.
    pub mismatched_words: u64,
    /// Where the first of them is.
    pub first: Option<String>,
}

/// Streams of one family whose pictures fit into one buffer, group after group.
fn groups<'a>(gpu: &Gpu, chosen: &[Chosen<'a>]) -> Vec<Vec<Chosen<'a>>> {
    let most = gpu.info.max_binding_bytes / 4;
    let mut groups: Vec<(Family, u64, Vec<Chosen<'a>>)> = Vec::new();
    for &(stream, frames) in chosen {
        let (family, words) = (Family::of(&stream.header), picture_words(stream));
        match groups.iter_mut().find(|(other, used, _)| *other == family && *used + words <= most) {
            Some((_, used, streams)) => {
                *used += words;
                streams.push((stream, frames));
            }
            None => groups.push((family, words, vec![(stream, frames)])),
        }
    }
    groups.into_iter().map(|(_, _, streams)| streams).collect()
}

/// Decodes everything chosen, frame by frame, all streams of a kernel together, and drops it. The monitor advances by
/// one for every image.
///
/// # Errors
/// A chunk is damaged, or the device fails.
pub fn decode_to_nothing(
    gpu: &Gpu,
    decoder: &Decoder,
    chosen: &[Chosen<'_>],
    monitor: &dyn Monitor,
) -> Result<DecodeSummary> {
    let mut summary = DecodeSummary::default();
    for group in groups(gpu, chosen) {
        summary = summary.plus(decode_group(gpu, decoder, &group, monitor, |_, _, _| Ok(()))?);
    }
    Ok(summary)
}

/// Decodes everything chosen on the device and on the CPU, and compares all words. The monitor advances by one for every
/// image.
///
/// # Errors
/// A chunk is damaged, or the device fails.
pub fn verify(
    gpu: &Gpu,
    decoder: &Decoder,
    chosen: &[Chosen<'_>],
    monitor: &dyn Monitor,
) -> Result<(DecodeSummary, Verification)> {
    let (mut summary, mut verification) = (DecodeSummary::default(), Verification::default());
    for group in groups(gpu, chosen) {
        let mut on_cpu: Vec<FaceDecoder<'_>> = group.iter().map(|(stream, _)| decoder.face(stream)).collect();
        let compare = |on_gpu: &mut GpuDecoder<'_>, now: &[usize], frame: u32| {
            let pictures = on_gpu.read()?;
            for &at in now {
                verification.compare(&pictures[at], &on_cpu[at].decode(frame)?, || {
                    let (probe, face) = (&decoder.probe(group[at].0).name, group[at].0.face.name());
                    format!("frame {frame} of the {} stream of {probe}/{face}", group[at].0.kind.name())
                });
            }
            Ok(())
        };
        summary = summary.plus(decode_group(gpu, decoder, &group, monitor, compare)?);
    }
    Ok((summary, verification))
}

impl Verification {
    /// Compares two pictures; `place` names them.
    pub fn compare(&mut self, one: &Picture, other: &Picture, place: impl FnOnce() -> String) {
        let words = mismatched_words(one, other);
        self.mismatched_words += words;
        if words > 0 {
            self.first.get_or_insert_with(place);
        }
    }
}

/// Decodes streams of one group; `seen` is called when some of them show a frame.
fn decode_group(
    gpu: &Gpu,
    decoder: &Decoder,
    group: &[Chosen<'_>],
    monitor: &dyn Monitor,
    mut seen: impl FnMut(&mut GpuDecoder<'_>, &[usize], u32) -> Result<()>,
) -> Result<DecodeSummary> {
    let streams: Vec<&StreamInfo> = group.iter().map(|(stream, _)| *stream).collect();
    let mut on_gpu = GpuDecoder::new(gpu, decoder, &streams)?;
    let spans = group.iter().map(|(_, frames)| *frames);
    let span = spans.reduce(|a, b| FrameRange { first: a.first.min(b.first), last: a.last.max(b.last) });
    for frame in span.into_iter().flat_map(FrameRange::iter) {
        monitor.check()?;
        let now: Vec<usize> = (0..group.len()).filter(|&at| group[at].1.contains(frame)).collect();
        let units_of = |stream: usize| (0..streams[stream].entry.unit_count()).map(move |unit| (stream, unit));
        let units = now.iter().flat_map(|&stream| units_of(stream));
        on_gpu.decode_units(&units.map(|(stream, unit)| Wanted { stream, unit, frame }).collect::<Vec<_>>())?;
        on_gpu.wait()?;
        seen(&mut on_gpu, &now, frame)?;
        monitor.advance(now.len() as u64);
    }
    let cost = on_gpu.cost();
    let pixels =
        |(stream, frames): &Chosen<'_>| frames.count() * u64::from(stream.entry.width) * u64::from(stream.entry.height);
    Ok(DecodeSummary {
        frames: group.iter().map(|(_, frames)| frames.count()).sum(),
        pixels: group.iter().map(pixels).sum(),
        bytes_out: cost.updated_pixels * streams.first().map_or(0, |stream| decoded_pixel_bytes(&stream.header)),
        cost,
    })
}

/// Images are decoded on a graphics device.
impl ImageSource for Gpu {
    fn open<'a>(&'a self, decoder: &'a Decoder, stream: &'a StreamInfo) -> Result<Box<dyn Images + 'a>> {
        Ok(Box::new(GpuDecoder::new(self, decoder, &[stream])?))
    }
}

impl Images for GpuDecoder<'_> {
    fn decode(&mut self, frame: u32) -> Result<Picture> {
        GpuDecoder::decode(self, frame)?;
        let pictures = self.read()?;
        pictures.into_iter().next().ok_or_else(|| Error::invalid("a decoder of no stream"))
    }

    fn cost(&self) -> DecodeCost {
        GpuDecoder::cost(self)
    }
}
