//! Options of `render`, by what they are about.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use glam::DVec3;

use crate::cli::options::{parse_not_negative, parse_point, parse_positive};
use crate::evaluate::rendered_image::HoleFill;
use crate::march::settings::{Acceleration, EffectMode};

/// `--method`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum MethodArg {
    /// March rays through all active views
    March,
    /// Draw every texel as a point of one pixel: what marching is to be better than
    Splat,
    /// Take distances from the reference, not from marching, and blend views there: what marching comes near to, and goes
    /// beyond in mirrors and glass, and where few probes know a surface
    Reproject,
}

impl MethodArg {
    /// Its word on the command line.
    pub fn name(self) -> &'static str {
        match self {
            MethodArg::March => "march",
            MethodArg::Splat => "splat",
            MethodArg::Reproject => "reproject",
        }
    }
}

/// `--holes`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum HolesArg {
    /// Nothing
    Blank,
    /// What comes nearest; alpha is 0 all the same
    Nearest,
}

impl From<HolesArg> for HoleFill {
    fn from(holes: HolesArg) -> HoleFill {
        match holes {
            HolesArg::Blank => HoleFill::Blank,
            HolesArg::Nearest => HoleFill::Nearest,
        }
    }
}

/// `--effects`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum EffectsArg {
    /// Where the light field has mirrors or glass in it
    Auto,
    /// Nowhere: views are blended
    None,
    /// Everywhere, for tests: slower, and the same pictures as auto
    Force,
}

impl From<EffectsArg> for EffectMode {
    fn from(effects: EffectsArg) -> EffectMode {
        match effects {
            EffectsArg::Auto => EffectMode::Auto,
            EffectsArg::None => EffectMode::None,
            EffectsArg::Force => EffectMode::Force,
        }
    }
}

/// `--acceleration`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum AccelerationArg {
    /// Pass over regions that lie before the nearest depth in them, and so are empty; the pictures are the same
    Pyramid,
    /// Look at every step
    None,
}

impl From<AccelerationArg> for Acceleration {
    fn from(acceleration: AccelerationArg) -> Acceleration {
        match acceleration {
            AccelerationArg::Pyramid => Acceleration::Pyramid,
            AccelerationArg::None => Acceleration::None,
        }
    }
}

/// `--view-priority`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum PriorityArg {
    /// Probes near the eye first
    Distance,
    /// Probes in the eye's direction from --pivot first
    Angle,
}

/// `--decode`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum DecodeArg {
    /// The tiles and cells that the eye sees; all where mirrors or glass send rays anywhere
    Seen,
    /// All
    All,
}

/// How rays find surfaces and colours.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Quality and time")]
pub struct MarchArgs {
    /// Steps of a ray from near to far, even in the logarithm of the distance
    #[arg(long, value_name = "N", default_value_t = 1024, value_parser = clap::value_parser!(u32).range(1..=65_536))]
    pub steps: u32,
    /// How often the step in which a ray meets a surface is halved
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = clap::value_parser!(u32).range(0..=32))]
    pub refine: u32,
    /// Where rays begin, in metres from the eye [default: a tenth of what is nearest to any probe]
    #[arg(long, value_name = "M", value_parser = parse_metres)]
    pub near: Option<f64>,
    /// Where rays end, in metres from the eye [default: beyond everything]
    #[arg(long, value_name = "M", value_parser = parse_metres)]
    pub far: Option<f64>,
    /// N x N rays for each pixel
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=16))]
    pub samples: u32,
    /// How rays are marched
    #[arg(long, value_enum, default_value_t = AccelerationArg::Pyramid)]
    pub acceleration: AccelerationArg,
    /// Where mirrors and glass send rays on
    #[arg(long, value_enum, default_value_t = EffectsArg::Auto)]
    pub effects: EffectsArg,
    /// How often a ray is sent on at most
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = clap::value_parser!(u32).range(0..=8))]
    pub max_bounces: u32,
    /// What is shown where no probe saw anything; such pixels have alpha 0 and are counted
    #[arg(long, value_enum, default_value_t = HolesArg::Blank)]
    pub holes: HolesArg,
    /// What makes a picture of the views
    #[arg(long, value_enum, default_value_t = MethodArg::March)]
    pub method: MethodArg,
}

/// Which probes take part.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Views")]
pub struct ViewArgs {
    /// Only these probes, such as 00,01
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    pub probe: Vec<String>,
    /// All probes but these, such as 00,01
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    pub exclude_probe: Vec<String>,
    /// So many probes at most, those of highest priority [default: all]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub views: Option<u32>,
    /// Which probes have priority
    #[arg(long, value_enum, default_value_t = PriorityArg::Distance)]
    pub view_priority: PriorityArg,
    /// Where angles of probes are measured, in metres [default: the middle of all probes]
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_point, allow_hyphen_values = true)]
    pub pivot: Option<DVec3>,
    /// Leave out a probe that the eye sees within so many degrees of one of higher priority
    #[arg(long, value_name = "DEGREES", value_parser = parse_not_negative, default_value = "0")]
    pub cull_angle: f64,
    /// Leave out probes of low priority while a frame takes longer than this
    #[arg(long, value_name = "MS", value_parser = parse_positive)]
    pub target_ms: Option<f64>,
    /// Write which probes were active in each frame, and why others were not, as lines of JSON
    #[arg(long, value_name = "FILE")]
    pub trace: Option<PathBuf>,
    /// What is decoded
    #[arg(long, value_enum, default_value_t = DecodeArg::Seen)]
    pub decode: DecodeArg,
}

/// Parses metres that single floats can tell from nothing and from infinity.
fn parse_metres(text: &str) -> Result<f64, String> {
    let metres = parse_positive(text)?;
    if (metres as f32).is_normal() {
        Ok(metres)
    } else {
        Err(format!("'{text}': metres between 1e-37 and 1e38 were expected"))
    }
}

/// Parses `256` or `640x480`, sides of up to 65,536 pixels and 2^28 pixels in all.
pub fn parse_size(text: &str) -> Result<(u32, Option<u32>), String> {
    let size = crate::cli::capture::parse_size(text)?;
    let (width, height) = (u64::from(size.0), u64::from(size.1.unwrap_or(size.0)));
    if width.max(height) > 1 << 16 || width * height > 1 << 28 {
        return Err(format!("'{text}': up to 65536 pixels a side and 268 million in all were expected"));
    }
    Ok(size)
}
