//! Measures of pictures and of depth: SSIM, SSIMULACRA2, butteraugli, PSNR-HVS-M, depth error in codes and metres.

pub mod depth_error;
pub mod eye;
pub mod psnr_hvs_m;
pub mod ssim;

pub use depth_error::DepthErrors;
pub use eye::{EyeScores, scoring_bytes};
pub use psnr_hvs_m::{HVS_BLOCK, HvsError, psnr_hvs_m_rgb8};
pub use ssim::{SSIM_WINDOW, ssim_rgb8};
