//! `lightfold encode-depth SEQ -o OUT`: one depth sequence.

use crate::cli::encode;
use crate::cli::options::{DepthArgs, OutputArgs, ResumeArgs, SequenceInputArgs};
use crate::cli::{ExitStatus, GlobalArgs};
use crate::dataset::source::SourceOptions;
use crate::encode::EncodeSettings;
use crate::error::Result;
use crate::image::StreamKind;

/// Arguments.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  lightfold encode-depth face_px/depth.%04d.exr --face px -o px.lfold\n  \
    lightfold encode-depth depth.####.exr --depth-codec aabb --depth-block bc5 --update-threshold 30 \\\n      \
    -o a.lfold\n  \
    lightfold encode-depth frame-######.depth.png --depth-scale 0.001 --background 0 \\\n      \
    --depth-kind planar --intrinsics 585,585,320,240 -o kinect.lfold\n\n\
    Channels are found by their usual names: Z, depth.Z, depth.V, depth, Depth, ViewLayer.Depth.Z and the like, in any \
    layer.")]
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
    /// Depth.
    #[command(flatten)]
    pub depth: DepthArgs,
}

impl Args {
    /// Settings of the source and of the encoder.
    pub fn settings(&self) -> Result<(SourceOptions, EncodeSettings)> {
        let (mut options, mut settings) = (SourceOptions::default(), EncodeSettings::default());
        self.depth.apply(&mut options, &mut settings)?;
        self.input.apply(&mut options, &mut settings);
        self.output.store.apply(&mut settings);
        Ok((options, settings))
    }
}

/// Encodes the sequence.
pub fn run(args: &Args, global: &GlobalArgs) -> Result<ExitStatus> {
    let (options, settings) = args.settings()?;
    let source = args.input.open(StreamKind::Depth, options)?;
    encode::encode_to(&source, &settings, &args.output.target(args.resume), global)
}
