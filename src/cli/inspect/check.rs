//! `inspect --check`: whether a dataset is what its manifest says.

use std::fmt::Write;
use std::time::Instant;

use serde_json::{Map, Value, json};

use super::Args;
use crate::cli::options::is_dataset;
use crate::cli::output::json_number;
use crate::cli::progress::Progress;
use crate::cli::{ExitStatus, GlobalArgs, output, with_option_names};
use crate::convention::{self, Choice, Finding, MAX_PROBES, Report, Verdict};
use crate::dataset::Source;
use crate::error::{Error, Result};
use crate::report::table::{Column, Table};

/// Lines of text are no longer.
const COLUMNS: u16 = 100;

/// Checks, reports, and answers [`ExitStatus::Failed`] where something is suspected.
pub fn run(args: &Args, global: &GlobalArgs) -> Result<ExitStatus> {
    if !is_dataset(&args.input) {
        let message = "--check compares a lightfield.json, or the folder that holds one, with its files".to_owned();
        return Err(Error::Usage(format!("{}: {message}", args.input.display())));
    }
    if !args.selection.face.is_empty() || !args.selection.stream.is_empty() {
        return Err(Error::Usage("--check looks at all faces and kinds: only --probe and --frame choose".into()));
    }
    if args.memory.memory.is_some() {
        let message = "--memory does not bound --check, which holds one image for each thread and at most 65,536 samples of \
                       every face: leave it out, or choose fewer probes with --probe";
        return Err(Error::Usage(message.into()));
    }
    let start = Instant::now();
    let options = args.reading.options(args.selection.with(None))?.source;
    let source = Source::open(&args.input, &options)?;
    let choice = Choice {
        probes: args.selection.probe.clone(),
        max_probes: if args.selection.probe.is_empty() { MAX_PROBES } else { usize::MAX },
        frame: args.frame,
    };
    let progress = Progress::start(global, "checking", convention::steps(&source, &choice)?)?;
    let report = convention::check(&source, &choice, &progress)?;
    drop(progress);
    if args.json {
        let mut value = json_report(&report);
        value["name"] = json!(source.name());
        value["seconds"] = json_number(start.elapsed().as_secs_f64());
        output::print_json(&value)?;
    } else {
        output::print_text(&text(source.name(), &report))?;
    }
    Ok(if report.suspects() { ExitStatus::Failed } else { ExitStatus::Passed })
}

fn json_report(report: &Report) -> Value {
    let check = |finding: &Finding| {
        let figures: Map<String, Value> =
            finding.figures.iter().map(|(name, value)| ((*name).to_owned(), json_number(*value))).collect();
        json!({
            "check": finding.check,
            "verdict": finding.verdict.name(),
            "says": with_option_names(&finding.says),
            "figures": figures,
        })
    };
    json!({
        "suspect": report.suspects(),
        "probes": report.probes,
        "all_probes": report.all_probes,
        "images": report.images,
        "checks": report.findings.iter().map(check).collect::<Vec<_>>(),
    })
}

fn text(name: &str, report: &Report) -> String {
    let mut out = format!("{name}: {} of {} probes, {} images\n\n", report.probes, report.all_probes, report.images);
    let mut table = Table::new(&[Column::Left("Check"), Column::Left("Verdict"), Column::Left("Why")]).wrapped(COLUMNS);
    for finding in &report.findings {
        let verdict = match finding.verdict {
            Verdict::Fine => "fine",
            Verdict::Suspect => "SUSPECT",
            Verdict::CannotTell => "cannot tell",
        };
        table.row([finding.check.to_owned(), verdict.to_owned(), with_option_names(&finding.says)]);
    }
    let suspects = report.findings.iter().filter(|finding| finding.verdict == Verdict::Suspect).count();
    let _ = match suspects {
        0 => writeln!(out, "{table}\nNothing is suspected."),
        1 => writeln!(out, "{table}\nOne check suspects that the manifest or the files are wrong."),
        count => writeln!(out, "{table}\n{count} checks suspect that the manifest or the files are wrong."),
    };
    out
}
