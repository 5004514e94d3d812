//! `lightfold quadtree SEQ -o OUT`: one depth sequence as quadtrees, to be packed at any error bound.

use crate::cli::encode;
use crate::cli::options::{DepthUnitArgs, DomainArgs, ModelArgs, OutputArgs, ResumeArgs, SequenceInputArgs};
use crate::cli::{ExitStatus, GlobalArgs};
use crate::dataset::source::SourceOptions;
use crate::encode::{DepthCodec, EncodeSettings, ErrorBound};
use crate::error::Result;
use crate::image::StreamKind;

/// Arguments.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  lightfold quadtree face_px/depth.%04d.exr --face px -o px.tree.lfold\n  \
    lightfold quadtree face_px/depth.%04d.exr --max-error 1000 --effort fast -o px.tree.lfold\n  \
    lightfold pack px.tree.lfold --max-error 30 -o px.lfold\n\n\
    The intermediate form holds every code and the modelling functions of every node. It decodes without loss; \
    `lightfold pack` reduces it to any error bound up to --max-error.")]
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
    /// Largest error of a modelling function in 16-bit log codes, and so the largest bound to pack at
    #[arg(long, value_name = "CODES", default_value_t = 300, help_heading = "Depth",
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
}

/// Encodes the sequence.
pub fn run(args: &Args, global: &GlobalArgs) -> Result<ExitStatus> {
    let (mut options, mut settings) = (SourceOptions::default(), EncodeSettings::default());
    args.domain.apply(&mut settings);
    args.model.apply(&mut settings);
    args.units.apply(&mut options, &mut settings);
    args.input.apply(&mut options, &mut settings);
    args.output.store.apply(&mut settings);
    settings.depth.codec = DepthCodec::Tree;
    settings.depth.error = ErrorBound::Codes(args.max_error);
    let source = args.input.open(StreamKind::Depth, options)?;
    encode::encode_to(&source, &settings, &args.output.target(args.resume), global)
}
