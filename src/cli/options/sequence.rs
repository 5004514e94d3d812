//! Options of image sequences: contents and layout of the images.

use clap::Args;

use super::value::{Choices, one_of};
use super::{ChannelArgs, EffortArgs, FrameArgs, MissingArgs, parse_face};
use crate::refuse;
use codec::error::Result;
use codec::image::StreamKind;
use codec::image::cube::Face;
use footage::dataset::source::{Arrangement, SequenceLayout, Source, SourceOptions};
use footage::encode::EncodeSettings;
use footage::image_files::ColorSpace;

const REC709: (&str, ColorSpace, &str) = ("linear-rec709", ColorSpace::LinearRec709, "Scene-linear Rec. 709");
const ACESCG: (&str, ColorSpace, &str) = ("acescg", ColorSpace::AcesCg, "Scene-linear AP1");
const ACES: (&str, ColorSpace, &str) = ("aces2065-1", ColorSpace::Aces2065, "Scene-linear AP0");
const REC2020: (&str, ColorSpace, &str) = ("linear-rec2020", ColorSpace::LinearRec2020, "Scene-linear Rec. 2020");
const P3: (&str, ColorSpace, &str) = ("linear-p3-d65", ColorSpace::LinearP3D65, "Scene-linear P3, white of D65");

pub const COLOR_SPACES: &Choices<ColorSpace> =
    &[REC709, ("srgb", ColorSpace::Srgb, "sRGB codes"), ACESCG, ACES, REC2020, P3];

/// Colour spaces with linear values.
pub const LIGHT_SPACES: &Choices<ColorSpace> = &[REC709, ACESCG, ACES, REC2020, P3];

/// Values of `--layout`. Single images may show another face.
const LAYOUTS: &Choices<Arrangement> = &[
    ("single", Arrangement::Single(Face::View), "One face or a perspective image"),
    ("cross", Arrangement::Cross, "Six faces unfolded, 4:3 or 3:4"),
    ("strip", Arrangement::Strip, "Six faces in a row or a column, px nx py ny pz nz"),
    ("equirect", Arrangement::Equirect, "Longitude and latitude, resampled to six faces"),
];

#[derive(Debug, Clone, Args)]
pub struct SequenceInputArgs {
    /// Image sequence: a pattern such as name.%04d.exr or name.####.exr, a folder, or one file
    #[arg(value_name = "SEQ")]
    pub input: String,
    /// Files that a shell made of a pattern.
    #[arg(hide = true)]
    pub more: Vec<String>,
    #[command(flatten)]
    pub frames: FrameArgs,
    #[command(flatten)]
    pub missing: MissingArgs,
    /// Name of the probe
    #[arg(long, value_name = "NAME", default_value = "00", help_heading = "Sequence")]
    pub probe: String,
    /// Face that the images show: px, nx, py, ny, pz, nz, or view for perspective images
    #[arg(long, value_name = "FACE", default_value = "view", value_parser = parse_face, help_heading = "Sequence")]
    pub face: Face,
    #[command(flatten)]
    pub effort: EffortArgs,
    // Groups with headings come last: a heading continues until the next one.
    #[command(flatten)]
    pub images: ImageArgs,
}

#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Sequence")]
pub struct ImageArgs {
    /// Layout of the images
    #[arg(long, value_parser = one_of(LAYOUTS), default_value = "single")]
    pub layout: Arrangement,
    /// Intrinsics fx,fy,cx,cy of perspective images in pixels, to convert planar depth to distance
    #[arg(long, value_name = "FX,FY,CX,CY", value_delimiter = ',', num_args = 1, allow_negative_numbers = true)]
    pub intrinsics: Option<Vec<f64>>,
    /// Size of cube faces resampled from equirectangular images [default: image width / 3.14, rounded up to 32]
    #[arg(long, value_name = "PIXELS")]
    pub face_size: Option<u32>,
    #[command(flatten)]
    pub channels: ChannelArgs,
}

impl SequenceInputArgs {
    /// Applies the options to the file reader and the encoder. Call it after those of depth and colour.
    pub fn apply(&self, source: &mut SourceOptions, settings: &mut EncodeSettings) {
        source.frames = self.frames.frames;
        source.missing = self.missing.missing;
        source.face_size = self.images.face_size;
        self.effort.apply(settings);
    }

    pub fn open(&self, kind: StreamKind, options: &SourceOptions) -> Result<Source> {
        if !self.more.is_empty() {
            return refuse(format!(
                "{} and {} more inputs: one sequence was expected: use a pattern such as color.%04d.exr",
                self.input,
                self.more.len()
            ));
        }
        self.images.channels.check(kind)?;
        let mut options = options.clone();
        self.images.channels.apply(&mut options);
        let images = self.images.layout()?;
        let arrangement = match images.arrangement {
            Arrangement::Single(_) => Arrangement::Single(self.face),
            unfolded => unfolded,
        };
        let layout = SequenceLayout { arrangement, probe: self.probe.clone(), ..images };
        Source::from_sequence(kind, &self.input, &layout, &options)
    }
}

impl ImageArgs {
    /// Returns the layout of images of the default probe and face.
    pub fn layout(&self) -> Result<SequenceLayout> {
        let intrinsics = match self.intrinsics.as_deref() {
            None => None,
            Some(&[fx, fy, cx, cy]) => Some([fx, fy, cx, cy]),
            Some(other) => {
                return refuse(format!("--intrinsics: four numbers were expected, not {}", other.len()));
            }
        };
        Ok(SequenceLayout { arrangement: self.layout, intrinsics, ..SequenceLayout::default() })
    }
}
