//! `lightfold encode-color SEQ -o OUT`: encodes one colour sequence.

use crate::encode::SequenceCodec;
use crate::options::{COLOR_SPACES, ColorArgs, one_of};
use codec::error::Result;
use codec::image::StreamKind;
use footage::dataset::source::SourceOptions;
use footage::encode::EncodeSettings;
use footage::image_files::ColorSpace;

#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  lightfold encode-color face_px/color.%04d.exr --face px -o px.lfold\n  \
    lightfold encode-color color.####.exr --color-block bc1 -o small.lfold\n  \
    lightfold encode-color pano.####.exr --layout equirect --hdr -o pano.lfold\n\n\
    Channels are detected by common names: R, G, B, or layers such as rgba, Combined and beauty; Y alone is gray.")]
pub struct Args {
    /// Colour space of the input [default: linear light for EXR, sRGB for PNG]
    #[arg(long, value_parser = one_of(COLOR_SPACES), help_heading = "Colour")]
    pub color_space: Option<ColorSpace>,
    #[command(flatten)]
    pub color: ColorArgs,
}

impl SequenceCodec for Args {
    const KIND: StreamKind = StreamKind::Color;

    fn apply(&self, source: &mut SourceOptions, settings: &mut EncodeSettings) -> Result<()> {
        source.color_space = self.color_space;
        self.color.apply(source, settings)
    }
}
