//! `lightfold encode-color SEQ -o OUT`: one colour sequence.

use crate::cli::encode::Encodes;
use crate::cli::options::choice::one_of;
use crate::cli::options::{COLOR_SPACES, ColorArgs, SequenceArgs, Target};
use crate::dataset::source::{Source, SourceOptions};
use crate::encode::EncodeSettings;
use crate::error::Result;
use crate::image::StreamKind;
use crate::image::png::ColorSpace;

#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  lightfold encode-color face_px/color.%04d.exr --face px -o px.lfold\n  \
    lightfold encode-color color.####.exr --color-block bc1 -o small.lfold\n  \
    lightfold encode-color pano.####.exr --layout equirect --hdr -o pano.lfold\n\n\
    Channels are found by their usual names: R, G, B, or layers such as rgba, Combined and beauty; Y alone is gray.")]
pub struct Args {
    #[command(flatten)]
    pub sequence: SequenceArgs,
    /// Encoding of the values [default: linear light for EXR, sRGB for PNG]
    #[arg(long, value_parser = one_of(COLOR_SPACES))]
    pub color_space: Option<ColorSpace>,
    #[command(flatten)]
    pub color: ColorArgs,
}

impl Encodes for Args {
    fn settings(&self) -> Result<(SourceOptions, EncodeSettings)> {
        let (mut options, mut settings) = (SourceOptions::default(), EncodeSettings::default());
        self.color.apply(&mut options, &mut settings)?;
        options.color_space = self.color_space;
        self.sequence.apply(&mut options, &mut settings);
        Ok((options, settings))
    }

    fn open(&self, options: &SourceOptions) -> Result<Source> {
        self.sequence.input.open(StreamKind::Color, options)
    }

    fn target(&self) -> Target<'_> {
        self.sequence.target()
    }
}
