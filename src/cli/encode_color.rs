//! `lightfold encode-color SEQ -o OUT`: one colour sequence.

use crate::cli::encode::encode_to;
use crate::cli::options::{ColorArgs, ColorSpaceArg, EffortArgs, FrameArgs, OutputArgs, ResumeArgs, SequenceArgs};
use crate::cli::{ExitStatus, GlobalArgs};
use crate::dataset::source::SourceOptions;
use crate::dataset::stream::StreamKind;
use crate::encode::EncodeSettings;
use crate::error::Result;

/// Arguments.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  lightfold encode-color face_px/color.%04d.exr --face px -o px.lfold\n  \
    lightfold encode-color color.####.exr --color-block bc1 -o small.lfold\n  \
    lightfold encode-color pano.####.exr --layout equirect --hdr -o pano.lfold\n\n\
    Channels are looked for by their usual names: R, G, B, or layers such as rgba, Combined and beauty; Y alone is gray.")]
pub struct Args {
    /// The sequence: a pattern such as color.%04d.exr or color.####.exr, a folder, or one file
    #[arg(value_name = "SEQ")]
    pub input: String,
    /// Output.
    #[command(flatten)]
    pub output: OutputArgs,
    /// Resume.
    #[command(flatten)]
    pub resume: ResumeArgs,
    /// What the values mean [default: light for EXR, sRGB for PNG]
    #[arg(long, value_enum)]
    pub color_space: Option<ColorSpaceArg>,
    /// Frames.
    #[command(flatten)]
    pub frames: FrameArgs,
    /// Sequence.
    #[command(flatten)]
    pub sequence: SequenceArgs,
    /// Colour.
    #[command(flatten)]
    pub color: ColorArgs,
    /// Effort.
    #[command(flatten)]
    pub effort: EffortArgs,
}

impl Args {
    /// What the options come to.
    pub fn settings(&self) -> Result<(SourceOptions, EncodeSettings)> {
        let (mut options, mut settings) = (SourceOptions::default(), EncodeSettings::default());
        self.color.apply(&mut options, &mut settings)?;
        options.color_space = self.color_space.map(Into::into);
        options.frames = self.frames.frames;
        self.effort.apply(&mut settings);
        settings.lzma2 = self.output.lzma2;
        settings.memory = self.output.memory.get();
        Ok((options, settings))
    }
}

/// Encodes a sequence.
pub fn run(args: &Args, global: &GlobalArgs) -> Result<ExitStatus> {
    let (options, settings) = args.settings()?;
    let source = args.sequence.open(StreamKind::Color, &args.input, options)?;
    encode_to(&source, &settings, (&args.output, args.resume.into()), global)
}
