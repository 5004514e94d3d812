//! `lightfold encode-depth SEQ -o OUT`: one depth sequence.

use crate::cli::encode::encode_to;
use crate::cli::options::{DepthArgs, EffortArgs, FrameArgs, OutputArgs, ResumeArgs, SequenceArgs};
use crate::cli::{ExitStatus, GlobalArgs};
use crate::dataset::source::SourceOptions;
use crate::dataset::stream::StreamKind;
use crate::encode::EncodeSettings;
use crate::error::Result;

/// Arguments.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  lightfold encode-depth face_px/depth.%04d.exr --face px -o px.lfold\n  \
    lightfold encode-depth depth.####.exr --depth-codec aabb --depth-block bc5 --update-threshold 30 -o a.lfold\n  \
    lightfold encode-depth frame-######.depth.png --depth-scale 0.001 --background 0 \\\n      \
    --depth-kind planar --intrinsics 585,585,320,240 -o kinect.lfold\n\n\
    Channels are looked for by their usual names: Z, depth.Z, depth.V, depth, Depth, ViewLayer.Depth.Z and the like, \
    in any layer.")]
pub struct Args {
    /// The sequence: a pattern such as depth.%04d.exr or depth.####.exr, a folder, or one file
    #[arg(value_name = "SEQ")]
    pub input: String,
    /// Output.
    #[command(flatten)]
    pub output: OutputArgs,
    /// Resume.
    #[command(flatten)]
    pub resume: ResumeArgs,
    /// Frames.
    #[command(flatten)]
    pub frames: FrameArgs,
    /// Sequence.
    #[command(flatten)]
    pub sequence: SequenceArgs,
    /// Depth.
    #[command(flatten)]
    pub depth: DepthArgs,
    /// Effort.
    #[command(flatten)]
    pub effort: EffortArgs,
}

impl Args {
    /// What the options come to.
    pub fn settings(&self) -> Result<(SourceOptions, EncodeSettings)> {
        let (mut options, mut settings) = (SourceOptions::default(), EncodeSettings::default());
        self.depth.apply(&mut options, &mut settings)?;
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
    let source = args.sequence.open(StreamKind::Depth, &args.input, options)?;
    encode_to(&source, &settings, (&args.output, args.resume.into()), global)
}
