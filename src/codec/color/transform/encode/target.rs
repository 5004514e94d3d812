//! Search for the step, and for the weights of frames, that reach the quality target in every frame with the fewest bytes,
//! measured on decoded frames.

use std::collections::BTreeMap;
use std::rc::Rc;

use serde::{Deserialize, Serialize};

use crate::color::quality::{MAX_QUALITY, Quality, SearchSettings, Target, outside_codes};
use crate::color::transform::blocks::regions;
use crate::color::transform::domain::{ChromaSlopes, Keyed, forward};
use crate::color::transform::encode::activity;
use crate::color::transform::encode::estimate::Scales;
use crate::color::transform::encode::rate::{Counts, PricedTables, SymbolCounter, Writer};
use crate::color::transform::encode::search::{Search, SearchContext};
use crate::color::transform::encode::source::{CellSource, RegionSource, TimeBases};
use crate::color::transform::encode::tree::Tree;
use crate::color::transform::encode::weights::FrameWeights;
use crate::color::transform::palette::{CACHED, Color, ColorCache};
use crate::color::transform::payload::Header;
use crate::color::transform::reconstruct::TransformChunk;
use crate::color::transform::steps::{DELTA_UNIT, OCTAVE, StepIndices, Steps};
use crate::effort::Effort;
use crate::entropy::Encoder;
use crate::metrics::visible::{error_of, visible_error};

/// Table set whose prices the first search uses. The prices of sets for sparse chunks are too high for levels, and textures
/// would be lost.
const USUAL_SET: usize = 1;
/// λ in steps² per bit.
const LAMBDA: f32 = 0.09;
/// λ without a PSNR target: a larger λ drops textures visibly.
const LAMBDA_BY_EYE: f32 = 0.063;
/// Change of log2 of the squared error per step index.
const OCTAVES_AN_INDEX: f64 = 0.09;
/// The partition is searched again if the step changes by more indices than this.
const REPARTITION_STEP_DELTA: i32 = 8;
/// Number of trials whose step is predicted from the errors before.
const MAX_PREDICTED_TRIALS: i32 = 6;
/// Round in which the partition is searched again, with weights.
const WEIGHTED_ROUND: i32 = 2;
/// Octaves by which errors aim below the limit; increased by as much after each trial that misses the limit by less than
/// [`SMALL_EXCESS`].
const MARGIN: f64 = 0.005;
const SMALL_EXCESS: f64 = 0.1;
/// Maximum step index.
pub const COARSEST: i32 = 240;
/// Maximum slope of chroma in 16ths.
const MAX_SLOPE: f64 = 24.0;
/// Offset of step indices of half-float keys from those of bytes, at the same PSNR.
const USUAL_HALF_OFFSET: f64 = 96.0;

/// Loss of perceptual quality at step index 0 of bytes, and its factor per index, 2^(1/24).
const LOSS_OF_FINEST: f64 = 1.93;
const LOSS_A_STEP: f64 = 1.029_302_236_643_492;
/// Offset of the step indices of half floats: 16 keys are one code where [`Quality::codes_a_key`] is 1.
const HALF_KEYS_A_CODE: i32 = 64;

/// Start of the search for a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Start {
    pub step: i32,
    pub set: usize,
}

impl Start {
    /// True if a search over `sets` table sets could have ended at these values.
    pub fn is_possible(self, sets: usize) -> bool {
        (0..=COARSEST).contains(&self.step) && self.set < sets
    }
}

/// A payload that reaches the quality target.
#[derive(Debug)]
pub struct Encoded {
    pub payload: Vec<u8>,
    pub start: Start,
}

/// Encodes a chunk; `None` if no step reaches the quality target.
pub fn encode_chunk<S: Keyed, Q: Quality<S>>(
    cell: &CellSource<'_, S>,
    quality: &Q,
    search: &SearchSettings,
    tables: &PricedTables,
    start: Option<Start>,
) -> Option<Encoded> {
    let slopes = fit_slopes(cell);
    let by_eye = !matches!(search.target, Target::Psnr(_));
    let delta = |region| if by_eye { activity::delta(cell, region, quality) } else { 0 };
    let mut deltas: Vec<i8> = regions(cell.size).map(delta).collect();
    // A delta that all regions have is moved into the step.
    let shared = deltas.first().copied().filter(|first| deltas.iter().all(|delta| delta == first)).unwrap_or(0);
    deltas.iter_mut().for_each(|delta| *delta -= shared);
    let moved = DELTA_UNIT * i32::from(shared);
    let trials = Trials {
        cell,
        quality,
        tables,
        effort: search.effort,
        slopes,
        target: search.target,
        by_eye,
        moved,
        deltas,
        regions: regions(cell.size)
            .map(|region| RegionSource::new(cell, region, slopes, usize::from(by_eye)))
            .collect(),
        bases: TimeBases::up_to(cell.frames.len()),
    };
    // Without a PSNR target a chunk does not depend on earlier chunks, so that static cells do not change.
    let set = if by_eye { USUAL_SET } else { start.map_or(USUAL_SET, |start| start.set) };
    let kept = match search.target {
        Target::Step(step) => trials.at_step(Start { step: i32::from(step), set }),
        // A better quality than the target is kept, so that the same content has the same step.
        Target::Quality(least) => {
            let start = Start { step: step_of_quality::<S, Q>(least), set };
            trials.coarsest(start, start.step, visible_units(error_of(least)).saturating_sub(1))
        }
        Target::Psnr(db) => {
            let limit = quality.max_squared_error(db, 3 * cell.size[0] * cell.size[1]);
            let start = start.unwrap_or_else(|| Start { step: usual_step::<S, Q>(db), set });
            let mut kept = trials.coarsest(start, COARSEST, limit);
            if let Some(kept) = &mut kept {
                trials.balance(kept, limit);
            }
            kept
        }
    };
    kept.map(|Kept { payload, start, .. }| Encoded { payload, start })
}

/// Trees of all regions for one step.
#[derive(Debug, Clone)]
struct Trial {
    step: i32,
    header: Header,
    trees: Vec<Tree>,
}

struct Trials<'a, S, Q> {
    cell: &'a CellSource<'a, S>,
    quality: &'a Q,
    tables: &'a PricedTables,
    effort: Effort,
    slopes: ChromaSlopes,
    target: Target,
    /// True without a PSNR target: steps depend on visibility, whereas a PSNR counts all errors alike.
    by_eye: bool,
    /// Offset of the step index in all regions; `deltas` are added to it by region.
    moved: i32,
    deltas: Vec<i8>,
    regions: Vec<RegionSource>,
    bases: TimeBases,
}

/// A decoded trial: errors by frame, `None` if decoders refuse the payload because it has more leaves than its bytes allow. A
/// finer step has more bytes.
struct Measured {
    trial: Trial,
    payload: Vec<u8>,
    errors: Option<Vec<u64>>,
}

/// The best payload so far, and the errors of its frames.
struct Kept {
    payload: Vec<u8>,
    start: Start,
    errors: Vec<u64>,
    /// Trial with the partition that was searched last.
    partition: Rc<Trial>,
}

impl Measured {
    fn keeps(&self, limit: u64) -> bool {
        self.errors.as_ref().is_some_and(|errors| errors.iter().all(|&error| error <= limit))
    }
}

impl<S: Keyed, Q: Quality<S>> Trials<'_, S, Q> {
    /// Encodes at the given step, or at a finer one if decoders refuse the payload.
    fn at_step(&self, start: Start) -> Option<Kept> {
        let Measured { trial, payload, errors } =
            self.measure(start, &FrameWeights::even(self.cell.frames.len()), None);
        let set = trial.header.set;
        match errors {
            Some(errors) => Some(Kept { payload, start: Start { set, ..start }, errors, partition: trial.into() }),
            None => self.coarsest(start, COARSEST, u64::MAX),
        }
    }

    /// Finds the coarsest step up to `most` at which all frames are within the limit, with equal weights of frames.
    fn coarsest(&self, mut start: Start, most: i32, limit: u64) -> Option<Kept> {
        let even = FrameWeights::even(self.cell.frames.len());
        let (mut kept, mut too_coarse): (Option<Kept>, i32) = (None, most + 1);
        let mut partition: Option<Rc<Trial>> = None;
        for number in 0.. {
            let near = partition.take_if(|trial| (trial.step - start.step).abs() <= REPARTITION_STEP_DELTA);
            let Measured { trial, payload, errors } = self.measure(start, &even, near.as_deref());
            start.set = trial.header.set;
            let worst = errors.as_ref().and_then(|errors| errors.iter().copied().max());
            let finer = worst
                .map_or(REPARTITION_STEP_DELTA, |worst| (log2_ratio(worst, limit) / OCTAVES_AN_INDEX).ceil() as i32);
            let step = trial.step;
            partition = Some(near.unwrap_or_else(|| trial.into()));
            match errors.filter(|_| worst.is_some_and(|worst| worst <= limit)) {
                Some(errors) => kept = partition.clone().map(|partition| Kept { payload, start, errors, partition }),
                None => too_coarse = step,
            }
            let coarsest_kept = kept.as_ref().map_or(-1, |kept| kept.start.step);
            let enough = match self.effort {
                Effort::Fast => number >= 1,
                Effort::Normal => number >= 2,
                Effort::Exhaustive => false,
            };
            let between = too_coarse - coarsest_kept;
            if between <= 1
                || (enough && kept.is_some() && (number <= MAX_PREDICTED_TRIALS || between <= REPARTITION_STEP_DELTA))
            {
                break;
            }
            // Predictions converge slowly if the error hardly depends on the step. The step is then bisected, or made finer
            // by growing amounts until one is kept.
            start.step = match &kept {
                _ if number < MAX_PREDICTED_TRIALS => (step - finer).clamp(coarsest_kept + 1, too_coarse - 1),
                Some(_) => (coarsest_kept + too_coarse) / 2,
                None => (too_coarse - (REPARTITION_STEP_DELTA << (number - MAX_PREDICTED_TRIALS).min(5))).max(0),
            };
        }
        kept
    }

    /// Adjusts the weights of frames, and the step with them, until the errors of all frames are close to the limit. Keeps
    /// the smallest payload.
    fn balance(&self, kept: &mut Kept, limit: u64) {
        let mut weights = FrameWeights::even(self.cell.frames.len());
        let (mut start, mut errors, mut keeps) = (kept.start, kept.errors.clone(), true);
        let mut margin = MARGIN;
        // Errors of at least `enough` times the limit are close enough to it.
        let (rounds, enough) = match self.effort {
            Effort::Fast => (2, 0.8),
            Effort::Normal => (8, 0.985),
            Effort::Exhaustive => (24, 0.985),
        };
        for round in 0..rounds {
            let is_close = |&error: &u64| error as f64 >= enough * limit as f64;
            if (keeps && errors.iter().all(is_close)) || errors.iter().all(|&error| error == 0) {
                break;
            }
            let excess: Vec<f64> = errors.iter().map(|&error| log2_ratio(error, limit).max(-4.0) + margin).collect();
            if !keeps && excess.iter().all(|&excess| excess < SMALL_EXCESS) {
                margin += MARGIN;
            }
            start.step = (start.step - weights.follow(&excess)).clamp(0, COARSEST);
            // The partition is searched again once the weights show which frames are hard to code.
            let partition = (round != WEIGHTED_ROUND).then_some(kept.partition.as_ref());
            let measured = self.measure(start, &weights, partition);
            keeps = measured.keeps(limit);
            let Some(measured_errors) = measured.errors else { break };
            errors = measured_errors;
            start.set = measured.trial.header.set;
            if round == WEIGHTED_ROUND {
                kept.partition = measured.trial.into();
            }
            if keeps && measured.payload.len() < kept.payload.len() {
                kept.payload = measured.payload;
                kept.start = start;
            }
        }
    }

    fn measure(&self, start: Start, weights: &FrameWeights, partition: Option<&Trial>) -> Measured {
        let Trials { cell, tables, .. } = self;
        let trial = self.encode(start, weights, partition);
        let payload = self.payload(&trial);
        let parsed = TransformChunk::parse::<S>(&payload, cell.size, cell.frames.len() as u32, &tables.tables);
        let mut shown = vec![S::default(); 3 * cell.size[0] * cell.size[1]];
        let errors = parsed.ok().map(|chunk| {
            let error_of = |(frame, source): (usize, &Vec<S>)| {
                chunk.show(frame, frame.checked_sub(1), &mut shown);
                self.error(&shown, source)
            };
            cell.frames.iter().enumerate().map(error_of).collect()
        });
        Measured { trial, payload, errors }
    }

    /// Encodes at a step, with the partition of a trial or a new one.
    fn encode(&self, start: Start, weights: &FrameWeights, partition: Option<&Trial>) -> Trial {
        let colors = match partition {
            Some(trial) => trial.header.colors.clone(),
            None => self.frequent_colors(),
        };
        let steps = step_indices(start.step + self.moved, self.slopes);
        let mut header =
            Header { set: start.set, steps, slopes: self.slopes, offset_set: usize::from(self.by_eye), colors };
        let tree = |(at, region): (usize, &RegionSource)| {
            let steps = Steps::new(header.steps, header.offset_set, self.deltas[at], S::DOMAIN.steps);
            let context = SearchContext {
                header: &header,
                domain: &S::DOMAIN,
                scales: Scales::new(&steps, &S::DOMAIN),
                steps,
                prices: &self.tables.prices[start.set],
                bases: &self.bases,
                lambda: if self.by_eye { LAMBDA_BY_EYE } else { LAMBDA },
                weights,
                effort: self.effort,
            };
            match partition {
                Some(trial) => Search::requantise(region, &context, &trial.trees[at]),
                None => Search::partition(region, &context),
            }
        };
        let trees: Vec<Tree> = self.regions.iter().enumerate().map(tree).collect();
        header.colors = shared_colors(&header.colors, &trees);
        header.set = self.cheapest_set(&header, &trees);
        Trial { step: start.step, header, trees }
    }

    /// Error of a frame that the target limits: squared, or visible.
    fn error(&self, shown: &[S], source: &[S]) -> u64 {
        let Target::Quality(least) = self.target else {
            return self.quality.squared_error(shown, shown, 0, source, u64::MAX);
        };
        let codes = |samples: &[S], at: usize| [0, 1, 2].map(|channel| self.quality.code(samples[3 * at + channel]));
        let at = |x, y| [shown, source].map(|samples| codes(samples, y * self.cell.size[0] + x));
        let visible = visible_error(self.cell.size, at);
        // Exceeds the limit by as much as the worst sample outside the range exceeds its own limit.
        let excess = f64::from(self.quality.largest_outside(shown, source)) / outside_codes(least);
        visible_units(if excess > 1.0 { visible.max(error_of(least) * excess * excess) } else { visible })
    }

    fn cheapest_set(&self, header: &Header, trees: &[Tree]) -> usize {
        let mut counts = Counts::default();
        for tree in trees {
            let mut cache = ColorCache::new(&header.colors);
            tree.code(&mut SymbolCounter(&mut counts), &mut cache, S::DOMAIN.key_bits);
        }
        self.tables.cheapest(&counts).0
    }

    fn payload(&self, trial: &Trial) -> Vec<u8> {
        let write = |tree: &Tree| {
            let mut writer =
                Writer { stream: Encoder::default(), tables: &self.tables.tables.sets()[trial.header.set] };
            tree.code(&mut writer, &mut ColorCache::new(&trial.header.colors), S::DOMAIN.key_bits);
            writer.stream.finish()
        };
        let substreams: Vec<Vec<u8>> = trial.trees.iter().map(write).collect();
        trial.header.write::<S>(&self.deltas, &substreams)
    }

    /// Colours that are frequent in at least two regions, the most frequent first.
    fn frequent_colors(&self) -> Vec<Color> {
        let mut places: BTreeMap<Color, [usize; 2]> = BTreeMap::new();
        let least = 4 * self.cell.frames.len();
        for region in self.regions.iter().filter(|region| is_flat(&region.keys)) {
            let mut keys = region.keys.clone();
            keys.sort_unstable();
            for run in keys.chunk_by(|a, b| a == b).filter(|run| run.len() >= least) {
                let [regions, pixels] = places.entry(run[0]).or_default();
                *regions += 1;
                *pixels += run.len();
            }
        }
        most_frequent(places)
    }
}

/// True if at least a quarter of all pixels have the colour of the pixel before.
fn is_flat(keys: &[Color]) -> bool {
    4 * keys.windows(2).filter(|pair| pair[0] == pair[1]).count() >= keys.len()
}

/// Candidates that palettes of at least two regions have, the most frequent first.
fn shared_colors(candidates: &[Color], trees: &[Tree]) -> Vec<Color> {
    let mut places: BTreeMap<Color, [usize; 2]> = BTreeMap::new();
    for tree in trees {
        let mut colors = Vec::new();
        tree.for_each_palette(&mut |palette| colors.extend_from_slice(palette));
        colors.sort_unstable();
        for run in colors.chunk_by(|a, b| a == b).filter(|run| candidates.contains(&run[0])) {
            let [regions, uses] = places.entry(run[0]).or_default();
            *regions += 1;
            *uses += run.len();
        }
    }
    most_frequent(places)
}

fn most_frequent(places: BTreeMap<Color, [usize; 2]>) -> Vec<Color> {
    let mut shared: Vec<_> = places.into_iter().filter(|(_, [regions, _])| *regions >= 2).collect();
    shared.sort_by_key(|&(color, uses)| (std::cmp::Reverse(uses), color));
    shared.into_iter().take(CACHED).map(|(color, _)| color).collect()
}

/// Fits the slopes of chroma over luma; 0 where chroma does not follow luma.
fn fit_slopes<S: Keyed>(cell: &CellSource<'_, S>) -> ChromaSlopes {
    let (mut luma, mut chroma, mut both) = (0.0, [0.0; 2], [0.0; 2]);
    for frame in cell.frames {
        for row in frame.chunks_exact(3 * cell.size[0]) {
            let channels = |pixel: &[S; 3]| forward(pixel.map(S::key), ChromaSlopes::default(), &S::DOMAIN);
            let mut before = None;
            for pixel in row.as_chunks().0 {
                let channels = channels(pixel);
                if let Some(before) = before.replace(channels) {
                    let change: [f64; 3] = std::array::from_fn(|at| f64::from(channels[at] - before[at]));
                    luma += change[0] * change[0];
                    for at in 0..2 {
                        chroma[at] += change[at + 1] * change[at + 1];
                        both[at] += change[0] * change[at + 1];
                    }
                }
            }
        }
    }
    let slope = |at: usize| {
        // If less than a twentieth of the energy is explained, prediction would only add noise.
        let follows = both[at] * both[at] > 0.05 * luma * chroma[at];
        if follows { (16.0 * both[at] / luma).round().clamp(-MAX_SLOPE, MAX_SLOPE) as i8 } else { 0 }
    };
    ChromaSlopes { green: slope(0), orange: slope(1) }
}

/// Step indices of luma and chroma. The luma step accounts for the slopes, so that an error of a step counts the same in red,
/// green and blue.
fn step_indices(step: i32, slopes: ChromaSlopes) -> StepIndices {
    let (green, orange) = (f64::from(slopes.green) / 32.0, f64::from(slopes.orange) / 32.0);
    // Change of red, green and blue per unit of luma.
    let change = [1.0 + orange - green, 1.0 + green, 1.0 - orange - green];
    let energy: f64 = change.iter().map(|change| change * change).sum();
    // Number of indices, 16 · log2 of the length: each index is 1/8 of an octave of the energy.
    let finer = (1..64).take_while(|&at| {
        energy >= f64::from(OCTAVE[(2 * at - 1) % 16]) / 4096.0 * f64::from(1u32 << ((2 * at - 1) / 16))
    });
    let clamp = |index: i32| index.clamp(0, 255) as u8;
    StepIndices { luma: clamp(step - finer.count() as i32), chroma: clamp(step) }
}

/// Converts a visible error to units of 2^-16, in which errors are compared.
fn visible_units(error: f64) -> u64 {
    (error * 65_536.0) as u64
}

/// Step index that reaches a perceptual quality on most footage; 24 more indices double the loss.
fn step_of_quality<S: Keyed, Q: Quality<S>>(least: f64) -> i32 {
    let mut loss = LOSS_OF_FINEST;
    let mut step = 0;
    while step < COARSEST && loss * LOSS_A_STEP <= MAX_QUALITY - least {
        loss *= LOSS_A_STEP;
        step += 1;
    }
    if Q::KEYS_ARE_STEPS { step } else { (step + HALF_KEYS_A_CODE).min(COARSEST) }
}

/// Step index that reaches a PSNR on most footage.
fn usual_step<S: Keyed, Q: Quality<S>>(min_psnr_db: f64) -> i32 {
    // Step indices relative to that of 40 dB, which is usually 88 for 8-bit samples.
    let relative = (40.0 - min_psnr_db) * 3.7;
    let keys_a_step = if Q::KEYS_ARE_STEPS { 0.0 } else { USUAL_HALF_OFFSET };
    (88.0 + relative + keys_a_step).clamp(0.0, f64::from(COARSEST)) as i32
}

/// Approximates log2(a / b), with the same result on all machines; 40 for b = 0 and -40 for a = 0.
fn log2_ratio(a: u64, b: u64) -> f64 {
    if a == 0 || b == 0 {
        return if b == 0 && a > 0 { 40.0 } else { -40.0 };
    }
    let linear = |value: u64| {
        let whole = value.ilog2();
        f64::from(whole) + (value as f64 / (1u64 << whole) as f64 - 1.0)
    };
    (linear(a) - linear(b)).clamp(-40.0, 40.0)
}
