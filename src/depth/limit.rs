//! How wrong an approximation may be, and whether it is: by the decoder, in every pixel.

use crate::depth::block::{Accuracy, Block, MAX_TILE};
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

/// Decodes a block row by row and compares it; `None` as soon as a pixel or the sum breaks the limit, or a surface is
/// taken for the background or the reverse.
pub(crate) fn measure(block: &Block, limit: Limit, mut decode_row: impl FnMut(usize, &mut [u16])) -> Option<Accuracy> {
    let mut decoded = [0u16; MAX_TILE as usize];
    let decoded = &mut decoded[..block.width()];
    let mut total = Accuracy { max_error: 0, squared_error: 0 };
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
