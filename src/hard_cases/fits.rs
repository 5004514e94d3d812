//! Modelling functions where they are hard to fit: pictures through the default codec at every bound, and the arithmetic
//! of fits and of Horner's scheme against references in binary64 (GDC 3.2; arithmetic.md 6).

use crate::depth::biquadratic::Biquadratic;
use crate::depth::domain::{Domain, DomainKind};
use crate::depth::least_squares::{Frame, Sample};
use crate::depth::mode_decision::Decide;
use crate::depth::node_encoder::NodeSettings;
use crate::error::{Error, Result};
use crate::gpu::random::Random;
use crate::hard_cases::clip::{Clip, EFFORT, any_range};
use crate::hard_cases::pictures::{HardPicture, PICTURES};
use crate::hard_cases::{Bound, Family, HardCase, Measured, Shelf, Worst};

/// Bounds that every picture is held to, in codes.
const BOUNDS: [u16; 7] = [0, 1, 10, 30, 100, 300, 1000];
/// Sides of nodes, in pixels, whose arithmetic is looked at.
const SIDES: [usize; 8] = [4, 8, 16, 32, 64, 128, 256, 512];
/// A matrix over the six terms.
type Matrix = [[f64; 6]; 6];

/// All cases.
pub(super) fn cases() -> Vec<HardCase> {
    let mut cases = Vec::new();
    for bound in BOUNDS {
        let shelf = Shelf::new(Family::Fits, format!("DQPN, E = {bound}, all domains and rules"), "codes");
        for picture in PICTURES {
            let case = shelf.case(picture.name, Bound::AtMost(f64::from(bound)), move || through_nodes(picture, bound));
            cases.push(case);
        }
    }
    let condition = Shelf::new(Family::Fits, "normal equations in the scaled basis", "condition number");
    let projected = Shelf::new(Family::Fits, "least squares against an orthogonal reference", "codes, rms");
    let horner = Shelf::new(Family::Fits, "Horner's scheme in integers against binary64", "codes");
    for side in SIDES {
        // The basis is orthogonal; the squares of its functions have means of 1, 1/3 · (1 − 1/n²) and
        // 4/45 · (1 − 1/n²)(1 − 4/n²): the least at n = 4, where 4/45 · 15/16 · 3/4 is 1/16.
        let name = format!("{side}x{side}");
        cases.push(condition.case(name.clone(), Bound::AtMost(16.0), move || Ok(condition_number(side))));
        // Two roundings to 2^-14 of half a unit each, multiplied by the last column and by the last row.
        let most = (side - 1) as f64 / f64::from(1 << 14);
        cases.push(horner.case(name, Bound::AtMost(most), move || Ok(horner_error(side))));
    }
    for picture in PICTURES.iter().filter(|picture| picture.size.iter().all(|side| *side >= 8)) {
        // Each of six sums over n pixels of up to 65535 is off by a part of n · 2^-53 at most, and is divided by a mean
        // square of 1/16 or more.
        let pixels = (picture.size[0] * picture.size[1]) as f64;
        let most = 6.0 * 16.0 * pixels * f64::EPSILON / 2.0 * 65535.0;
        cases.push(projected.case(picture.name, Bound::AtMost(most), move || fit_excess(picture)));
    }
    let few = Shelf::new(Family::Fits, "minimax over pixels that tell too little", "codes");
    // 1024 samples, a condition of 16, values of up to 65535, two passes; what depends on other terms is left out.
    let most = 2.0 * 1024.0 * 16.0 * f64::EPSILON * 65535.0;
    for (name, pixels) in FEW {
        cases.push(few.case(name, Bound::AtMost(most), move || fit_of_few(pixels)));
    }
    cases
}

fn through_nodes(picture: &HardPicture, bound: u16) -> Result<Measured> {
    let (source, range) = (picture.moving(), any_range()?);
    let (mut worst, mut clips) = (Worst::greatest(), Vec::new());
    for kind in DomainKind::ALL {
        let domain = Domain::new(kind, range)?;
        for decide in [Decide::Mse, Decide::Size] {
            let settings = NodeSettings { bound, decide, effort: EFFORT, ..NodeSettings::default() };
            let clip = Clip::nodes(&source, (range, &domain), settings)?;
            let (error, place) = source.error(&clip)?;
            worst.see(error, || place);
            clips.push(clip);
        }
    }
    Ok(worst.measured().with_clips(clips))
}

/// The condition of the basis over a square, with that of plain powers of pixel coordinates beside it.
fn condition_number(side: usize) -> Measured {
    let frame = Frame::new([0, side - 1], [0, side - 1]);
    let (mut ours, mut powers) = ([[0.0; 6]; 6], [[0.0; 6]; 6]);
    for (x, y) in (0..side * side).map(|at| (at % side, at / side)) {
        add_products(&mut ours, frame.basis(frame.at(x, y)));
        add_products(&mut powers, raw_terms(x, y));
    }
    let (figure, raw) = (condition_of(ours), condition_of(powers));
    let note = format!("{raw:.2e} in powers of pixel coordinates");
    Measured { figure, place: None, note: Some(note), clips: Vec::new() }
}

fn raw_terms(x: usize, y: usize) -> [f64; 6] {
    let (x, y) = (x as f64, y as f64);
    [1.0, x, y, x * y, x * x, y * y]
}

fn add_products(matrix: &mut Matrix, terms: [f64; 6]) {
    for (row, a) in matrix.iter_mut().zip(terms) {
        row.iter_mut().zip(terms).for_each(|(sum, b)| *sum += a * b);
    }
}

/// Greatest eigenvalue over least, of a symmetric matrix, by Jacobi's rotations.
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

/// How much larger the residual of [`Frame::project`] is than that of a projection on vectors made orthogonal twice.
fn fit_excess(picture: &HardPicture) -> Result<Measured> {
    let ([width, height], codes) = (picture.size, picture.picture());
    let frame = Frame::new([0, width - 1], [0, height - 1]);
    let (terms, _) = frame.project(codes.chunks_exact(width), 6);
    let places = || (0..codes.len()).map(|at| (at % width, at / width));
    let ours = rms(places().zip(&codes).map(|((x, y), &code)| {
        let basis = frame.basis(frame.at(x, y));
        basis.iter().zip(terms).map(|(basis, term)| basis * term).sum::<f64>() - f64::from(code)
    }));
    let mut basis: Vec<Vec<f64>> = Vec::new();
    for term in 0..6 {
        let mut column: Vec<f64> = places().map(|(x, y)| raw_terms(x, y)[term]).collect();
        for _ in 0..2 {
            for other in &basis {
                let part = dot(&column, other);
                column.iter_mut().zip(other).for_each(|(value, other)| *value -= part * other);
            }
        }
        let length = dot(&column, &column).sqrt();
        column.iter_mut().for_each(|value| *value /= length);
        basis.push(column);
    }
    let mut rest: Vec<f64> = codes.iter().map(|&code| f64::from(code)).collect();
    for column in &basis {
        let part = dot(&rest, column);
        rest.iter_mut().zip(column).for_each(|(value, column)| *value -= part * column);
    }
    let reference = rms(rest.into_iter());
    let note = format!("{ours:.6} codes against {reference:.6}");
    Ok(Measured { figure: (ours - reference).max(0.0), place: None, note: Some(note), clips: Vec::new() })
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), value| (sum + value * value, count + 1.0));
    f64::sqrt(sum / count)
}

/// Random functions that stay in range, evaluated in integers and in binary64.
fn horner_error(side: usize) -> Measured {
    let mut random = Random::new(side as u64);
    let (mut worst, mut tried) = (Worst::greatest(), 0);
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
            worst.see((found - exact).abs(), || format!("{coefficients:?} at ({column}, {row})"));
        }
    }
    worst.measured().with_note(format!("{tried} functions"))
}

/// Columns and rows of the pixels that a fit may see, in a node of 64x64.
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

/// A plane through few pixels, all six terms asked for: the largest error in these pixels.
fn fit_of_few(pixels: Few) -> Result<Measured> {
    let frame = Frame::new([0, 63], [0, 63]);
    let plane = |[x, y]: [usize; 2]| 31_000.0 + 200.0 * x as f64 - 300.0 * y as f64;
    let sample = |&place: &[usize; 2]| Sample { at: frame.at(place[0], place[1]), value: plane(place), slope: 1.0 };
    let samples: Vec<Sample> = pixels().iter().map(sample).collect();
    let error = |terms: &[f64; 6]| {
        let residual = |sample: &Sample| {
            let basis = frame.basis(sample.at);
            (basis.iter().zip(terms).map(|(basis, term)| basis * term).sum::<f64>() - sample.value).abs()
        };
        samples.iter().map(residual).fold(0.0, f64::max)
    };
    let mut worst = Worst::greatest();
    let mut accept = |terms: &[f64; 6]| terms.iter().all(|term| term.is_finite()).then(|| error(terms));
    let found = [frame.minimax::<3, _>(&samples, 0, &mut accept), frame.minimax::<6, _>(&samples, 0, &mut accept)];
    for (found, terms) in found.into_iter().zip([3, 6]) {
        let error = found.ok_or_else(|| Error::invalid("no function was found for pixels of a plane"))?;
        worst.see(error, || format!("{terms} terms"));
    }
    Ok(worst.measured())
}
