//! Fits platelets to blocks.
//!
//! Input: a block of codes and an error bound. Output: a line and integer coefficients. Based on: GDC 3.2.

use crate::depth::biquadratic::Biquadratic;
use crate::depth::biquadratic::fit::{EXACT, Sight, sample};
use crate::depth::block::{Accuracy, Block};
use crate::depth::domain::{Domain, DomainKind, log_code};
use crate::depth::least_squares::{Constants, Frame, Terms};
use crate::depth::limit::{Limit, NodeFunction, measure};
use crate::depth::nodes;
use crate::depth::nodes::{COEFFICIENT_BYTES, Shifts};
use crate::depth::platelet::line_search::{LineSearch, separating_line};
use crate::depth::platelet::{Plane, Platelet, SideTest};
use crate::depth::quantise::BACKGROUND_CODE;

/// Maximum level at which lines are searched: edges are rarely straight across larger nodes.
pub const MAX_PLATELET_LEVEL: u8 = 6;
const CANDIDATES: usize = 4;

impl Platelet {
    /// Fits a platelet that is within `bound` codes of the block in every pixel; returns `None` if none was found. Each side is
    /// either all background or all surface.
    pub fn fit(block: &Block, domain: &Domain, bound: u16) -> Option<(Platelet, Accuracy)> {
        if block.level == 0 || block.level > MAX_PLATELET_LEVEL {
            return None;
        }
        match Sight::of(block) {
            Sight::Background => {
                let sides = [Plane::constant(domain.background()); 2];
                return Some((Platelet { sides, line: [0; 4] }, Accuracy::default()));
            }
            Sight::Both => {
                let line = separating_line(block, |code| code == BACKGROUND_CODE)?;
                return fit_sides(block, domain, bound, line);
            }
            Sight::Surface => {}
        }
        let gap = widest_gap(block).and_then(|middle| separating_line(block, |code| code > middle));
        if let Some(found) = gap.and_then(|line| fit_sides(block, domain, bound, line)) {
            return Some(found);
        }
        let search = LineSearch::new(block, domain);
        let worst = (f64::from(bound) + 1.0) * if domain.kind() == DomainKind::Log { 1.0 } else { 2.0 };
        let worst = worst * worst * block.pixel_count() as f64;
        let lines = search.best::<CANDIDATES>();
        lines
            .into_iter()
            .filter(|&(squared_error, _)| squared_error <= worst)
            .find_map(|(_, line)| fit_sides(block, domain, bound, line))
    }
}

impl NodeFunction for Platelet {
    fn to_bytes(self) -> [u8; COEFFICIENT_BYTES] {
        let ([a, b], [x0, y0, x1, y1]) = (self.sides, self.line);
        nodes::put([a.a0, a.a1, a.a5, b.a0, b.a1, b.a5], [x0, y0, x1, y1, 0xFF, 0xFF, 0xFF, 0xFF])
    }

    fn rounded(&self, shifts: Shifts, block: &Block, domain: &Domain, limit: Limit) -> Option<(Platelet, Accuracy)> {
        let test = SideTest::new(self.line, block.level);
        let round = |value: i32| {
            let step = 1i64 << shifts.linear;
            i32::try_from((i64::from(value) + step / 2).div_euclid(step) * step).ok()
        };
        let mut sides = self.sides;
        for side in &mut sides {
            *side = Plane { a0: round(side.a0)?, a1: round(side.a1)?, a5: 0 };
        }
        let mut constants = [Constants::ANY; 2];
        for (y, row) in block.rows().enumerate() {
            for (x, &code) in row.iter().enumerate() {
                let side = usize::from(test.at(x as i32, y as i32) > 0);
                constants[side].add_pixel(domain, code, sides[side].value(x as i32, y as i32), limit.max_error);
            }
            if constants.iter().any(Constants::is_empty) {
                return None;
            }
        }
        for (side, constants) in sides.iter_mut().zip(constants) {
            side.a5 = constants.choose(shifts.constant)?;
        }
        let platelet = Platelet { sides, line: self.line };
        Some((platelet, platelet.measure(block, domain, limit)?))
    }

    fn measure(&self, block: &Block, domain: &Domain, limit: Limit) -> Option<Accuracy> {
        if !self.sides.iter().all(|side| side.stays_in_range(block)) {
            return None;
        }
        let test = SideTest::new(self.line, block.level);
        measure(block, limit, |y, row| match domain.kind() {
            DomainKind::Log => self.fill_row(test, y as i32, row, log_code),
            DomainKind::Linear => self.fill_row(test, y as i32, row, |r| domain.linear_code(r)),
            DomainKind::Inverse => self.fill_row(test, y as i32, row, |r| domain.inverse_code(r)),
        })
    }
}

impl Plane {
    fn stays_in_range(self, block: &Block) -> bool {
        let whole = Biquadratic { coefficients: [self.a0, self.a1, 0, 0, 0, self.a5] };
        whole.stays_in_range(block.width, block.height)
    }
}

fn fit_sides(block: &Block, domain: &Domain, bound: u16, line: [u8; 4]) -> Option<(Platelet, Accuracy)> {
    let sides = [fit_side(block, domain, bound, (line, 0))?, fit_side(block, domain, bound, (line, 1))?];
    let platelet = Platelet { sides, line };
    Some((platelet, platelet.measure(block, domain, Limit::on_max(bound))?))
}

/// Fits the plane of one side. Coefficients that its pixels do not determine, because they are too few or collinear, are 0.
fn fit_side(block: &Block, domain: &Domain, bound: u16, (line, side): ([u8; 4], usize)) -> Option<Plane> {
    let test = SideTest::new(line, block.level);
    let (mut pixels, mut background) = (Vec::with_capacity(block.pixel_count()), 0);
    let (mut first, mut last) = ([usize::MAX; 2], [0; 2]);
    for (y, row) in block.rows().enumerate() {
        for (x, &code) in row.iter().enumerate() {
            if usize::from(test.at(x as i32, y as i32) > 0) == side {
                pixels.push(([x, y], code));
                first = [first[0].min(x), first[1].min(y)];
                last = [last[0].max(x), last[1].max(y)];
                background += usize::from(code == BACKGROUND_CODE);
            }
        }
    }
    if pixels.is_empty() {
        return Some(Plane::default());
    }
    if background > 0 {
        return (background == pixels.len()).then(|| Plane::constant(domain.background()));
    }
    let frame = Frame::new([first[0], last[0]], [first[1], last[1]]);
    let samples: Vec<_> = pixels.iter().map(|&([x, y], code)| sample(domain, frame.at(x, y), code)).collect();
    let accept = |terms: &Terms| {
        // `quantise` returns coefficients for pixels counted from the node's top left.
        let [a0, a1, _, _, _, a5] = frame.quantise(terms, EXACT)?;
        let plane = Plane { a0, a1, a5 };
        let close = |&([x, y], code): &([usize; 2], u16)| {
            let found = domain.code_of(plane.value(x as i32, y as i32));
            found.abs_diff(code) <= bound && found != BACKGROUND_CODE
        };
        (plane.stays_in_range(block) && pixels.iter().all(close)).then_some(plane)
    };
    frame.minimax::<3, _>(&samples, bound, accept).or_else(|| frame.minimax::<1, _>(&samples, bound, accept))
}

/// Returns the middle of the widest gap between the codes of the block, at a resolution of 1/64 of their range; `None` if there
/// is no gap.
fn widest_gap(block: &Block) -> Option<u16> {
    const BUCKETS: usize = 64;
    let (low, high) = block.rows().flatten().fold((u16::MAX, 0), |(low, high), &code| (low.min(code), high.max(code)));
    let width = usize::from(high - low) / BUCKETS + 1;
    let mut seen = [false; BUCKETS];
    block.rows().flatten().for_each(|&code| seen[usize::from(code - low) / width] = true);
    let (mut start, mut widest) = (0, 0..0);
    for bucket in (0..BUCKETS).filter(|&bucket| seen[bucket]) {
        if bucket - start > widest.len() {
            widest = start..bucket;
        }
        start = bucket + 1;
    }
    (!widest.is_empty()).then(|| low + (widest.start * width + widest.len() * width / 2) as u16)
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
        let (mut random, domains) = (Random::new(5), domains());
        for case in 0..3000u32 {
            let mut number = || (random.bits() as i32) >> (random.bits() % 32);
            let mut plane = || Plane { a0: number(), a1: number(), a5: number() };
            let sides = [plane(), plane()];
            let platelet = Platelet { sides, line: (random.bits() as u32).to_le_bytes() };
            let level = (case % 4 + 1) as u8;
            let side = side_of(level);
            let (width, height) = (1 + random.bits() as usize % side, 1 + random.bits() as usize % side);
            for domain in &domains {
                let mut picture = vec![0u16; width * height];
                platelet.decode(domain, &mut BlockMut::of(&mut picture, width, level, [0, 0]));
                for (i, &code) in picture.iter().enumerate() {
                    let r = platelet.value(level, (i % width) as i32, (i / width) as i32);
                    assert_eq!(code, domain.code_of(r), "{platelet:?} pixel {i}");
                }
            }
        }
    }

    #[test]
    fn the_side_test_is_the_cross_product_of_the_document() {
        let mut random = Random::new(6);
        for _ in 0..2000 {
            let [x0, y0, x1, y1] = (random.bits() as u32).to_le_bytes();
            let level = (random.bits() % 9) as u8;
            let side = side_of(level) as i64;
            let (x, y) = (random.bits() as i64 & (side - 1), random.bits() as i64 & (side - 1));
            let test = SideTest::new([x0, y0, x1, y1], level).at(x as i32, y as i32);
            let [x0, y0, x1, y1] = [x0, y0, x1, y1].map(i64::from);
            let cross =
                (x1 - x0) * ((2 * y + 1) * 256 - y0 * 2 * side) - (y1 - y0) * ((2 * x + 1) * 256 - x0 * 2 * side);
            assert_eq!(cross.signum(), i64::from(test.signum()));
            assert!(test.abs() < 1 << 24);
        }
    }

    /// Fits and trims a platelet, and checks both results with the decoder in every pixel.
    fn checked(picture: &[u16], width: usize, level: u8, (domain, bound): (&Domain, u16)) -> Option<Platelet> {
        let block = Block::of(picture, width, level, [0, 0]);
        let (function, accuracy) = Platelet::fit(&block, domain, bound)?;
        let decoded = |function: &Platelet| {
            let mut decoded = vec![7u16; picture.len()];
            function.decode(domain, &mut BlockMut::of(&mut decoded, width, level, [0, 0]));
            block.accuracy(&decoded).unwrap()
        };
        assert_eq!(decoded(&function), accuracy);
        assert!(accuracy.max_error <= bound && function.line != [0xff; 4]);
        let limit = Limit { max_error: bound, squared_error: accuracy.squared_error * 2 + 64 };
        let (trimmed, after) = function.trim(&block, domain, limit);
        assert_eq!(decoded(&trimmed), after);
        assert!(limit.allows(after));
        let is_rounded = |shifts: Shifts| {
            trimmed.sides.iter().all(|side| {
                [side.a0, side.a1].iter().all(|a| a.trailing_zeros() >= shifts.linear)
                    && side.a5.trailing_zeros() >= shifts.constant
            })
        };
        assert!(trimmed == function || Precision::from_coarsest().any(|p| is_rounded(p.shifts(level))));
        Some(function)
    }

    /// Returns the pixels of a square: from `planes[1]` where `inside` is true, from `planes[0]` elsewhere.
    fn parted(side: usize, inside: impl Fn(f64, f64) -> bool, planes: [[f64; 3]; 2]) -> Vec<u16> {
        let pixels = (0..side * side).map(|i| ((i % side) as f64, (i / side) as f64));
        let code = |(x, y): (f64, f64)| {
            let [a, b, c] = planes[usize::from(inside(x, y))];
            (a * x + b * y + c + 0.5).clamp(0.0, 65_534.0) as u16
        };
        pixels.map(code).collect()
    }

    #[test]
    fn steps_along_any_line_are_exact() {
        let (mut random, domains) = (Random::new(11), domains());
        let mut found = 0;
        let cases = 400;
        for case in 0..cases {
            let level = [1, 1, 2, 3, 5][case % 5];
            let side = side_of(level);
            let angle = (random.bits() % 6283) as f64 / 1000.0;
            let n = side as f64;
            let through = [0, 1].map(|_| n * (0.2 + 0.6 * (random.bits() % 1000) as f64 / 1000.0));
            let inside = |x: f64, y: f64| (x - through[0]) * angle.cos() + (y - through[1]) * angle.sin() > 0.0;
            let picture = parted(side, inside, [[40.0 / n, 90.0 / n, 5000.0], [-70.0 / n, 30.0 / n, 60_000.0]]);
            for domain in &domains {
                found += usize::from(checked(&picture, side, level, (domain, 2)).is_some());
            }
        }
        // In a large node, not every line that passes a pixel at less than 1/256 of the side can be represented.
        assert!(found * 100 >= cases * 3 * 99, "{found} of {}", cases * 3);
    }

    #[test]
    fn creases_are_found_without_a_step() {
        let mut random = Random::new(12);
        let (mut found, cases) = (0, 200);
        for case in 0..cases {
            let level = [1, 2, 3, 4][case % 4];
            let side = side_of(level);
            let n = side as f64;
            let angle = (random.bits() % 6283) as f64 / 1000.0;
            let (c, s) = (angle.cos() * 4000.0 / n, angle.sin() * 4000.0 / n);
            let fold = 30_000.0 - (c + s) * n / 2.0;
            let inside = |x: f64, y: f64| (x - n / 2.0) * c + (y - n / 2.0) * s > 0.0;
            let picture = parted(side, inside, [[0.0, 0.0, 30_000.0], [c, s, fold]]);
            found += usize::from(checked(&picture, side, level, (&Domain::log(), 30)).is_some());
        }
        assert!(found * 100 >= cases * 95, "{found} of {cases}");
    }

    #[test]
    fn sides_of_one_and_two_pixels_are_exact() {
        for domain in domains() {
            for level in [1, 2, 4] {
                let side = side_of(level);
                let last = side * side - 1;
                let sets: [&[usize]; 6] = [&[0], &[side - 1], &[last], &[0, 1], &[0, side], &[last - 1, last]];
                for set in sets {
                    for (near, far) in [(0, 65_534), (65_534, 0), (500, 40_000)] {
                        let mut picture = vec![near; side * side];
                        set.iter().for_each(|&i| picture[i] = far);
                        assert!(checked(&picture, side, level, (&domain, 0)).is_some(), "{set:?} {level}");
                    }
                }
            }
        }
    }

    #[test]
    fn a_line_of_pixels_is_a_side() {
        let picture = parted(8, |x, _| x == 0.0, [[3.0, 2.0, 900.0], [0.0, 700.0, 20_000.0]]);
        let flipped = parted(8, |_, y| y == 7.0, [[3.0, 2.0, 900.0], [700.0, 0.0, 20_000.0]]);
        for picture in [picture, flipped] {
            assert!(checked(&picture, 8, 1, (&Domain::log(), 1)).is_some());
        }
    }

    #[test]
    fn the_background_is_one_side_or_there_is_no_fit() {
        for domain in domains() {
            for level in [1, 3, 6] {
                let side = side_of(level);
                let n = side as f64;
                let mut picture = parted(side, |_, _| false, [[100.0 / n, 50.0 / n, 65_000.0]; 2]);
                for i in (0..side * side).filter(|i| 3 * (i % side) + 2 * (i / side) > 2 * side) {
                    picture[i] = BACKGROUND_CODE;
                }
                assert!(checked(&picture, side, level, (&domain, 1)).is_some(), "{level} {:?}", domain.kind());
                picture[side * side - 1] = 65_000;
                assert!(checked(&picture, side, level, (&domain, u16::MAX)).is_none());
            }
            assert!(checked(&[BACKGROUND_CODE; 64], 8, 1, (&domain, 0)).is_some());
        }
    }

    #[test]
    fn blocks_at_the_edge_of_a_picture_and_noise_keep_the_bound() {
        let (mut random, domains) = (Random::new(13), domains());
        for case in 0..600 {
            let domain = &domains[case % 3];
            let spread = 1 << (random.bits() % 16);
            let base = random.bits() % (65_536 - spread);
            let (width, height) = match case % 5 {
                0 => (1, 1 + case % 7),
                1 => (1 + case % 8, 1),
                2 => (3, 5),
                _ => (8, 8),
            };
            let picture: Vec<u16> = (0..width * height).map(|_| (base + random.bits() % spread) as u16).collect();
            checked(&picture, width, 1, (domain, 300));
        }
        assert!(checked(&[5], 1, 1, (&Domain::log(), 0)).is_some());
        let checkerboard: Vec<u16> = (0..64).map(|i| if (i + i / 8) % 2 == 0 { 0 } else { 65_534 }).collect();
        assert!(checked(&checkerboard, 8, 1, (&Domain::log(), 1000)).is_none());
        assert!(Platelet::fit(&Block::of(&[0; 16], 4, 0, [0, 0]), &Domain::log(), 0).is_none());
        assert!(Platelet::fit(&Block::of(&[0; 16], 4, 7, [0, 0]), &Domain::log(), 0).is_none());
    }
}
