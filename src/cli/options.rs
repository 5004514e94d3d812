//! Options that several subcommands share. Each knob has one name here, in the code and in reports.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};

use crate::color::keyframes::SearchSettings;
use crate::dataset::source::{Arrangement, InvalidColor, InvalidDepth, SequenceLayout, Source, SourceOptions};
use crate::dataset::stream::{DepthKind, StreamKind};
use crate::depth::domain::DomainKind;
use crate::depth::mode_decision::Decide;
use crate::depth::node_encoder::NodeSettings;
use crate::depth::temporal::TemporalSettings;
use crate::effort::Effort;
use crate::error::{Error, Result};
use crate::image::cube::Face;
use crate::image::png::ColorSpace;
use crate::image::sequence::FrameRange;
use crate::image::transfer::{ToneMap, Transfer};
use crate::metrics::pu21::DEFAULT_WHITE_CD_M2;
use crate::video::codec::ColorFormat;
use crate::video::encode::{DepthCodec, DepthSettings, EncodeSettings, ErrorBound};
use crate::video::export::Selection;

/// Parses a stream kind.
pub fn parse_kind(text: &str) -> Result<StreamKind, String> {
    StreamKind::from_name(text).ok_or_else(|| format!("'{text}' is none of color, depth, material"))
}

/// Parses a face.
pub fn parse_face(text: &str) -> Result<Face, String> {
    Face::from_name(text).ok_or_else(|| format!("'{text}' is none of px, nx, py, ny, pz, nz, view"))
}

/// Parses `A-B` or `A`.
pub fn parse_frames(text: &str) -> Result<FrameRange, String> {
    text.parse::<FrameRange>().map_err(|error: Error| error.to_string())
}

/// Parses a background: a finite float, or +inf.
pub fn parse_background(text: &str) -> Result<f32, String> {
    let value: f32 = text.parse().map_err(|_| format!("'{text}' is no number"))?;
    if value == f32::INFINITY && !text.contains("inf") || value == f32::NEG_INFINITY || value.is_nan() {
        return Err(format!("'{text}' is neither a finite 32-bit float nor inf"));
    }
    Ok(value)
}

/// Which frames of the input.
#[derive(Debug, Clone, Args)]
pub struct FrameArgs {
    /// Only these frames, such as 10-99 or 12
    #[arg(long, value_name = "A-B", value_parser = parse_frames)]
    pub frames: Option<FrameRange>,
}

/// Which streams of a container.
#[derive(Debug, Clone, Args)]
pub struct SelectionArgs {
    /// Only these probes
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    pub probe: Vec<String>,
    /// Only these faces
    #[arg(long, value_name = "FACE", value_delimiter = ',', value_parser = parse_face)]
    pub face: Vec<Face>,
    /// Only streams of these kinds: color, depth, material
    #[arg(long, value_name = "KIND", value_delimiter = ',', value_parser = parse_kind)]
    pub stream: Vec<StreamKind>,
}

impl SelectionArgs {
    /// The selection of these streams and of `frames`.
    pub fn with(&self, frames: Option<FrameRange>) -> Selection {
        Selection { probes: self.probe.clone(), faces: self.face.clone(), kinds: self.stream.clone(), frames }
    }
}

/// How depth is read and coded.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Depth")]
pub struct DepthArgs {
    /// How depth is stored
    #[arg(long, value_name = "CODEC", value_enum, default_value_t = DepthCodecArg::Quadtree)]
    pub depth_codec: DepthCodecArg,
    /// Largest error of a decoded depth in 16-bit log codes, for quadtree; 0 is lossless
    #[arg(long, value_name = "CODES", default_value_t = NodeSettings::default().bound, conflicts_with = "error_relative",
        value_parser = clap::value_parser!(u16).range(..=65534))]
    pub error: u16,
    /// Largest error of a decoded depth in proportion to it, such as 0.1%, for quadtree
    #[arg(long, value_name = "SHARE", value_parser = parse_share)]
    pub error_relative: Option<f64>,
    /// What modelling functions are fitted in
    #[arg(long, value_name = "DOMAIN", value_enum, default_value_t = DomainArg::Log)]
    pub depth_domain: DomainArg,
    /// Which of the modelling functions within the bound a node gets
    #[arg(long, value_name = "WHAT", value_enum, default_value_t = DecideArg::Mse)]
    pub decide: DecideArg,
    /// Of a node's four children, how many must have changed before one function is tried for all of it
    #[arg(long, value_name = "N", default_value_t = NodeSettings::default().min_children,
        value_parser = clap::value_parser!(u8).range(1..=4))]
    pub min_children: u8,
    /// W: pixels are sent whenever they differ from any of the W frames before, so that a decoder may step over
    /// W − 1 of them
    #[arg(long, value_name = "W", default_value_t = TemporalSettings::default().window,
        value_parser = clap::value_parser!(u8).range(1..))]
    pub depth_window: u8,
    /// How far a depth may move, in 16-bit log codes, before it is sent again, on top of --error; with aabb this is
    /// the largest error, and 0 is lossless
    #[arg(long, value_name = "CODES", default_value_t = 0)]
    pub epsilon: u16,
    /// Most boxes that one frame of one tile is updated with, for aabb and material
    #[arg(long, value_name = "N", default_value_t = TemporalSettings::default().max_aabbs,
        value_parser = clap::value_parser!(u16).range(1..=256))]
    pub max_aabbs: u16,
    /// Frames from one keyframe to the next
    #[arg(long, value_name = "FRAMES", default_value_t = TemporalSettings::default().keyframe_interval,
        value_parser = clap::value_parser!(u32).range(1..))]
    pub keyframe_interval: u32,
    /// Tiles along each side of a face
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = clap::value_parser!(u32).range(1..=256))]
    pub tiles: u32,
    /// Nearest surface in metres [default: found for each probe]
    #[arg(long, value_name = "M")]
    pub near: Option<f32>,
    /// Farthest surface in metres [default: found for each probe]
    #[arg(long, value_name = "M")]
    pub far: Option<f32>,
    /// Reading.
    #[command(flatten)]
    pub reading: DepthReadingArgs,
}

/// `--depth-codec`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum DepthCodecArg {
    /// Modelling functions in a quadtree, within --error of the source everywhere
    Quadtree,
    /// Codes as they are, in boxes around what changes
    Aabb,
    /// Blocks of 8x8 pixels at a fixed 4:1, without a bound
    Bc4w,
}

/// `--depth-domain`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum DomainArg {
    /// Log codes
    Log,
    /// Metres
    Linear,
    /// One over metres, in which a plane is exact
    Inverse,
}

/// `--decide`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum DecideArg {
    /// The closest
    Mse,
    /// The smallest
    Size,
}

impl From<DomainArg> for DomainKind {
    fn from(domain: DomainArg) -> DomainKind {
        match domain {
            DomainArg::Log => DomainKind::Log,
            DomainArg::Linear => DomainKind::Linear,
            DomainArg::Inverse => DomainKind::Inverse,
        }
    }
}

impl From<DecideArg> for Decide {
    fn from(decide: DecideArg) -> Decide {
        match decide {
            DecideArg::Mse => Decide::Mse,
            DecideArg::Size => Decide::Size,
        }
    }
}

/// Parses a share: `0.1%` or `0.001`.
pub fn parse_share(text: &str) -> Result<f64, String> {
    let (number, unit) = text.strip_suffix('%').map_or((text, 1.0), |number| (number, 0.01));
    let share: f64 = number.trim().parse().map_err(|_| format!("'{text}' is no number"))?;
    let share = share * unit;
    if !(0.0..=1.0).contains(&share) {
        return Err(format!("'{text}' is not between 0 and 100%"));
    }
    Ok(share)
}

/// How hard searches try.
#[derive(Debug, Clone, Copy, Args)]
pub struct EffortArgs {
    /// How hard to search: for the farthest keyframe of colour, and for BC4w blocks of depth
    #[arg(long, value_enum, default_value_t = EffortArg::Normal)]
    pub effort: EffortArg,
}

impl EffortArgs {
    /// The effort.
    pub fn get(self) -> Effort {
        match self.effort {
            EffortArg::Fast => Effort::Fast,
            EffortArg::Normal => Effort::Normal,
            EffortArg::Exhaustive => Effort::Exhaustive,
        }
    }

    /// Puts the option where the encoder reads it; after those of depth and colour.
    pub fn apply(self, settings: &mut EncodeSettings) {
        settings.search.effort = self.get();
        settings.depth.effort = self.get();
    }
}

/// How depth files are read.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Depth")]
pub struct DepthReadingArgs {
    /// What becomes of NaN, negative and zero depths
    #[arg(long, value_name = "WHAT", value_enum, default_value_t = InvalidDepthArg::Refuse)]
    pub invalid_depth: InvalidDepthArg,
    /// Metres for one unit of an integer image
    #[arg(long, value_name = "M")]
    pub depth_scale: Option<f64>,
    /// The value in the files that means "nothing there"; +inf always does
    #[arg(long, value_name = "VALUE", allow_negative_numbers = true, value_parser = parse_background)]
    pub background: Option<f32>,
    /// What depth values measure [default: as the manifest says, or distance]
    #[arg(long, value_name = "KIND", value_enum)]
    pub depth_kind: Option<DepthKindArg>,
}

/// `--invalid-depth`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum InvalidDepthArg {
    /// An error that names file and pixel
    Refuse,
    /// Taken for background
    Far,
    /// Taken for the nearest distance
    Near,
}

/// `--depth-kind`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum DepthKindArg {
    /// From the centre of the probe
    Distance,
    /// Along the viewing axis
    Planar,
}

/// How colour is read and coded.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Colour")]
pub struct ColorArgs {
    /// Width and height of a cell in pixels
    #[arg(long, value_name = "PIXELS", default_value_t = 64, value_parser = clap::value_parser!(u32).range(1..=16384))]
    pub cell: u32,
    /// Least PSNR of every frame of every cell, in dB
    #[arg(long, value_name = "DB", default_value_t = SearchSettings::default().min_psnr_db)]
    pub psnr: f64,
    /// From light to 8-bit codes
    #[arg(long, value_enum, default_value_t = TransferArg::Srgb, conflicts_with = "hdr")]
    pub transfer: TransferArg,
    /// Stops by which light is brightened before it becomes 8 bits, -8 to 8
    #[arg(long, value_name = "EV", default_value_t = 0.0, allow_negative_numbers = true, conflicts_with = "hdr")]
    pub exposure: f32,
    /// Keep half floats instead of 8 bits; quality is then the PSNR of the PU21 encoding
    #[arg(long)]
    pub hdr: bool,
    /// Luminance of the value 1.0 for --hdr, in cd/m²
    #[arg(long, value_name = "CD_M2", default_value_t = DEFAULT_WHITE_CD_M2)]
    pub white: f64,
    /// Distinct pictures that may lie between two keyframes of a cell: more compress better, and cost memory and time;
    /// at most as many as fit 768 MiB for all faces of an image
    #[arg(long, value_name = "N", default_value_t = SearchSettings::default().reach,
        value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub keyframe_reach: u32,
    /// What becomes of NaN colours
    #[arg(long, value_name = "WHAT", value_enum, default_value_t = InvalidColorArg::Refuse)]
    pub invalid_color: InvalidColorArg,
}

/// `--transfer`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum TransferArg {
    /// The curve of sRGB
    Srgb,
    /// In proportion to light
    Linear,
}

/// `--effort`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum EffortArg {
    /// Quick, at a small loss
    Fast,
    /// What an exhaustive search finds, or nearly so
    Normal,
    /// Everything is tried: the reference, slow
    Exhaustive,
}

/// `--invalid-color`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum InvalidColorArg {
    /// An error that names file and pixel
    Refuse,
    /// Taken for black
    Black,
}

impl From<InvalidColorArg> for InvalidColor {
    fn from(what: InvalidColorArg) -> InvalidColor {
        match what {
            InvalidColorArg::Refuse => InvalidColor::Refuse,
            InvalidColorArg::Black => InvalidColor::Black,
        }
    }
}

/// Where a container is written, how its chunks are stored, and how that is reported.
#[derive(Debug, Clone, Args)]
pub struct OutputArgs {
    /// The container to write, - for standard output
    #[arg(long = "output", short = 'o', value_name = "OUT.lfold")]
    pub path: PathBuf,
    /// Compress chunks with LZMA2 at a level of 0 (fast) to 9 (small), 6 where none is given
    #[arg(long, value_name = "LEVEL", num_args = 0..=1, require_equals = true, default_missing_value = "6",
        value_parser = clap::value_parser!(u32).range(0..=9))]
    pub lzma2: Option<u32>,
    /// Report as JSON
    #[arg(long)]
    pub json: bool,
}

impl OutputArgs {
    /// Refuses a report that would run into the container on standard output.
    pub fn check(&self) -> Result<()> {
        if self.json && self.path == Path::new("-") {
            return Err(Error::Usage("--json and -o - would both write to standard output; name a file".into()));
        }
        Ok(())
    }
}

impl DepthArgs {
    /// Puts the options where the encoder reads them.
    pub fn apply(&self, source: &mut SourceOptions, settings: &mut EncodeSettings) {
        settings.temporal = TemporalSettings {
            window: self.depth_window,
            epsilon: self.epsilon,
            max_aabbs: self.max_aabbs,
            keyframe_interval: self.keyframe_interval,
        };
        settings.depth = DepthSettings {
            codec: match self.depth_codec {
                DepthCodecArg::Quadtree => DepthCodec::Quadtree,
                DepthCodecArg::Aabb => DepthCodec::Boxes,
                DepthCodecArg::Bc4w => DepthCodec::Blocks,
            },
            error: self.error_relative.map_or(ErrorBound::Codes(self.error), ErrorBound::Relative),
            domain: self.depth_domain.into(),
            decide: self.decide.into(),
            effort: settings.depth.effort,
            min_children: self.min_children,
        };
        settings.tiles = self.tiles;
        settings.near_m = self.near;
        settings.far_m = self.far;
        self.reading.apply(source);
    }
}

impl DepthReadingArgs {
    /// Puts the options where the reader of files finds them.
    pub fn apply(&self, source: &mut SourceOptions) {
        source.depth_scale = self.depth_scale;
        source.background = self.background;
        source.invalid_depth = match self.invalid_depth {
            InvalidDepthArg::Refuse => InvalidDepth::Refuse,
            InvalidDepthArg::Far => InvalidDepth::Far,
            InvalidDepthArg::Near => InvalidDepth::Near,
        };
        source.depth_kind = self.depth_kind.map(|kind| match kind {
            DepthKindArg::Distance => DepthKind::Distance,
            DepthKindArg::Planar => DepthKind::Planar,
        });
    }
}

impl ColorArgs {
    /// Puts the options where the encoder reads them.
    pub fn apply(&self, source: &mut SourceOptions, settings: &mut EncodeSettings) -> Result<()> {
        if !self.psnr.is_finite() || !(0.0..=200.0).contains(&self.psnr) {
            return Err(Error::Usage(format!("--psnr {}: 0 to 200 dB was expected", self.psnr)));
        }
        if !(-8.0..=8.0).contains(&self.exposure) {
            return Err(Error::Usage(format!("--exposure {}: -8 to 8 stops were expected", self.exposure)));
        }
        settings.cell = self.cell;
        settings.search =
            SearchSettings { min_psnr_db: self.psnr, effort: settings.search.effort, reach: self.keyframe_reach };
        let transfer = match self.transfer {
            TransferArg::Srgb => Transfer::Srgb,
            TransferArg::Linear => Transfer::Linear,
        };
        settings.color = if self.hdr {
            ColorFormat::Half { white_cd_m2: self.white }
        } else {
            ColorFormat::EightBit(ToneMap { transfer, exposure_ev: self.exposure })
        };
        source.invalid_color = self.invalid_color.into();
        Ok(())
    }
}

/// Whether a path names a dataset: a manifest, or a folder that holds one.
pub fn is_dataset(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension == "json")
        || path.join(crate::dataset::manifest::MANIFEST_NAME).is_file()
}

/// `--color-space` of a lone sequence.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ColorSpaceArg {
    /// Scene-referred light
    LinearRec709,
    /// Display codes
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

/// What a lone sequence shows.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Sequence")]
pub struct SequenceArgs {
    /// Name of the probe
    #[arg(long, value_name = "NAME", default_value = "00")]
    pub probe: String,
    /// The face that single images show: px, nx, py, ny, pz, nz, or view for a perspective image
    #[arg(long, value_name = "FACE", default_value = "view", value_parser = parse_face)]
    pub face: Face,
    /// Images.
    #[command(flatten)]
    pub images: ImageArgs,
}

/// How the images of a lone sequence show what they show.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Sequence")]
pub struct ImageArgs {
    /// How the images show the probe's surroundings
    #[arg(long, value_enum, default_value_t = LayoutArg::Single)]
    pub layout: LayoutArg,
    /// fx,fy,cx,cy in pixels of a perspective image; planar depth becomes distance with them
    #[arg(long, value_name = "FX,FY,CX,CY", value_delimiter = ',', num_args = 1, allow_negative_numbers = true)]
    pub intrinsics: Option<Vec<f64>>,
    /// Size of the cube faces that an equirectangular image becomes [default: a quarter of its width]
    #[arg(long, value_name = "PIXELS")]
    pub face_size: Option<u32>,
    /// Channel or layer to read, where its name is none of the usual ones
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

impl SequenceArgs {
    /// Opens the sequence `spec` as a source of one kind of stream.
    pub fn open(&self, kind: StreamKind, spec: &str, mut options: SourceOptions) -> Result<Source> {
        options.channel = self.images.channel.clone();
        options.face_size = self.images.face_size;
        let layout = SequenceLayout {
            arrangement: self.images.arrangement(self.face),
            probe: self.probe.clone(),
            intrinsics: self.images.intrinsics()?,
        };
        Source::from_sequence(kind, spec, &layout, &options)
    }
}

impl ImageArgs {
    /// What each image shows, `face` where it is a single one.
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
