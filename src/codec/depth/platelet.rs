//! Platelets: two planes with a line between them (arithmetic.md 6).
//!
//! Decodes integer coefficients and a line into codes. Based on: GDC 3.2, equation 4, after Morvan et al. 2006.

#[cfg(feature = "encode")]
mod fit;
#[cfg(feature = "encode")]
mod line_search;

use crate::depth::biquadratic::{LANES, ramp, straight};
use crate::depth::block::{BlockMut, side_of};
use crate::depth::domain::{Domain, DomainKind, log_code};

/// The plane a0 x + a1 y + a5, in Q14, with x and y from 0 at the node's top left.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Plane {
    pub a0: i32,
    pub a1: i32,
    pub a5: i32,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Platelet {
    pub sides: [Plane; 2],
    /// Two points of the line, x0 y0 x1 y1, in 1/256 of the node's side from its top left corner.
    pub line: [u8; 4],
}

/// Side test of a line for the pixels of a node: a positive value is side B.
#[derive(Debug, Clone, Copy)]
pub struct SideTest {
    pub start: i32,
    pub across: i32,
    pub down: i32,
}

impl SideTest {
    /// Returns the side test of a line in a node of `level`. Its magnitude is below 2^24 in every pixel.
    pub fn new([x0, y0, x1, y1]: [u8; 4], level: u8) -> SideTest {
        // Pixel centres are (2x + 1) / (2 side), points of the line x0 / 256. Both are multiplied by the least common multiple of
        // the denominators.
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

    pub fn at(self, x: i32, y: i32) -> i32 {
        self.start + self.across * x + self.down * y
    }
}

impl Plane {
    pub fn constant(value: i32) -> Plane {
        Plane { a0: 0, a1: 0, a5: value }
    }

    /// Evaluates the plane at a pixel in Q14, with wrapping arithmetic.
    pub fn value(self, x: i32, y: i32) -> i32 {
        self.a5.wrapping_add(self.a0.wrapping_mul(x)).wrapping_add(self.a1.wrapping_mul(y))
    }
}

impl Platelet {
    /// Evaluates the function at a pixel of a node of `level` in Q14, with wrapping arithmetic.
    pub fn value(&self, level: u8, x: i32, y: i32) -> i32 {
        let side = usize::from(SideTest::new(self.line, level).at(x, y) > 0);
        self.sides[side].value(x, y)
    }

    pub fn decode(&self, domain: &Domain, target: &mut BlockMut) {
        match domain.kind() {
            DomainKind::Log => self.fill(target, log_code),
            DomainKind::Linear => self.fill(target, |r| domain.linear_code(r)),
            DomainKind::Inverse => self.fill(target, |r| domain.inverse_code(r)),
        }
    }

    fn fill(&self, target: &mut BlockMut, code: impl Fn(i32) -> u16) {
        let test = SideTest::new(self.line, target.level);
        for (y, row) in target.rows_mut().enumerate() {
            self.fill_row(test, y as i32, row, &code);
        }
    }

    /// Fills one row. The line crosses a row at most once, so the groups of pixels before and after the crossing are linear.
    #[inline]
    fn fill_row(&self, test: SideTest, y: i32, row: &mut [u16], code: impl Fn(i32) -> u16) {
        let [a, b] = self.sides;
        let begin = test.at(0, y);
        let end = begin + test.across * (row.len() as i32 - 1);
        let (first, second) = if begin > 0 { (b, a) } else { (a, b) };
        if (begin > 0) == (end > 0) {
            straight(first.value(0, y), first.a0, row, code);
            return;
        }
        // First pixel on the other side.
        let crossing = if begin > 0 { (begin - test.across - 1) / -test.across } else { -begin / test.across + 1 };
        let before = crossing as usize / LANES * LANES;
        let (left, rest) = row.split_at_mut(before.min(row.len()));
        straight(first.value(0, y), first.a0, left, &code);
        let (mixed, right) = rest.split_at_mut(LANES.min(rest.len()));
        let x = before as i32;
        let (of_first, of_second) = (ramp(first.value(x, y), first.a0), ramp(second.value(x, y), second.a0));
        for (at, pixel) in mixed.iter_mut().enumerate() {
            *pixel = code(if before + at < crossing as usize { of_first[at] } else { of_second[at] });
        }
        straight(second.value(x + LANES as i32, y), second.a0, right, &code);
    }
}
