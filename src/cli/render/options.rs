//! Option groups of `render`.

use std::path::PathBuf;

use clap::parser::ValueSource;
use clap::{ArgMatches, Args};
use glam::DVec3;

use crate::options::{Choices, one_of, parse_not_negative, parse_number_where, parse_point, parse_positive};
use codec::math::Camera;
use render::march::aov::AovKind;
use render::march::playback::frames::DecodeScope;
use render::march::playback::selection::ViewPriority;
use render::march::settings::{Acceleration, Refinements, SpecularMode};
use render::rendered_image::{BackgroundFill, HoleFill};

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    March,
    Calf,
    Splat,
    Reproject,
    Painter,
    ZBuffer,
}

impl Method {
    /// True if rays are marched.
    pub fn marches(self) -> bool {
        matches!(self, Method::March | Method::Calf)
    }
}

pub const METHODS: &Choices<Method> = &[
    ("march", Method::March, "March rays through all active views"),
    ("calf", Method::Calf, "As march without --refinements: the algorithm of the CALF paper"),
    ("splat", Method::Splat, "Baseline: draw each texel as a point of one pixel"),
    (
        "reproject",
        Method::Reproject,
        "Baseline: blend views at the true distances of --reference, without reflection and refraction",
    ),
    ("painter", Method::Painter, "Simplified scenes: blend all triangles in their order"),
    (
        "z-buffer",
        Method::ZBuffer,
        "Simplified scenes: show the nearest triangle at each sample; alpha covers a fraction of the samples of a \
        pixel",
    ),
];

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PictureProjection {
    Perspective,
    Equirect,
    Vr180,
    Cubemap,
}

const PROJECTIONS: &Choices<PictureProjection> = &[
    ("perspective", PictureProjection::Perspective, "Perspective of the camera"),
    ("equirect", PictureProjection::Equirect, "360 degrees: longitude and latitude, forward at the centre"),
    ("vr180", PictureProjection::Vr180, "Front half: longitude and latitude"),
    (
        "cubemap",
        PictureProjection::Cubemap,
        "Six faces in two rows: right, left, up; down, front, back. --size is the side of a face",
    ),
];

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StereoLayout {
    OverUnder,
    SideBySide,
}

const STEREO_LAYOUTS: &Choices<StereoLayout> = &[
    ("over-under", StereoLayout::OverUnder, "Left eye above the right eye"),
    ("side-by-side", StereoLayout::SideBySide, "Left eye to the left of the right eye"),
];

#[derive(Debug, Clone, Args)]
pub struct ProjectionArgs {
    /// Projection of pictures; the camera defines the eye and the direction of the picture centre
    #[arg(long, value_parser = one_of(PROJECTIONS), default_value = "perspective", conflicts_with = "reference")]
    pub projection: PictureProjection,
    /// Render two eyes into one picture, or into separate files if OUT has %V. For equirect and vr180 the eyes rotate
    /// with longitude (omnidirectional stereo)
    #[arg(long, value_name = "LAYOUT", value_parser = one_of(STEREO_LAYOUTS), conflicts_with = "reference")]
    pub stereo: Option<StereoLayout>,
    /// Distance between the eyes in metres [default: 0.063]
    #[arg(long, value_name = "M", value_parser = parse_positive, requires = "stereo")]
    pub eye_distance: Option<f64>,
}

/// Number of cube map faces per row.
pub const CUBE_COLUMNS: u32 = 3;
/// Mean distance between the pupils of adults, in metres.
const EYE_DISTANCE_M: f64 = 0.063;

impl ProjectionArgs {
    pub fn is_panorama(&self) -> bool {
        matches!(self.projection, PictureProjection::Equirect | PictureProjection::Vr180)
    }

    /// Number of pictures that are joined for an eye.
    pub fn faces(&self) -> u32 {
        if self.projection == PictureProjection::Cubemap { 6 } else { 1 }
    }

    pub fn eyes_in_row(&self) -> u32 {
        if self.stereo == Some(StereoLayout::SideBySide) { 2 } else { 1 }
    }

    /// Returns the size of a picture with both eyes and all faces, given that of one.
    pub fn joined_size(&self, [width, height]: [u32; 2]) -> [u32; 2] {
        let eyes = if self.stereo.is_some() { 2 } else { 1 };
        let columns = CUBE_COLUMNS.min(self.faces());
        let rows = self.faces().div_ceil(columns);
        [width * columns * self.eyes_in_row(), height * rows * (eyes / self.eyes_in_row())]
    }

    /// Returns the cameras of a picture: by eye, then by face.
    pub fn cameras(&self, camera: &Camera) -> Vec<Camera> {
        let half_m = self.eye_distance.unwrap_or(EYE_DISTANCE_M) / 2.0;
        let eyes = if self.stereo.is_some() { vec![-half_m, half_m] } else { vec![0.0] };
        let of_eye = |offset_m: f64| match self.projection {
            PictureProjection::Perspective => vec![camera.moved_right(offset_m)],
            PictureProjection::Equirect => vec![camera.as_panorama(360.0, offset_m)],
            PictureProjection::Vr180 => vec![camera.as_panorama(180.0, offset_m)],
            PictureProjection::Cubemap => camera.moved_right(offset_m).cube().to_vec(),
        };
        eyes.into_iter().flat_map(of_eye).collect()
    }

    /// Returns the aspect of a picture of one eye, or of a face. `None` if the camera defines it.
    pub fn aspect(&self) -> Option<f64> {
        match self.projection {
            PictureProjection::Perspective => None,
            PictureProjection::Equirect => Some(2.0),
            PictureProjection::Vr180 | PictureProjection::Cubemap => Some(1.0),
        }
    }
}

/// Options that do not apply to simplified scenes.
pub const OF_LIGHT_FIELDS: &[&str] = &[
    "steps",
    "refine",
    "near",
    "far",
    "acceleration",
    "effects",
    "max-bounces",
    "holes",
    "background",
    "refinements",
    "aov",
    "probe",
    "exclude-probe",
    "views",
    "view-priority",
    "pivot",
    "cull-angle",
    "target-ms",
    "trace",
    "decode",
];

/// Names, without dashes, of the options given on the command line, as opposed to options with their default value.
#[derive(Debug, Clone, Default)]
pub struct Given {
    pub names: Vec<String>,
}

impl clap::FromArgMatches for Given {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Given, clap::Error> {
        let is_given = |id: &&clap::Id| matches.value_source(id.as_str()) == Some(ValueSource::CommandLine);
        Ok(Given { names: matches.ids().filter(is_given).map(|id| id.as_str().replace('_', "-")).collect() })
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Given::from_arg_matches(matches)?;
        Ok(())
    }
}

impl clap::Args for Given {
    fn augment_args(command: clap::Command) -> clap::Command {
        command
    }

    fn augment_args_for_update(command: clap::Command) -> clap::Command {
        command
    }
}

const HOLES: &Choices<HoleFill> = &[
    ("behind", HoleFill::Behind, "Fill with what probes saw behind the surface, else as nearest; alpha is 1"),
    ("nearest", HoleFill::Nearest, "Fill with the texel of the nearest depth; alpha is 0"),
    ("blank", HoleFill::Blank, "Leave transparent black"),
];

const BACKGROUNDS: &Choices<BackgroundFill> = &[
    ("opaque", BackgroundFill::Opaque, "Show what probes saw, with the alpha of the footage, or 1"),
    (
        "transparent",
        BackgroundFill::Transparent,
        "Leave transparent; alpha is the fraction of a pixel that surfaces cover",
    ),
];

const AOVS: &Choices<AovKind> = &[
    ("depth", AovKind::Depth, "Z: metres along the ray, +inf for background and where nothing is known"),
    ("normal", AovKind::Normal, "N.X, N.Y, N.Z: normal in world axes; 0 where unknown"),
    ("holes", AovKind::Holes, "holes: 1 where no probe saw the surface, else 0"),
    ("views", AovKind::Views, "views: number of probes that saw the shown surface"),
];

const EFFECTS: &Choices<SpecularMode> = &[
    ("auto", SpecularMode::Auto, "Cast if the light field has reflective or refractive materials"),
    ("none", SpecularMode::None, "Never cast; blend views instead"),
    ("force", SpecularMode::Force, "Always cast, for tests: slower, with the same images as auto"),
];

const ACCELERATIONS: &Choices<Acceleration> = &[
    ("pyramid", Acceleration::Pyramid, "Skip empty space with depth pyramids; does not change the images"),
    ("none", Acceleration::None, "Sample every step"),
];

const VIEW_PRIORITIES: &Choices<ViewPriority> = &[
    ("distance", ViewPriority::Distance, "By distance from the eye"),
    ("angle", ViewPriority::Angle, "By angle to the eye at --pivot"),
];

const DECODE_SCOPES: &Choices<DecodeScope> = &[
    (
        "seen",
        DecodeScope::Seen,
        "Visible tiles and cells; all of them with reflective or refractive materials in sight, and for --aov normal",
    ),
    ("all", DecodeScope::All, "All tiles and cells"),
];

#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Quality and time")]
pub struct MarchArgs {
    /// Number of steps per ray from near to far, even in log distance
    #[arg(long, value_name = "N", default_value_t = 1024, value_parser = clap::value_parser!(u32).range(1..=65_536))]
    pub steps: u32,
    /// Number of bisections of the step that hits a surface
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = clap::value_parser!(u32).range(0..=32))]
    pub refine: u32,
    /// Start of rays in metres from the eye [default: a tenth of the nearest depth]
    #[arg(long, value_name = "M", value_parser = parse_metres)]
    pub near: Option<f64>,
    /// End of rays in metres from the eye [default: unlimited]
    #[arg(long, value_name = "M", value_parser = parse_metres)]
    pub far: Option<f64>,
    /// Cast N x N rays per pixel; from N = 3 on, only 5 where these show no edge. For simplified scenes, N x N samples
    /// [default: 1; with --method z-buffer 2]
    #[arg(long, value_name = "N", default_value_t = 1, hide_default_value = true, value_parser = clap::value_parser!(u32).range(1..=16))]
    pub samples: u32,
    /// Acceleration of ray marching
    #[arg(long, value_parser = one_of(ACCELERATIONS), default_value = "pyramid")]
    pub acceleration: Acceleration,
    /// Secondary rays for reflection and refraction
    #[arg(long, value_parser = one_of(EFFECTS), default_value = "auto")]
    pub effects: SpecularMode,
    /// Maximum number of successive secondary rays
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = clap::value_parser!(u32).range(0..=8))]
    pub max_bounces: u32,
    /// Fill of holes, which are surfaces that no probe saw
    #[arg(long, value_parser = one_of(HOLES), default_value = "behind")]
    pub holes: HoleFill,
    /// Display of background, which are directions in which no probe saw a surface
    #[arg(long, value_parser = one_of(BACKGROUNDS), default_value = "opaque")]
    pub background: BackgroundFill,
    /// Refinements of the CALF paper, joined by +: angles (weights of probes by angle and resolution), edges (coverage
    /// between texels), thin (surfaces thinner than texels); or all or none
    #[arg(long, value_name = "LIST", value_parser = parse_refinements, default_value = "all")]
    pub refinements: Refinements,
    /// Additional channels of EXR images, from the ray through the pixel centre
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = one_of(AOVS))]
    pub aov: Vec<AovKind>,
    /// Rendering method [default: march; for simplified scenes painter]
    #[arg(long, value_parser = one_of(METHODS))]
    pub method: Option<Method>,
}

#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Views")]
pub struct ViewArgs {
    /// Only these probes, such as 00,01
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    pub probe: Vec<String>,
    /// Exclude these probes, such as 00,01
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    pub exclude_probe: Vec<String>,
    /// Maximum number of active probes, by priority [default: all]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub views: Option<u32>,
    /// Priority of probes
    #[arg(long, value_parser = one_of(VIEW_PRIORITIES), default_value = "distance")]
    pub view_priority: ViewPriority,
    /// Reference point of --view-priority angle in metres, at which the angles between probes and the eye are measured
    /// [default: the centre of all probes]
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_point, allow_hyphen_values = true)]
    pub pivot: Option<DVec3>,
    /// Cull a probe if it is within this angle, seen from the eye, of a probe of higher priority
    #[arg(long, value_name = "DEGREES", value_parser = parse_not_negative, default_value = "0")]
    pub cull_angle: f64,
    /// Cull probes of low priority while a frame takes longer than this time
    #[arg(long, value_name = "MS", value_parser = parse_positive)]
    pub target_ms: Option<f64>,
    /// Write active and culled probes of each frame to this file, one line of JSON per frame
    #[arg(long, value_name = "FILE")]
    pub trace: Option<PathBuf>,
    /// Tiles and cells to decode
    #[arg(long, value_parser = one_of(DECODE_SCOPES), default_value = "seen")]
    pub decode: DecodeScope,
}

#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Reference")]
pub struct TruthArgs {
    /// Render the same images as this dataset, and report PSNR and SSIM
    #[arg(long, value_name = "DATASET", conflicts_with_all = ["camera", "eye"])]
    pub reference: Option<PathBuf>,
    /// Only these probes of the reference, such as 00,01
    #[arg(long, value_name = "NAME", value_delimiter = ',', requires = "reference", conflicts_with_all = ["camera", "eye"])]
    pub reference_probe: Vec<String>,
    /// Write error maps into this folder
    #[arg(long, value_name = "DIR", requires = "reference", conflicts_with_all = ["camera", "eye"])]
    pub error_map: Option<PathBuf>,
}

fn parse_refinements(text: &str) -> Result<Refinements, String> {
    if let Some(all) = [("all", Refinements::ALL), ("none", Refinements::NONE)].iter().find(|(name, _)| *name == text) {
        return Ok(all.1);
    }
    text.split('+').try_fold(Refinements::NONE, |sum, name| match name {
        "angles" => Ok(Refinements { angles: true, ..sum }),
        "edges" => Ok(Refinements { edges: true, ..sum }),
        "thin" => Ok(Refinements { thin: true, ..sum }),
        _ => Err(format!("'{name}': all, none, or one or more of angles, edges and thin joined by + were expected")),
    })
}

fn parse_metres(text: &str) -> Result<f64, String> {
    parse_positive(text)?;
    parse_number_where(text, |metres| (metres as f32).is_normal(), "metres between 1e-37 and 1e38 were expected")
}

/// Parses `256` or `640x480`: sides of up to 65,536 pixels, and at most 2^28 pixels.
pub fn parse_size(text: &str) -> Result<(u32, Option<u32>), String> {
    let size = crate::capture::parse_size(text)?;
    let (width, height) = (u64::from(size.0), u64::from(size.1.unwrap_or(size.0)));
    if width.max(height) > 1 << 16 || width * height > 1 << 28 {
        return Err(format!("'{text}': at most 65536 pixels a side and 268 million in total are possible"));
    }
    Ok(size)
}
