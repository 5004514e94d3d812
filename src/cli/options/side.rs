//! How compared files are read.

use clap::Args;

use super::depth::InvalidDepthArg;
use super::sequence::LayoutArg;
use super::{ColorSpaceArg, DepthReadingArgs, ImageArgs, InvalidColorArg};
use crate::compare::SideOptions;
use crate::dataset::source::{SequenceLayout, SourceOptions};
use crate::decode::Selection;
use crate::error::Result;
use crate::image::cube::Face;

/// How files that are compared are read.
#[derive(Debug, Clone, Args)]
pub struct SideArgs {
    /// Encoding of colour values [default: linear light for EXR, sRGB for PNG]
    #[arg(long, value_enum, help_heading = "Colour")]
    pub color_space: Option<ColorSpaceArg>,
    /// Handling of NaN colours
    #[arg(long, value_name = "WHAT", value_enum, default_value_t = InvalidColorArg::Refuse, help_heading = "Colour")]
    pub invalid_color: InvalidColorArg,
    /// Depth.
    #[command(flatten)]
    pub depth: DepthReadingArgs,
    /// Images.
    #[command(flatten)]
    pub images: ImageArgs,
}

impl SideArgs {
    /// Whether all options have their defaults.
    pub fn is_usual(&self) -> bool {
        let (depth, images) = (&self.depth, &self.images);
        self.color_space.is_none()
            && self.invalid_color == InvalidColorArg::Refuse
            && depth.invalid_depth == InvalidDepthArg::Refuse
            && (depth.depth_scale, depth.background, depth.depth_kind) == (None, None, None)
            && images.layout == LayoutArg::Single
            && images.intrinsics.is_none()
            && (images.face_size, images.channel.as_ref()) == (None, None)
    }

    /// Options of both sides and the compared selection.
    ///
    /// # Errors
    /// A wrong number of intrinsics.
    pub fn options(&self, selection: Selection) -> Result<SideOptions> {
        let mut source = SourceOptions::default();
        self.depth.apply(&mut source);
        source.color_space = self.color_space.map(Into::into);
        source.invalid_color = self.invalid_color.into();
        source.face_size = self.images.face_size;
        source.channel = self.images.channel.clone();
        Ok(SideOptions {
            source,
            layout: SequenceLayout {
                arrangement: self.images.arrangement(Face::View),
                intrinsics: self.images.intrinsics()?,
                ..SequenceLayout::default()
            },
            selection,
        })
    }
}
