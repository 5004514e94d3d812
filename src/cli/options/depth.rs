//! Depth options.

use std::path::PathBuf;

use clap::Args;

use super::value::{Choices, InBlocks, one_of};
use crate::refuse;
use codec::depth::TemporalSettings;
use codec::depth::domain::DomainKind;
use codec::depth::mode_decision::Decide;
use codec::depth::node_encoder::NodeSettings;
use codec::depth::quantise::FAR_CODE;
use codec::error::Result;
use codec::image::DepthKind;
use footage::dataset::{InvalidDepth, SourceOptions};
use footage::encode::{DepthCodec, EncodeSettings, ErrorBound, TileSize};
use footage::train::read_tables;

pub fn parse_background(text: &str) -> std::result::Result<f32, String> {
    let value: f32 = text.parse().map_err(|_| format!("'{text}' is not a number"))?;
    if value == f32::INFINITY && !text.contains("inf") || value == f32::NEG_INFINITY || value.is_nan() {
        return Err(format!("'{text}': a finite 32-bit float or inf was expected"));
    }
    Ok(value)
}

const DEPTH_CODECS: &Choices<DepthCodec> = &[
    (
        "predictive",
        DepthCodec::Predictive,
        "Prediction and residuals; every pixel within --max-error of the source; smallest files",
    ),
    (
        "quadtree",
        DepthCodec::Quadtree,
        "Modelling functions in a quadtree; every pixel within --max-error of the source",
    ),
    ("aabb", DepthCodec::Boxes, "Raw codes in boxes around changed pixels"),
    ("bc4w", DepthCodec::Blocks, "BC4w blocks: 32 bytes per 8x8 pixels, without an error bound"),
];

const DEPTH_BLOCKS: &Choices<InBlocks> = &[("none", false, "Raw codes"), ("bc5", true, "16 bytes per 4x4 pixels")];

const DEPTH_DOMAINS: &Choices<DomainKind> = &[
    ("log", DomainKind::Log, "Log codes"),
    ("linear", DomainKind::Linear, "Metres"),
    ("inverse", DomainKind::Inverse, "Inverse metres, in which planes are modelled exactly"),
];

const OPTIMIZE_GOALS: &Choices<Decide> =
    &[("quality", Decide::Mse, "Smallest squared error"), ("size", Decide::Size, "Smallest size")];

const INVALID_DEPTHS: &Choices<InvalidDepth> = &[
    ("refuse", InvalidDepth::Refuse, "Fail, and report file and pixel"),
    ("far", InvalidDepth::Far, "Replace by background"),
    ("near", InvalidDepth::Near, "Replace by the nearest distance; beyond --far, by --far"),
];

const DEPTH_KINDS: &Choices<DepthKind> = &[
    ("distance", DepthKind::Distance, "Distance from the probe along the ray"),
    ("planar", DepthKind::Planar, "Depth along the viewing axis (Z)"),
];

#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Depth")]
pub struct DepthArgs {
    /// Depth codec
    #[arg(long, value_name = "CODEC", value_parser = one_of(DEPTH_CODECS), default_value = "predictive")]
    pub depth_codec: DepthCodec,
    /// Store depth as texture blocks with errors up to --update-threshold, for aabb; the threshold then defaults to 100
    #[arg(long, value_name = "FORMAT", ignore_case = true, value_parser = one_of(DEPTH_BLOCKS), default_value = "none")]
    pub depth_block: InBlocks,
    /// Maximum error of decoded depth, for quadtree and predictive: in percent of the distance, such as 0.4%, or in
    /// 16-bit log codes, where 0 is lossless. A percentage becomes the largest number of codes that satisfies it for
    /// each probe [default: 100]
    #[arg(long, value_name = "SHARE%|CODES", conflicts_with = "max_error_relative", value_parser = parse_bound)]
    pub max_error: Option<ErrorBound>,
    /// Same as --max-error SHARE%, as an option of its own for sweeps
    #[arg(long, value_name = "SHARE", hide = true, value_parser = parse_share)]
    pub max_error_relative: Option<f64>,
    /// File of entropy tables from lightfold train-depth, for predictive, stored once per stream and used for each
    /// chunk that they make smaller
    #[arg(long, value_name = "TABLES")]
    pub depth_tables: Option<PathBuf>,
    #[command(flatten)]
    pub domain: DomainArgs,
    #[command(flatten)]
    pub model: ModelArgs,
    #[command(flatten)]
    pub steps: DepthStepArgs,
    /// Maximum number of boxes per frame and tile, for aabb and material
    #[arg(long, value_name = "N", default_value_t = TemporalSettings::default().max_aabbs,
        value_parser = clap::value_parser!(u16).range(1..=256))]
    pub max_aabbs: u16,
    #[command(flatten)]
    pub units: DepthUnitArgs,
}

#[derive(Debug, Clone, Copy, Args)]
#[command(next_help_heading = "Depth")]
pub struct DomainArgs {
    /// Domain of the modelling functions, for quadtree; always log if near and far are too close to each other
    #[arg(long, value_name = "DOMAIN", value_parser = one_of(DEPTH_DOMAINS), default_value = "log")]
    pub depth_domain: DomainKind,
}

#[derive(Debug, Clone, Copy, Args)]
#[command(next_help_heading = "Depth")]
pub struct ModelArgs {
    /// Goal when several ways to code pixels are within the bound
    #[arg(long, value_name = "GOAL", value_parser = one_of(OPTIMIZE_GOALS), default_value = "quality")]
    pub optimize: Decide,
    /// Minimum number of changed children at which the encoder tries one function for the whole node, for quadtree
    #[arg(long, value_name = "N", default_value_t = NodeSettings::default().min_children,
        value_parser = clap::value_parser!(u8).range(1..=4))]
    pub min_children: u8,
}

#[derive(Debug, Clone, Copy, Args)]
#[command(next_help_heading = "Depth")]
pub struct DepthStepArgs {
    /// Depth window W: decoders may skip up to W − 1 frames, because pixels are updated if they differ from any of the
    /// W previous frames; for quadtree, aabb and material
    #[arg(long, value_name = "W", default_value_t = TemporalSettings::default().window,
        value_parser = clap::value_parser!(u8).range(1..))]
    pub depth_window: u8,
    /// Update a pixel only if its depth changed by more than this, in 16-bit log codes; adds to --max-error. With aabb
    /// this is the maximum error, and 0 is lossless [default: 0]
    #[arg(long, value_name = "CODES")]
    pub update_threshold: Option<u16>,
}

#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Depth")]
pub struct DepthUnitArgs {
    /// Number of frames from one keyframe to the next
    #[arg(long, value_name = "FRAMES", default_value_t = TemporalSettings::default().keyframe_interval,
        value_parser = clap::value_parser!(u32).range(1..))]
    pub keyframe_interval: u32,
    /// Width and height of a tile in pixels, rounded up to a multiple of 8 [default: half of the face, 128 for predictive]
    #[arg(long, value_name = "PX", value_parser = clap::value_parser!(u32).range(1..=16384))]
    pub depth_tile: Option<u32>,
    /// Distance of the nearest surface in metres; nearer ones are invalid (--invalid-depth). With both --near and
    /// --far, images are not read in advance, and predictive depth has no levels [default: measured per probe]
    #[arg(long, value_name = "M")]
    pub near: Option<f32>,
    /// Distance of the farthest surface in metres; farther ones are invalid [default: measured per probe]
    #[arg(long, value_name = "M")]
    pub far: Option<f32>,
    #[command(flatten)]
    pub reading: DepthReadingArgs,
}

#[derive(Debug, Clone, Copy, Args)]
#[command(next_help_heading = "Depth")]
pub struct BoundArgs {
    /// Pack quadtrees of the intermediate form with this maximum error: in percent of the distance, such as 0.4%, or in
    /// 16-bit log codes, where 0 is lossless
    #[arg(long, value_name = "SHARE%|CODES", value_parser = parse_bound)]
    pub max_error: Option<ErrorBound>,
}

/// Parses a number of codes, or a percentage of the distance.
pub fn parse_bound(text: &str) -> std::result::Result<ErrorBound, String> {
    if text.ends_with('%') {
        return parse_share(text).map(ErrorBound::Relative);
    }
    let expected =
        || format!("'{text}': percent of the distance, such as 0.4%, or 0 to {FAR_CODE} codes were expected");
    text.parse().ok().filter(|codes| *codes <= FAR_CODE).map(ErrorBound::Codes).ok_or_else(expected)
}

pub fn parse_share(text: &str) -> std::result::Result<f64, String> {
    let (number, unit) = text.strip_suffix('%').map_or((text, 1.0), |number| (number, 0.01));
    let share: f64 = number.trim().parse().map_err(|_| format!("'{text}' is not a number"))?;
    let share = share * unit;
    if !(0.0..=1.0).contains(&share) {
        return Err(format!("'{text}' is not between 0 and 100%"));
    }
    Ok(share)
}

#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Depth")]
pub struct DepthReadingArgs {
    /// Handling of NaN, negative and zero depths, and of surfaces outside a given near and far
    #[arg(long, value_name = "WHAT", value_parser = one_of(INVALID_DEPTHS), default_value = "refuse")]
    pub invalid_depth: InvalidDepth,
    /// Metres per unit of depth, for integer images; negative if depth is negative, such as Pz of Houdini
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    pub depth_scale: Option<f64>,
    /// Background value in the files, in addition to +inf
    #[arg(long, value_name = "VALUE", allow_negative_numbers = true, value_parser = parse_background)]
    pub background: Option<f32>,
    /// Kind of depth values [default: from the manifest, else distance]
    #[arg(long, value_name = "KIND", value_parser = one_of(DEPTH_KINDS))]
    pub depth_kind: Option<DepthKind>,
}

impl DepthArgs {
    pub fn apply(&self, source: &mut SourceOptions, settings: &mut EncodeSettings) -> Result<()> {
        settings.depth.codec = match (self.depth_codec, self.depth_block) {
            (codec, false) => codec,
            (DepthCodec::Boxes, true) => DepthCodec::BoxesInBlocks,
            (_, true) => return refuse("--depth-block bc5 needs --depth-codec aabb"),
        };
        if self.max_error.is_some() || self.max_error_relative.is_some() {
            match self.depth_codec {
                DepthCodec::Boxes => {
                    return refuse("--max-error does not apply to --depth-codec aabb: use --update-threshold");
                }
                DepthCodec::Blocks => {
                    return refuse("--depth-codec bc4w has no error bound: leave out --max-error, or use quadtree");
                }
                _ => {}
            }
        }
        let usual = ErrorBound::Codes(NodeSettings::default().bound);
        settings.depth.error = self.max_error_relative.map(ErrorBound::Relative).or(self.max_error).unwrap_or(usual);
        settings.depth_tables = self.depth_tables.as_deref().map(read_tables).transpose()?.unwrap_or_default();
        settings.temporal.max_aabbs = self.max_aabbs;
        settings.depth.domain = self.domain.depth_domain;
        self.model.apply(settings);
        self.steps.apply(settings);
        if self.depth_block {
            // BC5 is rarely exact.
            settings.temporal.epsilon = self.steps.update_threshold.unwrap_or(NodeSettings::default().bound);
        }
        self.units.apply(source, settings);
        Ok(())
    }
}

impl ModelArgs {
    pub fn apply(&self, settings: &mut EncodeSettings) {
        settings.depth.decide = self.optimize;
        settings.depth.min_children = self.min_children;
    }
}

impl DepthStepArgs {
    pub fn apply(&self, settings: &mut EncodeSettings) {
        settings.temporal.window = self.depth_window;
        settings.temporal.epsilon = self.update_threshold.unwrap_or(0);
    }
}

impl DepthUnitArgs {
    pub fn apply(&self, source: &mut SourceOptions, settings: &mut EncodeSettings) {
        settings.temporal.keyframe_interval = self.keyframe_interval;
        settings.tiles = self.depth_tile.map_or(settings.tiles, TileSize::Pixels);
        settings.near_m = self.near;
        settings.far_m = self.far;
        settings.outside_depth = self.reading.invalid_depth;
        self.reading.apply(source);
    }
}

impl DepthReadingArgs {
    pub fn apply(&self, source: &mut SourceOptions) {
        source.depth_scale = self.depth_scale;
        source.background = self.background;
        source.invalid_depth = self.invalid_depth;
        source.depth_kind = self.depth_kind;
    }
}
