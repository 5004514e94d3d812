//! Presets: named sets of encoder settings, which other options override. Search effort.

use clap::Args;

use super::value::{Choices, one_of};
use super::{ColorArgs, DepthArgs, StoreArgs};
use codec::color::Target;
use codec::effort::Effort;
use footage::encode::{ColorCodec, DepthCodec, EncodeSettings, ErrorBound};

pub const EFFORTS: &Choices<Effort> = &[
    ("fast", Effort::Fast, "Faster, slightly worse result"),
    ("normal", Effort::Normal, "Result close to exhaustive"),
    ("exhaustive", Effort::Exhaustive, "Full search: the reference"),
];

#[derive(Debug, Clone, Copy, Args)]
pub struct EffortArgs {
    /// Search effort for colour partitions, quantisation steps and keyframes, and for blocks of all kinds [default:
    /// normal]
    #[arg(long, value_parser = one_of(EFFORTS))]
    pub effort: Option<Effort>,
}

impl EffortArgs {
    pub fn apply(self, settings: &mut EncodeSettings) {
        settings.search.effort = self.effort.unwrap_or_default();
        settings.depth.effort = self.effort.unwrap_or_default();
    }
}

/// Settings of a preset. All others have their defaults.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Preset {
    /// Replaces --quality and --psnr.
    target: Option<Target>,
    /// Replaces --max-error.
    max_error: Option<u16>,
    /// Replaces --effort.
    effort: Option<Effort>,
    /// Replaces --hdr.
    hdr: bool,
    /// Replaces --lzma2.
    lzma2: Option<u32>,
}

const NONE: Preset = Preset { target: None, max_error: None, effort: None, hdr: false, lzma2: None };

const PRESETS: &Choices<Preset> = &[
    (
        "small",
        Preset {
            target: Some(Target::Quality(65.0)),
            max_error: Some(400),
            effort: Some(Effort::Exhaustive),
            lzma2: Some(9),
            ..NONE
        },
        "Smallest files, by lower quality of colour and larger errors of depth: --quality 65 --max-error 400 --effort exhaustive --lzma2=9",
    ),
    ("balanced", NONE, "The defaults: --quality 79 --max-error 100 --effort normal"),
    ("fast", Preset { effort: Some(Effort::Fast), ..NONE }, "Fastest: --effort fast"),
    (
        "exact",
        Preset { target: Some(Target::Psnr(200.0)), max_error: Some(0), hdr: true, ..NONE },
        "Lossless half-float colour and 16-bit depth codes: --hdr --psnr 200 --max-error 0",
    ),
];

#[derive(Debug, Clone, Copy, Args)]
pub struct PresetArgs {
    /// Preset; other options override its settings
    #[arg(long, value_name = "NAME", value_parser = one_of(PRESETS), default_value = "balanced")]
    pub preset: Preset,
}

impl PresetArgs {
    /// True for the preset with the smallest output.
    pub fn is_small(self) -> bool {
        PRESETS.first().is_some_and(|(_, smallest, _)| *smallest == self.preset)
    }

    /// Sets the options that are not given.
    pub fn fill(
        self,
        (depth, color): (&mut DepthArgs, &mut ColorArgs),
        (effort, store): (&mut EffortArgs, &mut StoreArgs),
    ) {
        let Preset { target, max_error, effort: usual_effort, hdr, lzma2 } = self.preset;
        let has_blocks = color.color_block.flatten().is_some();
        let is_given = color.quality.is_some() || color.psnr.is_some() || color.color_qp.is_some();
        match target.filter(|_| !is_given && !has_blocks) {
            Some(Target::Psnr(db)) => color.psnr = Some(db),
            Some(Target::Quality(quality)) if color.color_codec != Some(ColorCodec::Cells) => {
                color.quality = Some(quality)
            }
            _ => {}
        }
        let says_8_bits = color.transfer.is_some() || color.exposure.is_some();
        color.hdr |= hdr && !says_8_bits && !has_blocks;
        let has_bound = matches!(depth.depth_codec, DepthCodec::Predictive | DepthCodec::Quadtree);
        if depth.max_error_relative.is_none() && has_bound {
            depth.max_error = depth.max_error.or(max_error.map(ErrorBound::Codes));
        }
        effort.effort = effort.effort.or(usual_effort);
        if store.compression().is_none() {
            store.lzma2 = lzma2;
        }
    }
}
