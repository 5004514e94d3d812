//! Arguments of `render --reference`.

use std::path::PathBuf;

use clap::Args;

/// Reference images.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Reference")]
pub struct TruthArgs {
    /// Render the images of this dataset, and report PSNR and SSIM
    #[arg(long, value_name = "DATASET", conflicts_with_all = ["camera", "eye"])]
    pub reference: Option<PathBuf>,
    /// Only these probes of the reference, such as 00,01
    #[arg(long, value_name = "NAME", value_delimiter = ',', requires = "reference", conflicts_with_all = ["camera", "eye"])]
    pub reference_probe: Vec<String>,
    /// Folder for error maps
    #[arg(long, value_name = "DIR", requires = "reference", conflicts_with_all = ["camera", "eye"])]
    pub error_map: Option<PathBuf>,
}
