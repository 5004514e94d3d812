//! Material options.

use clap::Args;

use super::choice::{Choices, InBlocks, one_of};
use footage::encode::{EncodeSettings, MaterialSettings};

/// Default error of material in blocks, in 8-bit steps.
const USUAL_ERROR_IN_BLOCKS: u16 = 8;

const MATERIAL_BLOCKS: &Choices<InBlocks> = &[("none", false, "Raw values"), ("bc1", true, "8 bytes per 4x4 pixels")];

#[derive(Debug, Clone, Copy, Args)]
#[command(next_help_heading = "Material")]
pub struct MaterialArgs {
    /// Store material as texture blocks with errors up to --material-error
    #[arg(long, value_name = "FORMAT", value_parser = one_of(MATERIAL_BLOCKS), default_value = "none")]
    pub material_block: InBlocks,
    /// Maximum error of decoded material in 8-bit steps; 0 is lossless [default: 0, with blocks 8]
    #[arg(long, value_name = "STEPS", value_parser = clap::value_parser!(u16).range(..=255))]
    pub material_error: Option<u16>,
}

impl MaterialArgs {
    pub fn apply(self, settings: &mut EncodeSettings) {
        let usual = if self.material_block { USUAL_ERROR_IN_BLOCKS } else { 0 };
        let epsilon = self.material_error.unwrap_or(usual);
        settings.material = MaterialSettings { epsilon, in_blocks: self.material_block };
    }
}
