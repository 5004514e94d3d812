//! Dataset options: frames and channels to read.

use std::path::Path;

use clap::Args;

use super::value::one_of;
use super::{COLOR_SPACES, ChannelArgs, FrameArgs, MissingArgs};
use crate::refuse;
use codec::error::{Error, Result};
use footage::dataset::manifest;
use footage::dataset::source::{Source, SourceOptions};
use footage::image_files::ColorSpace;

#[derive(Debug, Clone, Args)]
pub struct DatasetArgs {
    /// Size of cube faces resampled from equirectangular images [default: image width / 3.14, rounded up to 32]
    #[arg(long, value_name = "PIXELS")]
    pub face_size: Option<u32>,
    #[command(flatten)]
    pub missing: MissingArgs,
    #[command(flatten)]
    pub frames: FrameArgs,
    /// Colour space of the input [default: from the manifest, else linear light with the chromaticities of the file for
    /// EXR, sRGB for PNG]
    #[arg(long, value_parser = one_of(COLOR_SPACES), help_heading = "Colour")]
    pub color_space: Option<ColorSpace>,
    // Groups with headings come last: a heading continues until the next one.
    #[command(flatten)]
    pub channels: ChannelArgs,
}

impl DatasetArgs {
    pub fn apply(&self, options: &mut SourceOptions) {
        options.frames = self.frames.frames;
        options.face_size = self.face_size;
        self.channels.apply(options);
        options.color_space = self.color_space;
        options.missing = self.missing.missing;
    }

    /// Opens the dataset. Fails if it lacks the requested frames.
    pub fn open(&self, input: &Path, options: &SourceOptions) -> Result<Source> {
        if !input.exists() {
            return Err(Error::not_found(input, "there is no such dataset"));
        }
        if !manifest::is_dataset(input) {
            return refuse(format!(
                "{}: neither a lightfield.json nor a folder with one: create one with lightfold init, or encode a \
                sequence with encode-depth or encode-color",
                input.display()
            ));
        }
        let source = Source::open(input, options)?;
        let (asked, there) = (self.frames.frames, source.manifest.as_ref().map(|manifest| manifest.frame_range()));
        if let (Some(asked), Some(there)) = (asked, there)
            && (asked.first < there.first || asked.last > there.last)
        {
            return refuse(format!("--frames {asked}: the dataset has frames {there}"));
        }
        Ok(source)
    }
}
