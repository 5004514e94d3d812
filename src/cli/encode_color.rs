//! `lightfold encode-color SEQ -o OUT`: one colour sequence.

use crate::cli::encode;
use crate::cli::options::{ColorArgs, ColorSpaceArg, OutputArgs, ResumeArgs, SequenceInputArgs};
use crate::cli::{ExitStatus, GlobalArgs};
use crate::dataset::source::SourceOptions;
use crate::encode::EncodeSettings;
use crate::error::Result;
use crate::image::StreamKind;

/// Arguments.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  lightfold encode-color face_px/color.%04d.exr --face px -o px.lfold\n  \
    lightfold encode-color color.####.exr --color-block bc1 -o small.lfold\n  \
    lightfold encode-color pano.####.exr --layout equirect --hdr -o pano.lfold\n\n\
    Channels are found by their usual names: R, G, B, or layers such as rgba, Combined and beauty; Y alone is gray.")]
pub struct Args {
    /// Output.
    #[command(flatten)]
    pub output: OutputArgs,
    /// Resume.
    #[command(flatten)]
    pub resume: ResumeArgs,
    /// Sequence.
    #[command(flatten)]
    pub input: SequenceInputArgs,
    /// Encoding of the values [default: linear light for EXR, sRGB for PNG]
    #[arg(long, value_enum)]
    pub color_space: Option<ColorSpaceArg>,
    /// Colour.
    #[command(flatten)]
    pub color: ColorArgs,
}

impl Args {
    /// Settings of the source and of the encoder.
    pub fn settings(&self) -> Result<(SourceOptions, EncodeSettings)> {
        let (mut options, mut settings) = (SourceOptions::default(), EncodeSettings::default());
        self.color.apply(&mut options, &mut settings)?;
        options.color_space = self.color_space.map(Into::into);
        self.input.apply(&mut options, &mut settings);
        self.output.store.apply(&mut settings);
        Ok((options, settings))
    }
}

/// Encodes the sequence.
pub fn run(args: &Args, global: &GlobalArgs) -> Result<ExitStatus> {
    let (options, settings) = args.settings()?;
    let source = args.input.open(StreamKind::Color, options)?;
    encode::encode_to(&source, &settings, &args.output.target(args.resume), global)
}
