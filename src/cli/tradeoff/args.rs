//! Arguments of `lightfold tradeoff`.

use std::path::PathBuf;

use crate::options::{self, Choices, one_of, parse_positive};
use crate::refuse;
use crate::report::tradeoff::plan::{Preset, Sweep};
use crate::report::tradeoff::recommend::Demands;
use crate::report::tradeoff::study::Weights;
use codec::error::Result;
use codec::image::StreamKind;

#[derive(Debug, clap::Args)]
#[command(after_help = include_str!("help.txt").trim_end())]
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
    #[command(flatten)]
    demands: Demands,
}

const PRESETS: &Choices<Preset> = &[
    ("paper", Preset::Paper, "CALF figures 7 and 8, GDC figures 5, 6 and 8"),
    ("quick", Preset::Quick, "As paper, with few values and without statistics of tiles"),
];

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
        if self.demands.is_empty() {
            return refuse(
                "--recommend needs a limit: --max-error, --max-error-m, --min-psnr, --min-quality, --decode-ms, \
                --max-bytes or --max-ratio",
            );
        }
        Ok(Some(self.demands))
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
