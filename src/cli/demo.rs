//! `lightfold demo`: captures, encodes, decodes and compares a built-in scene.

use std::path::{Path, PathBuf};
use std::time::Instant;

use serde::Serialize;

use crate::child::shell_word;
use crate::decode::Export;
use crate::encode::Encode;
use crate::options::{Target, Unfinished};
use crate::output::{self, human_bytes};
use crate::progress::Progress;
use crate::report::Table;
use crate::{ExitStatus, GlobalArgs};
use codec::decode::{self, Decoder, OnCpu, OnDamage, Selection, StreamInfo};
use codec::error::Result;
use codec::image::StreamKind;
use footage::compare::{self, CompareSettings, Comparison, Pairing, SideOptions, SsimFrames};
use footage::dataset::source::{Source, SourceOptions};
use footage::encode::{EncodeSettings, ErrorBound};
use footage::export::{Destination, FileCoding};
use footage::inspect::{self, InspectSettings, percent};
use footage::json::Number;
use scene::{CapturePlan, DemoKind, DemoScene, FootagePlan, Scene};

#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  lightfold demo\n  lightfold demo -o out/demo --frame-count 48 --size 256 --json\n\n\
    Captures a procedural street corner into DIR/scene, encodes it to DIR/demo.lfold, decodes that into DIR/decoded and \
    compares both. The same options write the same bytes in every run. The exit code is 1 if an error exceeds the \
    bounds of the encoder."
)]
pub struct Args {
    /// Output folder
    #[arg(long, short, value_name = "DIR", default_value = "lightfold-demo")]
    pub output: PathBuf,
    /// Number of frames, at 24 frames per second; the animation repeats after 96
    #[arg(long, value_name = "N", default_value_t = 16, value_parser = clap::value_parser!(u32).range(1..=9999))]
    pub frame_count: u32,
    /// Width and height of each cube face in pixels
    #[arg(long, value_name = "PIXELS", default_value_t = 128, value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub size: u32,
    /// Number of probes
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = clap::value_parser!(u32).range(1..=64))]
    pub probes: u32,
    /// Report as JSON
    #[arg(long)]
    pub json: bool,
}

/// Samples per pixel of colour: a quarter of the default, for a short capture.
const SAMPLES: u32 = 4;

struct Places {
    scene: PathBuf,
    container: PathBuf,
    decoded: PathBuf,
}

impl Places {
    fn below(folder: &Path) -> Places {
        let at = |name| folder.join(name);
        Places { scene: at("scene"), container: at("demo.lfold"), decoded: at("decoded") }
    }

    fn commands(&self, settings: &EncodeSettings) -> [String; 5] {
        let word = |path: &PathBuf| shell_word(&path.display().to_string());
        let [scene, container, decoded] = [&self.scene, &self.container, &self.decoded].map(word);
        [
            format!("lightfold encode {scene} --clip -o {container}"),
            format!("lightfold inspect {container}"),
            format!("lightfold decode {container} -o {decoded}"),
            format!(
                "lightfold diff {scene} {decoded} --max-error {} --min-quality {} --allow-clipping",
                depth_bound(settings),
                settings.search.target.min_quality()
            ),
            format!("lightfold view {container} --open"),
        ]
    }
}

#[derive(Serialize)]
struct Report {
    bytes: u64,
    raw_bytes: u64,
    ratio_percent: f64,
    frames: u64,
    kinds: Vec<KindReport>,
    depth: DepthReport,
    color: ColorReport,
    seconds: Seconds,
    commands: [String; 5],
}

#[derive(Serialize)]
struct KindReport {
    kind: &'static str,
    streams: u64,
    frames: u64,
    raw_bytes: u64,
    temporal_bytes: u64,
    ratio_percent: f64,
    decode_megapixels_per_second: f64,
}

#[derive(Serialize)]
struct DepthReport {
    max_error_codes: Option<u16>,
}

/// Lowest quality and PSNR of any frame of any cell.
#[derive(Serialize)]
struct ColorReport {
    min_quality: Option<f64>,
    min_psnr_db: Option<Number>,
}

#[derive(Serialize)]
struct Seconds {
    capture: f64,
    encode: f64,
    /// Includes writing the files.
    decode: f64,
}

pub fn run(args: &Args, global: &GlobalArgs) -> Result<ExitStatus> {
    let places = Places::below(&args.output);
    let settings = EncodeSettings::default();
    let start = Instant::now();
    capture(args, &places.scene, global)?;
    let captured = start.elapsed();
    let encoding = Instant::now();
    let source = Source::open(&places.scene, &SourceOptions::default())?;
    let target = Target { path: &places.container, unfinished: Unfinished::Discard, json: false };
    Encode {
        source: &source,
        part: None,
        settings: &settings,
        target,
        time: None,
        smaller: None,
        start: encoding,
        global,
    }
    .encode()?;
    let encoded = start.elapsed();
    let decoder = Decoder::open(&places.container)?;
    decode(&decoder, &places.decoded, global)?;
    let [capture, encode, decode] =
        [captured, encoded - captured, start.elapsed() - encoded].map(|time| time.as_secs_f64());
    let comparison = compare(&places, global)?;
    let (bytes, all) = (decoder.reader().file_bytes, measure(&decoder, global)?);
    let raw_bytes = all.iter().map(|kind| kind.raw_bytes).sum();
    let lowest_db = |total: compare::SampleTotal| total.lowest_cell.map_or(f64::INFINITY, |(_, lowest)| lowest.value);
    let lowest_quality = |total: compare::SampleTotal| total.lowest_quality.map(|(_, lowest)| lowest.value);
    let report = Report {
        bytes,
        raw_bytes,
        ratio_percent: percent(bytes, raw_bytes),
        frames: all.iter().map(|kind| kind.frames).sum(),
        kinds: all,
        depth: DepthReport { max_error_codes: comparison.depth().map(|(errors, _)| errors.max_error_codes) },
        color: ColorReport {
            min_quality: comparison.color().and_then(lowest_quality),
            min_psnr_db: comparison.color().map(lowest_db).map(Number),
        },
        seconds: Seconds { capture, encode, decode },
        commands: places.commands(&settings),
    };
    output::print_either(args.json, &report, || report.text(&places))?;
    let passed = report.keeps(&settings) && comparison.missing.is_empty();
    Ok(if passed { ExitStatus::Passed } else { ExitStatus::Failed })
}

fn capture(args: &Args, path: &Path, global: &GlobalArgs) -> Result<()> {
    let plan =
        FootagePlan { kind: DemoKind::Street, frames: args.frame_count, face_size: args.size, probes: args.probes };
    let plan = CapturePlan { samples: SAMPLES, ..plan.capture()? };
    let progress = Progress::start(global, "capturing", plan.image_count())?;
    plan.write(&Scene::Procedural(DemoScene::new(DemoKind::Street)), path, &progress).map(drop)
}

fn decode(decoder: &Decoder, path: &Path, global: &GlobalArgs) -> Result<()> {
    let chosen = Selection::default().choose(decoder)?;
    let progress = Progress::start(global, "decoding", chosen.iter().map(|part| part.frames.count()).sum())?;
    let request = decode::Request::all(&chosen);
    let export =
        Export { source: &OnCpu::default(), decoder, request, coding: FileCoding::default(), progress: &progress };
    export.write_into(path, |folder| Destination::Dataset(folder.to_path_buf())).map(drop)
}

fn compare(places: &Places, global: &GlobalArgs) -> Result<Comparison> {
    let paths = [&places.scene, &places.decoded].map(|path| path.to_string_lossy());
    let sides = compare::open_both([&paths[0], &paths[1]], &SideOptions::default())?;
    // The scene's bright lamps are clipped, also by the printed commands.
    let settings = CompareSettings { ssim: SsimFrames::None, allow_clipping: true, ..CompareSettings::default() };
    let pairing = Pairing::new(&sides, settings.coverage)?;
    let progress = Progress::start(global, "comparing", pairing.images())?;
    compare::compare(&pairing, &settings, &progress)
}

/// Measures sizes in the container, and decoding times without writing files.
fn measure(decoder: &Decoder, global: &GlobalArgs) -> Result<Vec<KindReport>> {
    let streams: Vec<&StreamInfo> = decoder.streams().iter().collect();
    let images: u64 = streams.iter().map(|stream| stream.frames.count()).sum();
    let progress = Progress::start(global, "measuring", inspect::steps(decoder, &streams) + images)?;
    let settings = InspectSettings::default();
    let inspection = inspect::inspect(decoder, &streams, settings, &progress)?;
    let mut rows = Vec::new();
    for kind in StreamKind::ALL.into_iter().filter(|kind| streams.iter().any(|stream| stream.kind == *kind)) {
        let chosen = Selection { kinds: vec![kind], ..Selection::default() }.choose(decoder)?;
        let start = Instant::now();
        let summary = decode::decode_units(decoder, decode::Request::all(&chosen), OnDamage::Stop, &progress)?.summary;
        let seconds = start.elapsed().as_secs_f64().max(1e-9);
        let totals = inspection.totals(Some(kind));
        rows.push(KindReport {
            kind: kind.name(),
            streams: totals.streams,
            frames: totals.frames,
            raw_bytes: totals.raw_bytes,
            temporal_bytes: totals.temporal_bytes,
            ratio_percent: percent(totals.temporal_bytes, totals.raw_bytes),
            decode_megapixels_per_second: summary.pixels as f64 / 1e6 / seconds,
        });
    }
    Ok(rows)
}

impl Report {
    fn keeps(&self, settings: &EncodeSettings) -> bool {
        let depth = self.depth.max_error_codes.is_none_or(|codes| codes <= depth_bound(settings));
        // The last digit may differ between the encoder and `diff`.
        depth && self.color.min_quality.is_none_or(|quality| quality >= settings.search.target.min_quality() - 1e-6)
    }

    fn text(&self, places: &Places) -> String {
        let mut table = Table::new("Kind|>Streams|>Images|>Raw|>Temporal|>%|>Max error|>Min quality|>Decoding");
        for row in &self.kinds {
            let error = self.depth.max_error_codes.filter(|_| row.kind == StreamKind::Depth.name());
            let quality = self.color.min_quality.filter(|_| row.kind == StreamKind::Color.name());
            table.row([
                row.kind.to_owned(),
                row.streams.to_string(),
                row.frames.to_string(),
                human_bytes(row.raw_bytes),
                human_bytes(row.temporal_bytes),
                format!("{:.2}", row.ratio_percent),
                error.map_or_else(String::new, |codes| format!("{codes} codes")),
                quality.map_or_else(String::new, |quality| format!("{quality:.1}")),
                format!("{:.0} MPix/s", row.decode_megapixels_per_second),
            ]);
        }
        let Seconds { capture, encode, decode } = self.seconds;
        format!(
            "{table}\n{}: {} of {} raw ({:.2}%)\n\
             captured in {capture:.2} s, encoded in {encode:.2} s, decoded into files in {decode:.2} s\n\n\
             The same, step by step:\n  {}\n",
            places.container.display(),
            human_bytes(self.bytes),
            human_bytes(self.raw_bytes),
            self.ratio_percent,
            self.commands.join("\n  "),
        )
    }
}

fn depth_bound(settings: &EncodeSettings) -> u16 {
    match settings.depth.error {
        ErrorBound::Codes(codes) => codes.saturating_add(settings.temporal.epsilon),
        // Not used by the demo.
        ErrorBound::Relative(_) => settings.temporal.epsilon,
    }
}
