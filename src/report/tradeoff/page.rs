//! One page with everything: findings, figures, all points, and how they came about. It needs no other file, no network
//! and no script.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use super::figures::{self, Figure};
use super::findings::{self, Finding};
use super::knob::KNOBS;
use super::point::Measured;
use super::score;
use super::study::Results;
use crate::dataset::stream::StreamKind;
use crate::error::{Error, Result};
use crate::report::plot::number;
use crate::report::plot::save::{self, escape};

/// The page's own name.
const PAGE: &str = "index.html";

/// Look of the page: readable on a screen in the light, and on paper.
const STYLE: &str = "\
body{font:16px/1.5 'DejaVu Sans',Verdana,sans-serif;color:#222;background:#fff;max-width:1320px;margin:0 auto;padding:24px}\
h1{font-size:26px;margin:0 0 4px}h2{font-size:20px;margin:40px 0 8px;border-bottom:1px solid #ddd;padding-bottom:4px}\
p{margin:6px 0}.faint{color:#606060}figure{margin:24px 0 36px;break-inside:avoid}\
figure svg{max-width:100%;height:auto;border:1px solid #e2e2e2}figcaption{font-size:14px;max-width:1000px;color:#444}\
.scroll{overflow-x:auto}table{border-collapse:collapse;font-size:13px;font-variant-numeric:tabular-nums}\
th,td{padding:3px 9px;text-align:right;border-bottom:1px solid #e2e2e2;white-space:nowrap}\
th{background:#f5f5f5;border-bottom:2px solid #bbb}tr.best td{background:#fdf3d7}\
ol.findings{padding-left:24px}ol.findings li{margin:12px 0;max-width:1100px}\
.verdict{display:inline-block;padding:0 8px;border-radius:3px;font-size:13px;font-weight:bold;color:#fff;margin-right:6px}\
.found{background:#1b7a4b}.not-found{background:#b3261e}.not-measured{background:#6b6b6b}\
.small{font-size:14px;color:#444}code{font:13px 'DejaVu Sans Mono',Consolas,monospace;background:#f5f5f5;padding:1px 4px;\
overflow-wrap:anywhere}dl{display:grid;grid-template-columns:max-content 1fr;gap:4px 16px;font-size:14px}dt{color:#606060}\
dd{margin:0;overflow-wrap:anywhere}\
@media print{body{max-width:none;padding:0;font-size:12px}h2{break-after:avoid}.scroll{overflow:visible}table{font-size:8px}\
th,td{padding:1px 3px}}";

/// Writes every figure as SVG and PNG, and `index.html`, which shows them, into a folder. Returns the files.
///
/// # Errors
/// When a file cannot be written.
pub fn write(results: &Results, folder: &Path) -> Result<Vec<PathBuf>> {
    let figures = figures::all(results);
    let mut files = Vec::new();
    for figure in &figures {
        files.extend(save::save(&figure.drawing, folder, &figure.name)?);
    }
    let path = folder.join(PAGE);
    save::whole(&path, |partial| {
        std::fs::write(partial, html(results, &figures)?).map_err(|error| Error::io(&path, error))
    })?;
    files.push(path);
    Ok(files)
}

/// The page's text.
fn html(results: &Results, figures: &[Figure]) -> Result<String> {
    let mut page = String::new();
    let title = format!("What accuracy costs: {}", escape(&results.input));
    // Writing into a string does not fail.
    let _ = write!(
        page,
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <title>{title}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n<h1>{title}</h1>\n\
         <p class=\"faint\">{} points in {} studies. Less is better for bytes, time and score.</p>\n",
        results.measured.len(),
        results.studies.len()
    );
    page.push_str("<h2>Findings of the papers on this footage</h2>\n<ol class=\"findings\">\n");
    findings::judge(results).iter().for_each(|finding| page.push_str(&item(finding)));
    page.push_str("</ol>\n");
    left_out(&mut page, results);
    best_points(&mut page, results);

    page.push_str("<h2>Figures</h2>\n");
    if figures.is_empty() {
        page.push_str("<p>There is nothing to draw: no study has two points.</p>\n");
    }
    for figure in figures {
        let svg = save::to_svg(&figure.drawing)?;
        let _ = write!(
            page,
            "<figure id=\"{}\">\n{svg}<figcaption>{}</figcaption>\n</figure>\n",
            escape(&figure.name),
            escape(&figure.caption)
        );
    }
    page.push_str("<h2>All points</h2>\n");
    for kind in StreamKind::ALL {
        table(&mut page, results, kind);
    }
    foot(&mut page, results);
    page.push_str("</body>\n</html>\n");
    Ok(page)
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

/// The best score of each study, and what the score is.
fn best_points(page: &mut String, results: &Results) {
    let mut items = String::new();
    for study in &results.studies {
        let (points, scores, best) = score::of_study(results, study);
        let scored = scores.iter().flatten().count();
        let Some((at, point)) = best.and_then(|at| Some((at, points[at]?))) else { continue };
        if scored < 2 {
            continue;
        }
        let _ = writeln!(
            items,
            "<li>{}: <code>{}</code>, {}, {} ms a frame, score {} of {scored} points</li>",
            escape(&study.title),
            escape(&settings(point)),
            number::bytes(point.sizes.container as f64),
            number::short(point.decode_ms_per_frame().unwrap_or(f64::NAN)),
            number::short(scores[at].unwrap_or(f64::NAN)),
        );
    }
    if items.is_empty() {
        return;
    }
    let _ = write!(
        page,
        "<h2>Best compromises</h2>\n<ul>\n{items}</ul>\n<p class=\"small\">The score is the product of a point’s bytes over \
         the least bytes of its study, to the power of {}, and its decoding time over the least time, to the power of {}: \
         1 would be best in both. CALF brings bytes and times into the range of 0 to 1 first, by which a point that is best \
         in one has the score 0, whatever the other is; ratios do not.</p>\n",
        number::short(results.weights.compression),
        number::short(results.weights.decoding)
    );
}

fn settings(point: &Measured) -> String {
    let words: Vec<String> = point.point.settings.iter().map(|(name, value)| format!("--{name} {value}")).collect();
    if words.is_empty() { "usual settings".to_owned() } else { words.join(" ") }
}

/// A column of a table: heading, and a point's cell.
type Column = (&'static str, fn(&Measured) -> Option<String>);

const COLUMNS: &[Column] = &[
    ("in time", |of| Some(number::bytes(of.sizes.temporal as f64))),
    ("blocks or functions", |of| of.sizes.spatial.map(|bytes| number::bytes(bytes as f64))),
    ("container", |of| Some(number::bytes(of.sizes.container as f64))),
    ("% of raw", |of| Some(format!("{:.2}", of.ratio_percent()))),
    ("+ LZMA2", |of| Some(number::bytes(of.sizes.lzma2 as f64))),
    ("encode s", |of| of.encode.median().map(number::even)),
    ("min–max", |of| of.encode.spread().map(|(low, high)| format!("{}–{}", number::even(low), number::even(high)))),
    ("decode ms/frame", |of| of.decode_ms_per_frame().map(number::even)),
    ("min–max", |of| {
        let frames = of.frames.max(1) as f64;
        let ms = |seconds: f64| number::even(1000.0 * seconds / frames);
        of.decode.spread().map(|(low, high)| format!("{}–{}", ms(low), ms(high)))
    }),
    ("Mpixel/s", |of| of.megapixels_per_second().map(|speed| format!("{speed:.0}"))),
    ("changed %", |of| Some(format!("{:.1}", of.changed_percent()))),
    ("PSNR dB", |of| Some(decibels(of.quality.psnr_db))),
    ("worst cell dB", |of| of.quality.min_psnr_db.map(decibels)),
    ("SSIM", |of| of.quality.ssim.map(|ssim| format!("{ssim:.4}"))),
    ("max error", |of| of.quality.max_error_codes.map(|codes| codes.to_string())),
    ("max error m", |of| of.quality.max_error_m.map(number::even)),
    ("encode memory", |of| of.encode_peak_bytes.map(|bytes| number::bytes(bytes as f64))),
    ("decode memory", |of| of.decode_peak_bytes.map(|bytes| number::bytes(bytes as f64))),
];

fn decibels(db: f64) -> String {
    if db.is_infinite() { "lossless".to_owned() } else { format!("{db:.2}") }
}

fn table(page: &mut String, results: &Results, kind: StreamKind) {
    let points: Vec<&Measured> = results.measured.iter().filter(|of| of.point.kind == kind).collect();
    if points.is_empty() {
        return;
    }
    let has = |name: &str| points.iter().any(|of| of.point.value(name).is_some());
    let knobs: Vec<&str> = KNOBS.iter().map(|knob| knob.name).filter(|name| has(name)).collect();
    let columns: Vec<&Column> = COLUMNS.iter().filter(|(_, cell)| points.iter().any(|of| cell(of).is_some())).collect();
    let best: Vec<&Measured> = results
        .studies
        .iter()
        .filter(|study| study.kind == kind)
        .filter_map(|study| {
            let (points, scores, best) = score::of_study(results, study);
            if scores.iter().flatten().count() > 1 { points[best?] } else { None }
        })
        .collect();
    let _ = write!(page, "<h3>{}</h3>\n<div class=\"scroll\"><table>\n<thead><tr>", escape(kind.name()));
    for heading in knobs.iter().copied().chain(columns.iter().map(|(heading, _)| *heading)) {
        let _ = write!(page, "<th>{}</th>", escape(heading));
    }
    page.push_str("</tr></thead>\n<tbody>\n");
    for of in points {
        let is_best = best.iter().any(|best| std::ptr::eq(*best, of));
        page.push_str(if is_best { "<tr class=\"best\">" } else { "<tr>" });
        let values = knobs.iter().map(|name| of.point.value(name).unwrap_or("usual").to_owned());
        let figures = columns.iter().map(|(_, cell)| cell(of).unwrap_or_else(|| "–".to_owned()));
        for cell in values.chain(figures) {
            let _ = write!(page, "<td>{}</td>", escape(&cell));
        }
        page.push_str("</tr>\n");
    }
    page.push_str("</tbody></table></div>\n<p class=\"small\">Tinted: the best score of a study.</p>\n");
}

fn foot(page: &mut String, results: &Results) {
    let _ = write!(
        page,
        "<h2>How this was measured</h2>\n<dl>\n<dt>Footage</dt><dd>{}</dd>\n<dt>Command</dt><dd><code>{}</code></dd>\n\
         <dt>Machine</dt><dd>{}</dd>\n<dt>Version</dt><dd>lightfold {}</dd>\n</dl>\n\
         <p class=\"small\">Each point was encoded, decoded and compared by commands of the program, which tradeoff.csv \
         names. Rounds of timed runs went over all points in turn; times are medians of them. A frame is one point in time \
         with all its probes and faces; a decoding time is that of showing it with the container in memory.</p>\n",
        escape(&results.input),
        escape(&results.command_line),
        escape(&results.machine),
        env!("CARGO_PKG_VERSION")
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
        assert_eq!((ends("svg"), ends("png"), ends("html")), (9, 9, 1), "{files:?}");
        assert!(files.iter().all(|file| file.is_file()));
        let left = std::fs::read_dir(folder.path()).unwrap().count();
        assert_eq!(left, files.len(), "nothing half written stays");
    }

    #[test]
    fn a_page_without_points_says_so() {
        let results = Results { measured: vec![], studies: vec![], ..sample::paper() };
        let page = html(&Results { tiles: None, ..results }, &[]).unwrap();
        assert!(page.contains("nothing to draw") && page.contains("not measured"), "{page}");
    }
}
