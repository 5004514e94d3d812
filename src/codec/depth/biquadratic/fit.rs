//! Fits biquadratic functions to blocks.
//!
//! Input: a block of codes and an error bound. Output: integer coefficients. Based on: GDC 3.2, equations 6 and 7.

use crate::depth::biquadratic::Biquadratic;
use crate::depth::block::{Accuracy, Block};
use crate::depth::domain::{Domain, DomainKind, VALUE_BITS, log_code};
use crate::depth::least_squares::{Constants, Frame, Sample, Terms};
use crate::depth::limit::{Limit, NodeFunction, measure};
use crate::depth::nodes;
use crate::depth::nodes::{COEFFICIENT_BYTES, Shifts};
use crate::depth::quantise::BACKGROUND_CODE;

/// Blocks with more pixels are subsampled for reweighting; all pixels are verified.
const MAX_SAMPLES: usize = 1024;
pub const EXACT: Shifts = Shifts { constant: 0, linear: 0, quadratic: 0 };

#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Order {
    Constant,
    Plane,
    Full,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sight {
    Surface,
    Background,
    Both,
}

impl Sight {
    pub fn of(block: &Block) -> Sight {
        let (mut background, mut surface) = (false, false);
        for row in block.rows() {
            let count = row.iter().map(|&code| u32::from(code == BACKGROUND_CODE)).sum::<u32>();
            background |= count > 0;
            surface |= count < row.len() as u32;
        }
        match (background, surface) {
            (true, true) => Sight::Both,
            (true, false) => Sight::Background,
            _ => Sight::Surface,
        }
    }
}

impl Biquadratic {
    /// Fits a function of an order that is within `bound` codes of the block in every pixel: the least-squares fit if it is
    /// within the bound, otherwise one with a smaller maximum error. Returns `None` if none was found.
    pub fn fit(block: &Block, domain: &Domain, bound: u16, order: Order) -> Option<(Biquadratic, Accuracy)> {
        match Sight::of(block) {
            Sight::Both => return None,
            Sight::Background => {
                return Some((Biquadratic::constant(domain.background()), Accuracy::default()));
            }
            Sight::Surface => {}
        }
        match order {
            Order::Constant => fit_constant(block, domain, bound),
            Order::Plane => fit_terms::<3>(block, domain, bound),
            Order::Full => fit_terms::<6>(block, domain, bound),
        }
    }

    fn constants(&self, block: &Block, domain: &Domain, max_error: u16) -> Option<Constants> {
        let mut constants = Constants::ANY;
        for (y, row) in block.rows().enumerate() {
            for (x, &code) in row.iter().enumerate() {
                constants.add_pixel(domain, code, self.value(x as i32, y as i32), max_error);
            }
            if constants.is_empty() {
                return None;
            }
        }
        Some(constants)
    }

    /// Returns true if no intermediate of Horner's scheme overflows 32 bits in the first `width` columns and `height` rows.
    pub fn stays_in_range(&self, width: usize, height: usize) -> bool {
        let [a0, a1, a2, a3, a4, a5] = self.coefficients.map(i64::from);
        // The pixels tried are next to the extremes; rounding changes the values between them by less than this margin.
        let fits = |value: i64| value.abs() < (1 << 31) - (1 << 14);
        let (right, bottom) = (width as i64 - 1, height as i64 - 1);
        let whole = |x: i64, y: i64| {
            let (bend, v) = (a2 * y + a3 * x + 128, a1 + ((a4 * y + 128) >> 8));
            let u = a0 + (bend >> 8);
            let steps = [a2 * y, a3 * x, bend, u, a4 * y, v, u * x, v * y, a5 + u * x, a5 + u * x + v * y];
            steps.into_iter().all(fits)
        };
        if [a2, a3, a4] == [0; 3] {
            return whole(0, 0) && whole(right, 0) && whole(0, bottom) && whole(right, bottom);
        }
        // Along a row every intermediate is linear or quadratic in x, so its extremes are at the ends or at the vertex.
        (0..=bottom).all(|y| {
            let vertex = if a3 == 0 { 0 } else { (-((a0 << 8) + a2 * y) / (2 * a3)).clamp(0, right) };
            whole(0, y) && whole(right, y) && (vertex == 0 || whole(vertex, y))
        })
    }
}

impl NodeFunction for Biquadratic {
    fn to_bytes(self) -> [u8; COEFFICIENT_BYTES] {
        nodes::put(self.coefficients, [0xFF; 8])
    }

    fn rounded(&self, shifts: Shifts, block: &Block, domain: &Domain, limit: Limit) -> Option<(Biquadratic, Accuracy)> {
        let frame = frame_of(block);
        let mut coefficients = frame.quantise(&frame.terms_of(self.coefficients), shifts)?;
        coefficients[5] = 0;
        let constants = Biquadratic { coefficients }.constants(block, domain, limit.max_error)?;
        coefficients[5] = constants.choose(shifts.constant)?;
        let function = Biquadratic { coefficients };
        Some((function, function.measure(block, domain, limit)?))
    }

    fn measure(&self, block: &Block, domain: &Domain, limit: Limit) -> Option<Accuracy> {
        if !self.stays_in_range(block.width, block.height) {
            return None;
        }
        measure(block, limit, |y, row| match domain.kind() {
            DomainKind::Log => self.fill_row(y as i32, row, log_code),
            DomainKind::Linear => self.fill_row(y as i32, row, |r| domain.linear_code(r)),
            DomainKind::Inverse => self.fill_row(y as i32, row, |r| domain.inverse_code(r)),
        })
    }
}

fn frame_of(block: &Block) -> Frame {
    Frame::new([0, block.width - 1], [0, block.height - 1])
}

fn fit_constant(block: &Block, domain: &Domain, bound: u16) -> Option<(Biquadratic, Accuracy)> {
    let (mut low, mut high, mut sum) = (u16::MAX, 0, 0u64);
    for row in block.rows() {
        for &code in row {
            (low, high) = (low.min(code), high.max(code));
            sum += u64::from(code);
        }
        if high - low > bound.saturating_mul(2) {
            return None;
        }
    }
    let mean = (sum as f64 / block.pixel_count() as f64).round() as u16;
    [mean, low + (high - low) / 2].into_iter().find_map(|code| {
        let function = Biquadratic::constant((domain.value_of(code) * f64::from(1 << VALUE_BITS)).round() as i32);
        Some((function, function.measure(block, domain, Limit::on_max(bound))?))
    })
}

fn fit_terms<const N: usize>(block: &Block, domain: &Domain, bound: u16) -> Option<(Biquadratic, Accuracy)> {
    let frame = frame_of(block);
    let accept = |terms: &Terms| {
        let function = Biquadratic { coefficients: frame.quantise(terms, EXACT)? };
        Some((function, function.measure(block, domain, Limit::on_max(bound))?))
    };
    if domain.kind() == DomainKind::Log {
        let (terms, squared_error) = frame.project(block.rows(), N);
        let mean = squared_error / block.pixel_count() as f64;
        // The maximum error is at least the RMS error, and rounding adds less than one code.
        if mean.sqrt() > f64::from(bound) + 1.0 {
            return None;
        }
        if let Some(found) = accept(&terms) {
            return Some(found);
        }
    }
    let mut samples = Vec::with_capacity(block.pixel_count().min(2 * MAX_SAMPLES));
    let stride = (block.pixel_count() as f64 / MAX_SAMPLES as f64).sqrt().ceil().max(1.0) as usize;
    let picked = |at: usize, end: usize| at.is_multiple_of(stride) || at + 1 == end;
    for (y, row) in block.rows().enumerate().filter(|&(y, _)| picked(y, block.height)) {
        for (x, &code) in row.iter().enumerate().filter(|&(x, _)| picked(x, row.len())) {
            samples.push(sample(domain, frame.at(x, y), code));
        }
    }
    frame.minimax::<N, _>(&samples, bound, accept)
}

pub fn sample(domain: &Domain, at: [f64; 2], code: u16) -> Sample {
    let value = domain.value_of(code);
    Sample { at, value, slope: domain.slope_at(value).abs() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::depth::block::{BlockMut, side_of};
    use crate::depth::nodes::Precision;
    use crate::depth::quantise::DepthRange;
    use crate::math::random::Random;

    fn domains() -> [Domain; 3] {
        DomainKind::ALL.map(|kind| Domain::new(kind, DepthRange::new(1.5, 15.5).unwrap()).unwrap())
    }

    #[test]
    fn rows_are_what_pixels_are() {
        let (mut random, domains) = (Random::new(3), domains());
        for case in 0..3000u32 {
            let mut coefficients: [i32; 6] = std::array::from_fn(|_| (random.bits() as i32) >> (random.bits() % 32));
            match case % 4 {
                0 => coefficients[..5].fill(0),
                1 => coefficients[2..5].fill(0),
                2 => coefficients[3] = 0,
                _ => {}
            }
            let function = Biquadratic { coefficients };
            let level = (random.bits() % 5) as u8;
            let side = side_of(level);
            let (width, height) = (1 + random.bits() as usize % side, 1 + random.bits() as usize % side);
            for domain in &domains {
                let mut picture = vec![0u16; width * height];
                function.decode(domain, &mut BlockMut::of(&mut picture, width, level, [0, 0]));
                for (i, &code) in picture.iter().enumerate() {
                    let r = function.value((i % width) as i32, (i / width) as i32);
                    assert_eq!(code, domain.code_of(r), "{function:?} pixel {i}");
                }
            }
        }
    }

    /// Returns a picture of one block, rounded from codes in f64.
    fn picture(width: usize, height: usize, code: impl Fn(f64, f64) -> f64) -> Vec<u16> {
        let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x as f64, y as f64)));
        pixels.map(|(x, y)| (code(x, y) + 0.5).clamp(0.0, 65535.0) as u16).collect()
    }

    /// Fits and trims a function, and checks both results with the decoder in every pixel.
    fn checked(
        picture: &[u16],
        width: usize,
        level: u8,
        (domain, bound, order): (&Domain, u16, Order),
    ) -> Option<Accuracy> {
        let block = Block::of(picture, width, level, [0, 0]);
        let (function, accuracy) = Biquadratic::fit(&block, domain, bound, order)?;
        let decoded = |function: &Biquadratic| {
            let mut decoded = vec![7u16; picture.len()];
            function.decode(domain, &mut BlockMut::of(&mut decoded, width, level, [0, 0]));
            block.accuracy(&decoded).unwrap()
        };
        assert_eq!(decoded(&function), accuracy);
        assert!(accuracy.max_error <= bound);
        let limit = Limit { max_error: bound, squared_error: accuracy.squared_error * 2 + 64 };
        let (trimmed, after) = function.trim(&block, domain, limit);
        assert_eq!(decoded(&trimmed), after);
        assert!(limit.allows(after));
        let [a0, a1, a2, a3, a4, a5] = trimmed.coefficients;
        let is_rounded = |shifts: Shifts| {
            [a0, a1].iter().all(|a| a.trailing_zeros() >= shifts.linear)
                && [a2, a3, a4].iter().all(|a| a.trailing_zeros() >= shifts.quadratic)
                && a5.trailing_zeros() >= shifts.constant
        };
        assert!(trimmed == function || Precision::from_coarsest().any(|p| is_rounded(p.shifts(level))));
        Some(accuracy)
    }

    #[test]
    fn planes_and_biquadratics_are_recovered() {
        for (level, width, height) in [(1, 8, 8), (2, 16, 11), (4, 64, 64), (7, 512, 512), (8, 1024, 700)] {
            let n = width as f64;
            let plane = picture(width, height, |x, y| 9000.0 + (20_000.0 * x + 15_000.0 * y) / n);
            // In a small node such curvature exceeds the range of Q22.
            let bend = if level < 3 { 0.2 } else { 1.0 };
            let bent = picture(width, height, |x, y| {
                let (x, y) = (x / n, y / n);
                let (x, y) = (x * bend, y * bend);
                20_000.0 + 9000.0 * x - 5000.0 * y + 20_000.0 * x * y - 14_000.0 * x * x + 8000.0 * y * y
            });
            let log = Domain::log();
            assert!(checked(&plane, width, level, (&log, 1, Order::Plane)).is_some(), "{level}");
            assert!(checked(&plane, width, level, (&log, 1, Order::Full)).is_some(), "{level}");
            assert!(checked(&bent, width, level, (&log, 1, Order::Full)).is_some(), "{level}");
            assert!(checked(&bent, width, level, (&log, 1, Order::Plane)).is_none(), "{level}");
            assert!(checked(&plane, width, level, (&log, 300, Order::Constant)).is_none(), "{level}");
        }
    }

    #[test]
    fn planes_of_other_domains_are_recovered_in_them() {
        for domain in &domains()[1..] {
            for (level, width) in [(1, 8), (3, 32), (5, 128), (7, 512)] {
                let codes = |x: f64, y: f64| {
                    let r = 20_000.0 + (30_000.0 * x + 8000.0 * y) / width as f64;
                    f64::from(domain.code_of((r * 16384.0) as i32))
                };
                let picture = picture(width, width, codes);
                assert!(checked(&picture, width, level, (domain, 1, Order::Plane)).is_some(), "{:?}", domain.kind());
                assert!(checked(&picture, width, level, (domain, 1, Order::Full)).is_some(), "{:?}", domain.kind());
            }
        }
    }

    #[test]
    fn gentle_ramps_and_grazing_planes_keep_the_bound() {
        let log = Domain::log();
        for (level, width) in [(1, 8), (4, 64), (7, 512)] {
            let ramp = picture(width, width, |x, y| 30_000.0 + (x + y) / 64.0);
            assert!(checked(&ramp, width, level, (&log, 1, Order::Plane)).is_some());
            let grazing = picture(width, width, |x, y| (65_534.0 * y + 3.0 * x) / (width as f64 + 2.0));
            assert!(checked(&grazing, width, level, (&log, 1, Order::Plane)).is_some());
        }
    }

    #[test]
    fn the_largest_error_is_brought_below_the_bound() {
        let log = Domain::log();
        let bent = picture(8, 8, |x, _| 1000.0 + 8.0 * x * x);
        let block = Block::of(&bent, 8, 1, [0, 0]);
        let (_, square) = frame_of(&block).project(block.rows(), 3);
        assert!(square > 0.0);
        // The best plane has a maximum error of 49 · 8 / 8 = 49 against the parabola.
        assert!(checked(&bent, 8, 1, (&log, 51, Order::Plane)).is_some());
        assert!(checked(&bent, 8, 1, (&log, 47, Order::Plane)).is_none());
    }

    #[test]
    fn small_pictures_fit_whatever_their_shape() {
        let mut random = Random::new(8);
        for domain in domains() {
            for (width, height) in [(1, 1), (1, 2), (2, 1), (1, 7), (6, 1), (2, 2), (3, 5), (2, 8), (8, 2)] {
                let (a, b) = ((random.bits() % 100) as f64, (random.bits() % 100) as f64);
                let picture = picture(width, height, |x, y| 4000.0 + a * x + b * y);
                for order in [Order::Plane, Order::Full] {
                    assert!(checked(&picture, width, 1, (&domain, 12, order)).is_some(), "{width}x{height} {order:?}");
                }
            }
            let any = [(random.bits() % 65_535) as u16];
            assert_eq!(checked(&any, 1, 1, (&domain, 0, Order::Full)).unwrap().max_error, 0);
        }
    }

    #[test]
    fn constants_are_exact_in_each_domain() {
        for domain in domains() {
            for code in [0, 1, 30_000, 65_533, 65_534, BACKGROUND_CODE] {
                for order in [Order::Constant, Order::Plane, Order::Full] {
                    let accuracy = checked(&[code; 64], 8, 1, (&domain, 0, order));
                    assert_eq!(accuracy, Some(Accuracy { max_error: 0, squared_error: 0 }), "{code} {order:?}");
                }
            }
            let mut odd = [65_534; 64];
            odd[63] = BACKGROUND_CODE;
            assert!(checked(&odd, 8, 1, (&domain, u16::MAX, Order::Full)).is_none());
        }
    }

    #[test]
    fn noise_keeps_the_bound_or_is_refused() {
        let (mut random, domains) = (Random::new(9), domains());
        let mut found = 0;
        for case in 0..600 {
            let domain = &domains[case % 3];
            let spread = 1 << (random.bits() % 16);
            let base = random.bits() % (65_536 - spread);
            let (width, height) = (1 + random.bits() as usize % 16, 1 + random.bits() as usize % 16);
            let picture: Vec<u16> = (0..width * height).map(|_| (base + random.bits() % spread) as u16).collect();
            for order in [Order::Constant, Order::Plane, Order::Full] {
                found += u32::from(checked(&picture, width, 2, (domain, 300, order)).is_some());
            }
        }
        assert!(found > 300);
    }

    #[test]
    fn what_would_wrap_is_refused() {
        let at = |coefficients: [i32; 6], side: usize| Biquadratic { coefficients }.stays_in_range(side, side);
        assert!(at([0, 0, 0, 0, 0, 1 << 30], 1024));
        assert!(at([1 << 19, 0, 0, 0, 0, 1 << 30], 1024));
        assert!(!at([1 << 21, 0, 0, 0, 0, 1 << 30], 1024));
        assert!(!at([0, 0, 1 << 26, 0, 0, 0], 64));
        assert!(!at([0, 0, 0, 0, -(1 << 30), 0], 8));
        assert!(!at([-(1 << 28), 0, 0, 1 << 30, 0, 0], 4));
        assert!(!at([i32::MIN, 0, 0, 0, 0, 0], 1));
        let mut random = Random::new(10);
        for _ in 0..20_000 {
            let coefficients: [i32; 6] = std::array::from_fn(|_| (random.bits() as i32) >> (random.bits() % 24));
            let function = Biquadratic { coefficients };
            if function.stays_in_range(8, 8) {
                let [a0, a1, a2, a3, a4, a5] = coefficients.map(i64::from);
                for (x, y) in (0..64).map(|i| (i % 8, i / 8)) {
                    let u = a0 + ((a2 * y + a3 * x + 128) >> 8);
                    let r = a5 + u * x + (a1 + ((a4 * y + 128) >> 8)) * y;
                    assert_eq!(i64::from(function.value(x as i32, y as i32)), r);
                }
            }
        }
        // Three pixels of full contrast need larger coefficients than the format can hold.
        let steep = picture(3, 1, |x, _| if x == 1.0 { 65_534.0 } else { 0.0 });
        assert!(checked(&steep, 3, 1, (&Domain::log(), 0, Order::Full)).is_none());
    }
}
