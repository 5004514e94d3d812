//! `lightfold encode-depth SEQ -o OUT`: encodes one depth sequence.

use crate::encode::SequenceCodec;
use crate::options::DepthArgs;
use codec::error::Result;
use codec::image::StreamKind;
use footage::dataset::source::SourceOptions;
use footage::encode::EncodeSettings;

#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  lightfold encode-depth face_px/depth.%04d.exr --face px -o px.lfold\n  \
    lightfold encode-depth depth.####.exr --depth-codec aabb --depth-block bc5 --update-threshold 30 \\\n      \
    -o a.lfold\n  \
    lightfold encode-depth frame-######.depth.png --depth-scale 0.001 --background 0 \\\n      \
    --depth-kind planar --intrinsics 585,585,320,240 -o kinect.lfold\n\n\
    Channels are detected by common names in any layer: Z, depth.Z, depth.V, depth, Depth, ViewLayer.Depth.Z and \
    similar.")]
pub struct Args {
    #[command(flatten)]
    pub depth: DepthArgs,
}

impl SequenceCodec for Args {
    const KIND: StreamKind = StreamKind::Depth;

    fn apply(&self, source: &mut SourceOptions, settings: &mut EncodeSettings) -> Result<()> {
        self.depth.apply(source, settings)
    }
}
