//! Options of material.

use clap::{Args, ValueEnum};

use crate::encode::{EncodeSettings, MaterialSettings};

/// Default error of material in blocks, in steps of 8 bits.
const USUAL_ERROR_IN_BLOCKS: u16 = 8;

/// How material is coded.
#[derive(Debug, Clone, Copy, Args)]
#[command(next_help_heading = "Material")]
pub struct MaterialArgs {
    /// Store material in blocks of a texture format that stay within --material-error
    #[arg(long, value_name = "FORMAT", value_enum, default_value_t = MaterialBlockArg::None)]
    pub material_block: MaterialBlockArg,
    /// Largest error of a decoded material in steps of 8 bits; 0 is lossless [default: 0, with blocks 8]
    #[arg(long, value_name = "STEPS", value_parser = clap::value_parser!(u16).range(..=255))]
    pub material_error: Option<u16>,
}

/// `--material-block`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum MaterialBlockArg {
    /// Raw values
    None,
    /// 8 bytes for 4x4 pixels
    Bc1,
}

impl MaterialArgs {
    /// Puts the options where the encoder reads them.
    pub fn apply(self, settings: &mut EncodeSettings) {
        let in_blocks = self.material_block == MaterialBlockArg::Bc1;
        let usual = if in_blocks { USUAL_ERROR_IN_BLOCKS } else { 0 };
        settings.material = MaterialSettings { epsilon: self.material_error.unwrap_or(usual), in_blocks };
    }
}
