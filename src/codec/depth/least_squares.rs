//! Least-squares and minimax fits over pixels, with coordinates centred and scaled to [−1, 1] (errata.md 2).
//!
//! Input: the values that a function should have in some pixels. Output: coefficients in a basis that is orthogonal over a
//! rectangle, in binary64 or rounded to integers. Based on: GDC 3.2, equations 6 and 7, without their sums of fourth powers;
//! Lawson's reweighting.

use crate::depth::domain::{Domain, VALUE_BITS};
use crate::depth::nodes::Shifts;

/// Coefficients of 1, x, y, xy, x² − mean x², y² − mean y², with x and y of a [`Frame`].
pub type Terms = [f64; 6];

const QUADRATIC_BITS: u32 = 22;
const ROUNDS: usize = 10;
/// Margin, in codes, for rounding to codes and in Horner's scheme.
const ROUNDING: f64 = 0.6;
/// A term is dropped if other terms explain all but this part of it.
const DEPENDENT: f64 = 1e-10;

/// Rectangle of pixels that coordinates are centred on and scaled by.
#[derive(Debug, Clone, Copy)]
pub struct Frame {
    centre: [f64; 2],
    scale: [f64; 2],
    mean_square: [f64; 2],
}

#[derive(Debug, Clone, Copy)]
pub struct Sample {
    pub at: [f64; 2],
    /// Target value, scaled so that 65535 is the whole range.
    pub value: f64,
    /// Codes per unit of `value`; positive.
    pub slope: f64,
}

impl Frame {
    pub fn new(xs: [usize; 2], ys: [usize; 2]) -> Frame {
        let counts = [xs, ys].map(|[first, last]| (last - first + 1) as f64);
        let scale = counts.map(|count| 2.0 / count);
        Frame {
            centre: [xs, ys].map(|[first, last]| (first + last) as f64 / 2.0),
            scale,
            mean_square: [0, 1].map(|axis| (counts[axis] * counts[axis] - 1.0) / 12.0 * scale[axis] * scale[axis]),
        }
    }

    pub fn at(&self, x: usize, y: usize) -> [f64; 2] {
        [(x as f64 - self.centre[0]) * self.scale[0], (y as f64 - self.centre[1]) * self.scale[1]]
    }

    #[inline]
    pub fn basis(&self, [x, y]: [f64; 2]) -> Terms {
        [1.0, x, y, x * y, x * x - self.mean_square[0], y * y - self.mean_square[1]]
    }

    /// Returns the least-squares fit of the first `terms` terms over the whole rectangle, and the sum of squared residuals. Each
    /// term is computed independently, because the basis is orthogonal.
    pub fn project<'a>(&self, rows: impl Iterator<Item = &'a [u16]>, terms: usize) -> (Terms, f64) {
        let (mut products, mut squares, mut count, mut energy) = ([0.0; 6], [0.0; 3], [0.0; 2], 0.0);
        let mut offset = None;
        for (y, row) in rows.enumerate() {
            // Values are relative to the first one: the sum of squares stays small, so the residual is precise.
            let offset = *offset.get_or_insert(f64::from(row[0]));
            let [_, y] = self.at(0, y);
            let (mut sum, mut across, mut bent, mut square) = (0.0, 0.0, 0.0, 0.0);
            let mut x = -self.centre[0] * self.scale[0];
            for &code in row {
                let value = f64::from(code) - offset;
                sum += value;
                across += value * x;
                bent += value * (x * x - self.mean_square[0]);
                square += value * value;
                x += self.scale[0];
            }
            energy += square;
            let bend = y * y - self.mean_square[1];
            let row_products = [sum, across, sum * y, across * y, bent, sum * bend];
            products.iter_mut().zip(row_products).for_each(|(total, product)| *total += product);
            squares[1] += y * y;
            squares[2] += bend * bend;
            count = [row.len() as f64, count[1] + 1.0];
        }
        let (mut xx, mut bends) = (0.0, 0.0);
        for x in 0..count[0] as usize {
            let [x, _] = self.at(x, 0);
            xx += x * x;
            bends += (x * x - self.mean_square[0]).powi(2);
        }
        squares[0] = xx;
        let norms = [
            count[0] * count[1],
            squares[0] * count[1],
            squares[1] * count[0],
            squares[0] * squares[1],
            bends * count[1],
            squares[2] * count[0],
        ];
        let mut found = [0.0; 6];
        for term in 0..terms {
            // One row or column does not determine its slope, two do not determine their curvature.
            if norms[term] > DEPENDENT {
                found[term] = products[term] / norms[term];
                energy -= found[term] * products[term];
            }
        }
        found[0] += offset.unwrap_or_default();
        (found, energy.max(0.0))
    }

    /// Returns the coefficients a0 to a5, rounded to multiples of 2^shift. Quadratic ones are rounded first: in the orthogonal
    /// basis lower-order terms compensate for the rounding. Returns `None` if a coefficient exceeds its format.
    pub fn quantise(&self, terms: &Terms, shifts: Shifts) -> Option<[i32; 6]> {
        let ([cx, cy], [sx, sy]) = (self.centre, self.scale);
        let round = |value: f64, bits: u32, shift: u32| {
            let step = f64::from(1u32 << shift);
            let multiple = (value * f64::from(1u32 << bits) / step).round() * step;
            let fits = multiple.abs() <= f64::from(i32::MAX);
            fits.then_some((multiple as i32, multiple / f64::from(1u32 << bits)))
        };
        let quadratic = |value: f64| round(value, QUADRATIC_BITS, shifts.quadratic);
        let linear = |value: f64| round(value, VALUE_BITS, shifts.linear);
        let ((a2, xy), (a3, xx)) = (quadratic(terms[3] * sx * sy)?, quadratic(terms[4] * sx * sx)?);
        let (a4, yy) = quadratic(terms[5] * sy * sy)?;
        let (a0, x) = linear(terms[1] * sx - xy * cy - 2.0 * xx * cx)?;
        let (a1, y) = linear(terms[2] * sy - xy * cx - 2.0 * yy * cy)?;
        // Keeps the mean over the rectangle.
        let mean_x = cx * cx + self.mean_square[0] / (sx * sx);
        let mean_y = cy * cy + self.mean_square[1] / (sy * sy);
        let constant = terms[0] - x * cx - y * cy - xy * cx * cy - xx * mean_x - yy * mean_y;
        let (a5, _) = round(constant, VALUE_BITS, shifts.constant)?;
        Some([a0, a1, a2, a3, a4, a5])
    }

    pub fn terms_of(&self, coefficients: [i32; 6]) -> Terms {
        let ([cx, cy], [sx, sy]) = (self.centre, self.scale);
        let real = |value: i32, bits: u32| f64::from(value) / f64::from(1u32 << bits);
        let [x, y, constant] = [0, 1, 5].map(|i| real(coefficients[i], VALUE_BITS));
        let [xy, xx, yy] = [2, 3, 4].map(|i| real(coefficients[i], QUADRATIC_BITS));
        let mean_x = cx * cx + self.mean_square[0] / (sx * sx);
        let mean_y = cy * cy + self.mean_square[1] / (sy * sy);
        [
            constant + x * cx + y * cy + xy * cx * cy + xx * mean_x + yy * mean_y,
            (x + xy * cy + 2.0 * xx * cx) / sx,
            (y + xy * cx + 2.0 * yy * cy) / sy,
            xy / (sx * sy),
            xx / (sx * sx),
            yy / (sy * sy),
        ]
    }

    /// Fits the first `N` terms within `bound` codes, by least squares and then by reweighting in proportion to the errors
    /// (Lawson). `accept` verifies a fit with the decoder. Terms that are linearly dependent on lower-order ones over the samples
    /// are dropped.
    pub fn minimax<const N: usize, T>(
        &self,
        samples: &[Sample],
        bound: u16,
        mut accept: impl FnMut(&Terms) -> Option<T>,
    ) -> Option<T> {
        let bound = f64::from(bound) + ROUNDING;
        let mut weights = vec![1.0; samples.len()];
        let mut errors = vec![0.0; samples.len()];
        for round in 0..=ROUNDS {
            let mut terms = self.weighted::<N>(samples, &weights);
            let (mut low, mut high) = ((f64::INFINITY, 1.0), (f64::NEG_INFINITY, 1.0));
            let (mut weighted, mut weight_sum) = (0.0, 0.0);
            for ((sample, error), weight) in samples.iter().zip(&mut errors).zip(&weights) {
                let basis = self.basis(sample.at);
                let value = (0..N).map(|term| basis[term] * terms[term]).sum::<f64>();
                *error = (value - sample.value) * sample.slope;
                if *error > high.0 {
                    high = (*error, sample.slope);
                }
                if *error < low.0 {
                    low = (*error, sample.slope);
                }
                weighted += weight * *error * *error;
                weight_sum += weight;
            }
            // For any weights, the weighted RMS error of the weighted least-squares fit is a lower bound of the maximum error of
            // every function of this kind.
            if weighted > bound * bound * weight_sum {
                return None;
            }
            let max_error = high.0.max(-low.0);
            if max_error <= bound
                && let Some(accepted) = accept(&terms)
            {
                return Some(accepted);
            }
            if round == 0 && max_error > 6.0 * bound {
                return None;
            }
            let shift = (high.0 + low.0) / (high.1 + low.1);
            if (high.0 - low.0) / (high.1 + low.1) * high.1.max(low.1) <= bound * 1.02 {
                terms[0] -= shift;
                if let Some(accepted) = accept(&terms) {
                    return Some(accepted);
                }
            }
            let mean = errors.iter().map(|error| error.abs()).sum::<f64>() / errors.len() as f64;
            if mean < 1e-9 {
                return None;
            }
            weights.iter_mut().zip(&errors).for_each(|(weight, error)| *weight *= error.abs() / mean + 1e-3);
        }
        None
    }

    fn weighted<const N: usize>(&self, samples: &[Sample], weights: &[f64]) -> Terms {
        let (mut matrix, mut right) = ([[0.0; N]; N], [0.0; N]);
        for (sample, weight) in samples.iter().zip(weights) {
            let weight = weight * sample.slope * sample.slope;
            let basis = self.basis(sample.at);
            for row in 0..N {
                let product = weight * basis[row];
                for column in 0..=row {
                    matrix[row][column] += product * basis[column];
                }
                right[row] += product * sample.value;
            }
        }
        let mut terms = [0.0; 6];
        terms[..N].copy_from_slice(&solve(&matrix, &right));
        terms
    }
}

/// Solves a symmetric system, given by its lower half, with LDLᵀ. Unknowns that depend on earlier ones are 0.
pub fn solve<const N: usize>(matrix: &[[f64; N]; N], right: &[f64; N]) -> [f64; N] {
    let (mut lower, mut pivots, mut solution) = ([[0.0; N]; N], [0.0; N], [0.0; N]);
    for row in 0..N {
        for column in 0..row {
            if pivots[column] > 0.0 {
                let known = (0..column).map(|k| lower[row][k] * lower[column][k] * pivots[k]).sum::<f64>();
                lower[row][column] = (matrix[row][column] - known) / pivots[column];
            }
        }
        let known = (0..row).map(|k| lower[row][k] * lower[row][k] * pivots[k]).sum::<f64>();
        let pivot = matrix[row][row] - known;
        if pivot > DEPENDENT * matrix[row][row] && pivot > f64::MIN_POSITIVE {
            pivots[row] = pivot;
            solution[row] = right[row] - (0..row).map(|k| lower[row][k] * solution[k]).sum::<f64>();
        }
    }
    for row in (0..N).rev() {
        if pivots[row] > 0.0 {
            let known = (row + 1..N).map(|k| lower[k][row] * solution[k]).sum::<f64>();
            solution[row] = solution[row] / pivots[row] - known;
        }
    }
    solution
}

#[derive(Debug, Clone, Copy)]
pub struct Constants {
    low: f64,
    high: f64,
    sum: f64,
    weight: f64,
}

impl Constants {
    pub const ANY: Constants = Constants { low: f64::NEG_INFINITY, high: f64::INFINITY, sum: 0.0, weight: 0.0 };

    /// Adds a pixel of `code` where the function without a constant is `value` (Q14). The error may be up to `max_error` codes.
    #[inline]
    pub fn add_pixel(&mut self, domain: &Domain, code: u16, value: i32, max_error: u16) {
        let wanted_value = domain.value_of(code);
        let wanted = wanted_value * f64::from(1 << VALUE_BITS) - f64::from(value);
        let slope = domain.slope_at(wanted_value).abs();
        let reach = (f64::from(max_error) + 0.5) / slope * f64::from(1 << VALUE_BITS);
        self.low = self.low.max(wanted - reach);
        self.high = self.high.min(wanted + reach);
        self.sum += wanted * slope * slope;
        self.weight += slope * slope;
    }

    pub fn is_empty(&self) -> bool {
        self.low > self.high
    }

    /// Returns the multiple of 1 << `shift` within the bound that is nearest to the mean.
    pub fn choose(&self, shift: u32) -> Option<i32> {
        let step = f64::from(1u32 << shift);
        let (first, last) = ((self.low / step).ceil(), (self.high / step).floor());
        if self.weight == 0.0 {
            return Some(0);
        }
        let found = (first <= last).then(|| (self.sum / self.weight / step).round().clamp(first, last) * step)?;
        (found.abs() <= f64::from(i32::MAX)).then_some(found as i32)
    }
}
