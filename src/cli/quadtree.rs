//! `lightfold quadtree SEQ -o OUT`: one depth sequence as quadtrees, to be packed at any bound.

use crate::cli::encode::encode_to;
use crate::cli::options::{
    DepthUnitArgs, DomainArgs, EffortArgs, FrameArgs, ModelArgs, OutputArgs, ResumeArgs, SequenceArgs,
};
use crate::cli::{ExitStatus, GlobalArgs};
use crate::dataset::source::SourceOptions;
use crate::dataset::stream::StreamKind;
use crate::encode::{DepthCodec, EncodeSettings, ErrorBound};
use crate::error::Result;

/// Largest error where none is given, in codes.
const DEFAULT_MAX_ERROR: u16 = 300;

/// Arguments.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  lightfold quadtree face_px/depth.%04d.exr --face px -o px.tree.lfold\n  \
    lightfold quadtree face_px/depth.%04d.exr --max-error 1000 --effort fast -o px.tree.lfold\n  \
    lightfold pack px.tree.lfold --max-error 30 -o px.lfold\n\n\
    The result is the intermediate form: all codes as they are, and the functions that were found for each node. It \
    decodes without loss; lightfold pack makes the small form of it, at any bound up to --max-error.")]
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
    /// Largest error of a function in 16-bit log codes: the largest bound that the result can be packed at
    #[arg(long, value_name = "CODES", default_value_t = DEFAULT_MAX_ERROR, help_heading = "Depth",
        value_parser = clap::value_parser!(u16).range(..=65534))]
    pub max_error: u16,
    /// Domain.
    #[command(flatten)]
    pub domain: DomainArgs,
    /// Model.
    #[command(flatten)]
    pub model: ModelArgs,
    /// Units.
    #[command(flatten)]
    pub units: DepthUnitArgs,
    /// Effort.
    #[command(flatten)]
    pub effort: EffortArgs,
}

/// Builds the quadtrees of a sequence.
pub fn run(args: &Args, global: &GlobalArgs) -> Result<ExitStatus> {
    let (mut options, mut settings) = (SourceOptions::default(), EncodeSettings::default());
    args.domain.apply(&mut settings);
    args.model.apply(&mut settings);
    args.units.apply(&mut options, &mut settings);
    args.effort.apply(&mut settings);
    options.frames = args.frames.frames;
    settings.depth.codec = DepthCodec::Tree;
    settings.depth.error = ErrorBound::Codes(args.max_error);
    settings.lzma2 = args.output.lzma2;
    settings.memory = args.output.memory.get();
    let source = args.sequence.open(StreamKind::Depth, &args.input, options)?;
    encode_to(&source, &settings, (&args.output, args.resume.into()), global)
}
