//! Biquadratic functions: six coefficients for a node (arithmetic.md 6).
//!
//! Enters: a block of codes and the bound that its approximation must keep. Leaves: integer coefficients, and codes
//! again. Based on: GDC 3.2, equations 5 to 7.

use crate::depth::block::BlockMut;
use crate::depth::domain::{Domain, DomainKind, log_code};

/// Pixels that are computed side by side.
const LANES: usize = 8;

/// a0 x + a1 y + a2 xy + a3 x² + a4 y² + a5 over the pixels of a node, x and y from 0 at its top left.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Biquadratic {
    /// a0 to a5: a0, a1 and a5 in Q14, a2 (xy), a3 (x²) and a4 (y²) in Q22.
    pub coefficients: [i32; 6],
}

impl Biquadratic {
    /// The same everywhere, in Q14.
    pub fn constant(value: i32) -> Biquadratic {
        Biquadratic { coefficients: [0, 0, 0, 0, 0, value] }
    }

    /// The function at a pixel in Q14, wrapping.
    pub fn value(&self, x: i32, y: i32) -> i32 {
        let [a0, a1, a2, a3, a4, a5] = self.coefficients;
        let u = a0.wrapping_add(a2.wrapping_mul(y).wrapping_add(a3.wrapping_mul(x)).wrapping_add(128) >> 8);
        let v = a1.wrapping_add(a4.wrapping_mul(y).wrapping_add(128) >> 8);
        a5.wrapping_add(u.wrapping_mul(x)).wrapping_add(v.wrapping_mul(y))
    }

    /// Fills a block with the codes of the function.
    pub fn decode(&self, domain: &Domain, target: &mut BlockMut) {
        match domain.kind() {
            DomainKind::Log => self.fill(target, log_code),
            DomainKind::Linear => self.fill(target, |r| domain.linear_code(r)),
            DomainKind::Inverse => self.fill(target, |r| domain.inverse_code(r)),
        }
    }

    fn fill(&self, target: &mut BlockMut, code: impl Fn(i32) -> u16) {
        if self.coefficients[..5] == [0; 5] {
            let code = code(self.coefficients[5]);
            target.rows_mut().for_each(|row| row.fill(code));
            return;
        }
        for (y, row) in target.rows_mut().enumerate() {
            self.fill_row(y as i32, row, &code);
        }
    }

    /// One row. What does not depend on x is done once; without x² the row is a straight line, which only adds.
    #[inline]
    fn fill_row(&self, y: i32, row: &mut [u16], code: impl Fn(i32) -> u16) {
        let [a0, a1, a2, a3, a4, a5] = self.coefficients;
        let v = a1.wrapping_add(a4.wrapping_mul(y).wrapping_add(128) >> 8);
        let start = a5.wrapping_add(v.wrapping_mul(y));
        let bend = a2.wrapping_mul(y).wrapping_add(128);
        let (chunks, rest) = row.as_chunks_mut::<LANES>();
        if a3 == 0 {
            let slope = a0.wrapping_add(bend >> 8);
            let mut lanes = ramp(start, slope);
            let step = slope.wrapping_mul(LANES as i32);
            for chunk in chunks {
                for (pixel, lane) in chunk.iter_mut().zip(&mut lanes) {
                    *pixel = code(*lane);
                    *lane = lane.wrapping_add(step);
                }
            }
            rest.iter_mut().zip(lanes).for_each(|(pixel, lane)| *pixel = code(lane));
            return;
        }
        let (mut xs, mut bends) = (ramp(0, 1), ramp(bend, a3));
        let step = a3.wrapping_mul(LANES as i32);
        let value = |x: i32, bend: i32| start.wrapping_add(a0.wrapping_add(bend >> 8).wrapping_mul(x));
        for chunk in chunks {
            for ((pixel, x), bend) in chunk.iter_mut().zip(&mut xs).zip(&mut bends) {
                *pixel = code(value(*x, *bend));
                *x += LANES as i32;
                *bend = bend.wrapping_add(step);
            }
        }
        rest.iter_mut().zip(xs).zip(bends).for_each(|((pixel, x), bend)| *pixel = code(value(x, bend)));
    }
}

/// The first values of a straight line.
#[inline]
pub(crate) fn ramp(start: i32, slope: i32) -> [i32; LANES] {
    std::array::from_fn(|x| start.wrapping_add(slope.wrapping_mul(x as i32)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::depth::block::side_of;
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
        let mut random = Random(3);
        for case in 0..3000u32 {
            let mut coefficients: [i32; 6] = std::array::from_fn(|_| (random.next() as i32) >> (random.next() % 32));
            match case % 4 {
                0 => coefficients[..5].fill(0),
                1 => coefficients[2..5].fill(0),
                2 => coefficients[3] = 0,
                _ => {}
            }
            let function = Biquadratic { coefficients };
            let level = (random.next() % 5) as u8;
            let side = side_of(level);
            let (width, height) = (1 + random.next() as usize % side, 1 + random.next() as usize % side);
            for domain in domains() {
                let mut picture = vec![0u16; width * height];
                function.decode(&domain, &mut BlockMut::of(&mut picture, width, level, [0, 0]));
                for (i, &code) in picture.iter().enumerate() {
                    let r = function.value((i % width) as i32, (i / width) as i32);
                    assert_eq!(code, domain.code_of(r), "{function:?} pixel {i}");
                }
            }
        }
    }
}
