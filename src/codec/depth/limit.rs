//! Error limits of approximations, verified with the decoder in every pixel.

use crate::depth::block::{Accuracy, Block, MAX_TILE};
use crate::depth::domain::Domain;
use crate::depth::nodes::{COEFFICIENT_BYTES, Precision, Shifts};
use crate::depth::quantise::BACKGROUND_CODE;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limit {
    pub max_error: u16,
    pub squared_error: u64,
}

impl Limit {
    pub fn on_max(max_error: u16) -> Limit {
        Limit { max_error, squared_error: u64::MAX }
    }

    pub fn allows(&self, accuracy: Accuracy) -> bool {
        accuracy.max_error <= self.max_error && accuracy.squared_error <= self.squared_error
    }
}

/// A modelling function whose coefficients can be rounded to take fewer bytes.
pub trait NodeFunction: Copy {
    fn to_bytes(self) -> [u8; COEFFICIENT_BYTES];

    /// Returns the function with these low bits set to zero; `None` if that exceeds the limit.
    fn rounded(&self, shifts: Shifts, block: &Block, domain: &Domain, limit: Limit) -> Option<(Self, Accuracy)>;

    /// Measures the error of the function with the decoder. Returns `None` if it exceeds the limit or the function would wrap
    /// inside the picture.
    fn measure(&self, block: &Block, domain: &Domain, limit: Limit) -> Option<Accuracy>;

    /// Returns the function with as many low bits set to zero as `limit` allows.
    fn trim(&self, block: &Block, domain: &Domain, limit: Limit) -> (Self, Accuracy) {
        let mut shifts = Precision::from_coarsest().map(|precision| precision.shifts(block.level));
        shifts.find_map(|shifts| self.rounded(shifts, block, domain, limit)).unwrap_or_else(|| {
            // A function that decodes a surface as background gets the largest possible error.
            let worst = Accuracy { max_error: u16::MAX, squared_error: u64::MAX };
            (*self, self.measure(block, domain, Limit::on_max(u16::MAX)).unwrap_or(worst))
        })
    }
}

impl Block<'_> {
    pub fn accuracy(&self, decoded: &[u16]) -> Option<Accuracy> {
        let row = |y: usize, row: &mut [u16]| row.copy_from_slice(&decoded[y * self.width..][..self.width]);
        measure(self, Limit::on_max(u16::MAX), row)
    }
}

/// Decodes a block row by row and measures its error. Returns `None` as soon as a pixel or the sum exceeds the limit, or a
/// surface is decoded as background or the reverse.
pub fn measure(block: &Block, limit: Limit, mut decode_row: impl FnMut(usize, &mut [u16])) -> Option<Accuracy> {
    let mut decoded = [0u16; MAX_TILE as usize];
    let decoded = &mut decoded[..block.width];
    let mut total = Accuracy::default();
    for (y, source) in block.rows().enumerate() {
        decode_row(y, decoded);
        let (mut max_error, mut squared_error, mut confused) = (0u16, 0u64, false);
        for (&source, &decoded) in source.iter().zip(decoded.iter()) {
            let error = source.abs_diff(decoded);
            max_error = max_error.max(error);
            squared_error += u64::from(error) * u64::from(error);
            confused |= (source == BACKGROUND_CODE) != (decoded == BACKGROUND_CODE);
        }
        total.max_error = total.max_error.max(max_error);
        total.squared_error += squared_error;
        if confused || !limit.allows(total) {
            return None;
        }
    }
    Some(total)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_background_is_no_surface_however_near() {
        let picture = [65535, 65534, 10, 20];
        let block = Block::of(&picture, 4, 0, [0, 0]);
        assert_eq!(block.accuracy(&[65535, 65530, 13, 20]), Some(Accuracy { max_error: 4, squared_error: 25 }));
        assert_eq!(block.accuracy(&[65534, 65534, 10, 20]), None);
        assert_eq!(block.accuracy(&[65535, 65535, 10, 20]), None);
    }
}
