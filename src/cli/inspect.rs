//! `lightfold inspect IN`: sizes and contents of a container, a scene or a Seurat manifest; checks of containers and
//! manifests.

mod args;
mod check;
mod plot;
mod scene;
mod seurat;
mod text;

use serde::Serialize;

use crate::options::WithAccount;
use crate::progress::Progress;
use crate::{ExitStatus, GlobalArgs, output, refuse, report};
use codec::decode::{Decoder, StreamInfo};
use codec::error::{Error, Result, counted};
use footage::dataset::manifest;
use footage::dataset::seurat::is_manifest as is_seurat_manifest;
use footage::inspect::{self, Check, ChunksReport, ContainerReport, FrameReport, FrameRows, InspectSettings};
pub use scene::Scene;

pub use args::Args;
use args::Report;

/// Columns of `--csv`: keys of a stream's report; a dot precedes a nested key.
const STREAM_COLUMNS: &str = "kind probe face frames first_frame width height codec bytes raw_bytes ratio_percent \
    temporal_bytes payload_bytes stored_bytes chunks lzma2_chunks zstd_chunks units unit_width unit_height keyframes \
    keyframes_per_cell.min keyframes_per_cell.mean keyframes_per_cell.max static_cells static_tiles constant_units aabbs \
    updated_pixels updated_percent error_bound_codes max_error_percent near_m far_m background depth_kind window max_aabbs \
    keyframe_interval min_psnr_db transfer exposure_ev white_cd_m2 keyframes_blocks keyframes_raw pieces.blocks pieces.raw";

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

pub fn run(args: &Args, global: &GlobalArgs) -> Result<ExitStatus> {
    if args.check {
        return check::run(args, global);
    }
    if let Some(name) = args.input.to_str().filter(|name| Scene::is_named_by(name)) {
        return scene::run(args, name, global);
    }
    if is_seurat_manifest(&args.input) {
        return seurat::run(args, global);
    }
    if manifest::is_dataset(&args.input) {
        return refuse(format!(
            "{}: this is a dataset, not a container: use --check to check it",
            args.input.display()
        ));
    }
    plot::check(args)?;
    let decoder = Decoder::open(&args.input)?;
    let selection = args.selection.with(None);
    let streams: Vec<&StreamInfo> = selection.choose(&decoder)?.into_iter().map(|part| part.stream).collect();
    let settings = InspectSettings {
        rows: match (args.per_frame, args.frames) {
            (true, None) => FrameRows::All,
            (true, Some(range)) => FrameRows::Range(range),
            (false, None) => FrameRows::None,
            (false, Some(range)) => {
                return refuse(format!("--frames {range} needs --per-frame"));
            }
        },
        check: if args.verify { Check::ListAll } else { Check::StopAtFirst },
        memory: args.memory.get(),
    };
    let account = inspect::account(&decoder, &streams);
    let progress = Progress::start(global, "inspecting", inspect::steps(&decoder, &streams))?;
    let inspection = inspect::inspect(&decoder, &streams, settings, &progress)?;
    drop(progress);
    let report = Report { args, decoder: &decoder, inspection: &inspection };
    // Damaged containers are not drawn.
    let plots = match &args.plot {
        Some(folder) if inspection.damaged.is_empty() => Some(plot::write(folder, &report, global)?),
        _ => None,
    };
    if args.json {
        let document = Document {
            container: inspection.report(&decoder),
            verify: args.verify.then(|| inspection.chunks_report(&decoder)),
            frame_rows: args.per_frame.then(|| inspection.frame_reports(&decoder)),
            plots: plots.as_deref(),
        };
        output::print_json(&output::with_memory(WithAccount { report: document, account: &account }))?;
    } else if args.csv {
        output::print_text(&if args.per_frame {
            report::csv::of_rows(&inspection.frame_reports(&decoder))?
        } else {
            let columns: Vec<&str> = STREAM_COLUMNS.split(' ').collect();
            report::csv::of_objects(&columns, &inspection.stream_reports(&decoder))?
        })?;
    } else if inspection.damaged.is_empty() {
        output::print_text(&if args.per_frame { text::frames(&report) } else { text::summary(&report) })?;
    }
    if let (Some(plots), Some(folder)) = (&plots, &args.plot) {
        let written = plot::text(args, folder, plots);
        match (args.json, args.csv) {
            (true, _) => {}
            (false, true) => output::note(written.trim_end()),
            (false, false) => output::print_text(&format!("\n{written}"))?,
        }
    }
    args.account.print_inspected(&account, args.json, global);
    if args.verify { verdict(&report) } else { Ok(ExitStatus::Passed) }
}

/// Lists damaged chunks, unless JSON contains them. Fails if there are any.
fn verdict(report: &Report<'_>) -> Result<ExitStatus> {
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
    let all = counted(chunks, "chunk");
    Err(Error::invalid(format!("damaged: {damaged} of {all}; copy or encode the file again"))
        .in_file(&report.args.input))
}
