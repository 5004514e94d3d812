//! How far a decoded image is from its reference: PSNR, SSIM, an HDR PSNR, depth error in codes and metres.
//!
//! Enters: two images of one size. Leaves: accumulators that merge over faces, frames and probes. Every sum is either
//! an exact integer or an f64 taken in a fixed order, so no number here depends on the thread count.

pub mod depth_error;
pub mod psnr;
pub mod pu21;
pub mod ssim;

pub use depth_error::{BACKGROUND_CODE, DEPTH_CODE_PEAK, DepthErrorStats, DepthMetres};
pub use psnr::{CodeError, ErrorSum, RealError, SquaredError, U8_PEAK, U16_PEAK, psnr_to_max_sse};
pub use pu21::{DEFAULT_WHITE_CD_M2, PU21_PEAK, PuTable, pu21_encode};
pub use ssim::{SSIM_WINDOW, ssim_rgb8};
