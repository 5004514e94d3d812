//! `inspect --check`: compares a manifest with its files.

use std::fmt::Write;
use std::time::Instant;

use serde::Serialize;

use super::args::Args;
use crate::depth_bound::stray_words;
use crate::options::WithAccount;
use crate::output::{self, with_option_names};
use crate::progress::Progress;
use crate::report::Table;
use crate::{ExitStatus, GlobalArgs, refuse};
use codec::error::Result;
use footage::convention::{self, Choice, MAX_PROBES, Report, Verdict};
use footage::dataset::{Source, manifest};
use footage::encode::{self, ProbePrecision};

/// Maximum number of characters of a line of text.
const COLUMNS: u16 = 100;

#[derive(Serialize)]
struct Document<'a> {
    name: &'a str,
    suspect: bool,
    #[serde(flatten)]
    report: &'a Report,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    depth_strays: &'a Vec<ProbePrecision>,
    seconds: f64,
}

pub fn run(args: &Args, global: &GlobalArgs) -> Result<ExitStatus> {
    if !manifest::is_dataset(&args.input) {
        return refuse(format!("{}: --check needs a lightfield.json or its folder", args.input.display()));
    }
    if !args.selection.face.is_empty() || !args.selection.stream.is_empty() {
        return refuse("--check uses all faces and kinds: select with --probe and --frame only");
    }
    if args.memory.memory.is_some() {
        return refuse(
            "--memory does not apply to --check, which keeps one image per thread and up to 65,536 samples of each \
            face: leave it out; fewer probes (--probe) need less memory",
        );
    }
    let start = Instant::now();
    let options = args.reading.options(args.selection.with(None))?.source;
    let source = Source::open(&args.input, &options)?;
    let choice = Choice {
        probes: args.selection.probe.clone(),
        max_probes: if args.selection.probe.is_empty() { MAX_PROBES } else { usize::MAX },
        frame: args.frame,
    };
    let account = source.account()?;
    let check = || {
        let progress = Progress::start(global, "checking", convention::steps(&source, &choice)?)?;
        convention::check(&source, &choice, &progress)
    };
    let mut report = args.account.print_if_failed(check(), &account, global)?;
    report.findings.iter_mut().for_each(|finding| finding.says = with_option_names(&finding.says));
    let strays =
        report.spreads.iter().filter_map(|(probe, spread)| encode::strays_of(&source, *probe, spread)).collect();
    let document = Document {
        name: source.name(),
        suspect: report.suspects(),
        report: &report,
        depth_strays: &strays,
        seconds: start.elapsed().as_secs_f64(),
    };
    let document = WithAccount { report: document, account: &account };
    output::print_either(args.json, &document, || text(source.name(), &report, &strays))?;
    args.account.print_inspected(&account, args.json, global);
    Ok(if report.suspects() { ExitStatus::Failed } else { ExitStatus::Passed })
}

fn text(name: &str, report: &Report, strays: &[ProbePrecision]) -> String {
    let mut out = format!("{name}: {}\n\n", report.extent());
    let mut table = Table::new("Check|Verdict|Why").wrapped(COLUMNS);
    for finding in &report.findings {
        let verdict = match finding.verdict {
            Verdict::Fine => "fine",
            Verdict::Suspect => "SUSPECT",
            Verdict::CannotTell => "cannot tell",
        };
        table.row([finding.check.to_owned(), verdict.to_owned(), finding.says.clone()]);
    }
    let suspects = report.findings.iter().filter(|finding| finding.verdict == Verdict::Suspect).count();
    let _ = match suspects {
        0 => writeln!(out, "{table}\nNo check is suspect."),
        1 => writeln!(out, "{table}\nOne check is suspect: the manifest or the files may be wrong."),
        count => writeln!(out, "{table}\n{count} checks are suspect: the manifest or the files may be wrong."),
    };
    for probe in strays {
        let _ = probe.strays.iter().try_for_each(|strays| writeln!(out, "\nwarning: {}", stray_words(probe, strays)));
    }
    out
}
