//! Hard cases on a graphics device. Streams decoded in order and from arbitrary frames must equal the CPU's in every
//! word; rendered pictures must agree within bounds, and interpolated views in every pixel except at highlights.

use crate::case::Inputs;
use crate::clip::{Clip, open};
use codec::decode::StreamInfo;
use codec::error::{Error, Result};
use codec::math::random::Random;
use codec::monitor::Monitor;
use gpu::epipolar::GpuInterpolator;
use gpu::family::{self, Family};
use gpu::selftest::{pictures, slices};
use gpu::{Gpu, GpuDecoder};
use kernels::pictures::mismatched_words;

/// Maximum number of pixels of the pictures held on the device at once.
const PIXELS_TOGETHER: u64 = 8 << 20;
/// Number of frames decoded out of order.
const JUMPS: u32 = 12;

#[derive(Debug, Clone, Default)]
pub struct DeviceFigures {
    /// Number of words that differ from the CPU's and, for rendered pictures, of pixels that differ by more than
    /// allowed.
    pub mismatched_words: u64,
    pub first: Option<String>,
    pub pictures: u64,
    pub rendered: u64,
}

/// Index of a case, and one of its clips.
type Numbered<'a> = (usize, &'a Clip);

/// Decodes and renders all cases on a device and on the CPU. Returns one result per case. The monitor advances by one
/// per clip.
pub fn compare(gpu: &Gpu, inputs: &[Inputs], monitor: &dyn Monitor) -> Result<Vec<DeviceFigures>> {
    let mut figures = vec![DeviceFigures::default(); inputs.len()];
    for (figures, inputs) in figures.iter_mut().zip(inputs) {
        for case in &inputs.pictures {
            monitor.check()?;
            let agreement = pictures::run(gpu, case)?.agreement;
            figures.pictures += 1;
            figures.rendered += 1;
            figures.mismatched_words += agreement.mismatches();
            if agreement.mismatches() > 0 {
                figures.first.get_or_insert_with(|| format!("{}: {agreement:?}", case.label));
            }
        }
        for case in &inputs.interpolations {
            monitor.check()?;
            let found = slices::run(&GpuInterpolator::new(gpu), case)?;
            let views = case.views.offsets_m.len() as u64;
            figures.pictures += views;
            figures.rendered += views;
            figures.mismatched_words += found.mismatches;
            figures.first = figures.first.take().or(found.first);
        }
    }
    let all = inputs.iter().enumerate().flat_map(|(case, inputs)| inputs.clips.iter().map(move |clip| (case, clip)));
    for group in groups(all) {
        let copies: Vec<Clip> = group.iter().map(|(_, clip)| (*clip).clone()).collect();
        let decoder = open(&copies)?;
        let streams: Vec<&StreamInfo> = decoder.streams().iter().collect();
        let mut on_gpu = GpuDecoder::new(gpu, &decoder, &streams)?;
        let mut on_cpu: Vec<_> = streams.iter().map(|stream| decoder.face(stream)).collect();
        let frames = group.first().map_or(0, |(_, clip)| clip.frame_count);
        let mut random = Random::new(u64::from(frames));
        let jumps: Vec<u32> = (0..JUMPS.min(frames)).map(|_| random.below(frames)).collect();
        for frame in (0..frames).chain(jumps) {
            monitor.check()?;
            on_gpu.decode(frame)?;
            let shown = on_gpu.read()?;
            for ((&(case, clip), shown), on_cpu) in group.iter().zip(&shown).zip(&mut on_cpu) {
                let words = mismatched_words(shown, &on_cpu.decode(frame)?);
                let figures = figures.get_mut(case).ok_or_else(|| Error::invalid("a clip of no case"))?;
                figures.pictures += 1;
                figures.mismatched_words += words;
                if words > 0 {
                    figures.first.get_or_insert_with(|| format!("{}, frame {frame}", clip.what));
                }
            }
        }
        monitor.advance(group.len() as u64);
    }
    Ok(figures)
}

/// Groups clips that a device decodes together.
fn groups<'a>(clips: impl Iterator<Item = Numbered<'a>>) -> Vec<Vec<Numbered<'a>>> {
    let keyed = clips.map(|(case, clip)| {
        let pixels = clip.pixels() / u64::from(clip.frame_count.max(1));
        ((case, clip), (Family::of(&clip.header), clip.frame_count), pixels)
    });
    family::groups(keyed, PIXELS_TOGETHER)
}
