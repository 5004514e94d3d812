//! `lightfold demo`: captures, encodes, decodes and compares a built-in scene.

use std::path::{Path, PathBuf};
use std::time::Instant;

use serde_json::json;

use crate::cli::output::{self, human_bytes, json_number};
use crate::cli::progress::Progress;
use crate::cli::{ExitStatus, GlobalArgs};
use crate::compare::{self, CompareSettings, Comparison, Pairing, SideOptions, SsimFrames};
use crate::dataset::source::{Source, SourceOptions};
use crate::decode::{self, Decoder, Destination, FileFormat, OnCpu, OnDamage, Selection, StreamInfo};
use crate::encode::{self, EncodeSettings, ErrorBound};
use crate::error::Result;
use crate::files::{OutputFile, OutputFolder};
use crate::image::StreamKind;
use crate::inspect::{self, InspectSettings, Totals};
use crate::report::tradeoff::runner::shell_word;
use crate::report::{Column, Table};
use crate::scene::{CapturePlan, DemoKind, DemoScene, ExistingImages, FootagePlan, Scene};

/// Arguments.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  lightfold demo\n  lightfold demo -o out/demo --frame-count 48 --size 256 --json\n\n\
    Captures a procedural courtyard into DIR/scene, encodes it to DIR/demo.lfold, decodes that into DIR/decoded and \
    compares the two. The same options write the same bytes on every run. The exit code is 1 if the errors exceed the \
    bounds of the encoder."
)]
pub struct Args {
    /// Folder to write into
    #[arg(long, short, value_name = "DIR", default_value = "lightfold-demo")]
    pub output: PathBuf,
    /// Number of frames, 24 a second; the scene repeats after 96
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

/// Samples of a pixel's colour: a quarter of the default, for a short capture.
const SAMPLES: u32 = 4;

/// Output paths.
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

    /// Equivalent commands for the steps after the capture.
    fn commands(&self, settings: &EncodeSettings) -> [String; 4] {
        let word = |path: &PathBuf| shell_word(&path.display().to_string());
        let [scene, container, decoded] = [&self.scene, &self.container, &self.decoded].map(word);
        [
            format!("lightfold encode {scene} -o {container}"),
            format!("lightfold inspect {container}"),
            format!("lightfold decode {container} -o {decoded}"),
            format!(
                "lightfold diff {scene} {decoded} --max-error {} --min-cell-psnr {}",
                depth_bound(settings),
                settings.search.min_psnr_db
            ),
        ]
    }
}

/// Figures of one kind of streams.
struct KindRow {
    kind: StreamKind,
    totals: Totals,
    decode_megapixels_per_second: f64,
}

/// Figures of the demo.
struct Report {
    rows: Vec<KindRow>,
    all: Totals,
    file_bytes: u64,
    comparison: Comparison,
    /// Of capturing, encoding, and decoding with files.
    seconds: [f64; 3],
}

/// Runs the demo.
pub fn run(args: &Args, global: &GlobalArgs) -> Result<ExitStatus> {
    let places = Places::below(&args.output);
    let settings = EncodeSettings::default();
    let start = Instant::now();
    capture(args, &places.scene, global)?;
    let captured = start.elapsed();
    encode(&places, &settings, global)?;
    let encoded = start.elapsed();
    let decoder = Decoder::open(&places.container)?;
    decode(&decoder, &places.decoded, global)?;
    let seconds = [captured, encoded - captured, start.elapsed() - encoded].map(|time| time.as_secs_f64());
    let comparison = compare(&places, global)?;
    let (rows, all) = measure(&decoder, global)?;
    let report = Report { rows, all, file_bytes: decoder.reader().file_bytes(), comparison, seconds };
    let commands = places.commands(&settings);
    if args.json {
        output::print_json(&report.json(&commands))?;
    } else {
        output::print_text(&report.text(&places, &commands))?;
    }
    Ok(if report.keeps(&settings) { ExitStatus::Passed } else { ExitStatus::Failed })
}

fn capture(args: &Args, path: &Path, global: &GlobalArgs) -> Result<()> {
    let plan =
        FootagePlan { kind: DemoKind::Courtyard, frames: args.frame_count, face_size: args.size, probes: args.probes };
    let plan = CapturePlan { samples: SAMPLES, ..plan.capture()? };
    let progress = Progress::start(global, "capturing", plan.image_count())?;
    let folder = OutputFolder::create(path)?;
    let scene = Scene::Procedural(DemoScene::new(DemoKind::Courtyard));
    plan.write(&scene, folder.work_path(), ExistingImages::Overwrite, &progress)?;
    folder.commit()
}

fn encode(places: &Places, settings: &EncodeSettings, global: &GlobalArgs) -> Result<()> {
    let source = Source::open(&places.scene, &SourceOptions::default())?;
    let images = source.groups().iter().map(|group| group.frames.count()).sum();
    let progress = Progress::start(global, "encoding", images)?;
    let path = &places.container;
    let file = OutputFile::create(path)?;
    let (mut file, _) = encode::encode(&source, settings, file, &progress).map_err(|error| error.in_file(path))?;
    file.commit()
}

fn decode(decoder: &Decoder, path: &Path, global: &GlobalArgs) -> Result<()> {
    let chosen = Selection::default().choose(decoder)?;
    let progress = Progress::start(global, "decoding", chosen.iter().map(|part| part.frames.count()).sum())?;
    let folder = OutputFolder::create(path)?;
    let destination = Destination::Dataset(folder.work_path().to_path_buf());
    let request = decode::Request::all(&chosen);
    decode::decode_to_files(&OnCpu::default(), decoder, request, &destination, FileFormat::Exr, &progress)?;
    folder.commit()
}

fn compare(places: &Places, global: &GlobalArgs) -> Result<Comparison> {
    let paths = [&places.scene, &places.decoded].map(|path| path.to_string_lossy());
    let sides = compare::open_both([&paths[0], &paths[1]], &SideOptions::default())?;
    let settings = CompareSettings { ssim: SsimFrames::None, ..CompareSettings::default() };
    let pairing = Pairing::new(&sides, settings.coverage)?;
    let progress = Progress::start(global, "comparing", pairing.images())?;
    compare::compare(&pairing, &settings, &progress)
}

/// Sizes from the container, and decoding times without writing files.
fn measure(decoder: &Decoder, global: &GlobalArgs) -> Result<(Vec<KindRow>, Totals)> {
    let streams: Vec<&StreamInfo> = decoder.streams().iter().collect();
    let progress = Progress::start(global, "measuring", inspect::steps(decoder, &streams))?;
    let settings = InspectSettings::default();
    let inspection = inspect::inspect(decoder, &streams, settings, &progress)?;
    let mut rows = Vec::new();
    for kind in StreamKind::ALL.into_iter().filter(|kind| streams.iter().any(|stream| stream.kind == *kind)) {
        let chosen = Selection { kinds: vec![kind], ..Selection::default() }.choose(decoder)?;
        let start = Instant::now();
        let summary = decode::decode_units(decoder, decode::Request::all(&chosen), OnDamage::Stop, &progress)?.summary;
        let seconds = start.elapsed().as_secs_f64().max(1e-9);
        rows.push(KindRow {
            kind,
            totals: inspection.totals(Some(kind)),
            decode_megapixels_per_second: summary.pixels as f64 / 1e6 / seconds,
        });
    }
    Ok((rows, inspection.totals(None)))
}

impl Report {
    fn max_error_codes(&self) -> Option<u16> {
        self.comparison.depth().map(|(errors, _)| errors.max_error_codes)
    }

    /// The lowest PSNR of any frame of any cell, in dB.
    fn min_psnr_db(&self) -> Option<f64> {
        self.comparison.color().map(|total| total.lowest_cell.map_or(f64::INFINITY, |(_, lowest)| lowest.psnr_db))
    }

    /// Whether errors are within the bounds of the encoder.
    fn keeps(&self, settings: &EncodeSettings) -> bool {
        let depth = self.max_error_codes().is_none_or(|codes| codes <= depth_bound(settings));
        // The encoder and diff may differ in the last digit.
        let color = self.min_psnr_db().is_none_or(|db| db >= settings.search.min_psnr_db - 1e-6);
        depth && color && self.comparison.missing.is_empty()
    }

    fn text(&self, places: &Places, commands: &[String]) -> String {
        let mut table = Table::new(&[
            Column::Left("Kind"),
            Column::Right("Streams"),
            Column::Right("Images"),
            Column::Right("Raw"),
            Column::Right("Temporal"),
            Column::Right("%"),
            Column::Right("Max error"),
            Column::Right("Min PSNR"),
            Column::Right("Decoding"),
        ]);
        for row in &self.rows {
            let error = self.max_error_codes().filter(|_| row.kind == StreamKind::Depth);
            let psnr = self.min_psnr_db().filter(|_| row.kind == StreamKind::Color);
            table.row([
                row.kind.name().to_owned(),
                row.totals.streams.to_string(),
                row.totals.frames.to_string(),
                human_bytes(row.totals.raw_bytes),
                human_bytes(row.totals.temporal_bytes),
                format!("{:.2}", percent(row.totals.temporal_bytes, row.totals.raw_bytes)),
                error.map_or_else(String::new, |codes| format!("{codes} codes")),
                psnr.map_or_else(String::new, |db| format!("{db:.2} dB")),
                format!("{:.0} MPix/s", row.decode_megapixels_per_second),
            ]);
        }
        let [captured, encoded, decoded] = self.seconds;
        format!(
            "{table}\n{}: {} of {} raw ({:.2}%)\n\
             captured in {captured:.2} s, encoded in {encoded:.2} s, decoded into files in {decoded:.2} s\n\n\
             The same, step by step:\n  {}\n",
            places.container.display(),
            human_bytes(self.file_bytes),
            human_bytes(self.all.raw_bytes),
            percent(self.file_bytes, self.all.raw_bytes),
            commands.join("\n  "),
        )
    }

    fn json(&self, commands: &[String]) -> serde_json::Value {
        let kind = |row: &KindRow| {
            json!({
                "kind": row.kind.name(),
                "streams": row.totals.streams,
                "frames": row.totals.frames,
                "raw_bytes": row.totals.raw_bytes,
                "temporal_bytes": row.totals.temporal_bytes,
                "ratio_percent": percent(row.totals.temporal_bytes, row.totals.raw_bytes),
                "decode_megapixels_per_second": row.decode_megapixels_per_second,
            })
        };
        let [captured, encoded, decoded] = self.seconds;
        json!({
            "bytes": self.file_bytes,
            "raw_bytes": self.all.raw_bytes,
            "ratio_percent": percent(self.file_bytes, self.all.raw_bytes),
            "frames": self.all.frames,
            "kinds": self.rows.iter().map(kind).collect::<Vec<_>>(),
            "depth": { "max_error_codes": self.max_error_codes() },
            "color": { "min_psnr_db": self.min_psnr_db().map(json_number) },
            "seconds": { "capture": captured, "encode": encoded, "decode": decoded },
            "commands": commands,
        })
    }
}

/// Error bound of depth in codes.
fn depth_bound(settings: &EncodeSettings) -> u16 {
    match settings.depth.error {
        ErrorBound::Codes(codes) => codes.saturating_add(settings.temporal.epsilon),
        // Not used by the demo.
        ErrorBound::Relative(_) => settings.temporal.epsilon,
    }
}

fn percent(part: u64, whole: u64) -> f64 {
    100.0 * part as f64 / whole.max(1) as f64
}
