//! The 16-bit codes of depth that measures know.

pub const BACKGROUND_CODE: u16 = u16::MAX;
