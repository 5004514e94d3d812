//! Biquadratic functions: six coefficients for a node (arithmetic.md 6).
//!
//! Decodes integer coefficients into codes. Based on: GDC 3.2, equation 5.

#[cfg(feature = "encode")]
pub mod fit;

use crate::depth::block::BlockMut;
use crate::depth::domain::{Domain, DomainKind, log_code};

pub const LANES: usize = 8;

/// The surface a0 x + a1 y + a2 xy + a3 x² + a4 y² + a5 over the pixels of a node, with x and y from 0 at its top left.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Biquadratic {
    /// a0 to a5: a0, a1 and a5 in Q14, a2 (xy), a3 (x²) and a4 (y²) in Q22.
    pub coefficients: [i32; 6],
}

impl Biquadratic {
    pub fn constant(value: i32) -> Biquadratic {
        Biquadratic { coefficients: [0, 0, 0, 0, 0, value] }
    }

    /// Evaluates the function at a pixel in Q14, with wrapping arithmetic.
    pub fn value(&self, x: i32, y: i32) -> i32 {
        let [a0, a1, a2, a3, a4, a5] = self.coefficients;
        let u = a0.wrapping_add(a2.wrapping_mul(y).wrapping_add(a3.wrapping_mul(x)).wrapping_add(128) >> 8);
        let v = a1.wrapping_add(a4.wrapping_mul(y).wrapping_add(128) >> 8);
        a5.wrapping_add(u.wrapping_mul(x)).wrapping_add(v.wrapping_mul(y))
    }

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

    /// Fills one row. Terms that do not depend on x are computed once; without an x² term the row is linear and needs only
    /// additions.
    #[inline]
    fn fill_row(&self, y: i32, row: &mut [u16], code: impl Fn(i32) -> u16) {
        let [a0, a1, a2, a3, a4, a5] = self.coefficients;
        let v = a1.wrapping_add(a4.wrapping_mul(y).wrapping_add(128) >> 8);
        let start = a5.wrapping_add(v.wrapping_mul(y));
        let bend = a2.wrapping_mul(y).wrapping_add(128);
        let (chunks, rest) = row.as_chunks_mut::<LANES>();
        if a3 == 0 {
            let slope = a0.wrapping_add(bend >> 8);
            straight(start, slope, row, code);
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

#[inline]
pub fn straight(start: i32, slope: i32, row: &mut [u16], code: impl Fn(i32) -> u16) {
    let (chunks, rest) = row.as_chunks_mut::<LANES>();
    let mut lanes = ramp(start, slope);
    let step = slope.wrapping_mul(LANES as i32);
    for chunk in chunks {
        for (pixel, lane) in chunk.iter_mut().zip(&mut lanes) {
            *pixel = code(*lane);
            *lane = lane.wrapping_add(step);
        }
    }
    rest.iter_mut().zip(lanes).for_each(|(pixel, lane)| *pixel = code(lane));
}

#[inline]
pub fn ramp(start: i32, slope: i32) -> [i32; LANES] {
    std::array::from_fn(|x| start.wrapping_add(slope.wrapping_mul(x as i32)))
}
