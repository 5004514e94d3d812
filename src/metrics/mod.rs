//! Every measure of pictures and depth, one of each: PSNR, visible errors, PSNR-HVS-M, SSIM, SSIMULACRA2, butteraugli, PU21 codes, depth error in codes and metres.
//!
//! Sums are exact integers, or have an order of their own, so no figure depends on the thread count.

pub mod codes;
#[cfg(feature = "encode")]
pub mod depth_error;
#[cfg(feature = "encode")]
pub mod eye;
pub mod psnr;
#[cfg(feature = "encode")]
pub mod psnr_hvs_m;
pub mod pu21;
#[cfg(feature = "encode")]
pub mod ssim;
#[cfg(feature = "encode")]
pub mod visible;

pub use codes::BACKGROUND_CODE;
#[cfg(feature = "encode")]
pub use depth_error::DepthErrors;
#[cfg(feature = "encode")]
pub use eye::{EyeScores, scoring_bytes};
pub use psnr::{SquaredError, U8_PEAK, U16_PEAK, psnr_to_max_sse};
#[cfg(feature = "encode")]
pub use psnr_hvs_m::{HVS_BLOCK, HvsError, psnr_hvs_m_rgb8};
pub use pu21::{DEFAULT_WHITE_CD_M2, PU21_PEAK, PuTable, pu21_encode};
#[cfg(feature = "encode")]
pub use ssim::{SSIM_WINDOW, ssim_rgb8};
