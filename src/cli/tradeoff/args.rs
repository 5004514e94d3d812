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
    Each point is encoded, decoded and compared by commands of this program that DIR/tradeoff.csv names. Points whose \
    bytes and quality are known and whose runs are finished are not measured again: the same command goes on after an \
    interruption. Rounds of timed runs go over all points, to and fro, so that a machine that becomes slower does so for \
    all alike. A decoding time is the median of runs in one process, the container in memory. A point that fails leaves a \
    hole, and is tried again the next time.\n\n\
    Where a scene is named (a .glb, .gltf or .obj file, or one that is built in), options of place are swept instead, and \
    DIR has placement.csv, placement.json, pictures and a page: seconds, and what the cameras cover by the same 32768 \
    points on surfaces for all. All knobs make one grid. placement.csv is written after each point, and keeps what was \
    measured where a sweep is stopped; the same command does not go on from there, but starts over with --overwrite. \
    --preset, --recommend, --budget-seconds, --weights and --stream are for footage alone.\n\n\
    Where options of render are swept, one probe of the dataset is left out (--reference-probe after --, else the most \
    central one) and rendered from the others: DIR has rendering.csv, rendering.json, pictures of PSNR against time and a page. \
    Options after -- are those of render then. What is said of a scene holds for such a sweep, too.\n\n\
    Where options of simplify are swept, each point simplifies the capture and compares the result with it: DIR has \
    simplification.csv, simplification.json, pictures and a page, with what Seurat's authors found and whether it holds here. A \
    point whose budgets cannot be kept is listed with the least value that would do. Options after -- are those of simplify, and \
    what is said of a scene holds, too. A folder holds sweeps of one kind: coding, rendering, simplifying, or placing cameras.\n\n\
    Exit codes: 0 measured, 1 no point meets what --recommend was given, 2 bad input or usage, or points that failed.")]
pub struct Args {
    /// The footage: a lightfield.json, its folder, or a lone sequence with --stream; or a scene to place cameras in. Not
    /// needed where --recommend is to look at what DIR holds
    #[arg(value_name = "MANIFEST|SEQ|SCENE", required_unless_present_any = ["recommend", "list_knobs"])]
    pub input: Option<String>,
    /// Options of encode (of place for a scene, of render or simplify where their options are swept) that all points have, such
    /// as --hdr or --frames 0-9
    #[arg(last = true, value_name = "OPTIONS")]
    pub fixed: Vec<String>,
    /// A knob and the values that it is to have, such as psnr=30,40,50; without values those of --list-knobs. Knobs of one
    /// kind of stream make one grid
    #[arg(long, value_name = "KNOB=V1,V2", value_parser = Sweep::parse)]
    pub sweep: Vec<Sweep>,
    /// Sweeps that are prepared: those of the papers' figures, or the same in few values
    #[arg(long, value_name = "NAME", value_parser = one_of(PRESETS))]
    pub preset: Option<Preset>,
    /// Folder for tradeoff.csv, tradeoff.json, the pictures and the page index.html; where rendering, simplifying or
    /// placing cameras is measured, for rendering.csv, simplification.csv or placement.csv, .json, pictures and page
    #[arg(long, short, value_name = "DIR", default_value = "lightfold-tradeoff")]
    pub output: PathBuf,
    /// Replace what DIR holds of other footage, options, machine or program, instead of refusing
    #[arg(long)]
    pub overwrite: bool,
    /// Timed runs of each point
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub repeats: u32,
    /// Seconds that all of it may take: values and runs that do not fit are left out, which is said. Not for a scene
    #[arg(long, value_name = "S", value_parser = parse_positive)]
    pub budget_seconds: Option<f64>,
    /// Only streams of these kinds: color, depth, material, alpha; also tells what a lone sequence holds
    #[arg(long, value_name = "KIND", value_delimiter = ',', value_parser = options::parse_kind)]
    pub stream: Vec<StreamKind>,
    /// How much bytes and decoding time count in the score, which knows nothing of quality, such as 1,3 [default: 0.25,0.75]
    #[arg(long, value_name = "BYTES,TIME", value_parser = parse_weights)]
    pub weights: Option<Weights>,
    /// List the knobs with their defaults, and do nothing else
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
    /// Of the points in DIR, or of those just measured, name the smallest of each kind that meets what is asked; or the
    /// closest to the source, where only time and bytes are limited
    #[arg(long)]
    pub recommend: bool,
    /// Largest error: 16-bit log codes of depth, steps of 8 bits of material
    #[arg(long, value_name = "CODES", requires = "recommend")]
    pub max_error: Option<u16>,
    /// Largest error of depth in metres
    #[arg(long, value_name = "M", requires = "recommend", value_parser = parse_positive)]
    pub max_error_m: Option<f64>,
    /// Lowest PSNR of any frame of any cell of colour, in dB
    #[arg(long, value_name = "DB", requires = "recommend", value_parser = parse_positive)]
    pub min_psnr: Option<f64>,
    /// Lowest quality to the eye of any frame of any cell of colour, as of diff --min-quality
    #[arg(long, value_name = "Q", requires = "recommend", value_parser = parse_positive)]
    pub min_quality: Option<f64>,
    /// Milliseconds of decoding for one point in time, all probes and faces of a kind
    #[arg(long, value_name = "MS", requires = "recommend", value_parser = parse_positive)]
    pub decode_ms: Option<f64>,
    /// Bytes of the container, such as 5000000, 5MB or 800kB
    #[arg(long, value_name = "BYTES", requires = "recommend", value_parser = parse_bytes)]
    pub max_bytes: Option<u64>,
    /// Bytes of the container in percent of those of the footage, such as 5 or 5%
    #[arg(long, value_name = "PERCENT", requires = "recommend", value_parser = parse_percent)]
    pub max_ratio: Option<f64>,
}

const PRESETS: &Choices<Preset> = &[
    ("paper", Preset::Paper, "CALF figures 7 and 8, GDC figures 5, 6 and 8"),
    ("quick", Preset::Quick, "The same in few values, without the statistics of tiles"),
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
        unit => return Err(format!("'{unit}' is none of B, kB, MB, GB")),
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
                "--recommend: say what is asked, by --max-error, --max-error-m, --min-psnr, --min-quality, --decode-ms, --max-bytes or --max-ratio",
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
        Some((name, _)) => refuse(format!("{name} is for coding footage, and not for {what}")),
        None => Ok(()),
    }
}
