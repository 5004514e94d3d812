//! Colour options.

use std::path::{Path, PathBuf};

use clap::Args;

use super::value::{Choices, one_of};
use crate::refuse;
use codec::color::quality::MAX_QUALITY;
use codec::color::transform::TableSet;
use codec::color::transform::blocks::MAX_FRAMES;
use codec::color::{SearchSettings, Target};
use codec::error::Result;
use codec::image::transfer::{ToneMap, Transfer};
use codec::metrics::pu21::DEFAULT_WHITE_CD_M2;
use codec::streams::{ColorBlocks, ColorFormat};
use footage::dataset::{InvalidColor, SourceOptions};
use footage::encode::{Clipping, ColorBlockSettings, ColorCodec, EncodeSettings};
use footage::train::read_tables;

/// Block format of keyframes, or none for raw samples. An alias, because clap treats an `Option` as an option that may
/// be absent.
type KeyframeBlocks = Option<ColorBlocks>;

const COLOR_BLOCKS: &Choices<KeyframeBlocks> = &[
    ("none", None, "Raw samples"),
    ("bc1", Some(ColorBlocks::Bc1), "8 bytes for 4x4 pixels"),
    ("bc7", Some(ColorBlocks::Bc7), "16 bytes for 4x4 pixels"),
    ("bc6h", Some(ColorBlocks::Bc6h), "16 bytes for 4x4 pixels of half floats"),
];

pub const COLOR_CODECS: &Choices<ColorCodec> = &[
    ("transform", ColorCodec::Transform, "Transform coding in space and time"),
    ("cells", ColorCodec::Cells, "Keyframes and blending weights"),
];

const TRANSFERS: &Choices<Transfer> = &[("srgb", Transfer::Srgb, "sRGB"), ("linear", Transfer::Linear, "Linear")];

pub const INVALID_COLORS: &Choices<InvalidColor> = &[
    ("refuse", InvalidColor::Refuse, "Fail, and report file and pixel"),
    ("black", InvalidColor::Black, "Replace NaN by black; clamp alpha"),
];

#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Colour")]
pub struct ColorArgs {
    /// Width and height of a cell in pixels, a multiple of 4 with --color-block
    #[arg(long, value_name = "PX", default_value_t = 64,
        value_parser = clap::value_parser!(u32).range(1..=16384))]
    pub color_cell: u32,
    /// Colour codec [default: transform, or cells with --color-block]
    #[arg(long, value_name = "CODEC", value_parser = one_of(COLOR_CODECS))]
    pub color_codec: Option<ColorCodec>,
    /// Number of frames per chunk of the transform codec: more compress better, fewer need less memory and seek faster
    /// [default: 24]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_FRAMES)))]
    pub color_chunk: Option<u32>,
    /// File of entropy tables from lightfold train-color, stored once and used for each cell that they make smaller
    #[arg(long, value_name = "TABLES")]
    pub color_tables: Option<PathBuf>,
    /// Minimum perceptual quality of every frame of every cell, 0 to 100 on the scale of SSIMULACRA2, for the transform
    /// codec; 65, 73 and 80 look like x265 at crf 22, 18 and 14 in the worst regions [default: 79]
    #[arg(long, value_name = "Q", conflicts_with_all = ["psnr", "color_block", "color_qp"])]
    pub quality: Option<f64>,
    /// Minimum PSNR in dB of every frame of every cell, instead of --quality, 0 to 200 (lossless); with --color-block,
    /// before block compression [default: none; for cells 50, or --psnr-final with --color-block]
    #[arg(long, value_name = "DB")]
    pub psnr: Option<f64>,
    /// Quantisation step of the transform codec for all cells, instead of --quality, without a bound on quality: 0
    /// (finest) to 240; +16 doubles the step
    #[arg(long, value_name = "N", conflicts_with_all = ["psnr", "color_block"],
        value_parser = clap::value_parser!(u8).range(0..=240))]
    pub color_qp: Option<u8>,
    /// Store keyframes of cells as texture blocks, with the loss bounded by --psnr-final: bc1 or bc7 for 8 bits, bc6h
    /// for --hdr. Implies --color-codec cells [default: none]
    #[arg(long, value_name = "FORMAT", ignore_case = true, value_parser = one_of(COLOR_BLOCKS))]
    pub color_block: Option<KeyframeBlocks>,
    /// Minimum PSNR in dB of every frame of every cell with keyframes in blocks, at most --psnr [default: 30 for bc1,
    /// 40 for bc7 and bc6h]
    #[arg(long, value_name = "DB")]
    pub psnr_final: Option<f64>,
    /// Transfer function to 8-bit codes; implies --clip [default: srgb]
    #[arg(long, value_parser = one_of(TRANSFERS), conflicts_with = "hdr")]
    pub transfer: Option<Transfer>,
    /// Exposure in stops before conversion to 8 bits, -8 to 8; implies --clip [default: 0]
    #[arg(long, value_name = "EV", allow_negative_numbers = true, conflicts_with = "hdr")]
    pub exposure: Option<f32>,
    /// Clip values above 1 to 8 bits. Without --clip, --hdr, --transfer or --exposure, footage whose first frames have
    /// such values is refused, unless its manifest selects a treatment ("keep")
    #[arg(long)]
    pub clip: bool,
    /// Encode colour as half floats instead of 8 bits, without clipping values above 1. PSNR is then computed on PU21
    /// codes, with the peak at 100 cd/m². Infinite values become 65504
    ///
    /// Samples below 0.005 or above 10000 cd/m² have a separate bound (color.md 5): bright ones are within 14% at the
    /// default, and with --psnr within 16% at 40 dB, 5% at 50 dB.
    #[arg(long)]
    pub hdr: bool,
    /// Luminance of the value 1.0 for --hdr, in cd/m²
    #[arg(long, value_name = "CD_M2", default_value_t = DEFAULT_WHITE_CD_M2, requires = "hdr")]
    pub white: f64,
    /// Keyframe lookahead: maximum number of distinct frames between two keyframes of a cell, limited to 768 MiB for
    /// all faces of an image. More compress better, with more memory and time. For --color-codec cells; the transform
    /// codec uses it only in chunks that are smaller as keyframes
    #[arg(long, value_name = "N", default_value_t = SearchSettings::default().lookahead,
        value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub lookahead: u32,
    /// Handling of NaN in colour, and of alpha outside 0 to 1
    #[arg(long, value_name = "WHAT", value_parser = one_of(INVALID_COLORS), default_value = "refuse")]
    pub invalid_color: InvalidColor,
}

impl ColorArgs {
    pub fn apply(&self, source: &mut SourceOptions, settings: &mut EncodeSettings) -> Result<()> {
        let blocks = self.color_block.flatten();
        let codec = match (self.color_codec, blocks) {
            (Some(ColorCodec::Transform), Some(_)) => {
                return refuse(
                    "--color-block needs --color-codec cells: leave out --color-block or --color-codec transform",
                );
            }
            (Some(codec), _) => codec,
            (None, Some(_)) => ColorCodec::Cells,
            (None, None) => ColorCodec::default(),
        };
        let of_blocks = blocks.map(|blocks| self.psnr_final.unwrap_or(ColorBlockSettings::usual_psnr_db(blocks)));
        let target = match (self.quality, self.psnr.or(of_blocks), self.color_qp) {
            (Some(quality), ..) => Target::Quality(quality),
            (None, Some(db), _) => Target::Psnr(db),
            (None, None, Some(step)) => Target::Step(step),
            (None, None, None) => codec.usual_target(),
        };
        for (option, db) in [("--psnr-final", self.psnr_final), ("--psnr", self.psnr)] {
            if let Some(db) = db.filter(|db| !(0.0..=200.0).contains(db)) {
                return refuse(format!("{option} {db}: 0 to 200 dB was expected"));
            }
        }
        if let Some(quality) = self.quality.filter(|quality| !(0.0..=MAX_QUALITY).contains(quality)) {
            return refuse(format!("--quality {quality}: 0 to {MAX_QUALITY} was expected"));
        }
        let exposure_ev = self.exposure.unwrap_or(0.0);
        if !(-8.0..=8.0).contains(&exposure_ev) {
            return refuse(format!("--exposure {exposure_ev}: -8 to 8 stops were expected"));
        }
        if let (Some(db), Target::Psnr(psnr)) = (self.psnr_final, target)
            && db > psnr
        {
            return refuse(format!("--psnr-final {db}: at most --psnr, {psnr} dB, was expected"));
        }
        settings.cell = self.color_cell;
        settings.color_codec = codec;
        settings.color_chunk = self.color_chunk.unwrap_or(settings.color_chunk);
        settings.color_tables = self.color_tables.as_deref().map(read_table_set).transpose()?;
        settings.search = SearchSettings { target, effort: settings.search.effort, lookahead: self.lookahead };
        settings.color_blocks = blocks.map(|blocks| {
            let usual = ColorBlockSettings::new(blocks, &settings.search);
            ColorBlockSettings { final_psnr_db: self.psnr_final.unwrap_or(usual.final_psnr_db), ..usual }
        });
        let of_transform = [
            ("--quality", self.quality.is_some()),
            ("--color-qp", self.color_qp.is_some()),
            ("--color-chunk", self.color_chunk.is_some()),
            ("--color-tables", self.color_tables.is_some()),
        ];
        if let Some((option, _)) = of_transform.into_iter().find(|(_, given)| *given && codec != ColorCodec::Transform)
        {
            return refuse(format!("{option} needs --color-codec transform"));
        }
        if settings.color_blocks.is_none() && self.psnr_final.is_some() {
            return refuse("--psnr-final needs --color-block");
        }
        settings.color = if self.hdr {
            ColorFormat::Half { white_cd_m2: self.white }
        } else {
            ColorFormat::EightBit(ToneMap { transfer: self.transfer.unwrap_or_default(), exposure_ev })
        };
        let chosen = self.clip || self.transfer.is_some() || self.exposure.is_some();
        settings.clipping = if chosen { Clipping::Allow } else { Clipping::Refuse };
        source.invalid_color = self.invalid_color;
        Ok(())
    }
}

fn read_table_set(path: &Path) -> Result<TableSet> {
    let sets = read_tables(path)?;
    match <[TableSet; 1]>::try_from(sets) {
        Ok([set]) => Ok(set),
        Err(sets) => refuse(format!(
            "--color-tables {}: {} table sets, one was expected: train with --sets 1",
            path.display(),
            sets.len()
        )),
    }
}
