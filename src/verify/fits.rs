//! Hard cases of fitting modelling functions: pictures through the default codec at every bound, and the arithmetic of
//! fits and of Horner's scheme compared with binary64 (GDC 3.2; arithmetic.md 6).

use crate::case::{Bound, Family, Group, HardCase, Measured, ROUNDING};
use crate::clip::{Clip, EFFORT, any_range};
use crate::pictures::{HardPicture, PICTURES};
use crate::report::CONDITION;
use codec::depth::biquadratic::Biquadratic;
use codec::depth::domain::{Domain, DomainKind};
use codec::depth::least_squares::{Frame, Sample, Terms, solve};
use codec::depth::mode_decision::Decide;
use codec::depth::node_encoder::NodeSettings;
use codec::depth::predictive::projection::Shape;
use codec::error::{Error, Result};
use codec::math::random::Random;

const BOUNDS: [u16; 7] = [0, 1, 10, 30, 100, 300, 1000];
const SIDES: [usize; 8] = [4, 8, 16, 32, 64, 128, 256, 512];
const SAMPLES_ACROSS: usize = 32;
type Matrix = [[f64; 6]; 6];

pub(super) fn cases() -> Vec<HardCase> {
    let mut cases = Vec::new();
    for bound in BOUNDS {
        let group = Group::new(Family::Fits, format!("DQPN, E = {bound}, all domains and rules"), "codes");
        for picture in PICTURES {
            let case = group.case(picture.name, Bound::AtMost(f64::from(bound)), move || through_nodes(picture, bound));
            cases.push(case);
        }
        let group = Group::new(Family::Fits, format!("DPRD, E = {bound}, all projections and rules"), "codes");
        for picture in PICTURES {
            let most = Bound::AtMost(f64::from(bound));
            cases.push(group.case(picture.name, most, move || through_prediction(picture, bound)));
        }
    }
    let condition = Group::new(Family::Fits, "normal equations in the scaled basis", CONDITION);
    let solved = Group::new(Family::Fits, "normal equations of a known function, solved", "codes");
    let projected = Group::new(Family::Fits, "least squares against sums in integers", "codes between functions");
    let horner = Group::new(Family::Fits, "Horner's scheme in integers against binary64", "codes");
    for side in SIDES {
        // The basis is orthogonal. The mean squares of its functions are 1, 1/3 · (1 − 1/n²) and 4/45 · (1 − 1/n²)(1 −
        // 4/n²). The smallest occurs at n = 4: 4/45 · 15/16 · 3/4 = 1/16.
        let name = format!("{side}x{side}");
        cases.push(condition.case(name.clone(), Bound::AtMost(16.0), move || Ok(condition_number(side))));
        let places = samples_of(side).len() as f64;
        // For n samples of functions bounded by 1 and values bounded by V = 65535, each entry of the matrix has an
        // error of at most n · 2^-53 · n, and each of the right-hand side V times that. The smallest eigenvalue is at
        // least n / 16 (for subsampled pixels the off-diagonal terms contribute less than 1/1000), and the sum of the
        // six coefficients is at most 4 V. So the coefficients have an error of at most 16 · n · 2^-53 · V · (√6 + 6 ·
        // 4), and the function √6 times that. Rounding in the solver and in the evaluation is less than that of eight
        // more samples.
        let root = 6f64.sqrt();
        let most = root * 16.0 * (places + 8.0) * (root + 24.0) * ROUNDING * 65535.0;
        cases.push(solved.case(name.clone(), Bound::AtMost(most), move || known_function(side)));
        // Two roundings to 2^-14 of half a unit each, multiplied by the last column and by the last row.
        let most = (side - 1) as f64 / f64::from(1 << 14);
        cases.push(horner.case(name, Bound::AtMost(most), move || Ok(horner_error(side))));
    }
    for picture in PICTURES.iter().filter(|picture| picture.size.iter().all(|side| *side >= 8)) {
        let most = projection_rounding(picture.size);
        cases.push(projected.case(picture.name, Bound::AtMost(most), move || Ok(projection_error(picture))));
    }
    let few = Group::new(Family::Fits, "minimax over pixels that tell too little", "codes");
    // 1024 samples, condition number 16, values up to 65535, two passes. The solver drops functions that depend
    // linearly on others.
    let most = 2.0 * 1024.0 * 16.0 * f64::EPSILON * 65535.0;
    for (name, pixels) in FEW {
        cases.push(few.case(name, Bound::AtMost(most), move || fit_of_few(pixels)));
    }
    cases
}

fn through_nodes(picture: &HardPicture, bound: u16) -> Result<Measured> {
    let (source, range) = (picture.moving(), any_range()?);
    let mut worst = Measured::nothing();
    for kind in DomainKind::ALL {
        let domain = Domain::new(kind, range)?;
        for decide in [Decide::Mse, Decide::Size] {
            let settings = NodeSettings { bound, decide, effort: EFFORT, ..NodeSettings::default() };
            worst = worst.join(source.compare(Clip::nodes(&source, (range, &domain), settings)?)?);
        }
    }
    Ok(worst)
}

fn through_prediction(picture: &HardPicture, bound: u16) -> Result<Measured> {
    let source = picture.moving();
    let mut worst = Measured::nothing();
    let [width, height] = source.size;
    for shape in [Shape::None, Shape::Planar, Shape::CubeDistance] {
        if shape == Shape::CubeDistance && width != height {
            continue;
        }
        for decide in [Decide::Mse, Decide::Size] {
            worst = worst.join(source.compare(Clip::predictive(&source, (bound, 0, 64), shape, decide)?)?);
        }
    }
    Ok(worst)
}

/// Computes the condition number of the basis over a square. The note has that of plain powers of pixel coordinates.
fn condition_number(side: usize) -> Measured {
    let frame = Frame::new([0, side - 1], [0, side - 1]);
    let (mut ours, mut powers) = ([[0.0; 6]; 6], [[0.0; 6]; 6]);
    for (x, y) in (0..side * side).map(|at| (at % side, at / side)) {
        add_products(&mut ours, frame.basis(frame.at(x, y)));
        add_products(&mut powers, raw_terms([x as f64, y as f64]));
    }
    let (figure, raw) = (condition_of(ours), condition_of(powers));
    let note = format!("condition {figure:.1}; in powers of pixel coordinates {raw:.2e}");
    Measured { figure, note: Some(note), ..Measured::nothing() }
}

fn raw_terms([x, y]: [f64; 2]) -> [f64; 6] {
    [1.0, x, y, x * y, x * x, y * y]
}

fn add_products(matrix: &mut Matrix, terms: [f64; 6]) {
    for (row, a) in matrix.iter_mut().zip(terms) {
        row.iter_mut().zip(terms).for_each(|(sum, b)| *sum += a * b);
    }
}

/// Returns the largest eigenvalue divided by the smallest, for a symmetric matrix, by Jacobi rotations.
fn condition_of(mut m: Matrix) -> f64 {
    for _ in 0..60 {
        for p in 0..5 {
            for q in p + 1..6 {
                if m[p][q] == 0.0 {
                    continue;
                }
                let theta = (m[q][q] - m[p][p]) / (2.0 * m[p][q]);
                let t = theta.signum() / (theta.abs() + theta.hypot(1.0));
                let c = 1.0 / t.hypot(1.0);
                let s = t * c;
                for row in &mut m {
                    (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
                }
                let (above, below) = (m[p], m[q]);
                m[p] = std::array::from_fn(|k| c * above[k] - s * below[k]);
                m[q] = std::array::from_fn(|k| s * above[k] + c * below[k]);
            }
        }
    }
    let values = (0..6).map(|at| m[at][at]);
    let (low, high) = values.fold((f64::INFINITY, 0.0f64), |(low, high), value| (low.min(value), high.max(value)));
    high / low
}

/// Returns column and row of the samples that a fit of a square uses: all pixels of small squares, the centres of equal
/// parts of large ones.
fn samples_of(side: usize) -> Vec<[f64; 2]> {
    let part = side.div_ceil(SAMPLES_ACROSS);
    let middle = |at: usize| (at * part) as f64 + (part - 1) as f64 / 2.0;
    let across = side / part;
    (0..across * across).map(|at| [middle(at % across), middle(at / across)]).collect()
}

/// Returns the value of a quadratic function that is within 0 to 65535 over a square of 2^k pixels and exact in
/// binary64.
fn known_value(side: usize, [x, y]: [f64; 2]) -> f64 {
    let (x, y) = (x / side as f64, y / side as f64);
    20_000.0 + 3001.0 * x - 7003.0 * y + 11_003.0 * x * y + 17_011.0 * x * x - 9013.0 * y * y
}

/// Returns the error of the solver in its scaled basis when it recovers a known function. The note compares it with the
/// same solver in powers of pixel coordinates.
fn known_function(side: usize) -> Result<Measured> {
    let (places, last) = (samples_of(side), side - 1);
    let frame = Frame::new([0, last], [0, last]);
    let place = |at: [f64; 2]| [0, 1].map(|axis| (at[axis] - last as f64 / 2.0) * (2.0 / side as f64));
    let sample = |&at: &[f64; 2]| Sample { at: place(at), value: known_value(side, at), slope: 1.0 };
    let samples: Vec<Sample> = places.iter().map(sample).collect();
    let terms = frame.minimax::<6, _>(&samples, 0, |terms| Some(*terms));
    let terms = terms.ok_or_else(|| Error::invalid("the solver does not find a function of its own kind"))?;
    let (mut matrix, mut raw, mut right) = ([[0.0; 6]; 6], [[0.0; 6]; 6], [0.0; 6]);
    for (&at, sample) in places.iter().zip(&samples) {
        let powers = raw_terms(at);
        add_products(&mut matrix, frame.basis(sample.at));
        add_products(&mut raw, powers);
        right.iter_mut().zip(powers).for_each(|(sum, power)| *sum += power * sample.value);
    }
    let of_powers = solve(&raw, &right);
    let (mut worst, mut beside) = (Measured::nothing(), 0.0f64);
    for (&at, sample) in places.iter().zip(&samples) {
        worst.greatest((value_of(&terms, frame.basis(sample.at)) - sample.value).abs(), || format!("at {at:?}"));
        beside = beside.max((value_of(&of_powers, raw_terms(at)) - sample.value).abs());
    }
    let note = format!(
        "condition {:.1}, error {:.1e}; in powers of pixel coordinates {:.2e} and {beside:.1e}",
        condition_of(matrix),
        worst.figure,
        condition_of(raw)
    );
    Ok(worst.with_note(note))
}

fn value_of(terms: &Terms, basis: Terms) -> f64 {
    basis.iter().zip(terms).map(|(basis, term)| basis * term).sum()
}

/// Bounds the rounding error of [`Frame::project`] at any pixel, in codes.
///
/// Let u = 2^-53, w columns, h rows, values up to V = 65535 and functions bounded by 1. Column coordinates are
/// accumulated and have an error of (w + 2) u, doubled by squares. Sums of products over w, then over h, have an error
/// of (w + h + 4) u V per pixel; norms, as sums of positive terms, a relative error of (w + h + 10) u. A coefficient is
/// such a sum divided by the mean square m of its function, and is at most V / √m. Evaluating it adds ten roundings.
fn projection_rounding([width, height]: [usize; 2]) -> f64 {
    let (w, h) = (width as f64, height as f64);
    let across = |n: f64| (1.0 - 1.0 / (n * n)) / 3.0;
    let bent = |n: f64| 4.0 / 45.0 * (1.0 - 1.0 / (n * n)) * (1.0 - 4.0 / (n * n));
    let mean_squares = [1.0, across(w), across(h), across(w) * across(h), bent(w), bent(h)];
    let of_term = |m: f64| (2.0 * (w + 2.0) + w + h + 8.0) / m + (w + h + 20.0) / m.sqrt();
    mean_squares.into_iter().map(of_term).sum::<f64>() * ROUNDING * 65535.0
}

/// Least squares with exact sums. X = 2x − w + 1 and Y = 2y − h + 1 are integers, and so are 3X² − w² + 1 and 3Y² − h²
/// + 1. The six functions are orthogonal over a rectangle.
struct ExactFit {
    size: [i128; 2],
    /// For each function: sum of its products with the codes, and sum of its squares.
    sums: [[i128; 2]; 6],
}

impl ExactFit {
    fn new([width, height]: [usize; 2], codes: &[u16]) -> ExactFit {
        let mut fit = ExactFit { size: [width as i128, height as i128], sums: [[0; 2]; 6] };
        for (at, &code) in codes.iter().enumerate() {
            let basis = fit.basis([at % width, at / width]);
            for (sums, value) in fit.sums.iter_mut().zip(basis) {
                sums[0] += value * i128::from(code);
                sums[1] += value * value;
            }
        }
        fit
    }

    fn basis(&self, [column, row]: [usize; 2]) -> [i128; 6] {
        let [w, h] = self.size;
        let (x, y) = (2 * column as i128 - w + 1, 2 * row as i128 - h + 1);
        [1, x, y, x * y, 3 * x * x - w * w + 1, 3 * y * y - h * h + 1]
    }

    fn value(&self, place: [usize; 2]) -> f64 {
        let part = |([product, squares], value): (&[i128; 2], i128)| (product * value) as f64 / *squares as f64;
        self.sums.iter().zip(self.basis(place)).map(part).sum()
    }
}

/// Returns the largest difference at any pixel between the function found by [`Frame::project`] and that of exact sums.
/// Comparing residuals would hide errors: residuals near the optimum agree to second order.
fn projection_error(picture: &HardPicture) -> Measured {
    let ([width, height], codes) = (picture.size, picture.picture());
    let frame = Frame::new([0, width - 1], [0, height - 1]);
    let (terms, _) = frame.project(codes.chunks_exact(width), 6);
    difference(&frame, &terms, (picture.size, &codes))
}

fn difference(frame: &Frame, terms: &Terms, (size, codes): ([usize; 2], &[u16])) -> Measured {
    let exact = ExactFit::new(size, codes);
    let mut worst = Measured::nothing();
    for (x, y) in (0..codes.len()).map(|at| (at % size[0], at / size[0])) {
        let ours = value_of(terms, frame.basis(frame.at(x, y)));
        worst.greatest((ours - exact.value([x, y])).abs(), || format!("pixel ({x}, {y})"));
    }
    worst
}

fn horner_error(side: usize) -> Measured {
    let mut random = Random::new(side as u64);
    let (mut worst, mut tried) = (Measured::nothing(), 0u32);
    let real = |value: i32, bits: u32| f64::from(value) / f64::from(1u32 << bits);
    for _ in 0..20_000 {
        let coefficients: [i32; 6] = std::array::from_fn(|_| random.word() as i32 >> random.below(26));
        let function = Biquadratic { coefficients };
        if !function.stays_in_range(side, side) {
            continue;
        }
        tried += 1;
        let [x, y, constant] = [0, 1, 5].map(|i| real(coefficients[i], 14));
        let [xy, xx, yy] = [2, 3, 4].map(|i| real(coefficients[i], 22));
        let last = side as u32 - 1;
        let corners = [[0, 0], [last, 0], [0, last], [last, last]];
        let inside = [(); 12].map(|()| [random.below(side as u32), random.below(side as u32)]);
        for [column, row] in corners.into_iter().chain(inside) {
            let (c, r) = (f64::from(column), f64::from(row));
            let exact = constant + x * c + y * r + xy * c * r + xx * c * c + yy * r * r;
            let found = real(function.value(column as i32, row as i32), 14);
            worst.greatest((found - exact).abs(), || format!("{coefficients:?} at ({column}, {row})"));
        }
    }
    worst.with_note(format!("{tried} functions"))
}

/// Column and row of the pixels that a fit may use, in a node of 64x64.
type Few = fn() -> Vec<[usize; 2]>;

const FEW: [(&str, Few); 8] = [
    ("one pixel", || vec![[63, 0]]),
    ("two pixels", || vec![[0, 0], [1, 0]]),
    ("two pixels far apart", || vec![[0, 63], [63, 0]]),
    ("a row", || (0..64).map(|x| [x, 40]).collect()),
    ("a column", || (0..64).map(|y| [63, y]).collect()),
    ("a diagonal", || (0..64).map(|at| [at, at]).collect()),
    ("a diagonal and one pixel beside it", || (0..64).map(|at| [at, at]).chain([[1, 0]]).collect()),
    ("two rows", || (0..128).map(|at| [at % 64, at / 64]).collect()),
];

/// Fits all six terms to a plane sampled at few pixels. Returns the largest error at these pixels.
fn fit_of_few(pixels: Few) -> Result<Measured> {
    let frame = Frame::new([0, 63], [0, 63]);
    let plane = |[x, y]: [usize; 2]| 31_000.0 + 200.0 * x as f64 - 300.0 * y as f64;
    let sample = |&place: &[usize; 2]| Sample { at: frame.at(place[0], place[1]), value: plane(place), slope: 1.0 };
    let samples: Vec<Sample> = pixels().iter().map(sample).collect();
    let error = |terms: &Terms| {
        let residual = |sample: &Sample| (value_of(terms, frame.basis(sample.at)) - sample.value).abs();
        samples.iter().map(residual).fold(0.0, f64::max)
    };
    let mut worst = Measured::nothing();
    let mut accept = |terms: &[f64; 6]| terms.iter().all(|term| term.is_finite()).then(|| error(terms));
    let found = [frame.minimax::<3, _>(&samples, 0, &mut accept), frame.minimax::<6, _>(&samples, 0, &mut accept)];
    for (found, terms) in found.into_iter().zip([3, 6]) {
        let error = found.ok_or_else(|| Error::invalid("no function was found for pixels of a plane"))?;
        worst.greatest(error, || format!("{terms} terms"));
    }
    Ok(worst)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_in_integers_find_what_is_there() {
        let size = [24, 16];
        let function = |x: usize, y: usize| (900 + 31 * x + 7 * y + 3 * x * y + 5 * x * x + 2 * y * y) as u16;
        let codes: Vec<u16> = (0..24 * 16).map(|at| function(at % 24, at / 24)).collect();
        let exact = ExactFit::new(size, &codes);
        let most = (0..codes.len()).map(|at| (exact.value([at % 24, at / 24]) - f64::from(codes[at])).abs());
        assert!(most.fold(0.0, f64::max) < 1e-9);
    }

    #[test]
    fn a_coefficient_that_is_off_by_a_millionth_is_seen() {
        for picture in PICTURES.iter().filter(|picture| picture.size.iter().all(|side| *side >= 8)) {
            let (size, codes) = (picture.size, picture.picture());
            let frame = Frame::new([0, size[0] - 1], [0, size[1] - 1]);
            let (terms, _) = frame.project(codes.chunks_exact(size[0]), 6);
            for term in 0..6 {
                let mut off = terms;
                off[term] += 65535e-6;
                let seen = difference(&frame, &off, (size, &codes)).figure;
                assert!(seen > projection_rounding(size), "{}, term {term}: {seen:e}", picture.name);
            }
        }
    }
}
