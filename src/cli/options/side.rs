//! Options for reading the compared files.

use clap::Args;

use super::color::INVALID_COLORS;
use super::sequence::COLOR_SPACES;
use super::value::one_of;
use super::{DepthReadingArgs, ImageArgs};
use codec::decode::Selection;
use codec::error::Result;
use codec::image::cube::Face;
use footage::compare::SideOptions;
use footage::dataset::source::{Arrangement, SourceOptions};
use footage::dataset::{InvalidColor, InvalidDepth};
use footage::image_files::ColorSpace;

#[derive(Debug, Clone, Args)]
pub struct SideArgs {
    /// Colour space of the input [default: linear light for EXR, sRGB for PNG]
    #[arg(long, value_parser = one_of(COLOR_SPACES), help_heading = "Colour")]
    pub color_space: Option<ColorSpace>,
    /// Handling of NaN in colour, and of alpha outside 0 to 1
    #[arg(long, value_name = "WHAT", value_parser = one_of(INVALID_COLORS), default_value = "refuse",
        help_heading = "Colour")]
    pub invalid_color: InvalidColor,
    #[command(flatten)]
    pub depth: DepthReadingArgs,
    #[command(flatten)]
    pub images: ImageArgs,
}

impl SideArgs {
    pub fn is_usual(&self) -> bool {
        let (depth, images) = (&self.depth, &self.images);
        self.color_space.is_none()
            && self.invalid_color == InvalidColor::Refuse
            && depth.invalid_depth == InvalidDepth::Refuse
            && (depth.depth_scale, depth.background, depth.depth_kind) == (None, None, None)
            && images.layout == Arrangement::Single(Face::View)
            && images.intrinsics.is_none()
            && images.face_size.is_none()
            && images.channels.is_usual()
    }

    /// Returns the options of both sides and the compared selection.
    pub fn options(&self, selection: Selection) -> Result<SideOptions> {
        let mut source = SourceOptions::default();
        self.depth.apply(&mut source);
        source.color_space = self.color_space;
        source.invalid_color = self.invalid_color;
        source.face_size = self.images.face_size;
        self.images.channels.apply(&mut source);
        Ok(SideOptions { source, layout: self.images.layout()?, selection })
    }
}
