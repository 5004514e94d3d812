//! HTML page of a sweep: figures, findings, all points, and how they were measured. It is self-contained: no other
//! files, no network, no scripts.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use super::figures::{self, Figure};
use super::findings::{Finding, Verdict};
use super::kind::{Measured, words};
use super::score::Scored;
use super::study::{Axis, Results};
use super::table::{self, PointTable};
use crate::report::plot::number;
use crate::report::plot::save::{self, escape};
use crate::report::timing::runs_in_words;
use codec::error::{Result, counted};
use footage::files::write_whole;

/// File name of the page.
pub const PAGE: &str = "index.html";

const STYLE: &str = "\
body{font:16px/1.5 'DejaVu Sans',Verdana,sans-serif;color:#222;background:#fff;max-width:1320px;margin:0 auto;padding:24px}\
h1{font-size:26px;margin:0 0 4px}h2{font-size:20px;margin:40px 0 8px;border-bottom:1px solid #ddd;padding-bottom:4px}\
p{margin:6px 0}.faint{color:#606060}figure{margin:24px 0 36px;break-inside:avoid}\
figure svg{max-width:100%;height:auto;border:1px solid #e2e2e2}figcaption{font-size:14px;max-width:1000px;color:#444}\
.scroll{overflow-x:auto}table{border-collapse:collapse;font-size:13px;font-variant-numeric:tabular-nums}\
th,td{padding:3px 8px;text-align:right;border-bottom:1px solid #e2e2e2;white-space:nowrap;vertical-align:top}\
th{background:#f5f5f5;border-bottom:2px solid #bbb;white-space:normal;vertical-align:bottom}\
td small{display:block;font-size:10px;color:#606060}h4{font-size:14px;margin:16px 0 4px}tr.best td{background:#fdf3d7}\
ol.findings{padding-left:24px}ol.findings li{margin:12px 0;max-width:1100px}\
.verdict{display:inline-block;padding:0 8px;border-radius:3px;font-size:13px;font-weight:bold;color:#fff;margin-left:6px}\
.found{background:#1b7a4b}.not-found{background:#b3261e}.not-measured{background:#6b6b6b}\
.small{font-size:14px;color:#444}code{font:13px 'DejaVu Sans Mono',Consolas,monospace;background:#f5f5f5;padding:1px 4px;\
overflow-wrap:anywhere}dl{display:grid;grid-template-columns:max-content 1fr;gap:4px 16px;font-size:14px}dt{color:#606060}\
dd{margin:0;overflow-wrap:anywhere}\
@media print{body{max-width:none;padding:0;font-size:12px}h2{break-after:avoid}.scroll{overflow:visible}table{font-size:8px}\
th,td{padding:1px 3px}}";

#[derive(Debug, Clone, Default)]
pub struct Extras {
    pub figures: Vec<Figure>,
    pub findings: Vec<Finding>,
}

/// Writes every figure as SVG and PNG, and `index.html`, which shows them, into a folder. Returns the paths of the
/// files.
pub fn write(results: &Results, extras: &Extras, folder: &Path) -> Result<Vec<PathBuf>> {
    let mut figures = figures::all(results);
    figures.extend(extras.figures.iter().cloned());
    let mut files = Vec::new();
    for figure in &figures {
        files.extend(save::save(&figure.drawing, folder, &figure.name)?);
    }
    let (path, text) = (folder.join(PAGE), html(results, &figures, &extras.findings)?);
    write_whole(&path, text.as_bytes())?;
    files.push(path);
    Ok(files)
}

fn html(results: &Results, figures: &[Figure], findings: &[Finding]) -> Result<String> {
    let title = escape(&format!("{}: {}", results.sweep.title, results.input));
    let mut page = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <title>{title}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n<h1>{title}</h1>\n\
         <p class=\"faint\">{} in {}. {}</p>\n",
        counted(results.measured.len() as u64, "point"),
        counted(results.studies.len() as u64, "grid"),
        escape(&results.about)
    );
    measured(&mut page, results);
    page.push_str("<h2>Figures</h2>\n");
    if figures.is_empty() {
        page.push_str("<p>There is nothing to draw: no study has two points.</p>\n");
    }
    for figure in figures {
        let (name, caption) = (escape(&figure.name), escape(&figure.caption));
        let svg = save::to_svg(&figure.drawing)?;
        let _ = writeln!(page, "<figure id=\"{name}\">\n{svg}<figcaption>{caption}</figcaption>\n</figure>");
    }
    least_points(&mut page, results);
    findings_of(&mut page, findings);
    if !results.left_out.is_empty() {
        let sentences: Vec<String> = results.left_out.iter().map(|of| format!("<li>{}</li>\n", escape(of))).collect();
        let _ = write!(page, "<h2>Left out</h2>\n<ul>\n{}</ul>\n", sentences.concat());
    }
    page.push_str("<h2>All points</h2>\n");
    tables(&mut page, results);
    foot(&mut page, results);
    page.push_str("</body>\n</html>\n");
    Ok(page)
}

/// Writes the values of each knob, and the default point of each study that contains it.
fn measured(page: &mut String, results: &Results) {
    page.push_str("<h2>Measured</h2>\n<ul>\n");
    for study in &results.studies {
        let axis = |axis: &Axis| format!("{} {}", axis.knob, axis.values.join(", "));
        let axes = study.axes.iter().map(axis).collect::<Vec<_>>().join("; ");
        let fixed = words(&study.fixed).map_or_else(String::new, |fixed| format!("; all with {fixed}"));
        let _ = writeln!(page, "<li>{}: {}</li>", escape(&study.title), escape(&format!("{axes}{fixed}")));
    }
    let defaults = results.studies.iter().filter_map(|study| results.of(&study.default_point()?));
    for point in defaults {
        let bytes = point.count("bytes_container");
        let bytes = if bytes == 0 { String::new() } else { format!("{}, ", number::bytes(bytes as f64)) };
        let figures = format!("{bytes}{}", quality(point));
        let _ = writeln!(
            page,
            "<li>Default settings, <code>{}</code>: {}</li>",
            escape(&point.point.words()),
            escape(figures.trim_end_matches(", "))
        );
    }
    page.push_str("</ul>\n");
}

/// Writes the findings that were tested, and one line with the measurements that the others need.
fn findings_of(page: &mut String, findings: &[Finding]) {
    if findings.is_empty() {
        return;
    }
    let (unmeasured, judged): (Vec<&Finding>, Vec<&Finding>) =
        findings.iter().partition(|finding| finding.verdict == Verdict::NotMeasured);
    page.push_str("<h2>Findings of the papers on this footage</h2>\n");
    if !judged.is_empty() {
        let items: Vec<String> = judged.into_iter().map(item).collect();
        let _ = write!(page, "<ol class=\"findings\">\n{}</ol>\n", items.concat());
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
        "<li>{}<br>{} <span class=\"verdict {}\">{verdict}</span><br><span class=\"small\">Rule: {}</span></li>\n",
        escape(&finding.rests_on),
        escape(finding.sentence),
        verdict.replace(' ', "-"),
        escape(finding.rule)
    )
}

fn least_points(page: &mut String, results: &Results) {
    let mut items = String::new();
    let mut warning = "";
    for study in &results.studies {
        let scored = Scored::of_study(results, study);
        let Some(point) = scored.winner() else { continue };
        let (mut what, mut alike) = ("best compromise", " of the same quality");
        if scored.quality_differs() {
            (what, alike) = ("least bytes and time", "");
            warning = " It ignores quality: where a knob that changes quality is swept, the worst quality often has the least \
                       score. Compare such settings by the Pareto fronts of the figures.";
        }
        let _ = writeln!(
            items,
            "<li>{}: {what} of {} points{alike}: <code>{}</code>: {}, {} ms a frame, {}</li>",
            escape(&study.title),
            scored.count(),
            escape(&point.point.words()),
            number::bytes(point.count("bytes_container") as f64),
            number::short(point.number("decode_ms_per_frame").unwrap_or(f64::NAN)),
            quality(point),
        );
    }
    if items.is_empty() {
        return;
    }
    let _ = write!(
        page,
        "<h2>Least bytes and time</h2>\n<ul>\n{items}</ul>\n<p>The score weighs bytes and decoding time only.{warning}</p>\n\
         <p class=\"small\">A score is a point’s bytes to the power of {} times its decoding time to the power of {}, relative to \
         the least such product: 1.00 is the best point of its study, and 1.10 is 10% more. CALF maps bytes and times to 0..1 \
         first, so its scores differ.</p>\n",
        number::short(results.weights.compression),
        number::short(results.weights.decoding)
    );
}

fn quality(point: &Measured) -> String {
    if point.number("psnr_db") == Some(f64::INFINITY) {
        return "lossless".to_owned();
    }
    let parts = [
        point.number("psnr_db").map(|db| format!("PSNR {db:.2} dB")),
        point.number("min_psnr_db").map(|db| format!("worst cell {db:.2} dB")),
        point.number("max_error_codes").map(|error| format!("largest error {error} codes")),
    ];
    parts.into_iter().flatten().collect::<Vec<_>>().join(", ")
}

fn tables(page: &mut String, results: &Results) {
    let best: Vec<&Measured> =
        results.studies.iter().filter_map(|study| Scored::of_study(results, study).winner()).collect();
    for stream in results.streams() {
        if let Some(stream) = stream {
            let _ = writeln!(page, "<h3>{}</h3>", escape(stream.name()));
        }
        table(page, &table::of(results, stream), &best);
    }
    let tinted = if best.is_empty() { "" } else { "Tinted: the least score of a study. " };
    let _ = writeln!(page, "<p class=\"small\">{tinted}Small figures are the shortest and the longest run.</p>");
}

fn table(page: &mut String, table: &PointTable<'_>, tinted: &[&Measured]) {
    page.push_str("<div class=\"scroll\"><table>\n<thead><tr>");
    for heading in &table.headings {
        let _ = write!(page, "<th>{}</th>", escape(heading));
    }
    page.push_str("</tr></thead>\n<tbody>\n");
    for row in &table.rows {
        let is_tinted = tinted.iter().any(|best| std::ptr::eq(*best, row.point));
        page.push_str(if is_tinted { "<tr class=\"best\">" } else { "<tr>" });
        for cell in &row.cells {
            let range =
                cell.range.as_ref().map_or_else(String::new, |range| format!("<small>{}</small>", escape(range)));
            let _ = write!(page, "<td>{}{range}</td>", escape(&cell.text));
        }
        page.push_str("</tr>\n");
    }
    page.push_str("</tbody></table></div>\n");
}

fn foot(page: &mut String, results: &Results) {
    page.push_str("<h2>How this was measured</h2>\n<dl>\n");
    let code = |line: &str| format!("<code>{}</code>", escape(line));
    let version = format!("lightfold {}", env!("CARGO_PKG_VERSION"));
    let facts = [
        (results.sweep.input_label, escape(&results.input)),
        ("Command", code(&results.command_line)),
        ("Machine", escape(&results.machine)),
        ("Version", version),
    ];
    let commands = results.commands.iter().map(|command| (command.makes, code(&command.line)));
    for (name, value) in facts.into_iter().chain(commands) {
        let _ = writeln!(page, "<dt>{}</dt><dd>{value}</dd>", escape(name));
    }
    let timed = runs_in_words(results.measured.iter().map(Measured::timed_runs));
    let timed = timed.map_or_else(String::new, |runs| format!(" Times are {runs}."));
    let _ = writeln!(
        page,
        "</dl>\n<p class=\"small\">{}{timed} Rounds of timed runs went over all points in turn.</p>",
        escape(results.sweep.method)
    );
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::tradeoff::coding;
    use crate::report::tradeoff::kind::Value;
    use crate::report::tradeoff::tests::sample;
    use codec::image::StreamKind;

    /// Content of the page of a coding sweep besides the points.
    fn extras(results: &Results) -> Extras {
        let tiles = sample::tiles();
        let mut figures = coding::figures::bounds(results);
        figures.extend(coding::figures::tiles(&tiles, "effort fast, domain log"));
        Extras { figures, findings: coding::findings::judge(results, Some(&tiles)) }
    }

    #[test]
    fn the_page_stands_alone_and_escapes_what_users_wrote() {
        let mut results = sample::paper();
        results.input = "<script>alert('x')</script> & \"more\"".to_owned();
        results.command_line = "lightfold tradeoff '<b>'".to_owned();
        results.left_out = vec!["<i>depth-window</i> 16".to_owned()];
        let folder = tempfile::tempdir().unwrap();
        let files = write(&results, &extras(&results), folder.path()).unwrap();
        let page = std::fs::read_to_string(folder.path().join(PAGE)).unwrap();
        for bad in ["<script", "<b>", "<i>", "NaN", "src=", "href="] {
            assert!(!page.contains(bad), "{bad}");
        }
        for said in ["&lt;script&gt;", "&lt;i&gt;depth-window", "A Processor", env!("CARGO_PKG_VERSION")] {
            assert!(page.contains(said), "{said}");
        }
        assert_eq!(page.matches("<svg ").count(), page.matches("<figcaption>").count());
        assert_eq!(page.matches("<tr").count(), 2 + results.measured.len());
        let ends = |ending: &str| files.iter().filter(|file| file.extension().is_some_and(|of| of == ending)).count();
        assert_eq!((ends("svg"), ends("png"), ends("html")), (11, 11, 1), "{files:?}");
        assert!(files.iter().all(|file| file.is_file()));
        let left = std::fs::read_dir(folder.path()).unwrap().count();
        assert_eq!(left, files.len(), "nothing half written stays");
    }

    #[test]
    fn a_page_without_points_says_so() {
        let results = Results { measured: vec![], studies: vec![], ..sample::paper() };
        let page = html(&results, &[], &coding::findings::judge(&results, None)).unwrap();
        assert!(page.contains("nothing to draw") && page.contains("Not measured: "), "{page}");
        assert!(page.contains("0 points in 0 grids") && !page.contains("<ol"), "{page}");
    }

    /// Returns the page of the sample results after a change.
    fn page_of(change: impl FnOnce(&mut Results)) -> String {
        let mut results = sample::paper();
        change(&mut results);
        html(&results, &[], &extras(&results).findings).unwrap()
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
        assert!(both.contains("It ignores quality:") && both.contains("Pareto fronts"), "{both}");
        let alike = page_of(|results| results.studies.retain(|study| study.name == "boxes"));
        assert!(alike.contains("best compromise") && !alike.contains("It ignores quality:"), "{alike}");
        assert!(alike.contains("in 1 grid."), "{alike}");
    }

    #[test]
    fn figures_come_first_and_findings_without_figures_are_one_line() {
        let page = page_of(|results| results.measured.retain(|of| of.point.stream == Some(StreamKind::Color)));
        let place = |what: &str| page.find(what).unwrap_or_else(|| panic!("{what}: {page}"));
        let order =
            ["<h2>Measured", "<h2>Figures", "<h2>Least", "<h2>Findings", "<h2>All points", "<h2>How"].map(place);
        assert!(order.is_sorted(), "{order:?}");
        assert_eq!(page.matches("Not measured: ").count(), 1);
        assert!(!page.contains(">not measured<") && page.contains(">found<"), "{page}");
        assert!(place("Not measured: ") > place("</ol>"));
    }

    #[test]
    fn tables_have_runs_and_defaults() {
        let page = page_of(|_| {});
        assert!(page.contains("Times are medians of 3 runs.") && page.contains("reading the source"), "{page}");
        assert!(page.contains("<td>default</td>") && !page.contains("usual"), "{page}");
        assert!(page.contains("<td>1.00<small>0.900–1.10</small></td>"), "{page}");
        let once = page_of(|results| {
            for of in &mut results.measured {
                of.set("encode_runs", Value::Runs(vec![1.0]));
            }
        });
        assert!(once.contains("Times are medians of 1 to") || once.contains("a single run"), "{once}");
        assert!(once.contains("<td>1.00</td>"), "{once}");
    }
}
