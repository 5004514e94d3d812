//! One page with everything: figures, findings, all points, and how they came about. It needs no other file, no network
//! and no script.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use super::figures::{self, Figure};
use super::findings::{self, Finding, Verdict};
use super::html;
use super::knob::KNOBS;
use super::point::{Measured, Quality, Timing};
use super::score::Scored;
use super::study::Results;
use crate::dataset::stream::StreamKind;
use crate::error::Result;
use crate::report::plot::number;
use crate::report::plot::save::escape;

/// Writes every figure as SVG and PNG, and `index.html`, which shows them, into a folder. Returns the files.
///
/// # Errors
/// When a file cannot be written.
pub fn write(results: &Results, folder: &Path) -> Result<Vec<PathBuf>> {
    let figures = figures::all(results);
    html::write(&figures, &html(results, &figures)?, folder)
}

/// The page's text.
fn html(results: &Results, figures: &[Figure]) -> Result<String> {
    let subtitle = format!(
        "{} in {}. Less is better for bytes, time and score.",
        counted(results.measured.len(), "point", "points"),
        counted(results.studies.len(), "study", "studies")
    );
    let mut page = html::begin(&format!("What accuracy costs: {}", results.input), &subtitle);
    page.push_str("<h2>Figures</h2>\n");
    if figures.is_empty() {
        page.push_str("<p>There is nothing to draw: no study has two points.</p>\n");
    }
    figures.iter().try_for_each(|figure| html::figure(&mut page, figure))?;
    least_points(&mut page, results);
    findings_of(&mut page, &findings::judge(results));
    left_out(&mut page, results);
    page.push_str("<h2>All points</h2>\n");
    for kind in StreamKind::ALL {
        tables(&mut page, results, kind);
    }
    foot(&mut page, results);
    Ok(html::end(page))
}

/// A count with its noun.
fn counted(count: usize, one: &str, many: &str) -> String {
    format!("{count} {}", if count == 1 { one } else { many })
}

/// The findings that could be judged, and in a line what the others need.
fn findings_of(page: &mut String, findings: &[Finding]) {
    let (unmeasured, judged): (Vec<&Finding>, Vec<&Finding>) =
        findings.iter().partition(|finding| finding.verdict == Verdict::NotMeasured);
    page.push_str("<h2>Findings of the papers on this footage</h2>\n");
    if !judged.is_empty() {
        page.push_str("<ol class=\"findings\">\n");
        judged.iter().for_each(|finding| page.push_str(&item(finding)));
        page.push_str("</ol>\n");
    }
    if !unmeasured.is_empty() {
        let each = unmeasured.iter().map(|finding| {
            format!("{} ({})", finding.sentence.trim_end_matches('.'), finding.rests_on.trim_end_matches('.'))
        });
        let all = each.collect::<Vec<_>>().join("; ");
        let _ = writeln!(page, "<p class=\"small\">Not measured: {}.</p>", escape(&all));
    }
}

fn item(finding: &Finding) -> String {
    let verdict = finding.verdict.name();
    format!(
        "<li><span class=\"verdict {}\">{verdict}</span>{}<br>{}<br><span class=\"small\">Rule: {}</span></li>\n",
        verdict.replace(' ', "-"),
        escape(finding.sentence),
        escape(&finding.rests_on),
        escape(finding.rule)
    )
}

fn left_out(page: &mut String, results: &Results) {
    if results.left_out.is_empty() {
        return;
    }
    page.push_str("<h2>Left out</h2>\n<ul>\n");
    for sentence in &results.left_out {
        let _ = writeln!(page, "<li>{}</li>", escape(sentence));
    }
    page.push_str("</ul>\n");
}

/// The least score of each study, and what the score is.
fn least_points(page: &mut String, results: &Results) {
    let mut items = String::new();
    let mut any_differs = false;
    for study in &results.studies {
        let scored = Scored::of_study(results, study);
        let Some(point) = scored.winner() else { continue };
        let differs = scored.quality_differs();
        any_differs |= differs;
        let (what, alike) =
            if differs { ("least bytes and time", "") } else { ("best compromise", " of the same quality") };
        let _ = writeln!(
            items,
            "<li>{}: {what} of {} points{alike}: <code>{}</code>: {}, {} ms a frame, {}</li>",
            escape(&study.title),
            scored.count(),
            escape(&point.point.words()),
            number::bytes(point.sizes.container as f64),
            number::short(point.decode_ms_per_frame().unwrap_or(f64::NAN)),
            quality(&point.quality, point.point.kind),
        );
    }
    if items.is_empty() {
        return;
    }
    let warning = if any_differs {
        " It knows nothing of quality: where a setting that changes quality is swept, the worst quality often has the least \
         score. Among settings of different quality, look at the Pareto fronts of the figures instead."
    } else {
        ""
    };
    let _ = write!(
        page,
        "<h2>Least bytes and time</h2>\n<ul>\n{items}</ul>\n<p>The score weighs bytes and decoding time only.{warning}</p>\n\
         <p class=\"small\">A score is a point’s bytes to the power of {}, multiplied by its decoding time to the power of {}, in \
         parts of the least such product: 1.00 is the best point of its study, and 1.10 is a tenth more than that. CALF brings \
         bytes and times into the range of what was captured first, from 0 to 1, by which a point that is best in one has the \
         score 0, whatever the other is; products of bytes and times as they are do not, so that these scores are not \
         those of the paper.</p>\n",
        number::short(results.weights.compression),
        number::short(results.weights.decoding)
    );
}

/// How good a point is.
fn quality(quality: &Quality, kind: StreamKind) -> String {
    if quality.psnr_db == f64::INFINITY {
        return "lossless".to_owned();
    }
    let steps = if kind == StreamKind::Depth { "codes" } else { "steps" };
    let parts = [
        Some(format!("PSNR {:.2} dB", quality.psnr_db)),
        quality.min_psnr_db.map(|db| format!("worst cell {db:.2} dB")),
        quality.max_error_codes.map(|error| format!("largest error {error} {steps}")),
    ];
    parts.into_iter().flatten().collect::<Vec<_>>().join(", ")
}

/// A cell of a table: a figure, and what stands smaller below it.
struct Cell {
    text: String,
    below: Option<String>,
}

impl Cell {
    fn new(text: impl Into<String>) -> Option<Cell> {
        Some(Cell { text: text.into(), below: None })
    }

    fn bytes(count: u64) -> Option<Cell> {
        Cell::new(number::bytes(count as f64))
    }

    /// The median with the shortest and the longest run, where there are several, in a unit of so many seconds.
    fn timed(timing: &Timing, unit: f64) -> Option<Cell> {
        let (low, high) = timing.spread()?;
        let told = |seconds: f64| number::even(seconds / unit);
        let below = (timing.runs.len() > 1).then(|| format!("{}–{}", told(low), told(high)));
        Some(Cell { text: told(timing.median()?), below })
    }
}

/// A column of a table.
struct Column {
    heading: &'static str,
    cell: fn(&Measured) -> Option<Cell>,
}

const fn column(heading: &'static str, cell: fn(&Measured) -> Option<Cell>) -> Column {
    Column { heading, cell }
}

/// What a point gives and costs.
const COLUMNS: &[Column] = &[
    column("container", |of| Cell::bytes(of.sizes.container)),
    column("% of raw", |of| Cell::new(format!("{:.2}", of.ratio_percent()))),
    column("+ LZMA2", |of| Cell::bytes(of.sizes.lzma2)),
    column("PSNR dB", |of| Cell::new(decibels(of.quality.psnr_db))),
    column("worst cell dB", |of| Cell::new(decibels(of.quality.min_psnr_db?))),
    column("SSIM", |of| Cell::new(format!("{:.4}", of.quality.ssim?))),
    column("max error", |of| Cell::new(of.quality.max_error_codes?.to_string())),
    column("max error m", |of| Cell::new(number::even(of.quality.max_error_m?))),
    column("encode s", |of| Cell::timed(&of.encode, 1.0)),
    column("decode ms a frame", |of| Cell::timed(&of.decode, 1e-3 * of.frames.max(1) as f64)),
    column("Mpixel/s", |of| Cell::new(format!("{:.0}", of.megapixels_per_second()?))),
    column("changed %", |of| Cell::new(format!("{:.1}", of.changed_percent()))),
];

/// Bytes of each stage, and memory.
const MORE_COLUMNS: &[Column] = &[
    column("raw", |of| Cell::bytes(of.sizes.raw)),
    column("in time", |of| Cell::bytes(of.sizes.temporal)),
    column("blocks or functions", |of| Cell::bytes(of.sizes.spatial?)),
    column("container", |of| Cell::bytes(of.sizes.container)),
    column("+ LZMA2", |of| Cell::bytes(of.sizes.lzma2)),
    column("encode memory", |of| Cell::bytes(of.encode_peak_bytes?)),
    column("decode memory", |of| Cell::bytes(of.decode_peak_bytes?)),
];

fn decibels(db: f64) -> String {
    if db.is_infinite() { "lossless".to_owned() } else { format!("{db:.2}") }
}

/// The tables of a kind, with what their figures are.
fn tables(page: &mut String, results: &Results, kind: StreamKind) {
    let points: Vec<&Measured> = results.measured.iter().filter(|of| of.point.kind == kind).collect();
    if points.is_empty() {
        return;
    }
    let studies = results.studies.iter().filter(|study| study.kind == kind);
    let best: Vec<&Measured> = studies.filter_map(|study| Scored::of_study(results, study).winner()).collect();
    let _ = writeln!(page, "<h3>{}</h3>", escape(kind.name()));
    table(page, COLUMNS, &points, &best);
    if !best.is_empty() {
        page.push_str(
            "<p class=\"small\">Tinted: the least score of a study, which is one of bytes and decoding time and knows nothing \
             of quality.</p>\n",
        );
    }
    let runs = |of: fn(&Measured) -> &Timing| Timing::runs_in_words(points.iter().map(|point| of(point)));
    if let (Some(encode), Some(decode)) = (runs(|of| &of.encode), runs(|of| &of.decode)) {
        let _ = writeln!(
            page,
            "<p class=\"small\">Encoding: {encode}, reading the source included. Decoding: {decode}, each run the median of \
             several passes, of the container as it is stored and not of the smaller one of “+ LZMA2”, which has to be \
             unpacked first. Small figures are the shortest and the longest run.</p>"
        );
    }
    page.push_str("<h4>Bytes by stage, and memory</h4>\n");
    table(page, MORE_COLUMNS, &points, &[]);
}

fn table(page: &mut String, columns: &[Column], points: &[&Measured], tinted: &[&Measured]) {
    let has = |name: &str| points.iter().any(|of| of.point.value(name).is_some());
    let knobs: Vec<&str> = KNOBS.iter().map(|knob| knob.name).filter(|name| has(name)).collect();
    let columns: Vec<&Column> =
        columns.iter().filter(|column| points.iter().any(|of| (column.cell)(of).is_some())).collect();
    page.push_str("<div class=\"scroll\"><table>\n<thead><tr>");
    for heading in knobs.iter().copied().chain(columns.iter().map(|column| column.heading)) {
        let _ = write!(page, "<th>{}</th>", escape(heading));
    }
    page.push_str("</tr></thead>\n<tbody>\n");
    for &of in points {
        let is_tinted = tinted.iter().any(|best| std::ptr::eq(*best, of));
        page.push_str(if is_tinted { "<tr class=\"best\">" } else { "<tr>" });
        let values = knobs.iter().map(|name| Cell::new(of.point.value(name).unwrap_or("default")));
        for cell in values.chain(columns.iter().map(|column| (column.cell)(of))) {
            let Cell { text, below } = cell.unwrap_or(Cell { text: "–".to_owned(), below: None });
            let below = below.map_or_else(String::new, |below| format!("<small>{}</small>", escape(&below)));
            let _ = write!(page, "<td>{}{below}</td>", escape(&text));
        }
        page.push_str("</tr>\n");
    }
    page.push_str("</tbody></table></div>\n");
}

fn foot(page: &mut String, results: &Results) {
    let how = html::How {
        input: ("Footage", &results.input),
        command_line: &results.command_line,
        machine: &results.machine,
    };
    html::how(page, &how);
    page.push_str(
        "<p class=\"small\">Each point was encoded, decoded and compared by commands of the program, which tradeoff.csv \
         names. Rounds of timed runs went over all points in turn; times are medians of them. A frame is one moment of the \
         footage with all its probes and faces; a decoding time is that of decoding it with the container in memory.</p>\n",
    );
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::tradeoff::sample;

    #[test]
    fn the_page_stands_alone_and_escapes_what_users_wrote() {
        let mut results = sample::paper();
        results.input = "<script>alert('x')</script> & \"more\"".to_owned();
        results.command_line = "lightfold tradeoff '<b>'".to_owned();
        results.left_out = vec!["<i>depth-window</i> 16".to_owned()];
        let folder = tempfile::tempdir().unwrap();
        let files = write(&results, folder.path()).unwrap();
        let page = std::fs::read_to_string(folder.path().join(html::PAGE)).unwrap();
        for bad in ["<script", "<b>", "<i>", "NaN", "src=", "href="] {
            assert!(!page.contains(bad), "{bad}");
        }
        for said in ["&lt;script&gt;", "&lt;i&gt;depth-window", "A Processor", env!("CARGO_PKG_VERSION")] {
            assert!(page.contains(said), "{said}");
        }
        assert_eq!(page.matches("<svg ").count(), page.matches("<figcaption>").count());
        assert_eq!(page.matches("<tr").count(), 4 + 2 * results.measured.len());
        let ends = |ending: &str| files.iter().filter(|file| file.extension().is_some_and(|of| of == ending)).count();
        assert_eq!((ends("svg"), ends("png"), ends("html")), (11, 11, 1), "{files:?}");
        assert!(files.iter().all(|file| file.is_file()));
        let left = std::fs::read_dir(folder.path()).unwrap().count();
        assert_eq!(left, files.len(), "nothing half written stays");
    }

    #[test]
    fn a_page_without_points_says_so() {
        let results = Results { measured: vec![], studies: vec![], ..sample::paper() };
        let page = html(&Results { tiles: None, ..results }, &[]).unwrap();
        assert!(page.contains("nothing to draw") && page.contains("Not measured: "), "{page}");
        assert!(page.contains("0 points in 0 studies") && !page.contains("<ol"), "{page}");
    }

    /// The page of the papers' results, changed.
    fn page_of(change: impl FnOnce(&mut Results)) -> String {
        let mut results = sample::paper();
        change(&mut results);
        html(&results, &[]).unwrap()
    }

    #[test]
    fn what_scores_do_not_know_is_said_where_quality_differs() {
        let both = page_of(|_| {});
        assert!(
            both.contains("Study boxes: best compromise of 25 points of the same quality: <code>depth-window=1"),
            "{both}"
        );
        assert!(
            both.contains("Study cells: least bytes and time of 25 points: <code>color-cell=128 psnr=30</code>"),
            "{both}"
        );
        assert!(
            both.contains("PSNR 33.00 dB, worst cell 30.00 dB") && both.contains("largest error 800 codes"),
            "{both}"
        );
        assert!(both.contains("knows nothing of quality:") && both.contains("Pareto fronts"), "{both}");
        let alike = page_of(|results| results.studies.retain(|study| study.name == "boxes"));
        assert!(alike.contains("best compromise") && !alike.contains("It knows nothing of quality:"), "{alike}");
        assert!(alike.contains("in 1 study."), "{alike}");
    }

    #[test]
    fn figures_come_first_and_findings_without_figures_are_one_line() {
        let page = page_of(|results| results.measured.retain(|of| of.point.kind == StreamKind::Color));
        let place = |what: &str| page.find(what).unwrap_or_else(|| panic!("{what}: {page}"));
        let order = ["<h2>Figures", "<h2>Least", "<h2>Findings", "<h2>All points", "<h2>How"].map(place);
        assert!(order.is_sorted(), "{order:?}");
        assert_eq!(page.matches("Not measured: ").count(), 1);
        assert!(!page.contains(">not measured<") && page.contains(">found<"), "{page}");
        assert!(place("Not measured: ") > place("</ol>"));
    }

    #[test]
    fn tables_tell_runs_and_defaults() {
        let page = page_of(|_| {});
        assert!(page.contains("Decoding: medians of 3 runs, each run the median of several passes"), "{page}");
        assert!(page.contains("reading the source included"), "{page}");
        assert!(page.contains("<td>default</td>") && !page.contains("usual"), "{page}");
        assert!(page.contains("<td>1.00<small>0.900–1.10</small></td>"), "{page}");
        let once = page_of(|results| results.measured.iter_mut().for_each(|of| of.encode.runs.truncate(1)));
        assert!(once.contains("Encoding: a single run, reading") && once.contains("<td>1.00</td>"), "{once}");
    }
}
