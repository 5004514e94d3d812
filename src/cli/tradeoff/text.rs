//! Results of sweeps as text.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::PathBuf;

use crate::output;
use crate::report::Table;
use crate::report::tradeoff::findings::{Finding, Verdict};
use crate::report::tradeoff::kind::KINDS;
use crate::report::tradeoff::page;
use crate::report::tradeoff::point::words;
use crate::report::tradeoff::recommend::{Advice, Aim};
use crate::report::tradeoff::study::Results;
use codec::error::Result;
use codec::image::StreamKind;

/// Returns tables of all points, the tested findings, and the written files.
pub fn report(results: &Results, findings: &[Finding], files: &[PathBuf]) -> String {
    // Writing into a string cannot fail.
    let mut text = String::new();
    for stream in results.streams() {
        for study in results.studies.iter().filter(|study| study.stream == stream) {
            if let Some(settings) = words(&study.fixed) {
                let _ = writeln!(text, "{}: all with {settings}", study.title);
            }
        }
        let name = stream.map_or_else(String::new, |stream| format!("{}\n", stream.name()));
        let _ = writeln!(text, "{name}{}", page::table_of(results, stream).text());
    }
    let _ = writeln!(text, "{} {}\n", results.about, results.sweep.method);
    let tested: Vec<_> = findings.iter().filter(|finding| finding.verdict != Verdict::NotMeasured).collect();
    for finding in &tested {
        let agrees = if finding.verdict == Verdict::Found { "agrees" } else { "does not agree" };
        let _ = writeln!(text, "{}\n  This {agrees} with a paper: {}", finding.rests_on, finding.sentence);
    }
    if !tested.is_empty() {
        text.push('\n');
    }
    for path in files {
        let _ = writeln!(text, "{}", path.display());
    }
    text
}

/// Returns the recommended points, or those closest to meeting the demands. `unasked` are kinds of streams without
/// demands.
pub fn advice(advice: &[Advice<'_>], unasked: &[StreamKind]) -> String {
    let mut text = String::new();
    for Advice { row, aim, misses } in advice {
        let point = &row.measured.point;
        let stream = point.stream.map_or("", StreamKind::name);
        let head = match (misses.is_empty(), aim) {
            (true, Aim::Smallest) => "the smallest point that meets all limits has",
            (true, Aim::Closest) => "the point closest to the source that meets all limits (none on quality) has",
            (false, _) => "no point meets all limits; the nearest has",
        };
        let _ = writeln!(text, "{stream}: {head} {}", point.words());
        for miss in misses {
            let _ = writeln!(text, "  misses {miss}");
        }
        let command = match row.command.strip_suffix("point.lfold") {
            Some(start) => format!("{start}{stream}.lfold"),
            None => row.command.clone(),
        };
        let _ = writeln!(text, "  {}\n  {command}", page::measure_words(&row.measured));
        if let Some(device) = point.value("device") {
            let _ = writeln!(text, "  decoded with --device {device}");
        }
    }
    for stream in unasked {
        let quality = match stream {
            StreamKind::Color => "--min-quality, --min-psnr",
            StreamKind::Depth => "--max-error, --max-error-m",
            StreamKind::Material | StreamKind::Alpha => "--max-error",
        };
        let _ =
            writeln!(text, "{}: no limit applies ({quality}, --decode-ms, --max-bytes or --max-ratio)", stream.name());
    }
    if advice.len() > 1 {
        let files = advice.iter().filter_map(|advice| advice.row.measured.point.stream);
        let files: Vec<_> = files.map(|stream| format!("{}.lfold", stream.name())).collect();
        let _ = writeln!(text, "join them: lightfold pack {} -o all.lfold", files.join(" "));
    }
    text
}

pub fn list_knobs(as_json: bool) -> Result<()> {
    let all = || KINDS.iter().flat_map(|kind| kind.knobs.iter().map(move |knob| (kind, knob)));
    let report = BTreeMap::from([("knobs", all().map(|(_, knob)| knob).collect::<Vec<_>>())]);
    output::print_either(as_json, &report, || {
        let mut table = Table::new("Knob|Description|Kinds|Option of|Default|Default values of a sweep");
        for (kind, knob) in all() {
            let of = match (kind.points_of, knob.is_general()) {
                ("", true) => "all".to_owned(),
                ("", false) => knob.streams.iter().map(|stream| stream.name()).collect::<Vec<_>>().join(", "),
                (of, _) => of.to_owned(),
            };
            let cells = [knob.name, knob.label, &of, knob.stage, knob.default, &knob.usual.join(",")];
            table.row(cells.map(str::to_owned));
        }
        table.to_string()
    })
}
