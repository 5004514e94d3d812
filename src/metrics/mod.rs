//! Metrics of images and depth, each implemented once: PSNR, visible error, PSNR-HVS-M, SSIM, SSIMULACRA2, butteraugli, PU21
//! codes, depth error in codes and metres.
//!
//! Sums are exact integers or have a fixed order, so no result depends on the number of threads.

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
