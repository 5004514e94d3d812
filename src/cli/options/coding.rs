//! Selection and coding options of a dataset.

use clap::Args;

use super::{ColorArgs, DatasetArgs, DepthArgs, EffortArgs, MaterialArgs, PresetArgs, StoreArgs, parse_kind};
use codec::error::Result;
use codec::image::StreamKind;
use footage::dataset::source::SourceOptions;
use footage::encode::EncodeSettings;

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
