//! Rate-distortion search of the partition of a region.

use crate::color::transform::basis::length_index;
use crate::color::transform::blocks::Block;
use crate::color::transform::contexts::{self, PlaneContext};
use crate::color::transform::domain::{CHANNELS, Domain};
use crate::color::transform::encode::estimate::{Estimates, Pricing, Scales};
use crate::color::transform::encode::quantise::{Cost, Plane, Quantiser};
use crate::color::transform::encode::rate::{Prices, RateCounter, number_bits};
use crate::color::transform::encode::source::{RegionSource, TimeBases};
use crate::color::transform::encode::tree::{BlockLevels, Tree};
use crate::color::transform::encode::weights::{FrameWeights, TimeWeights};
use crate::color::transform::means::Means;
use crate::color::transform::palette::{ColorCache, MAX_COLORS, Palette};
use crate::color::transform::payload::Header;
use crate::color::transform::region::{PALETTE, PARTS, QUARTERS, TRANSFORM, note_palette};
use crate::color::transform::scan::Magnitudes;
use crate::color::transform::steps::Steps;
use crate::effort::Effort;

/// A palette estimated at fewer bits is taken without trying other modes.
const FEW_BITS: f32 = 30.0;

/// Parameters of the search of a region, besides its samples.
pub struct SearchContext<'a> {
    pub header: &'a Header,
    pub domain: &'a Domain,
    pub steps: Steps,
    pub scales: Scales,
    pub prices: &'a Prices,
    pub bases: &'a TimeBases,
    pub lambda: f32,
    pub weights: &'a FrameWeights,
    pub effort: Effort,
}

impl SearchContext<'_> {
    fn pricing(&self) -> Pricing<'_> {
        let SearchContext { bases, scales, lambda, weights, .. } = self;
        let min_variance = if self.effort == Effort::Fast { 1.0 } else { 0.1 };
        Pricing { bases, scales, lambda: *lambda, weights, min_variance }
    }

    /// Ways whose estimate is at most this factor above the best are tried.
    fn slack(&self) -> f32 {
        match self.effort {
            Effort::Fast => 1.0,
            Effort::Normal => 1.06,
            Effort::Exhaustive => f32::INFINITY,
        }
    }
}

/// State that is passed from a block to the blocks after it.
#[derive(Debug, Clone)]
struct State {
    means: Means,
    cache: ColorCache,
}

pub struct Search<'a> {
    context: &'a SearchContext<'a>,
    source: &'a RegionSource,
    estimates: Option<Estimates>,
    state: State,
    scratch: Vec<f32>,
    magnitudes: Box<PlaneMagnitudes>,
}

/// Magnitudes that quantising a block uses.
#[derive(Default)]
struct PlaneMagnitudes {
    plane: Magnitudes,
    before: Magnitudes,
    /// Maximum of the first planes of the channels before.
    channels: Magnitudes,
}

struct Found {
    tree: Tree,
    cost: Cost,
}

impl<'a> Search<'a> {
    fn new(source: &'a RegionSource, context: &'a SearchContext<'a>, estimates: Option<Estimates>) -> Search<'a> {
        let state = State { means: Means::default(), cache: ColorCache::new(&context.header.colors) };
        Search { context, source, estimates, state, scratch: Vec::new(), magnitudes: Box::default() }
    }

    /// Returns the best partition found.
    pub fn partition(source: &'a RegionSource, context: &'a SearchContext<'a>) -> Tree {
        let estimates = (context.effort != Effort::Exhaustive).then(|| Estimates::new(source, &context.pricing()));
        Search::new(source, context, estimates).node(source.root).tree
    }

    /// Returns the partition of `tree`, with levels for other steps.
    pub fn requantise(source: &'a RegionSource, context: &'a SearchContext<'a>, tree: &Tree) -> Tree {
        Search::new(source, context, None).again(tree)
    }

    fn again(&mut self, tree: &Tree) -> Tree {
        match tree {
            Tree::Transform(block, _) => match length_index(block.shape.frames) {
                Some(length) => self.transform(*block, length).tree,
                None => tree.clone(),
            },
            Tree::Palette(block, palette) => {
                let SearchContext { header, domain, .. } = self.context;
                note_palette(palette, *block, header, domain, &mut self.state.means);
                tree.clone()
            }
            Tree::Quarters(block, children) => {
                Tree::Quarters(*block, children.iter().map(|child| self.again(child)).collect())
            }
            Tree::Parts(block, children) => {
                Tree::Parts(*block, children.iter().map(|child| self.again(child)).collect())
            }
        }
    }

    fn total(&self, cost: Cost) -> f32 {
        cost.total(self.context.lambda)
    }

    fn kind_bits(&self, block: Block, kind: usize) -> f32 {
        self.context.prices.symbol(contexts::node(block.shape), kind)
    }

    fn node(&mut self, block: Block) -> Found {
        let before = self.state.clone();
        let mut best: Option<(Found, State)> = None;
        if let Some(found) = self.palette(block) {
            if found.cost.bits < FEW_BITS {
                return found;
            }
            best = Some((found, self.state.clone()));
        }
        let ways = self.estimates.as_ref().map(|estimates| estimates.ways(block, self.context.lambda));
        let limit =
            ways.map_or(f32::INFINITY, |ways| ways.whole.min(ways.quarters).min(ways.parts) * self.context.slack());
        let promising = |estimate: Option<f32>| estimate.is_none_or(|estimate| estimate <= limit);
        if let Some(length) = length_index(block.shape.frames)
            && promising(ways.map(|ways| ways.whole))
        {
            self.state = before.clone();
            let mut found = self.transform(block, length);
            found.cost.bits += self.kind_bits(block, TRANSFORM);
            let nearly_free =
                found.cost.bits < 6.0 && found.cost.error < 0.0002 * (block.shape.pixels() * block.shape.frames) as f32;
            self.keep_better(&mut best, found);
            if nearly_free {
                return self.take(best, block);
            }
        }
        if block.shape.level > 0 && promising(ways.map(|ways| ways.quarters)) {
            self.state = before.clone();
            let children = &mut block.quarters().into_iter();
            if let Some((children, cost)) = self.split(block, QUARTERS, children, best.as_ref()) {
                self.keep_better(&mut best, Found { tree: Tree::Quarters(block, children), cost });
            }
        }
        if block.shape.frames > 1 && promising(ways.map(|ways| ways.parts)) {
            self.state = before.clone();
            let children = &mut block.parts();
            if let Some((children, cost)) = self.split(block, PARTS, children, best.as_ref()) {
                self.keep_better(&mut best, Found { tree: Tree::Parts(block, children), cost });
            }
        }
        self.take(best, block)
    }

    /// Returns the children of a split; `None` once they cost as much as the best so far.
    fn split(
        &mut self,
        block: Block,
        kind: usize,
        children: &mut dyn Iterator<Item = Block>,
        best: Option<&(Found, State)>,
    ) -> Option<(Vec<Tree>, Cost)> {
        let limit = best.map_or(f32::INFINITY, |(found, _)| self.total(found.cost));
        let mut cost = Cost { error: 0.0, bits: self.kind_bits(block, kind) };
        let mut trees = Vec::new();
        for child in children {
            let found = self.node(child);
            cost.add(found.cost);
            trees.push(found.tree);
            if self.total(cost) >= limit {
                return None;
            }
        }
        Some((trees, cost))
    }

    fn keep_better(&self, best: &mut Option<(Found, State)>, found: Found) {
        if best.as_ref().is_none_or(|(held, _)| self.total(found.cost) < self.total(held.cost)) {
            *best = Some((found, self.state.clone()));
        }
    }

    fn take(&mut self, best: Option<(Found, State)>, block: Block) -> Found {
        match best {
            Some((found, state)) => {
                self.state = state;
                found
            }
            // Not reached: every block has at least one promising way.
            None => Found { tree: Tree::Parts(block, Vec::new()), cost: Cost::default() },
        }
    }

    fn transform(&mut self, block: Block, length: usize) -> Found {
        let SearchContext { prices, bases, lambda, steps, scales, weights, .. } = self.context;
        let weights = TimeWeights::new(bases, weights.of(block));
        let (shape, pixels) = (block.shape, block.shape.pixels());
        let PlaneMagnitudes { plane: magnitudes, before: other, channels: channels_before } = &mut *self.magnitudes;
        channels_before.clear(shape.side());
        let mut values: [Vec<i32>; CHANNELS] = Default::default();
        let mut cost = Cost::default();
        let (mut planes_before, mut first_class) = (0, 0);
        let mut errors = Vec::new();
        for (channel, values) in values.iter_mut().enumerate() {
            self.source.coefficients(channel, block, bases, scales.of(channel, shape), &mut self.scratch);
            let steps = steps.of(channel, shape.level, length);
            let predicted = self.state.means.predict(channel, block, steps.at(0));
            self.scratch[0] -= predicted as f32;
            values.resize(pixels * shape.frames, 0);
            errors.clear();
            other.copy_from(channels_before, shape.side());
            magnitudes.clear(shape.side());
            let (mut class_before, mut planes) = (first_class, 0);
            let mut coded_before = false;
            // Cost of the planes up to the last with levels, and of the planes after it.
            let (mut coded_cost, mut tail) = (Cost::default(), Cost::default());
            let mut tail_energy = 0.0;
            for (plane, (coefficients, levels)) in
                self.scratch.chunks_exact_mut(pixels).zip(values.chunks_exact_mut(pixels)).enumerate()
            {
                let weight = weights.of_plane(plane);
                let saved = weights.compensate(plane, coefficients, &mut errors);
                let context = PlaneContext::new(channel, shape, plane);
                let plane_of = Plane { coefficients, shape, context, other, coded_before, class_before };
                let quantiser = Quantiser { prices, lambda: lambda / weight };
                let mut quantised = quantiser.quantise(&plane_of, levels, magnitudes);
                weights.subtract(plane, levels, &mut errors);
                quantised.cost.error = weight * (quantised.cost.error - saved);
                quantised.energy = weight * (quantised.energy - saved);
                let was_coded = coded_before || plane == 0;
                coded_before = quantised.last.is_some();
                class_before = contexts::last_class(quantised.last);
                tail.add(quantised.cost);
                tail_energy += quantised.energy;
                if coded_before {
                    planes = plane + 1;
                    coded_cost.add(std::mem::take(&mut tail));
                    tail_energy = 0.0;
                }
                if plane == 0 && channel + 1 < CHANNELS {
                    channels_before.raise_all(magnitudes);
                    first_class = first_class.max(class_before);
                }
                std::mem::swap(magnitudes, other);
                if was_coded {
                    magnitudes.clear(shape.side());
                }
            }
            cost.add(coded_cost);
            cost.error += tail_energy;
            cost.bits += number_bits(prices, contexts::planes(channel, shape, planes_before), planes as u32);
            if channel == 0 || planes > 0 {
                planes_before = planes.min(2);
            }
            let mut constant: Vec<i32> = values.chunks_exact(pixels).map(|plane| plane[0]).collect();
            constant[0] += predicted;
            constant.iter_mut().for_each(|level| *level = steps.coefficient(0, *level));
            self.state.means.set_block(channel, block, &constant);
        }
        Found { tree: Tree::Transform(block, BlockLevels::new(shape, values)), cost }
    }

    /// Codes the block as a palette; `None` if it has too many colours.
    fn palette(&mut self, block: Block) -> Option<Found> {
        let palette = self.exact_palette(block)?;
        let mut rate = RateCounter { prices: self.context.prices, bits: self.kind_bits(block, PALETTE) };
        let SearchContext { domain, header, .. } = self.context;
        palette.clone().code(&mut rate, block.shape, &mut self.state.cache, domain.key_bits);
        note_palette(&palette, block, header, domain, &mut self.state.means);
        let cost = Cost { error: 0.0, bits: rate.bits };
        Some(Found { tree: Tree::Palette(block, palette), cost })
    }

    fn exact_palette(&self, block: Block) -> Option<Palette> {
        let (side, root) = (block.shape.side(), self.source.root.shape);
        let mut palette = Palette::default();
        let mut latest = 0;
        for frame in block.place.frame..block.place.frame + block.shape.frames {
            for y in block.place.y..block.place.y + side {
                let first = frame * root.pixels() + y * root.side() + block.place.x;
                for color in &self.source.keys[first..first + side] {
                    if palette.colors.get(latest) != Some(color) {
                        latest = match palette.colors.iter().position(|held| held == color) {
                            Some(place) => place,
                            None if palette.colors.len() == MAX_COLORS => return None,
                            None => {
                                palette.colors.push(*color);
                                palette.colors.len() - 1
                            }
                        };
                    }
                    palette.indices.push(latest as u8);
                }
            }
        }
        if palette.colors.len() == 1 {
            palette.indices.clear();
        }
        Some(palette)
    }
}
