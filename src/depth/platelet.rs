//! Platelets: two planes with a line between them (arithmetic.md 6).
//!
//! Enters: a block of codes and the bound that its approximation must keep. Leaves: integer coefficients and a line,
//! and codes again. Based on: GDC 3.2, equation 4, after Morvan et al. 2006.

use crate::depth::biquadratic::ramp;
use crate::depth::block::{BlockMut, side_of};
use crate::depth::domain::{Domain, DomainKind, log_code};

/// a0 x + a1 y + a5, in Q14, x and y from 0 at the node's top left.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Plane {
    /// For each column.
    pub a0: i32,
    /// For each row.
    pub a1: i32,
    /// At the top left pixel.
    pub a5: i32,
}

/// Two planes and the line that separates them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Platelet {
    /// The planes of side A and side B.
    pub sides: [Plane; 2],
    /// Two points of the line, x0 y0 x1 y1, in 1/256 of the node's side from its top left corner.
    pub line: [u8; 4],
}

/// The line's side test for the pixels of a node: B where the value is positive.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SideTest {
    /// Value at the top left pixel.
    pub start: i32,
    /// Added for each column.
    pub across: i32,
    /// Added for each row.
    pub down: i32,
}

impl SideTest {
    /// The test of a line in a node of `level`; below 2^24 in every pixel.
    pub fn new([x0, y0, x1, y1]: [u8; 4], level: u8) -> SideTest {
        // Pixel centres are (2x + 1) / (2 side), the line's points x0 / 256: both times the lesser denominator's
        // multiple that makes them whole.
        let units = 2 * side_of(level) as i32;
        let common = units.min(256);
        let (of_pixels, of_points) = (256 / common, units / common);
        let [x0, y0, x1, y1] = [x0, y0, x1, y1].map(i32::from);
        let (dx, dy) = (x1 - x0, y1 - y0);
        SideTest {
            start: dx * (of_pixels - y0 * of_points) - dy * (of_pixels - x0 * of_points),
            across: -dy * 2 * of_pixels,
            down: dx * 2 * of_pixels,
        }
    }

    /// The value at a pixel.
    pub fn at(self, x: i32, y: i32) -> i32 {
        self.start + self.across * x + self.down * y
    }
}

impl Plane {
    /// The same everywhere, in Q14.
    pub fn constant(value: i32) -> Plane {
        Plane { a0: 0, a1: 0, a5: value }
    }

    /// The plane at a pixel in Q14, wrapping.
    pub fn value(self, x: i32, y: i32) -> i32 {
        self.a5.wrapping_add(self.a0.wrapping_mul(x)).wrapping_add(self.a1.wrapping_mul(y))
    }
}

impl Platelet {
    /// The function at a pixel of a node of `level` in Q14, wrapping.
    pub fn value(&self, level: u8, x: i32, y: i32) -> i32 {
        let side = usize::from(SideTest::new(self.line, level).at(x, y) > 0);
        self.sides[side].value(x, y)
    }

    /// Fills a block with the codes of the function.
    pub fn decode(&self, domain: &Domain, target: &mut BlockMut) {
        match domain.kind() {
            DomainKind::Log => self.fill(target, log_code),
            DomainKind::Linear => self.fill(target, |r| domain.linear_code(r)),
            DomainKind::Inverse => self.fill(target, |r| domain.inverse_code(r)),
        }
    }

    /// Evaluates both planes and the side test in all pixels: three sums each, and no branch.
    fn fill(&self, target: &mut BlockMut, code: impl Fn(i32) -> u16) {
        let test = SideTest::new(self.line, target.level());
        let [a, b] = self.sides;
        for (y, row) in target.rows_mut().enumerate() {
            let y = y as i32;
            let mut of_a = ramp(a.value(0, y), a.a0);
            let mut of_b = ramp(b.value(0, y), b.a0);
            let mut tests = ramp(test.at(0, y), test.across);
            let (chunks, rest) = row.as_chunks_mut();
            let steps = [a.a0, b.a0, test.across].map(|step| step.wrapping_mul(of_a.len() as i32));
            for chunk in chunks {
                let chunk: &mut [u16; 8] = chunk;
                for x in 0..chunk.len() {
                    chunk[x] = code(if tests[x] > 0 { of_b[x] } else { of_a[x] });
                    of_a[x] = of_a[x].wrapping_add(steps[0]);
                    of_b[x] = of_b[x].wrapping_add(steps[1]);
                    tests[x] += steps[2];
                }
            }
            for (x, pixel) in rest.iter_mut().enumerate() {
                *pixel = code(if tests[x] > 0 { of_b[x] } else { of_a[x] });
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::depth::quantise::DepthRange;

    /// A seeded generator (SplitMix64), so that failures repeat.
    struct Random(u64);

    impl Random {
        fn next(&mut self) -> u64 {
            self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
            let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            z ^ (z >> 31)
        }
    }

    fn domains() -> [Domain; 3] {
        DomainKind::ALL.map(|kind| Domain::new(kind, DepthRange::new(1.5, 15.5).unwrap()).unwrap())
    }

    #[test]
    fn rows_are_what_pixels_are() {
        let mut random = Random(5);
        for case in 0..3000u32 {
            let mut number = || (random.next() as i32) >> (random.next() % 32);
            let mut plane = || Plane { a0: number(), a1: number(), a5: number() };
            let sides = [plane(), plane()];
            let platelet = Platelet { sides, line: (random.next() as u32).to_le_bytes() };
            let level = (case % 4 + 1) as u8;
            let side = side_of(level);
            let (width, height) = (1 + random.next() as usize % side, 1 + random.next() as usize % side);
            for domain in domains() {
                let mut picture = vec![0u16; width * height];
                platelet.decode(&domain, &mut BlockMut::of(&mut picture, width, level, [0, 0]));
                for (i, &code) in picture.iter().enumerate() {
                    let r = platelet.value(level, (i % width) as i32, (i / width) as i32);
                    assert_eq!(code, domain.code_of(r), "{platelet:?} pixel {i}");
                }
            }
        }
    }

    #[test]
    fn the_side_test_is_the_cross_product_of_the_document() {
        let mut random = Random(6);
        for _ in 0..2000 {
            let [x0, y0, x1, y1] = (random.next() as u32).to_le_bytes();
            let level = (random.next() % 9) as u8;
            let side = side_of(level) as i64;
            let (x, y) = (random.next() as i64 & (side - 1), random.next() as i64 & (side - 1));
            let test = SideTest::new([x0, y0, x1, y1], level).at(x as i32, y as i32);
            let [x0, y0, x1, y1] = [x0, y0, x1, y1].map(i64::from);
            let cross =
                (x1 - x0) * ((2 * y + 1) * 256 - y0 * 2 * side) - (y1 - y0) * ((2 * x + 1) * 256 - x0 * 2 * side);
            assert_eq!(cross.signum(), i64::from(test.signum()));
            assert!(test.abs() < 1 << 24);
        }
    }
}
