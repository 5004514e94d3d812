//! Chooses how a frame is coded: for each block the mode of lowest cost in bits and squared error, within the bound at every
//! pixel.
//!
//! The loop is closed: every trial uses the decoder's own functions, and pixels are predicted from decoded ones.

use crate::depth::predictive::chunk::{CANDIDATES, CHANGES, Classes, ESCAPES};
use crate::depth::predictive::contexts;
use crate::depth::predictive::fit::{Sample, minimax};
use crate::depth::predictive::modes::{BACKGROUND, BLOCK, PIXELS, PLANES, QUARTERS, SAME, SMALL, SOURCES};
use crate::depth::predictive::pixel::{
    Around, Pixel, RESIDUALS, SYMBOL_ABOVE, SYMBOL_BACKGROUND, SYMBOL_BELOW, SYMBOL_CANDIDATE, SYMBOL_KEEP, code_of,
};
use crate::depth::predictive::plane::{Plane, Side};
use crate::depth::predictive::price::{Pricer, Prices, Sink};
use crate::depth::predictive::tile::{Area, Tile};
use crate::depth::quantise::BACKGROUND_CODE;
use crate::effort::Effort;

/// Maximum rounds of a fit.
const ROUNDS: usize = 30;
const FAST_ROUNDS: usize = 8;
/// Maximum magnitude of a number of a plane's change.
const MAX_CHANGE: f64 = 8000.0;

#[derive(Debug, Clone, Copy)]
pub struct SearchSettings {
    pub bound: u16,
    /// Difference in codes, in addition to the bound, that is allowed for blocks that stay as they are.
    pub epsilon: u16,
    /// Cost in bits of a pixel whose squared error is the square of the bound.
    pub error_weight: f64,
    pub effort: Effort,
}

pub struct FrameSearch<'a, S> {
    pub tile: &'a mut Tile,
    pub source: &'a [u16],
    pub prices: &'a Prices,
    pub settings: SearchSettings,
    pub sink: &'a mut S,
}

/// A plane within the bound.
#[derive(Debug, Clone, Copy)]
struct Found {
    cost: f64,
    source: usize,
    change: [i32; 3],
    plane: Plane,
}

impl Found {
    fn is_changed(&self) -> bool {
        self.change != [0; 3]
    }

    /// Returns the mode, counted from the first mode of planes.
    fn mode(&self) -> usize {
        self.source + if self.is_changed() { SOURCES } else { 0 }
    }
}

/// A block or quarter to be coded, with the context of its mode; `first` is the first of its modes of planes.
#[derive(Debug, Clone, Copy)]
struct Trial {
    area: Area,
    side: Side,
    context: usize,
    first: usize,
}

impl<S: Sink> FrameSearch<'_, S> {
    pub fn run(&mut self) {
        let changed: Vec<bool> = (0..self.tile.blocks.len()).map(|at| self.is_changed(self.tile.area(at))).collect();
        let any = changed.contains(&true);
        self.sink.symbol(contexts::frame(self.tile.later()), any.into());
        if any {
            for (at, is_changed) in changed.into_iter().enumerate() {
                self.block(at, is_changed.then_some(()));
            }
        }
        self.tile.is_later = true;
    }

    /// Returns true if a pixel of the block differs from the decoder's state by more than is allowed.
    fn is_changed(&self, area: Area) -> bool {
        let limit = i32::from(self.settings.bound) + i32::from(self.settings.epsilon);
        rows(area).any(|(y, row)| {
            let start = self.tile.at(area.x as isize, y as isize);
            let at = y * self.tile.width + area.x;
            row.clone().any(|x| {
                let (pixel, source) = (&self.tile.pixels[start + x], self.source[at + x]);
                !fits(pixel.code(self.tile.corrections[at + x]), source, limit)
            })
        })
    }

    /// Returns the bits of a symbol.
    fn price(&self, context: usize, symbol: usize) -> f64 {
        self.prices.symbol(context, symbol).into()
    }

    fn backgrounds(&self, area: Area) -> usize {
        let of_row = |y: usize| &self.source[y * self.tile.width + area.x..][..area.width];
        rows(area).map(|(y, _)| of_row(y).iter().filter(|&&code| code == BACKGROUND_CODE).count()).sum()
    }

    fn block(&mut self, at: usize, change: Option<()>) {
        let (area, context) = (self.tile.area(at), self.tile.mode_context(at));
        let backgrounds = self.backgrounds(area);
        let mode = match change {
            None => SAME,
            Some(()) if backgrounds == area.width * area.height => BACKGROUND,
            Some(()) => {
                return self.surfaces(at, Trial { area, side: Side::Block, context, first: PLANES }, backgrounds);
            }
        };
        self.sink.symbol(context, mode);
        self.tile.blocks[at].mode = mode;
        if mode == BACKGROUND {
            self.tile.blocks[at].content = mode;
            self.tile.fill_background(area);
        }
    }

    fn is_fast(&self) -> bool {
        self.settings.effort == Effort::Fast
    }

    fn surfaces(&mut self, at: usize, trial: Trial, backgrounds: usize) {
        let Trial { area, context, .. } = trial;
        let mut plane = if backgrounds > 0 {
            None
        } else {
            let sources = [0, 1, 2].map(|source| self.tile.plane_from(at, source));
            self.best_plane::<BLOCK>(trial, sources)
        };
        let mut cheapest = plane.map_or(f64::INFINITY, |found| found.cost);
        let takes_plane = self.is_fast() && plane.is_some_and(|found| !found.is_changed());
        if !takes_plane {
            let kept = self.keep(area);
            if let Some(cost) = self.price_of_pixels(area, self.price(context, PIXELS), cheapest) {
                (cheapest, plane) = (cost, None);
            }
            self.restore(area, &kept);
        }
        let tries_quarters = match (self.settings.effort, plane) {
            (Effort::Fast, found) => found.is_none(),
            (Effort::Normal, Some(found)) => found.is_changed(),
            _ => true,
        };
        let quarters = if tries_quarters { self.price_of_quarters(trial, cheapest) } else { None };
        let mode = match (&quarters, plane) {
            (Some(_), _) => QUARTERS,
            (None, Some(found)) => PLANES + found.mode(),
            (None, None) => PIXELS,
        };
        self.sink.symbol(context, mode);
        match (quarters, plane) {
            (Some(plans), _) => {
                for (quarter, plan) in self.tile.quarters(area).zip(plans) {
                    self.sink.symbol(self.tile.small_mode_context(quarter), plan.map_or(0, |found| 1 + found.mode()));
                    match plan {
                        None => self.pixels(quarter),
                        Some(found) => {
                            self.write_change(&found, Side::Quarter);
                            self.tile.fill_plane::<SMALL>(quarter, &found.plane);
                        }
                    }
                }
            }
            (None, Some(found)) => {
                self.write_change(&found, Side::Block);
                self.tile.fill_plane::<BLOCK>(area, &found.plane);
                self.tile.blocks[at].plane = found.plane;
            }
            (None, None) => self.pixels(area),
        }
        (self.tile.blocks[at].mode, self.tile.blocks[at].content) = (mode, mode);
    }

    fn write_change(&mut self, found: &Found, side: Side) {
        if found.is_changed() {
            put_change(self.sink, side, found.change);
        }
    }

    /// Codes the pixels of an area, row by row.
    fn pixels(&mut self, area: Area) {
        for y in area.y..area.y + area.height {
            code_row(self.tile, area, y, self.source, self.sink);
        }
    }

    /// Codes the pixels of an area into the tile. Returns the sum of bits, weighted errors and `mode_bits` if it is below
    /// `limit`; otherwise stops early, with some rows not coded.
    fn price_of_pixels(&mut self, area: Area, mode_bits: f64, limit: f64) -> Option<f64> {
        let mut pricer = Pricer { prices: self.prices, bits: 0.0 };
        let (mut squares, mut cost) = (0, mode_bits);
        for y in area.y..area.y + area.height {
            squares += code_row(self.tile, area, y, self.source, &mut pricer);
            cost = pricer.bits + self.weighted(squares) + mode_bits;
            if cost >= limit {
                return None;
            }
        }
        Some(cost)
    }

    /// Returns the planes of the quarters of a block (`None`: pixel by pixel) if their total cost is below `cheapest` and at
    /// least one is a plane. The tile is not changed.
    fn price_of_quarters(&mut self, trial: Trial, cheapest: f64) -> Option<Vec<Option<Found>>> {
        let kept = self.keep(trial.area);
        let mut total = self.price(trial.context, QUARTERS);
        let mut plans = Vec::with_capacity(4);
        for area in self.tile.quarters(trial.area) {
            let context = self.tile.small_mode_context(area);
            let mut plane = if self.backgrounds(area) > 0 {
                None
            } else {
                let sources = [0, 1, 2].map(|source| self.tile.small_plane_from(area, source));
                let trial = Trial { area, side: Side::Quarter, context, first: 1 };
                self.best_plane::<SMALL>(trial, sources)
            };
            let limit = plane.map_or(cheapest - total, |found| found.cost);
            match (self.price_of_pixels(area, self.price(context, 0), limit), plane) {
                (Some(cost), _) => {
                    plane = None;
                    total += cost;
                }
                (None, Some(found)) => {
                    self.tile.fill_plane::<SMALL>(area, &found.plane);
                    total += found.cost;
                }
                (None, None) => total = f64::INFINITY,
            }
            plans.push(plane);
            if total >= cheapest {
                break;
            }
        }
        self.restore(trial.area, &kept);
        (total < cheapest && plans.iter().any(Option::is_some)).then_some(plans)
    }

    fn keep(&self, area: Area) -> Vec<Pixel> {
        let start = |y: usize| self.tile.at(area.x as isize, y as isize);
        rows(area).flat_map(|(y, _)| &self.tile.pixels[start(y)..][..area.width]).copied().collect()
    }

    fn restore(&mut self, area: Area, kept: &[Pixel]) {
        for ((y, _), row) in rows(area).zip(kept.chunks(area.width)) {
            let start = self.tile.at(area.x as isize, y as isize);
            self.tile.pixels[start..][..area.width].copy_from_slice(row);
        }
    }

    fn weighted(&self, squares: u64) -> f64 {
        let bound = f64::from(self.settings.bound);
        squares as f64 * self.settings.error_weight / (bound * bound + 1.0)
    }

    fn best_plane<const SIDE: usize>(&self, trial: Trial, sources: [Plane; 3]) -> Option<Found> {
        let mut best: Option<Found> = None;
        for (source, plane) in sources.into_iter().enumerate() {
            self.consider::<SIDE>(trial, (source, plane), [0; 3], &mut best);
        }
        let takes_what_is_carried_on = match self.settings.effort {
            Effort::Fast => best.is_some(),
            Effort::Normal | Effort::Exhaustive => best.is_some() && self.settings.error_weight == 0.0,
        };
        if takes_what_is_carried_on {
            return best;
        }
        let bound = f64::from(self.settings.bound);
        let mut samples = [Sample { x: 0.0, y: 0.0, value: 0.0 }; 64];
        let count = self.samples::<SIDE>(trial.area, &mut samples);
        let rounds = if self.is_fast() { FAST_ROUNDS } else { ROUNDS };
        let fit = minimax(&samples[..count], bound, self.tile.curvature, rounds);
        if fit.error > bound + 0.5 {
            return best;
        }
        let steps = self.tile.change_steps(trial.side);
        for (source, plane) in sources.into_iter().enumerate() {
            let [value, x, y] = fit.numbers.map(|number| number * 256.0);
            let exact = [
                (value - f64::from(plane.value)) / f64::from(steps.value),
                (x - f64::from(plane.slope[0])) / f64::from(steps.slope),
                (y - f64::from(plane.slope[1])) / f64::from(steps.slope),
            ];
            if exact.iter().any(|number| number.abs() > MAX_CHANGE) {
                continue;
            }
            let [value, x, y] = exact.map(|number| number.round() as i32);
            let tried = if self.is_fast() { 1 } else { 3 };
            let near = |at: i32| [at, at - 1, at + 1].into_iter().take(tried);
            let trials = near(value).flat_map(|value| {
                let with_slopes = near(x).flat_map(move |x| near(y).map(move |y| [value, x, y]));
                let one_slope = near(x).map(move |x| [value, x, 0]).chain(near(y).map(move |y| [value, 0, y]));
                with_slopes.chain(one_slope).chain([[value, 0, 0]])
            });
            for change in trials {
                self.consider::<SIDE>(trial, (source, plane), change, &mut best);
            }
        }
        best
    }

    fn samples<const SIDE: usize>(&self, area: Area, samples: &mut [Sample; 64]) -> usize {
        let mut count = 0;
        let half = |at: usize| at as f64 + 0.5 - SIDE as f64 / 2.0;
        for (y, row) in rows(area) {
            for x in row {
                let at = y * self.tile.width + area.x + x;
                let value = f64::from(self.source[at]) - f64::from(self.tile.corrections[at]) / 256.0;
                samples[count] = Sample { x: half(x), y: half(y - area.y), value };
                count += 1;
            }
        }
        count
    }

    /// Replaces `best` by a changed plane if that is within the bound and costs less.
    fn consider<const SIDE: usize>(
        &self,
        trial: Trial,
        (source, plane): (usize, Plane),
        change: [i32; 3],
        best: &mut Option<Found>,
    ) {
        let plane = plane.changed(change, self.tile.change_steps(trial.side));
        let mut found = Found { cost: 0.0, source, change, plane };
        let mut pricer = Pricer { prices: self.prices, bits: self.price(trial.context, trial.first + found.mode()) };
        if found.is_changed() {
            put_change(&mut pricer, trial.side, change);
        }
        if best.as_ref().is_some_and(|best| best.cost <= pricer.bits) {
            return;
        }
        let Some(squares) = self.squares::<SIDE>(trial.area, &plane) else { return };
        found.cost = pricer.bits + self.weighted(squares);
        if best.as_ref().is_none_or(|best| found.cost < best.cost) {
            *best = Some(found);
        }
    }

    /// Returns the sum of squared errors of a plane; `None` if an error exceeds the bound.
    fn squares<const SIDE: usize>(&self, area: Area, plane: &Plane) -> Option<u64> {
        let bound = i32::from(self.settings.bound);
        let mut squares = 0;
        for (y, _) in rows(area) {
            let at = y * self.tile.width + area.x;
            let values = plane.row::<SIDE>(y - area.y, self.tile.curvature);
            let sources = self.source[at..][..area.width].iter().zip(&self.tile.corrections[at..][..area.width]);
            for (value, (&source, &correction)) in values.into_iter().zip(sources) {
                let error = i32::from(code_of(value, correction)) - i32::from(source);
                if error.abs() > bound {
                    return None;
                }
                squares += u64::from(error.unsigned_abs()) * u64::from(error.unsigned_abs());
            }
        }
        Some(squares)
    }
}

/// Returns the rows of an area, each with its columns counted from the area's left.
fn rows(area: Area) -> impl Iterator<Item = (usize, std::ops::Range<usize>)> {
    (area.y..area.y + area.height).map(move |y| (y, 0..area.width))
}

/// Returns true if a decoded code may represent a source code: background exactly, a surface within the limit.
fn fits(code: u16, source: u16, limit: i32) -> bool {
    if code == BACKGROUND_CODE || source == BACKGROUND_CODE {
        code == source
    } else {
        (i32::from(code) - i32::from(source)).abs() <= limit
    }
}

fn put_change(sink: &mut impl Sink, side: Side, change: [i32; 3]) {
    let mut before = 0;
    for (number, value) in change.into_iter().enumerate() {
        let context = contexts::change(side, number, before);
        match value.unsigned_abs() {
            0 => sink.symbol(context, 0),
            magnitude => {
                let class = CHANGES.of(magnitude);
                sink.symbol(context, 2 * class + 1 + usize::from(value > 0));
                put_rest(sink, &CHANGES, class, magnitude);
            }
        }
        before = value;
    }
}

fn put_rest<const COUNT: usize>(sink: &mut impl Sink, classes: &Classes<COUNT>, class: usize, magnitude: u32) {
    sink.bits(magnitude - classes.least[class], classes.bits[class].into());
}

/// Codes the pixels of a row of an area into the tile; returns the sum of squared errors.
fn code_row(tile: &mut Tile, area: Area, y: usize, source: &[u16], sink: &mut impl Sink) -> u64 {
    let mut squares = 0;
    let start = tile.at(area.x as isize, y as isize);
    let at = y * tile.width + area.x;
    for x in 0..area.width {
        let (source, correction) = (source[at + x], tile.corrections[at + x]);
        let around = tile.around(start + x, correction);
        let pixel = code_pixel(tile, &around, source, sink);
        tile.pixels[start + x] = pixel;
        if source != BACKGROUND_CODE {
            let error = u64::from(pixel.code(correction).abs_diff(source));
            squares += error * error;
        }
    }
    squares
}

fn code_pixel(tile: &Tile, around: &Around, source: u16, sink: &mut impl Sink) -> Pixel {
    let steps = &tile.steps;
    let above = contexts::pixel_above(&around.above, &around.above_right, tile.later());
    let context = contexts::pixel(&around.left, above);
    if source == BACKGROUND_CODE {
        sink.symbol(context, SYMBOL_BACKGROUND);
        return Pixel::BACKGROUND;
    }
    let fits = |pixel: &Pixel| fits(pixel.code(around.correction), source, steps.bound);
    if tile.is_later && !around.before.is_background() && fits(&around.before) {
        sink.symbol(context, SYMBOL_KEEP);
        return around.before.kept();
    }
    let prediction = around.predict(steps);
    let as_predicted = prediction.with_residual(0, steps);
    if fits(&as_predicted) {
        sink.symbol(context, 0);
        return as_predicted;
    }
    let residual = residual_of(source, code_of(prediction.value, around.correction), steps.step_codes());
    if residual.abs() <= 2 {
        let symbol = RESIDUALS.iter().position(|&of| of == residual).unwrap_or(0);
        sink.symbol(context, symbol);
        return prediction.with_residual(residual, steps);
    }
    let candidates = around.candidates(&prediction, steps);
    let mut best = None;
    let mut least = residual.unsigned_abs();
    for (which, candidate) in candidates.iter().enumerate() {
        let residual = residual_of(source, code_of(candidate.value, around.correction), steps.step_codes());
        let cost = 4 * residual.unsigned_abs() + 3;
        if cost < least {
            (least, best) = (cost, Some((which, residual)));
        }
    }
    match best {
        Some((which, residual)) => {
            sink.symbol(context, SYMBOL_CANDIDATE + which);
            let magnitude = residual.unsigned_abs();
            let class = CANDIDATES.of(magnitude);
            sink.symbol(contexts::candidate(which), class);
            put_rest(sink, &CANDIDATES, class, magnitude);
            if magnitude > 0 {
                sink.bits(u32::from(residual < 0), 1);
            }
            candidates.pixels[which].on_surface(residual, steps)
        }
        None => {
            sink.symbol(context, if residual > 0 { SYMBOL_ABOVE } else { SYMBOL_BELOW });
            let magnitude = residual.unsigned_abs();
            let class = ESCAPES.of(magnitude);
            sink.symbol(contexts::escape(&around.left, &around.above, &around.above_right), class);
            put_rest(sink, &ESCAPES, class, magnitude);
            prediction.escaped(residual, steps)
        }
    }
}

/// Returns the residual in steps whose reconstruction is nearest to the source. Its error is at most half a step.
fn residual_of(source: u16, predicted: u16, step: i32) -> i32 {
    let difference = i32::from(source) - i32::from(predicted);
    (difference.abs() + step / 2) / step * difference.signum()
}
