//! Arguments of `lightfold tradeoff`.

use std::path::PathBuf;

use crate::options::{self, Choices, one_of, parse_positive};
use crate::refuse;
use crate::report::tradeoff::coding::recommend::Demands;
use crate::report::tradeoff::plan::{Preset, Sweep};
use crate::report::tradeoff::study::Weights;
use codec::error::Result;
use codec::image::StreamKind;

#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
    lightfold tradeoff scene/lightfield.json --sweep depth-window=1,2,4,8 --sweep max-aabbs -o out\n  \
    lightfold tradeoff scene --preset paper -o out\n  \
    lightfold tradeoff scene --sweep psnr --budget-seconds 120 -o out -- --hdr --frames 0-9\n  \
    lightfold tradeoff depth.%04d.exr --stream depth --sweep max-error=0,50,200 -o out\n  \
    lightfold tradeoff --recommend --max-error 50 --decode-ms 5 -o out\n  \
    lightfold tradeoff scene --sweep views=2,4 --sweep steps -o out -- --frames 0\n  \
    lightfold tradeoff room.glb --sweep effort --sweep cameras=2,4 -o out -- --region=-1,1,-1,1,2,1\n  \
    lightfold tradeoff scene --sweep triangles=2000,20000 --sweep area=2,3 -o out -- --effort fast\n  \
    lightfold tradeoff --list-knobs\n\n\
    Each point is encoded, decoded and compared by lightfold commands, which DIR/tradeoff.csv lists. After an \
    interruption, the same command continues: complete points are not measured again. Timed runs alternate between \
    all points in both directions, so that a change in machine speed affects all points equally. A decoding time is \
    the median of runs in one process, with the container in memory. A point that fails is left empty, and measured \
    again by the next run.\n\n\
    If the input is a scene (a .glb, .gltf or .obj file, or built in), options of place are swept instead. DIR then \
    has placement.csv, placement.json, charts and a page, with time and coverage; coverage is measured on the same \
    32768 surface points for all points of the sweep. All knobs form one grid. placement.csv is written after each \
    point, so an interrupted sweep keeps its measurements; the same command does not continue it, but starts over \
    with --overwrite. --preset, --recommend, --budget-seconds, --weights and --stream apply to footage only.\n\n\
    If options of render are swept, one probe of the dataset is excluded (--reference-probe after --, else the most \
    central one) and rendered from the others. DIR then has rendering.csv, rendering.json, charts of PSNR against \
    time and a page. Options after -- are options of render. Otherwise such a sweep behaves like that of a scene.\n\n\
    If options of simplify are swept, each point simplifies the capture and compares the result with it. DIR then has \
    simplification.csv, simplification.json, charts and a page, which lists findings of the Seurat paper and whether \
    they hold here. A point whose budgets cannot be met is listed with the minimum budget. Options after -- are \
    options of simplify. Otherwise such a sweep behaves like that of a scene. A folder has sweeps of one kind: \
    coding, rendering, simplifying, or placing cameras.\n\n\
    Exit codes: 0 measured; 1 no point meets the limits of --recommend; 2 bad input or usage, or points failed.")]
pub struct Args {
    /// Footage: a lightfield.json, its folder, or a single sequence with --stream; or a scene in which to place
    /// cameras. Not needed if --recommend uses the points in DIR
    #[arg(value_name = "MANIFEST|SEQ|SCENE", required_unless_present_any = ["recommend", "list_knobs"])]
    pub input: Option<String>,
    /// Options common to all points, such as --hdr or --frames 0-9: options of encode, of place for a scene, or of
    /// render or simplify if their options are swept
    #[arg(last = true, value_name = "OPTIONS")]
    pub fixed: Vec<String>,
    /// Knob and its values, such as psnr=30,40,50; without values, those of --list-knobs. Knobs of the same kind of
    /// stream form a grid; repeatable
    #[arg(long, value_name = "KNOB=V1,V2", value_parser = Sweep::parse)]
    pub sweep: Vec<Sweep>,
    /// Predefined sweeps: those of the figures in the papers, or the same with few values
    #[arg(long, value_name = "NAME", value_parser = one_of(PRESETS))]
    pub preset: Option<Preset>,
    /// Output folder for tradeoff.csv, tradeoff.json, charts and index.html; files of other sweeps are named rendering,
    /// simplification or placement
    #[arg(long, short, value_name = "DIR", default_value = "lightfold-tradeoff")]
    pub output: PathBuf,
    /// Replace results of other footage, options, machines or versions of lightfold in DIR, instead of failing
    #[arg(long)]
    pub overwrite: bool,
    /// Number of timed runs per point
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub repeats: u32,
    /// Time limit in seconds: values and runs that do not fit are skipped and listed. Not for scenes
    #[arg(long, value_name = "S", value_parser = parse_positive)]
    pub budget_seconds: Option<f64>,
    /// Only streams of these kinds: color, depth, material, alpha; also the kind of a single sequence
    #[arg(long, value_name = "KIND", value_delimiter = ',', value_parser = options::parse_kind)]
    pub stream: Vec<StreamKind>,
    /// Weights of bytes and decoding time in the score, which ignores quality, such as 1,3 [default: 0.25,0.75]
    #[arg(long, value_name = "BYTES,TIME", value_parser = parse_weights)]
    pub weights: Option<Weights>,
    /// List knobs with their defaults and exit
    #[arg(long)]
    pub list_knobs: bool,
    /// Report as JSON
    #[arg(long)]
    pub json: bool,
    #[command(flatten)]
    pub recommend: RecommendArgs,
}

#[derive(Debug, Clone, clap::Args)]
#[command(next_help_heading = "Recommendation")]
pub struct RecommendArgs {
    /// Print the smallest point of each kind in DIR that meets all limits; if only time and bytes are limited, the
    /// point closest to the source
    #[arg(long)]
    pub recommend: bool,
    /// Maximum error: 16-bit log codes of depth, 8-bit steps of material
    #[arg(long, value_name = "CODES", requires = "recommend")]
    pub max_error: Option<u16>,
    /// Maximum error of depth in metres
    #[arg(long, value_name = "M", requires = "recommend", value_parser = parse_positive)]
    pub max_error_m: Option<f64>,
    /// Minimum PSNR in dB of every frame of every colour cell
    #[arg(long, value_name = "DB", requires = "recommend", value_parser = parse_positive)]
    pub min_psnr: Option<f64>,
    /// Minimum perceptual quality of every frame of every colour cell, as diff --min-quality
    #[arg(long, value_name = "Q", requires = "recommend", value_parser = parse_positive)]
    pub min_quality: Option<f64>,
    /// Maximum decoding time in milliseconds of one frame, all probes and faces of a kind
    #[arg(long, value_name = "MS", requires = "recommend", value_parser = parse_positive)]
    pub decode_ms: Option<f64>,
    /// Maximum size of the container, such as 5000000, 5MB or 800kB
    #[arg(long, value_name = "BYTES", requires = "recommend", value_parser = parse_bytes)]
    pub max_bytes: Option<u64>,
    /// Maximum size of the container in percent of the raw footage, such as 5 or 5%
    #[arg(long, value_name = "PERCENT", requires = "recommend", value_parser = parse_percent)]
    pub max_ratio: Option<f64>,
}

const PRESETS: &Choices<Preset> = &[
    ("paper", Preset::Paper, "CALF figures 7 and 8, GDC figures 5, 6 and 8"),
    ("quick", Preset::Quick, "As paper, with few values and without statistics of tiles"),
];

fn parse_percent(text: &str) -> Result<f64, String> {
    parse_positive(text.trim_end_matches('%').trim())
}

fn parse_bytes(text: &str) -> Result<u64, String> {
    let digits = text.trim_end_matches(|letter: char| letter.is_ascii_alphabetic());
    let factor = match text[digits.len()..].to_ascii_lowercase().as_str() {
        "" | "b" => 1.0,
        "k" | "kb" => 1e3,
        "m" | "mb" => 1e6,
        "g" | "gb" => 1e9,
        unit => return Err(format!("'{unit}': B, kB, MB or GB was expected")),
    };
    Ok((parse_positive(digits.trim())? * factor).round() as u64)
}

fn parse_weights(text: &str) -> Result<Weights, String> {
    let wrong = || format!("'{text}': two numbers such as 0.25,0.75 were expected, none negative and not both 0");
    let (compression, decoding) = text.split_once(',').ok_or_else(wrong)?;
    let part =
        |text: &str| text.trim().parse().ok().filter(|part: &f64| *part >= 0.0 && part.is_finite()).ok_or_else(wrong);
    let (compression, decoding) = (part(compression)?, part(decoding)?);
    let sum: f64 = compression + decoding;
    if sum > 0.0 && sum.is_finite() {
        Ok(Weights { compression: compression / sum, decoding: decoding / sum })
    } else {
        Err(wrong())
    }
}

impl RecommendArgs {
    pub fn demands(&self) -> Result<Option<Demands>> {
        if !self.recommend {
            return Ok(None);
        }
        let demands = Demands {
            max_error_codes: self.max_error.map(u32::from),
            max_error_m: self.max_error_m,
            min_psnr_db: self.min_psnr,
            min_quality: self.min_quality,
            decode_ms: self.decode_ms,
            max_bytes: self.max_bytes,
            max_ratio_percent: self.max_ratio,
        };
        if demands.is_empty() {
            return refuse(
                "--recommend needs a limit: --max-error, --max-error-m, --min-psnr, --min-quality, --decode-ms, \
                --max-bytes or --max-ratio",
            );
        }
        Ok(Some(demands))
    }
}

pub fn refuse_options_of_coding(args: &Args, what: &str) -> Result<()> {
    let given = [
        ("--preset", args.preset.is_some()),
        ("--recommend", args.recommend.recommend),
        ("--budget-seconds", args.budget_seconds.is_some()),
        ("--weights", args.weights.is_some()),
        ("--stream", !args.stream.is_empty()),
    ];
    match given.into_iter().find(|(_, given)| *given) {
        Some((name, _)) => refuse(format!("{name} applies to sweeps of encode options, not to {what}")),
        None => Ok(()),
    }
}
