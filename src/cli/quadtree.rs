//! `lightfold quadtree SEQ -o OUT`: encodes one depth sequence as quadtrees, which can be packed at any error bound.

use crate::encode::SequenceCodec;
use crate::options::{DepthUnitArgs, DomainArgs, ModelArgs};
use codec::error::Result;
use codec::image::StreamKind;
use footage::dataset::source::SourceOptions;
use footage::encode::{DepthCodec, EncodeSettings, ErrorBound};

#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  lightfold quadtree face_px/depth.%04d.exr --face px -o px.tree.lfold\n  \
    lightfold quadtree face_px/depth.%04d.exr --max-error 1000 --effort fast -o px.tree.lfold\n  \
    lightfold pack px.tree.lfold --max-error 30 -o px.lfold\n\n\
    The intermediate form stores every code and the modelling functions of every node. It decodes losslessly; \
    `lightfold pack` reduces it to any error bound up to --max-error.")]
pub struct Args {
    /// Maximum error of modelling functions in 16-bit log codes, which is the largest bound that pack accepts
    #[arg(long, value_name = "CODES", default_value_t = 300, help_heading = "Depth",
        value_parser = clap::value_parser!(u16).range(..=65534))]
    pub max_error: u16,
    #[command(flatten)]
    pub domain: DomainArgs,
    #[command(flatten)]
    pub model: ModelArgs,
    #[command(flatten)]
    pub units: DepthUnitArgs,
}

impl SequenceCodec for Args {
    const KIND: StreamKind = StreamKind::Depth;

    fn apply(&self, source: &mut SourceOptions, settings: &mut EncodeSettings) -> Result<()> {
        self.model.apply(settings);
        self.units.apply(source, settings);
        settings.depth.domain = self.domain.depth_domain;
        settings.depth.codec = DepthCodec::Tree;
        settings.depth.error = ErrorBound::Codes(self.max_error);
        Ok(())
    }
}
