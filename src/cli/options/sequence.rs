//! Options of image sequences: contents and layout of the images.

use clap::{Args, ValueEnum};

use super::{EffortArgs, FrameArgs, parse_face};
use crate::dataset::source::{Arrangement, SequenceLayout, Source, SourceOptions};
use crate::encode::EncodeSettings;
use crate::error::{Error, Result};
use crate::image::StreamKind;
use crate::image::cube::Face;
use crate::image::png::ColorSpace;

/// `--color-space`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ColorSpaceArg {
    /// Scene-linear Rec. 709
    LinearRec709,
    /// sRGB codes
    Srgb,
}

impl From<ColorSpaceArg> for ColorSpace {
    fn from(space: ColorSpaceArg) -> ColorSpace {
        match space {
            ColorSpaceArg::LinearRec709 => ColorSpace::LinearRec709,
            ColorSpaceArg::Srgb => ColorSpace::Srgb,
        }
    }
}

/// An image sequence to encode.
#[derive(Debug, Clone, Args)]
pub struct SequenceInputArgs {
    /// The sequence: a pattern such as name.%04d.exr or name.####.exr, a folder, or one file
    #[arg(value_name = "SEQ")]
    pub input: String,
    /// Frames.
    #[command(flatten)]
    pub frames: FrameArgs,
    /// Name of the probe
    #[arg(long, value_name = "NAME", default_value = "00", help_heading = "Sequence")]
    pub probe: String,
    /// Face of single images: px, nx, py, ny, pz, nz, or view for a perspective image
    #[arg(long, value_name = "FACE", default_value = "view", value_parser = parse_face, help_heading = "Sequence")]
    pub face: Face,
    /// Images.
    #[command(flatten)]
    pub images: ImageArgs,
    /// Effort.
    #[command(flatten)]
    pub effort: EffortArgs,
}

/// Layout of the images of a sequence.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Sequence")]
pub struct ImageArgs {
    /// Layout of the images
    #[arg(long, value_enum, default_value_t = LayoutArg::Single)]
    pub layout: LayoutArg,
    /// fx,fy,cx,cy of a perspective image in pixels, to convert planar depth to distance
    #[arg(long, value_name = "FX,FY,CX,CY", value_delimiter = ',', num_args = 1, allow_negative_numbers = true)]
    pub intrinsics: Option<Vec<f64>>,
    /// Size of the cube faces that an equirectangular image is resampled to [default: a quarter of its width]
    #[arg(long, value_name = "PIXELS")]
    pub face_size: Option<u32>,
    /// Name of the channel or layer, if unusual
    #[arg(long, value_name = "NAME")]
    pub channel: Option<String>,
}

/// `--layout`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum LayoutArg {
    /// One face, or a perspective image
    Single,
    /// Six faces unfolded, 4:3 or 3:4
    Cross,
    /// Six faces in a row or a column, px nx py ny pz nz
    Strip,
    /// Longitude and latitude, resampled to six faces
    Equirect,
}

impl SequenceInputArgs {
    /// Puts the options where the reader of files and the encoder find them; after those of depth and colour.
    pub fn apply(&self, source: &mut SourceOptions, settings: &mut EncodeSettings) {
        source.frames = self.frames.frames;
        source.channel = self.images.channel.clone();
        source.face_size = self.images.face_size;
        self.effort.apply(settings);
    }

    /// Opens the sequence as a source of one kind of stream.
    pub fn open(&self, kind: StreamKind, options: SourceOptions) -> Result<Source> {
        let layout = SequenceLayout {
            arrangement: self.images.arrangement(self.face),
            probe: self.probe.clone(),
            intrinsics: self.images.intrinsics()?,
        };
        Source::from_sequence(kind, &self.input, &layout, &options)
    }
}

impl ImageArgs {
    /// Arrangement of the images; single images show `face`.
    pub fn arrangement(&self, face: Face) -> Arrangement {
        match self.layout {
            LayoutArg::Single => Arrangement::Single(face),
            LayoutArg::Cross => Arrangement::Cross,
            LayoutArg::Strip => Arrangement::Strip,
            LayoutArg::Equirect => Arrangement::Equirect,
        }
    }

    /// The four numbers of `--intrinsics`.
    pub fn intrinsics(&self) -> Result<Option<[f64; 4]>> {
        match self.intrinsics.as_deref() {
            None => Ok(None),
            Some(&[fx, fy, cx, cy]) => Ok(Some([fx, fy, cx, cy])),
            Some(other) => {
                Err(Error::Usage(format!("--intrinsics: four numbers were expected, {} given", other.len())))
            }
        }
    }
}
