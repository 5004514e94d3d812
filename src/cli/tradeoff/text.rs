//! Reports of sweeps for people.

use std::fmt::Write as _;
use std::path::PathBuf;

use serde_json::json;

use super::Advised;
use crate::cli::output::{self, human_bytes};
use crate::dataset::stream::StreamKind;
use crate::error::Result;
use crate::report::tradeoff::findings::{self, Verdict};
use crate::report::tradeoff::knob::{KNOBS, Stage};
use crate::report::tradeoff::recommend::Aim;
use crate::report::tradeoff::{Measured, Results};
use crate::report::tradeoff::{placement, rendering};
use crate::report::{Column, Table};

/// A column of figures: heading, and a cell of a point.
type FigureColumn = (&'static str, fn(&Measured) -> Option<String>);

const FIGURES: &[FigureColumn] = &[
    ("Size", |of| Some(human_bytes(of.sizes.container))),
    ("% of raw", |of| Some(format!("{:.2}", of.ratio_percent()))),
    ("+LZMA2 %*", |of| Some(format!("{:.2}", 100.0 * of.sizes.lzma2 as f64 / of.sizes.raw.max(1) as f64))),
    ("Encode s", |of| of.encode.median().map(|seconds| format!("{seconds:.3}"))),
    ("Decode ms/frame", |of| of.decode_ms_per_frame().map(|ms| format!("{ms:.3}"))),
    ("Mpixel/s", |of| of.megapixels_per_second().map(|speed| format!("{speed:.0}"))),
    ("Changed %", |of| Some(format!("{:.2}", of.changed_percent()))),
    ("PSNR dB", |of| Some(format!("{:.2}", of.quality.psnr_db))),
    ("Min PSNR", |of| of.quality.min_psnr_db.map(|db| format!("{db:.2}"))),
    ("SSIM", |of| of.quality.ssim.map(|ssim| format!("{ssim:.4}"))),
    ("Max error", |of| of.quality.max_error_codes.map(|codes| codes.to_string())),
    ("Max error m", |of| of.quality.max_error_m.map(|metres| format!("{metres:.4}"))),
];

/// Tables of all points, one for each kind of stream, what the papers found and is to be judged, and the files that were
/// written.
pub fn report(results: &Results, files: &[PathBuf]) -> String {
    let mut text = String::new();
    for kind in StreamKind::ALL {
        let points: Vec<&Measured> = results.measured.iter().filter(|of| of.point.kind == kind).collect();
        if !points.is_empty() {
            // Writing into a string does not fail.
            let _ = writeln!(text, "{}{}", common(results, kind), table(results, kind, &points));
        }
    }
    if !results.measured.is_empty() {
        text.push_str("* compressed further by lightfold pack --lzma2; decoding is timed without it.\n\n");
    }
    let findings = findings::judge(results);
    for finding in findings.iter().filter(|finding| finding.verdict != Verdict::NotMeasured) {
        let _ = writeln!(text, "{}: {}\n  {}", finding.verdict.name(), finding.sentence, finding.rests_on);
    }
    if findings.iter().any(|finding| finding.verdict != Verdict::NotMeasured) {
        text.push('\n');
    }
    for path in files {
        let _ = writeln!(text, "{}", path.display());
    }
    text
}

/// Settings that all points of a study have and that are no defaults, a line for each study.
fn common(results: &Results, kind: StreamKind) -> String {
    let mut text = String::new();
    for study in results.studies.iter().filter(|study| study.kind == kind && !study.fixed.is_empty()) {
        let settings: Vec<_> = study.fixed.iter().map(|(name, value)| format!("{name}={value}")).collect();
        let _ = writeln!(text, "{}: all with {}", study.title, settings.join(" "));
    }
    text
}

fn table(results: &Results, kind: StreamKind, points: &[&Measured]) -> Table {
    let varied: Vec<&str> = KNOBS
        .iter()
        .map(|knob| knob.name)
        .filter(|name| {
            let of_kind = results.studies.iter().filter(|study| study.kind == kind);
            of_kind.flat_map(|study| &study.axes).any(|axis| axis.knob == *name)
        })
        .collect();
    let shown: Vec<&FigureColumn> =
        FIGURES.iter().filter(|(_, cell)| points.iter().any(|of| cell(of).is_some())).collect();
    let mut columns = vec![Column::Left("Kind")];
    columns.extend(varied.iter().map(|name| Column::Right(name)));
    columns.extend(shown.iter().map(|(heading, _)| Column::Right(heading)));
    let mut table = Table::new(&columns);
    for of in points {
        let mut cells = vec![kind.name().to_owned()];
        cells.extend(varied.iter().map(|name| of.point.value(name).unwrap_or("default").to_owned()));
        cells.extend(shown.iter().map(|(_, cell)| cell(of).unwrap_or_default()));
        table.row(cells);
    }
    table
}

/// What to use, or what comes nearest; `unasked` are kinds that were measured and of which nothing was asked.
pub fn advice(advised: &[Advised<'_>], unasked: &[StreamKind]) -> String {
    let mut text = String::new();
    for (advice, row) in advised {
        let of = advice.point;
        let kind = of.point.kind.name();
        let settings: Vec<_> = of.point.settings.iter().map(|(name, value)| format!("{name}={value}")).collect();
        let settings = if settings.is_empty() { "default settings".to_owned() } else { settings.join(" ") };
        let figures: Vec<_> = FIGURES
            .iter()
            .filter_map(|(heading, cell)| {
                Some(format!("{} {}", heading.to_lowercase().replace("psnr", "PSNR").replace(" db", " dB"), cell(of)?))
            })
            .collect();
        let head = match (advice.misses.is_empty(), advice.aim) {
            (true, Aim::Smallest) => "the smallest that will do has",
            (true, Aim::Closest) => "the closest to the source that will do (no quality was asked of it) has",
            (false, _) => "no point meets what is asked; the nearest has",
        };
        let _ = writeln!(text, "{kind}: {head} {settings}");
        for miss in &advice.misses {
            let _ = writeln!(text, "  misses {miss}");
        }
        let command = match row.command.strip_suffix("point.lfold") {
            Some(start) => format!("{start}{kind}.lfold"),
            None => row.command.clone(),
        };
        let _ = writeln!(text, "  {}\n  {command}", figures.join(", "));
        if let Some(device) = of.point.value("device") {
            let _ = writeln!(text, "  decoded with --device {device}");
        }
    }
    for kind in unasked {
        let quality = match kind {
            StreamKind::Color => "--min-psnr",
            StreamKind::Depth => "--max-error, --max-error-m",
            StreamKind::Material => "--max-error",
        };
        let _ = writeln!(
            text,
            "{}: nothing is asked of it ({quality}, --decode-ms, --max-bytes or --max-ratio)",
            kind.name()
        );
    }
    if advised.len() > 1 {
        let files: Vec<_> =
            advised.iter().map(|(advice, _)| format!("{}.lfold", advice.point.point.kind.name())).collect();
        let _ = writeln!(text, "join them: lightfold pack {} -o all.lfold", files.join(" "));
    }
    text
}

/// Prints the table of knobs.
pub fn list_knobs(as_json: bool) -> Result<()> {
    let kinds = |kinds: &[StreamKind]| kinds.iter().map(|kind| kind.name()).collect::<Vec<_>>();
    let stage = |stage| match stage {
        Stage::Encode => "encode",
        Stage::Decode => "decode",
        Stage::Both => "both",
        Stage::Place => "place",
        Stage::Render => "render",
    };
    let all = KNOBS.iter().chain(placement::KNOBS).chain(rendering::KNOBS);
    if as_json {
        let row = |knob: &crate::report::tradeoff::Knob| {
            json!({
                "name": knob.name,
                "label": knob.label,
                "kinds": kinds(knob.kinds),
                "stage": stage(knob.stage),
                "default": knob.default,
                "usual": knob.usual,
            })
        };
        return output::print_json(&json!({ "knobs": all.map(row).collect::<Vec<_>>() }));
    }
    let mut table = Table::new(&[
        Column::Left("Knob"),
        Column::Left("What"),
        Column::Left("Kinds"),
        Column::Left("Option of"),
        Column::Left("Default"),
        Column::Left("Swept where no values are given"),
    ]);
    for knob in all {
        let of = match knob.stage {
            Stage::Place => "cameras".to_owned(),
            Stage::Render => "pictures".to_owned(),
            _ if knob.is_general() => "all".to_owned(),
            _ => kinds(knob.kinds).join(", "),
        };
        table.row([
            knob.name.to_owned(),
            knob.label.to_owned(),
            of,
            stage(knob.stage).to_owned(),
            knob.default.to_owned(),
            knob.usual.join(","),
        ]);
    }
    output::print_text(&table.to_string())
}
