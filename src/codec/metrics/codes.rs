//! 16-bit depth codes with a special meaning in metrics.

pub const BACKGROUND_CODE: u16 = u16::MAX;
