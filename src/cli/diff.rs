//! `lightfold diff A B`: how far two of anything are apart, and where most.

use clap::ValueEnum;
use serde_json::{Value, json};

use crate::cli::options::{self, FrameArgs, MemoryArgs, SideArgs};
use crate::cli::output::{self, json_number};
use crate::cli::progress::Progress;
use crate::cli::{ExitStatus, GlobalArgs, diff_text};
use crate::color::quality::PU_STEPS;
use crate::compare::comparison::{Comparison, Measured, SampleTotal, StreamReport};
use crate::compare::difference::{DepthErrors, Lowest, SampleErrors, Spot};
use crate::compare::domain::{Domain, Origin};
use crate::compare::side::{self, Coding, Side, SideOptions, StreamId};
use crate::compare::streams::{CompareSettings, Coverage, Measure, Pairing, SsimFrames, compare};
use crate::dataset::stream::StreamKind;
use crate::decode::Selection;
use crate::error::Result;
use crate::image::cube::Face;
use crate::image::transfer::Transfer;
use crate::streams::ColorFormat;

/// Arguments.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  lightfold diff scene/lightfield.json scene.lfold --max-error 1 --min-psnr 50\n  \
    lightfold diff scene.lfold frames --json\n  \
    lightfold diff a.lfold b.lfold --exact --stream depth --probe 00\n  \
    lightfold diff face_px/depth.%04d.exr decoded/depth.####.exr --frames 0-9\n\n\
    Each side is a container, a lightfield.json or its folder, or a lone sequence: a pattern, a folder of images, one \
    image. Streams are matched by kind, probe and face; the only streams of a kind are matched whatever their names.\n\n\
    Depth is compared in 16-bit log codes from near to far, colour in 8-bit codes after the transfer function or, for \
    half floats, in the PU21 encoding: those of A where A is a container, else of B, else of a decoded folder's \
    manifest; two sides that were never coded are compared over the depths that both hold and in 8-bit sRGB. Errors in \
    metres are those of the files, before any code. Background against a surface, and a depth outside near to far, \
    count 65535 codes.\n\n\
    Exit codes: 0 nothing asked for is broken, 1 a bound is broken, bits differ (--exact), or streams or frames are \
    missing where a bound or --exact was given, 2 bad input.")]
pub struct Args {
    /// The one side, the reference where that matters; - for a container on standard input
    #[arg(value_name = "A")]
    pub a: String,
    /// The other side
    #[arg(value_name = "B")]
    pub b: String,
    /// Largest difference allowed: codes of depth, and 8-bit codes of material
    #[arg(long, value_name = "CODES")]
    pub max_error: Option<u16>,
    /// Lowest PSNR allowed of any frame of any colour stream, in dB
    #[arg(long, value_name = "DB", value_parser = parse_db)]
    pub min_psnr: Option<f64>,
    /// Lowest PSNR allowed of any frame of any cell of colour, in dB: what encode --psnr promises
    #[arg(long, value_name = "DB", value_parser = parse_db)]
    pub min_cell_psnr: Option<f64>,
    /// Every bit must be the same: depth and colour as files hold them
    #[arg(long)]
    pub exact: bool,
    /// Leave out streams and frames that one side alone has
    #[arg(long)]
    pub common: bool,
    /// Frames of each stream that SSIM is computed for (8-bit colour; it is slow)
    #[arg(long, value_enum, default_value_t = SsimArg::Sampled)]
    pub ssim: SsimArg,
    /// A row for every stream, however many there are
    #[arg(long)]
    pub streams: bool,
    /// Report as JSON
    #[arg(long)]
    pub json: bool,
    /// Only streams of these kinds: color, depth, material; also tells what a lone sequence holds
    #[arg(long, visible_alias = "kind", value_name = "KIND", value_delimiter = ',', value_parser = options::parse_kind)]
    pub stream: Vec<StreamKind>,
    /// Only these probes; also tells the probe of a lone sequence
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    pub probe: Vec<String>,
    /// Only these faces; also tells the face of a lone sequence
    #[arg(long, value_name = "FACE", value_delimiter = ',', value_parser = options::parse_face)]
    pub face: Vec<Face>,
    /// Memory.
    #[command(flatten)]
    pub memory: MemoryArgs,
    /// Frames.
    #[command(flatten)]
    pub frames: FrameArgs,
    /// How files are read.
    #[command(flatten)]
    pub reading: SideArgs,
}

/// `--ssim`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum SsimArg {
    /// Every frame
    Every,
    /// The first, the middle and the last
    Sampled,
    /// No frame
    None,
}

fn parse_db(text: &str) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|_| format!("'{text}' is no number of decibels"))?;
    if value.is_nan() { Err("decibels were expected".into()) } else { Ok(value) }
}

/// Compares.
pub fn run(args: &Args, global: &GlobalArgs) -> Result<ExitStatus> {
    let sides = side::open_both([&args.a, &args.b], &side_options(args)?)?;
    let settings = CompareSettings {
        coverage: if args.common { Coverage::Common } else { Coverage::Whole },
        measure: if args.exact { Measure::Bits } else { Measure::Codes },
        ssim: args.ssim.into(),
        memory: args.memory.get(),
    };
    let pairing = Pairing::new(&sides, settings.coverage)?;
    let progress = Progress::start(global, "comparing", pairing.images())?;
    let comparison = compare(&pairing, &settings, &progress)?;
    drop(progress);
    let verdict = Verdict::new(args, &comparison);
    if args.json {
        let mut report = report_json(&sides, &comparison, &verdict);
        output::add_peak_memory(&mut report);
        output::print_json(&report)?;
    } else {
        let rows = if args.streams { diff_text::Rows::All } else { diff_text::Rows::Few };
        output::print_text(&diff_text::report(&sides, &comparison, &verdict, rows))?;
    }
    Ok(if verdict.differs { ExitStatus::Failed } else { ExitStatus::Passed })
}

fn side_options(args: &Args) -> Result<SideOptions> {
    args.reading.options(Selection {
        probes: args.probe.clone(),
        faces: args.face.clone(),
        kinds: args.stream.clone(),
        frames: args.frames.frames,
    })
}

/// A bound that is broken, and where most.
#[derive(Debug, Clone, PartialEq)]
pub struct Broken {
    /// The option.
    pub bound: &'static str,
    /// What it allows.
    pub limit: f64,
    /// What was found.
    pub measured: f64,
    /// Index of the stream.
    pub stream: usize,
    /// The pixel, or the frame and the upper left corner of what was measured.
    pub spot: Option<Spot>,
}

/// What the numbers mean for what was asked.
#[derive(Debug, Clone, PartialEq)]
pub struct Verdict {
    /// Nothing differs and nothing is missing.
    pub equal: bool,
    /// All bounds that were given hold, and nothing is missing.
    pub within_bounds: bool,
    /// Whether the exit code says so.
    pub differs: bool,
    /// Whether any bound was given.
    pub bounded: bool,
    /// The bounds that do not hold.
    pub broken: Vec<Broken>,
}

impl Verdict {
    fn new(args: &Args, comparison: &Comparison) -> Verdict {
        let mut broken = Vec::new();
        if let Some(limit) = args.max_error {
            let spot = |at: usize| comparison.streams[at].worst().map(|(spot, _)| spot);
            let mut check = |measured: u32, stream: Option<usize>| {
                if let Some(stream) = stream
                    && measured > u32::from(limit)
                {
                    let (limit, measured) = (f64::from(limit), f64::from(measured));
                    broken.push(Broken { bound: "--max-error", limit, measured, stream, spot: spot(stream) });
                }
            };
            if let Some((errors, stream)) = comparison.depth() {
                check(u32::from(errors.max_error_codes), stream);
            }
            if let Some(total) = comparison.material() {
                check(total.max_error, total.worst);
            }
        }
        if let Some(total) = comparison.color() {
            let lowest = [
                ("--min-psnr", args.min_psnr, total.lowest_frame),
                ("--min-cell-psnr", args.min_cell_psnr, total.lowest_cell),
            ];
            for (bound, limit, lowest) in lowest {
                if let (Some(limit), Some((stream, Lowest { psnr_db, spot }))) = (limit, lowest)
                    && psnr_db < limit
                {
                    broken.push(Broken { bound, limit, measured: psnr_db, stream, spot: Some(spot) });
                }
            }
        }
        let bounded = args.max_error.is_some() || args.min_psnr.is_some() || args.min_cell_psnr.is_some();
        let equal = comparison.equal();
        let complete = comparison.missing.is_empty();
        Verdict {
            equal,
            within_bounds: broken.is_empty() && complete,
            differs: !broken.is_empty() || (bounded && !complete) || (args.exact && !equal),
            bounded,
            broken,
        }
    }
}

fn report_json(sides: &[Side; 2], comparison: &Comparison, verdict: &Verdict) -> Value {
    let mut report = json!({
        "equal": verdict.equal,
        "within_bounds": verdict.within_bounds,
        "broken": verdict.broken.iter().map(|broken| broken_json(broken, comparison)).collect::<Vec<_>>(),
        "worst": comparison.worst().map(|(at, spot)| located(comparison, at, spot)),
        "domains": domains_json(comparison),
        "missing": comparison
            .missing
            .iter()
            .map(|missing| {
                let mut value = id_json(&missing.id);
                value["only_in"] = json!(side_name(missing.only_in));
                value["frames"] = json!([missing.frames.first, missing.frames.last]);
                value
            })
            .collect::<Vec<_>>(),
        "sides": sides.iter().map(|side| json!({ "path": side.path, "form": side.form.name() })).collect::<Vec<_>>(),
        "streams": comparison.streams.iter().map(stream_json).collect::<Vec<_>>(),
    });
    if let Some((errors, worst)) = comparison.depth() {
        let mut group = depth_json(&errors);
        group["worst"] = worst.zip(errors.worst).map_or(Value::Null, |(at, spot)| located(comparison, at, spot));
        report["depth"] = group;
    }
    if let Some(total) = comparison.color() {
        report["color"] = color_json(&total, comparison);
    }
    if let Some(total) = comparison.material() {
        report["material"] = json!({
            "max_error_codes": total.max_error,
            "psnr_db": json_number(total.psnr_db()),
            "differing_pixels": total.differing_pixels,
            "worst": worst_json(&total, comparison),
        });
    }
    if let Some((count, first)) = comparison.bits() {
        report["exact"] = json!({
            "differing_pixels": count,
            "first": first.map(|(at, spot)| located(comparison, at, spot)),
        });
    }
    report
}

/// `A` or `B`.
pub fn side_name(side: usize) -> &'static str {
    if side == 0 { "A" } else { "B" }
}

fn id_json(id: &StreamId) -> Value {
    json!({ "stream": id.to_string(), "kind": id.kind.name(), "probe": id.probe, "face": id.face.name() })
}

fn located(comparison: &Comparison, at: usize, spot: Spot) -> Value {
    let mut value = id_json(&comparison.streams[at].id);
    value["frame"] = json!(spot.frame);
    value["x"] = json!(spot.x);
    value["y"] = json!(spot.y);
    value
}

fn broken_json(broken: &Broken, comparison: &Comparison) -> Value {
    let id = &comparison.streams[broken.stream].id;
    let mut value = broken.spot.map_or_else(|| id_json(id), |spot| located(comparison, broken.stream, spot));
    value["bound"] = json!(broken.bound.trim_start_matches('-'));
    value["limit"] = json_number(broken.limit);
    value["measured"] = json_number(broken.measured);
    value
}

fn depth_json(errors: &DepthErrors) -> Value {
    json!({
        "max_error_codes": errors.max_error_codes,
        "max_error_m": json_number(errors.max_error_m),
        "psnr_db": json_number(errors.error.psnr_db()),
        "differing_pixels": errors.differing_pixels,
        "background_mismatches": errors.background_mismatches,
        "outside_pixels": errors.outside_pixels,
    })
}

fn color_json(total: &SampleTotal, comparison: &Comparison) -> Value {
    let lowest = |lowest: Option<(usize, Lowest)>| {
        lowest.map_or(Value::Null, |(at, lowest)| located(comparison, at, lowest.spot))
    };
    json!({
        "psnr_db": json_number(total.psnr_db()),
        "min_psnr_db": total.lowest_frame.map(|(_, lowest)| json_number(lowest.psnr_db)),
        "min_psnr_at": lowest(total.lowest_frame),
        "min_cell_psnr_db": total.lowest_cell.map(|(_, lowest)| json_number(lowest.psnr_db)),
        "min_cell_psnr_at": lowest(total.lowest_cell),
        "ssim": total.ssim(),
        "ssim_frames": total.ssim_frames,
        "differing_pixels": total.differing_pixels,
        "clipped_pixels": total.clipped_pixels,
        "worst": worst_json(total, comparison),
    })
}

fn worst_json(total: &SampleTotal, comparison: &Comparison) -> Value {
    let worst = total.worst.and_then(|at| Some((at, comparison.streams[at].worst()?.0)));
    worst.map_or(Value::Null, |(at, spot)| located(comparison, at, spot))
}

fn stream_json(stream: &StreamReport) -> Value {
    let mut value = match &stream.measured {
        Measured::Depth(errors) => depth_json(errors),
        Measured::Color(errors) => {
            let mut value = samples_json(errors, &stream.domain);
            value["min_psnr_db"] = json!(errors.lowest_frame.map(|lowest| json_number(lowest.psnr_db)));
            value["min_psnr_frame"] = json!(errors.lowest_frame.map(|lowest| lowest.spot.frame));
            value["min_cell_psnr_db"] = json!(errors.lowest_cell.map(|lowest| json_number(lowest.psnr_db)));
            value["min_cell_psnr_at"] = json!(errors.lowest_cell.map(|lowest| spot_json(lowest.spot)));
            value["ssim"] = json!((errors.ssim_frames > 0).then(|| errors.ssim_sum / errors.ssim_frames as f64));
            value["ssim_frames"] = json!(errors.ssim_frames);
            value["clipped_pixels"] = json!(errors.clipped_pixels);
            value
        }
        Measured::Material(errors) => samples_json(errors, &stream.domain),
    };
    if let (Value::Object(all), Value::Object(id)) = (&mut value, id_json(&stream.id)) {
        all.extend(id);
    }
    if let Some(other) = &stream.other_id {
        value["stream_in_b"] = json!(other.to_string());
    }
    if let Some(bits) = &stream.bits {
        value["exact"] = json!({ "differing_pixels": bits.differing_pixels, "first": bits.first.map(spot_json) });
    }
    value["width"] = json!(stream.size[0]);
    value["height"] = json!(stream.size[1]);
    value["frames"] = json!([stream.frames.first, stream.frames.last]);
    value["worst"] = json!(stream.worst().map(|(spot, _)| spot_json(spot)));
    value["domain"] = domain_json(&stream.domain);
    value
}

fn samples_json(errors: &SampleErrors, domain: &Domain) -> Value {
    let mut value = json!({
        "psnr_db": json_number(errors.psnr_db()),
        "differing_pixels": errors.differing_pixels,
    });
    match domain.coding {
        Coding::Color(ColorFormat::Half { .. }, _) => {
            value["max_error_pu21"] = json!(f64::from(errors.max_error) / PU_STEPS);
        }
        _ => value["max_error_codes"] = json!(errors.max_error),
    }
    value
}

fn spot_json(spot: Spot) -> Value {
    json!({ "frame": spot.frame, "x": spot.x, "y": spot.y })
}

/// The domains in use, each once, by kind.
fn domains_json(comparison: &Comparison) -> Value {
    let mut by_kind = serde_json::Map::new();
    for stream in &comparison.streams {
        let list = by_kind.entry(stream.id.kind.name()).or_insert_with(|| json!([]));
        let mut domain = domain_json(&stream.domain);
        if stream.id.kind == StreamKind::Depth {
            domain["probe"] = json!(stream.id.probe);
        }
        if let Value::Array(list) = list
            && !list.contains(&domain)
        {
            list.push(domain);
        }
    }
    by_kind.into()
}

fn domain_json(domain: &Domain) -> Value {
    let mut value = match domain.coding {
        Coding::Depth(range) => json!({ "codes": "16bit-log", "near_m": range.near_m(), "far_m": range.far_m() }),
        Coding::Color(ColorFormat::EightBit(tone), cell) => json!({
            "codes": "8bit",
            "transfer": if tone.transfer == Transfer::Srgb { "srgb" } else { "linear" },
            "exposure_ev": tone.exposure_ev,
            "cell": cell,
        }),
        Coding::Color(ColorFormat::Half { white_cd_m2 }, cell) => {
            json!({ "codes": "half", "metric": "pu21 in 64ths", "white_cd_m2": white_cd_m2, "cell": cell })
        }
        Coding::Material => json!({ "codes": "8bit" }),
    };
    let (of, from) = match domain.origin {
        Origin::Container(side) => (json!(side_name(side)), "container"),
        Origin::Manifest(side) => (json!(side_name(side)), "manifest"),
        Origin::Chosen => (Value::Null, "default"),
    };
    value["of"] = of;
    value["from"] = json!(from);
    value
}

impl From<SsimArg> for SsimFrames {
    fn from(which: SsimArg) -> SsimFrames {
        match which {
            SsimArg::Every => SsimFrames::Every,
            SsimArg::Sampled => SsimFrames::Sampled,
            SsimArg::None => SsimFrames::None,
        }
    }
}
