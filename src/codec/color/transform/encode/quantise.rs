//! Rate-distortion optimisation of the levels of a plane: each level, and the last position, minimise squared error + λ·bits.

use crate::color::transform::blocks::Shape;
use crate::color::transform::contexts::{PlaneContext, Position};
use crate::color::transform::encode::rate::{Prices, number_bits};
use crate::color::transform::scan::{self, Magnitudes};

/// A coefficient of at most this magnitude is never coded as the last level.
const SURELY_ZERO: f32 = 0.6;

/// Squared error in steps², and bits.
#[derive(Debug, Clone, Copy, Default)]
pub struct Cost {
    pub error: f32,
    pub bits: f32,
}

impl Cost {
    pub fn total(self, lambda: f32) -> f32 {
        self.error + lambda * self.bits
    }

    pub fn add(&mut self, other: Cost) {
        self.error += other.error;
        self.bits += other.bits;
    }
}

/// A plane to quantise: its coefficients in steps, row by row.
pub struct Plane<'a> {
    pub coefficients: &'a [f32],
    pub shape: Shape,
    pub context: PlaneContext,
    /// Magnitudes of the plane before.
    pub other: &'a Magnitudes,
    /// True if the plane before has levels.
    pub coded_before: bool,
    /// Class of the last position of the plane before ([`PlaneContext::last`]).
    pub class_before: usize,
}

#[derive(Debug, Clone, Copy)]
pub struct Quantiser<'a> {
    pub prices: &'a Prices,
    pub lambda: f32,
}

#[derive(Debug, Clone, Copy)]
struct Choice {
    magnitude: u32,
    cost: Cost,
}

impl Quantiser<'_> {
    /// Fills `levels` and `magnitudes`, which must be 0 and stay 0 if the plane gets no levels. Returns the cost, including
    /// the flag of the plane.
    pub fn quantise(&self, plane: &Plane<'_>, levels: &mut [i32], magnitudes: &mut Magnitudes) -> Quantised {
        let side = plane.shape.side();
        let at = |position: Position| position.y() * side + position.x();
        let order = scan::order(plane.shape.level);
        let Extremes { energy, largest } = Extremes::of(plane.coefficients);
        let empty = Cost { error: energy, bits: self.prices.symbol(plane.context.coded(plane.coded_before), 0) };
        let nothing = Quantised { cost: empty, energy, last: None };
        if largest <= SURELY_ZERO {
            return nothing;
        }
        let first =
            order.iter().rposition(|&position| plane.coefficients[at(position)].abs() > SURELY_ZERO).unwrap_or(0);
        let reachable: f32 =
            order[..=first].iter().map(|&position| plane.coefficients[at(position)]).map(|value| value * value).sum();
        // Squared error of the coefficients beyond the current scan position, if all of them are dropped.
        let mut dropped = (energy - reachable).max(0.0);
        let flag = self.prices.symbol(plane.context.coded(plane.coded_before), 1);
        let mut last = None;
        let mut cost = Cost::default();
        for (index, &position) in order[..=first].iter().enumerate().rev() {
            let value = plane.coefficients[at(position)];
            let (size, other) = (value.abs(), plane.other.get(position));
            let nearest = (size + 0.5) as u32;
            let go_on = last.map(|_| self.other_level(plane, position, size, nearest, magnitudes, other));
            if nearest > 0 {
                let mut end = self.last_level(plane, index, size, nearest, other);
                end.cost.add(Cost { error: dropped, bits: flag });
                let so_far = go_on.map(|choice| cost.total(self.lambda) + choice.cost.total(self.lambda));
                if so_far.is_none_or(|so_far| end.cost.total(self.lambda) < so_far) {
                    for &beyond in last.map_or(&[][..], |last| &order[index + 1..=last]) {
                        levels[at(beyond)] = 0;
                        magnitudes.set(beyond, 0);
                    }
                    last = Some(index);
                    cost = end.cost;
                    levels[at(position)] = signed(end.magnitude, value);
                    magnitudes.set(position, end.magnitude);
                    dropped += size * size;
                    continue;
                }
            }
            dropped += size * size;
            if let Some(choice) = go_on {
                cost.add(choice.cost);
                levels[at(position)] = signed(choice.magnitude, value);
                magnitudes.set(position, choice.magnitude);
            }
        }
        match last {
            Some(_) if cost.total(self.lambda) < empty.total(self.lambda) => Quantised { cost, energy, last },
            Some(last) => {
                for &position in &order[..=last] {
                    levels[at(position)] = 0;
                    magnitudes.set(position, 0);
                }
                nothing
            }
            None => nothing,
        }
    }

    fn other_level(
        &self,
        plane: &Plane<'_>,
        position: Position,
        size: f32,
        nearest: u32,
        magnitudes: &Magnitudes,
        other: usize,
    ) -> Choice {
        let context = plane.context.level(position, magnitudes.sum(position), other);
        let zero = Cost { error: size * size, bits: self.prices.symbol(context, 0) };
        let mut best = Choice { magnitude: 0, cost: zero };
        for magnitude in nearest.saturating_sub(1).max(1)..=nearest {
            self.improve(&mut best, magnitude, size, number_bits(self.prices, context, magnitude));
        }
        best
    }

    fn last_level(&self, plane: &Plane<'_>, index: usize, size: f32, nearest: u32, other: usize) -> Choice {
        let position = scan::order(plane.shape.level)[index];
        let context = plane.context.last_level(position, other);
        let place = self.last_bits(plane, index);
        let mut best = Choice { magnitude: 0, cost: Cost { error: f32::INFINITY, bits: 0.0 } };
        for magnitude in nearest.saturating_sub(1).max(1)..=nearest {
            self.improve(&mut best, magnitude, size, number_bits(self.prices, context, magnitude - 1) + place);
        }
        best
    }

    #[inline(always)]
    fn improve(&self, best: &mut Choice, magnitude: u32, size: f32, bits: f32) {
        let error = size - magnitude as f32;
        let cost = Cost { error: error * error, bits: bits + 1.0 };
        if cost.total(self.lambda) < best.cost.total(self.lambda) {
            *best = Choice { magnitude, cost };
        }
    }

    /// Bits of the scan index of a plane's last level.
    fn last_bits(&self, plane: &Plane<'_>, index: usize) -> f32 {
        let class = (index + 1).ilog2() as usize;
        let bits = self.prices.symbol(plane.context.last(plane.class_before), class);
        if class == 0 {
            return bits;
        }
        let low_bits = class - class.min(2);
        let high = (index + 1 - (1 << class)) >> low_bits;
        bits + self.prices.symbol(plane.context.last_bits(class), high) + low_bits as f32
    }
}

/// Result of quantising a plane.
#[derive(Debug, Clone, Copy)]
pub struct Quantised {
    pub cost: Cost,
    /// Σ of the squared coefficients: the error without levels.
    pub energy: f32,
    /// Scan index of the last level other than 0.
    pub last: Option<usize>,
}

/// Sum of the squares of coefficients, and maximum magnitude. The order of summation is the same for all vector instruction
/// sets.
struct Extremes {
    energy: f32,
    largest: f32,
}

impl Extremes {
    fn of(coefficients: &[f32]) -> Extremes {
        let (mut sums, mut largest) = ([0.0f32; 16], [0.0f32; 16]);
        for values in coefficients.as_chunks::<16>().0 {
            for at in 0..16 {
                let square = values[at] * values[at];
                sums[at] += square;
                largest[at] = if square > largest[at] { square } else { largest[at] };
            }
        }
        Extremes { energy: sums.iter().sum(), largest: largest.into_iter().fold(0.0, f32::max).sqrt() }
    }
}

fn signed(magnitude: u32, value: f32) -> i32 {
    if value < 0.0 { -(magnitude as i32) } else { magnitude as i32 }
}
