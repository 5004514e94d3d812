//! `lightfold inspect IN`: what a container holds, what it costs, and whether it is sound; whether a dataset is what its
//! manifest says; what a scene is made of.

mod check;
mod columns;
mod plot;
mod scene;
mod text;

use std::path::PathBuf;

use serde::Serialize;

use crate::cli::options::{self, MemoryArgs, SelectionArgs, SideArgs, is_dataset};
use crate::cli::progress::Progress;
use crate::cli::{ExitStatus, GlobalArgs, output};
use crate::decode::{Decoder, StreamInfo};
use crate::error::{Error, Result};
use crate::image::sequence::FrameRange;
use crate::inspect::container::{self, Check, FrameRows, InspectSettings, Inspection};
use crate::inspect::report::{ChunksReport, ContainerReport, FrameReport};
use crate::report;
use crate::scene::Scene;

use columns::STREAM_COLUMNS;

/// Arguments.
#[derive(Debug, clap::Args)]
#[command(
    group = clap::ArgGroup::new("looks").args(["plot", "check"]),
    after_help = "Sizes are compared with raw footage of 32-bit depth and 24-bit colour. Temporal: after the coding in time, \
    before LZMA2.\nKeys: keyframes of all cells or tiles. AABBs: boxes of all frames. Upd. %: pixels written when all \
    frames are shown in order.\nStatic: cells or tiles that never change. Empty: tiles of one value in every frame.\n\n\
    Of a scene (glTF, GLB, OBJ, or built in) it tells bounds in metres, triangles, materials and lights at the beginning, and \
    animations.\n\n\
    --check reads one frame of up to 16 probes. It answers fine, SUSPECT or cannot tell for the order and orientation of \
    cube faces, planar depth or distance, scale, positions, orientations, near, far, background, and colour. \
    With --check the exit code is 1 where something is suspected.\n\n\
    Examples:\n  lightfold inspect film.lfold\n  lightfold inspect film.lfold --stream depth --streams\n  \
    lightfold inspect film.lfold --per-frame --frames 10-19 --csv > frames.csv\n  \
    lightfold inspect film.lfold --verify --json\n  \
    lightfold inspect film.lfold --plot pictures --source lightfield.json --probe 00\n  \
    lightfold inspect scene.glb\n  lightfold inspect lightfield.json --check\n  lightfold inspect lightfield.json --check --depth-kind planar --json"
)]
pub struct Args {
    /// The container, - for standard input; a scene, as `capture` takes it; with --check a lightfield.json or its folder
    #[arg(value_name = "IN")]
    pub input: PathBuf,
    /// Streams.
    #[command(flatten)]
    pub selection: SelectionArgs,
    /// One row for every stream, also where there are many; else they are summed up for each probe and kind
    #[arg(long)]
    pub streams: bool,
    /// One row for every frame of every stream
    #[arg(long)]
    pub per_frame: bool,
    /// With --per-frame, only rows of these frames, such as 10-99 or 12
    ///
    /// Without a value it is the older form of --per-frame.
    #[arg(long, value_name = "A-B", num_args = 0..=1, value_parser = options::parse_frames, help = "With --per-frame, only rows of these frames, such as 10-99 or 12")]
    pub frames: Option<Option<FrameRange>>,
    /// The older form of --frames A-B.
    #[arg(long, value_name = "A-B", hide = true, conflicts_with = "per_frame", value_parser = options::parse_frames)]
    pub range: Option<FrameRange>,
    /// Check every chunk: CRC-32, decompression by two decoders, structure; list all that are damaged
    #[arg(long)]
    pub verify: bool,
    /// Compare what a manifest says with what its files show, and say what is suspected to be wrong
    #[arg(long, conflicts_with_all = ["streams", "per_frame", "frames", "verify", "csv", "source"])]
    pub check: bool,
    /// Report as JSON
    #[arg(long, conflicts_with = "csv")]
    pub json: bool,
    /// Report as CSV: a row for each stream, or with --per-frame for each frame
    #[arg(long)]
    pub csv: bool,
    /// Write pictures of what each stream is made of into this folder, as PNG
    #[arg(long, value_name = "DIR")]
    pub plot: Option<PathBuf>,
    /// Memory.
    #[command(flatten)]
    pub memory: MemoryArgs,
    /// With --plot, the frame [default: the first one, and the one that changes most]; with --check [default: the first]
    #[arg(long, value_name = "N", requires = "looks")]
    pub frame: Option<u32>,
    /// With --plot, what the container was made of, for pictures of the error: a lightfield.json or its folder, a sequence
    #[arg(long, value_name = "SOURCE", requires = "plot")]
    pub source: Option<String>,
    /// How the source is read.
    #[command(flatten)]
    pub reading: SideArgs,
}

impl Args {
    fn is_per_frame(&self) -> bool {
        self.per_frame || matches!(self.frames, Some(None))
    }

    fn frame_range(&self) -> Option<FrameRange> {
        self.frames.flatten().or(self.range)
    }
}

/// Everything that the reports speak of.
struct Report<'a> {
    args: &'a Args,
    decoder: &'a Decoder,
    inspection: &'a Inspection<'a>,
}

/// The JSON report.
#[derive(Serialize)]
struct Document<'a> {
    #[serde(flatten)]
    container: ContainerReport<'a>,
    #[serde(skip_serializing_if = "Option::is_none")]
    verify: Option<ChunksReport<'a>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    frame_rows: Option<Vec<FrameReport<'a>>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    plots: Option<&'a [plot::PlotOut<'a>]>,
}

/// Inspects.
pub fn run(args: &Args, global: &GlobalArgs) -> Result<ExitStatus> {
    if args.check {
        return check::run(args, global);
    }
    if let Some(name) = args.input.to_str().filter(|name| Scene::is_named_by(name)) {
        return scene::run(args, name, global);
    }
    if is_dataset(&args.input) {
        return Err(Error::Usage(format!(
            "{}: a dataset, and no container yet; --check looks whether its files are what its manifest says",
            args.input.display()
        )));
    }
    plot::check(args)?;
    let decoder = Decoder::open(&args.input)?;
    let selection = args.selection.with(None);
    let streams: Vec<&StreamInfo> = selection.choose(&decoder)?.into_iter().map(|part| part.stream).collect();
    let settings = InspectSettings {
        rows: match (args.is_per_frame(), args.frame_range()) {
            (true, None) => FrameRows::All,
            (true, Some(range)) => FrameRows::Range(range),
            (false, None) => FrameRows::None,
            (false, Some(range)) => {
                return Err(Error::Usage(format!("--frames {range} selects rows of --per-frame: add --per-frame")));
            }
        },
        check: if args.verify { Check::ListAll } else { Check::StopAtFirst },
        memory: args.memory.get(),
    };
    let progress = Progress::start(global, "inspecting", container::steps(&decoder, &streams))?;
    let inspection = container::inspect(&decoder, &streams, settings, &progress)?;
    drop(progress);
    let report = Report { args, decoder: &decoder, inspection: &inspection };
    // Of a damaged container there is no picture: the verdict is what counts.
    let plots = match &args.plot {
        Some(folder) if inspection.damaged.is_empty() => Some(plot::write(folder, &report, global)?),
        _ => None,
    };
    if args.json {
        output::print_report(&Document {
            container: inspection.report(&decoder),
            verify: args.verify.then(|| inspection.chunks_report(&decoder)),
            frame_rows: args.is_per_frame().then(|| inspection.frame_reports(&decoder)),
            plots: plots.as_deref(),
        })?;
    } else if args.csv {
        output::print_text(&if args.is_per_frame() {
            report::csv::of_rows(&inspection.frame_reports(&decoder))?
        } else {
            report::csv::of_objects(STREAM_COLUMNS, &inspection.stream_reports(&decoder))?
        })?;
    } else if inspection.damaged.is_empty() {
        output::print_text(&if args.is_per_frame() { text::frames(&report) } else { text::summary(&report) })?;
    }
    if let (Some(plots), Some(folder)) = (&plots, &args.plot) {
        let written = plot::text(args, folder, plots);
        match (args.json, args.csv) {
            (true, _) => {}
            (false, true) => output::note(written.trim_end()),
            (false, false) => output::print_text(&format!("\n{written}"))?,
        }
    }
    if args.verify { tell_verdict(&report) } else { Ok(ExitStatus::Passed) }
}

/// Lists what is damaged, where JSON has not done so, and makes it an error.
fn tell_verdict(report: &Report<'_>) -> Result<ExitStatus> {
    let damaged = report.inspection.damaged.len();
    if report.args.csv {
        output::note(text::verdict(report).trim_end());
    } else if !report.args.json {
        output::print_text(&text::verdict(report))?;
    }
    if damaged == 0 {
        return Ok(ExitStatus::Passed);
    }
    let chunks = report.inspection.totals(None).chunks;
    Err(Error::invalid(format!("{damaged} of {chunks} chunks are damaged: copy or encode the file again"))
        .in_file(&report.args.input))
}

impl Report<'_> {
    fn probe_name(&self, stream: &StreamInfo) -> &str {
        &self.decoder.probe(stream).name
    }
}
