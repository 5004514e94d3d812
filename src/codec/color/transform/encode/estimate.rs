//! Rough costs of all blocks of a region, which select the partitions that the search tries.

use crate::color::transform::basis::{LENGTHS, length_index};
use crate::color::transform::blocks::{Block, MIN_SIDE, REGION, Shape};
use crate::color::transform::domain::{CHANNELS, Domain};
use crate::color::transform::encode::source::{RegionSource, TimeBases};
use crate::color::transform::encode::weights::FrameWeights;
use crate::color::transform::steps::{STEP_BITS, Steps};

const SQUARES: usize = (REGION / MIN_SIDE) * (REGION / MIN_SIDE);
const LEVELS: usize = 4;
/// Estimated bits of a block, and of a split.
const BLOCK_BITS: f32 = 8.0;
const SPLIT_BITS: f32 = 2.0;

/// Estimated costs in steps² + λ·bits: of a block as a whole, and of the best partition below it.
#[derive(Debug)]
pub struct Estimates {
    /// Index of a run of frames: the run with first frame f and length n is at f · frames + n - 1.
    runs: Vec<Option<usize>>,
    frames: usize,
    whole: Vec<f32>,
    best: Vec<f32>,
    /// Channels that estimates include.
    channels: Vec<usize>,
}

/// Estimated costs of a block as a whole, in quarters, and in parts.
#[derive(Debug, Clone, Copy)]
pub struct Ways {
    pub whole: f32,
    pub quarters: f32,
    pub parts: f32,
}

/// Parameters of estimates.
pub struct Pricing<'a> {
    pub bases: &'a TimeBases,
    pub scales: &'a Scales,
    pub lambda: f32,
    pub weights: &'a FrameWeights,
    /// A channel is left out if its variance is below this share of the greatest variance of a channel.
    pub min_variance: f32,
}

/// Factors from coefficients to steps, by channel, size class and length index, for each spatial frequency.
pub struct Scales(Vec<[f32; 2 * REGION]>);

impl Scales {
    pub fn new(steps: &Steps, domain: &Domain) -> Scales {
        let unit = (1u32 << (domain.fraction_bits + STEP_BITS)) as f32;
        let of = |channel, size_class, length: usize| {
            let steps = steps.of(channel, size_class, length);
            let root = (LENGTHS[length] as f32).sqrt();
            std::array::from_fn(|frequency| unit / (steps.at(frequency) as f32 * root))
        };
        let sizes = (0..CHANNELS).flat_map(|channel| (0..LEVELS).map(move |size| (channel, size)));
        Scales(
            sizes.flat_map(|(channel, size)| (0..LENGTHS.len()).map(move |length| of(channel, size, length))).collect(),
        )
    }

    pub fn of(&self, channel: usize, shape: Shape) -> &[f32] {
        let length = length_index(shape.frames).unwrap_or(0);
        &self.0[(channel * LEVELS + shape.level) * LENGTHS.len() + length][..2 * shape.side() - 1]
    }
}

impl Estimates {
    pub fn new(source: &RegionSource, pricing: &Pricing<'_>) -> Estimates {
        let frames = source.root.shape.frames;
        let mut runs = vec![None; frames * frames];
        let count = number_runs(source.root, &mut runs, 0);
        let entries = count * LEVELS * SQUARES;
        let [whole, best] = [(); 2].map(|()| vec![f32::INFINITY; entries]);
        let mut estimates = Estimates { runs, frames, whole, best, channels: busy_channels(source, pricing) };
        estimates.visit(source, source.root, pricing, &mut Vec::new());
        estimates
    }

    fn index(&self, block: Block) -> usize {
        let run = self.runs[block.place.frame * self.frames + block.shape.frames - 1].unwrap_or(0);
        let square = block.place.y / MIN_SIDE * (REGION / MIN_SIDE) + block.place.x / MIN_SIDE;
        (run * LEVELS + block.shape.level) * SQUARES + square
    }

    fn visit(&mut self, source: &RegionSource, block: Block, pricing: &Pricing<'_>, scratch: &mut Vec<f32>) {
        let index = self.index(block);
        if self.best[index].is_finite() {
            return;
        }
        if length_index(block.shape.frames).is_some() {
            let weight = pricing.weights.mean(block);
            let of = |channel| {
                let factors = pricing.scales.of(channel, block.shape);
                source.coefficients(channel, block, pricing.bases, factors, scratch);
                weight * estimate(scratch, pricing.lambda / weight)
            };
            self.whole[index] = self.channels.iter().copied().map(of).sum::<f32>() + pricing.lambda * BLOCK_BITS;
        }
        if block.shape.level > 0 {
            block.quarters().into_iter().for_each(|quarter| self.visit(source, quarter, pricing, scratch));
        }
        if block.shape.frames > 1 {
            block.parts().for_each(|part| self.visit(source, part, pricing, scratch));
        }
        let Ways { whole, quarters, parts } = self.ways(block, pricing.lambda);
        self.best[index] = whole.min(quarters).min(parts);
    }

    pub fn ways(&self, block: Block, lambda: f32) -> Ways {
        let split = lambda * SPLIT_BITS;
        let sum = |blocks: &mut dyn Iterator<Item = Block>| {
            blocks.map(|block| self.best[self.index(block)]).sum::<f32>() + split
        };
        let quarters = if block.shape.level > 0 { sum(&mut block.quarters().into_iter()) } else { f32::INFINITY };
        let parts = if block.shape.frames > 1 { sum(&mut block.parts()) } else { f32::INFINITY };
        Ways { whole: self.whole[self.index(block)], quarters, parts }
    }
}

/// Returns the channels whose variance in steps² is at least a share of the greatest variance of a channel: chroma mostly
/// splits where luma does.
fn busy_channels(source: &RegionSource, pricing: &Pricing<'_>) -> Vec<usize> {
    let side = source.root.shape.side();
    let still = Shape { frames: 1, ..source.root.shape };
    let variance = |channel: usize| source.variances[channel] * pricing.scales.of(channel, still)[side / 2].powi(2);
    let greatest = (0..CHANNELS).map(variance).fold(0.0, f32::max);
    (0..CHANNELS).filter(|&channel| variance(channel) >= pricing.min_variance * greatest).collect()
}

/// Numbers the runs of frames that a partition can have, from `next` on. Returns the number after the last.
fn number_runs(block: Block, runs: &mut [Option<usize>], mut next: usize) -> usize {
    let frames = runs.len().isqrt();
    let run = &mut runs[block.place.frame * frames + block.shape.frames - 1];
    if run.is_none() {
        *run = Some(next);
        next += 1;
    }
    if block.shape.frames > 1 {
        next = block.parts().fold(next, |next, part| number_runs(part, runs, next));
    }
    next
}

/// Estimates the error and bits of coefficients: those well below a step are dropped, others take bits by their logarithm.
fn estimate(coefficients: &[f32], lambda: f32) -> f32 {
    const LANES: usize = 16;
    // A level of 1 takes about five bits, and about one more for each octave above; rounding has an error of 1/12.
    let (base, octave) = (5.0 * lambda + 1.0 / 12.0, 0.55 * lambda);
    let mut sums = [0.0; LANES];
    for coefficients in coefficients.as_chunks::<LANES>().0 {
        for (sum, value) in sums.iter_mut().zip(coefficients) {
            let square = value * value;
            // The exponent of a float is the integer part of its logarithm, and the mantissa approximates the fraction.
            let logarithm = (square.to_bits() as i32 - 0x3f80_0000) as f32 * (1.0 / 8_388_608.0);
            let coded = base + octave * logarithm.max(0.0);
            *sum += if square < coded { square } else { coded };
        }
    }
    sums.iter().sum()
}
