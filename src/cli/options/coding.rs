//! Selection and coding options of a dataset, material among them.

use clap::Args;

use super::value::{Choices, InBlocks, one_of};
use super::{ColorArgs, DatasetArgs, DepthArgs, EffortArgs, PresetArgs, StoreArgs, parse_kind};
use codec::error::Result;
use codec::image::StreamKind;
use footage::dataset::source::SourceOptions;
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

/// Options of `encode`, which `scan` takes, too.
#[derive(Debug, Clone, Args)]
pub struct CodingArgs {
    /// Only streams of these kinds: color, depth, material, alpha
    #[arg(long, value_name = "KIND", value_delimiter = ',', value_parser = parse_kind)]
    pub stream: Vec<StreamKind>,
    #[command(flatten)]
    pub preset: PresetArgs,
    #[command(flatten)]
    pub effort: EffortArgs,
    #[command(flatten)]
    pub dataset: DatasetArgs,
    #[command(flatten)]
    pub depth: DepthArgs,
    #[command(flatten)]
    pub color: ColorArgs,
    #[command(flatten)]
    pub material: MaterialArgs,
}

impl CodingArgs {
    /// Returns the settings for reading and encoding files, including those of `store`.
    ///
    /// # Errors
    /// Fails if options contradict each other, or tables cannot be read.
    pub fn settings(&self, store: &StoreArgs) -> Result<(SourceOptions, EncodeSettings)> {
        let (mut options, mut settings) = (SourceOptions::default(), EncodeSettings::default());
        let (mut depth, mut color, mut effort) = (self.depth.clone(), self.color.clone(), self.effort);
        let mut store = store.clone();
        self.preset.fill((&mut depth, &mut color), (&mut effort, &mut store));
        depth.apply(&mut options, &mut settings)?;
        color.apply(&mut options, &mut settings)?;
        self.material.apply(&mut settings);
        self.dataset.apply(&mut options);
        effort.apply(&mut settings);
        store.apply(&mut settings);
        if !self.stream.is_empty() {
            settings.kinds = self.stream.clone();
        }
        Ok((options, settings))
    }
}
