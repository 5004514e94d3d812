//! PSNR, PU21 codes and the visible error (color.md 5).
//!
//! Sums are exact integers or have a fixed order, so that no result depends on the number of threads.

pub mod psnr;
pub mod pu21;
#[cfg(feature = "encode")]
pub mod visible;

pub use psnr::{BACKGROUND_CODE, SquaredError, U8_PEAK, U16_PEAK, psnr_to_max_sse};
pub use pu21::{DEFAULT_WHITE_CD_M2, PU21_PEAK, PuTable, pu21_encode};
