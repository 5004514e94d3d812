//! HTML page of a sweep: figures, findings, all points, and how they were measured. It is self-contained: no other
//! files, no network, no scripts.

use std::path::{Path, PathBuf};

use super::findings::{Finding, Verdict};
use super::kind::{Format, Measure, fill};
use super::point::{Measured, words};
use super::score::Scored;
use super::study::{Axis, Results, Study};
use super::{crops, figures};
use crate::report::Table;
use crate::report::plot::save::{self, escape};
use crate::report::plot::{Figure, number};
use crate::report::statistics::runs_in_words;
use codec::error::{Result, counted};
use codec::image::StreamKind;
use footage::files::write_whole;

/// File name of the page.
pub const PAGE: &str = "index.html";

/// Frame of the page, with the sections in braces.
const FRAME: &str = include_str!("page.html");
const STYLE: &str = include_str!("page.css");

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
    let (pictures, crops) = crops::section(results, folder)?;
    files.extend(crops);
    let (path, text) = (folder.join(PAGE), html(results, (&figures, &pictures), &extras.findings)?);
    write_whole(&path, text.as_bytes())?;
    files.push(path);
    Ok(files)
}

fn html(results: &Results, (figures, pictures): (&[Figure], &str), findings: &[Finding]) -> Result<String> {
    let figure = |figure: &Figure| {
        let (name, caption) = (escape(&figure.name), escape(&figure.caption));
        let svg = save::to_svg(&figure.drawing)?;
        Ok(format!("<figure id=\"{name}\">\n{svg}<figcaption>{caption}</figcaption>\n</figure>\n"))
    };
    let figures = match figures.is_empty() {
        true => "<p>There is nothing to draw: no study has two points.</p>\n".to_owned(),
        false => figures.iter().map(figure).collect::<Result<String>>()?,
    };
    let left_out: String = results.left_out.iter().map(|of| format!("<li>{}</li>\n", escape(of))).collect();
    let answer = answer(results);
    let timed = runs_in_words(results.measured.iter().map(Measured::timed_runs));
    let values = [
        ("title", escape(&format!("{}: {}", results.sweep.title, results.input))),
        ("style", STYLE.replace('\n', "")),
        ("points", counted(results.measured.len() as u64, "point")),
        ("grids", counted(results.studies.len() as u64, "grid")),
        ("about", escape(&results.about)),
        ("contents", contents([&answer, pictures, &left_out], findings)),
        ("answer", answer),
        ("measured", measured(results)),
        ("figures", figures),
        ("pictures", pictures.to_owned()),
        ("findings", findings_of(findings)),
        ("left_out", section(("left-out", "Left out"), &left_out)),
        ("tables", tables(results)),
        ("facts", facts(results)),
        ("method", escape(results.sweep.method)),
        ("timed", timed.map_or_else(String::new, |runs| format!(" Times are {runs}."))),
    ];
    Ok(fill(FRAME, &values))
}

/// Returns a section with a list. Empty without items.
fn section((id, title): (&str, &str), items: &str) -> String {
    if items.is_empty() { String::new() } else { format!("<h2 id=\"{id}\">{title}</h2>\n<ul>\n{items}</ul>\n") }
}

/// Returns links to the sections of the page.
fn contents([answer, pictures, left_out]: [&str; 3], findings: &[Finding]) -> String {
    let sections = [
        ("answer", "Answer", !answer.is_empty()),
        ("measured", "Measured", true),
        ("figures", "Figures", true),
        ("pictures", "Pictures", !pictures.is_empty()),
        ("findings", "Findings", !findings.is_empty()),
        ("left-out", "Left out", !left_out.is_empty()),
        ("points", "All points", true),
        ("how", "How", true),
    ];
    let link = |(id, title, _)| format!("<a href=\"#{id}\">{title}</a>");
    sections.into_iter().filter(|(.., is_there)| *is_there).map(link).collect()
}

/// Returns the values of each knob, and the default point of each study that contains it.
fn measured(results: &Results) -> String {
    let study = |study: &Study| {
        let axis = |axis: &Axis| format!("{} {}", axis.knob, axis.values.join(", "));
        let axes = study.axes.iter().map(axis).collect::<Vec<_>>().join("; ");
        let fixed = words(&study.fixed).map_or_else(String::new, |fixed| format!("; all with {fixed}"));
        format!("<li>{}: {}</li>\n", escape(&study.title), escape(&format!("{axes}{fixed}")))
    };
    let default = |point: &Measured| {
        let bytes = Some(point.count("bytes_container")).filter(|bytes| *bytes > 0);
        let bytes = bytes.map(|bytes| number::bytes(bytes as f64)).into_iter();
        let figures = bytes.chain([point.quality_words()].into_iter().filter(|words| !words.is_empty()));
        let figures = escape(&figures.collect::<Vec<_>>().join(", "));
        format!("<li>Default settings, <code>{}</code>: {figures}</li>\n", escape(&point.point.words()))
    };
    let defaults = results.studies.iter().filter_map(|study| results.of(&study.default_point()?));
    results.studies.iter().map(study).chain(defaults.map(default)).collect()
}

/// Returns the findings that were tested, and one line with the measurements that the others need.
fn findings_of(findings: &[Finding]) -> String {
    if findings.is_empty() {
        return String::new();
    }
    let item = |finding: &&Finding| {
        let verdict = finding.verdict.name();
        format!(
            "<li>{}<br>{} <span class=\"verdict {}\">{verdict}</span><br><span class=\"small\">Rule: {}</span></li>\n",
            escape(&finding.rests_on),
            escape(finding.sentence),
            verdict.replace(' ', "-"),
            escape(finding.rule)
        )
    };
    let need = |finding: &&Finding| {
        format!("{} ({})", finding.sentence.trim_end_matches('.'), finding.rests_on.trim_end_matches('.'))
    };
    let (unmeasured, judged): (Vec<&Finding>, Vec<&Finding>) =
        findings.iter().partition(|finding| finding.verdict == Verdict::NotMeasured);
    let (items, needs) =
        (judged.iter().map(item).collect::<String>(), unmeasured.iter().map(need).collect::<Vec<_>>().join("; "));
    let items = if items.is_empty() { items } else { format!("<ol class=\"findings\">\n{items}</ol>\n") };
    let needs = match needs.is_empty() {
        true => needs,
        false => format!("<p class=\"small\">Not measured: {}.</p>\n", escape(&needs)),
    };
    format!("<h2 id=\"findings\">Findings of the papers on this footage</h2>\n{items}{needs}")
}

/// Returns the point that the sweep recommends in each study, with its command; empty if no study has scores.
fn answer(results: &Results) -> String {
    let mut warning = "";
    let item = |study: &Study| {
        let scored = Scored::of_study(results, study);
        let point = scored.winner()?;
        let (mut what, mut alike) = ("best compromise", " of the same quality");
        if scored.quality_differs() {
            (what, alike) = ("least bytes and time", "");
            warning = " It ignores quality: where a knob that changes quality is swept, the worst quality often has the least \
                       score. Compare such settings by the Pareto fronts of the figures.";
        }
        let command = results.command_of(point);
        let command = command.map_or_else(String::new, |line| format!("<pre><code>{}</code></pre>", escape(line)));
        Some(format!(
            "<li>{}: {what} of {} points{alike}: <code>{}</code>: {}, {} ms a frame, {}{command}</li>\n",
            escape(&study.title),
            scored.count(),
            escape(&point.point.words()),
            number::bytes(point.count("bytes_container") as f64),
            number::short(point.number("decode_ms_per_frame").unwrap_or(f64::NAN)),
            point.quality_words(),
        ))
    };
    let items: String = results.studies.iter().filter_map(item).collect();
    if items.is_empty() {
        return items;
    }
    format!(
        "{}<p>The score weighs bytes and decoding time only.{warning}</p>\n\
         <p class=\"small\">A score is a point’s bytes to the power of {} times its decoding time to the power of {}, relative to \
         the least such product: 1.00 is the best point of its study, and 1.10 is 10% more. CALF maps bytes and times to 0..1 \
         first, so its scores differ.</p>\n",
        section(("answer", "Answer"), &items),
        number::short(results.weights.compression),
        number::short(results.weights.decoding)
    )
}

fn tables(results: &Results) -> String {
    let best: Vec<&Measured> =
        results.studies.iter().filter_map(|study| Scored::of_study(results, study).winner()).collect();
    let table = |stream: Option<StreamKind>| {
        let title = stream.map_or_else(String::new, |stream| format!("<h3>{}</h3>\n", escape(stream.name())));
        let table = table_of(results, stream);
        let headings: String = table.headings.iter().map(|heading| format!("<th>{}</th>", escape(heading))).collect();
        let cell = |(text, range): &Cell| {
            let range = range.as_ref().map_or_else(String::new, |range| format!("<small>{}</small>", escape(range)));
            format!("<td>{}{range}</td>", escape(text))
        };
        let row = |(point, cells): &(&Measured, Vec<Cell>)| {
            let is_best = best.iter().any(|best| std::ptr::eq(*best, *point));
            let class = if is_best { " class=\"best\"" } else { "" };
            format!("<tr{class}>{}</tr>\n", cells.iter().map(cell).collect::<String>())
        };
        let rows: String = table.rows.iter().map(row).collect();
        format!(
            "{title}<div class=\"scroll\"><table>\n<thead><tr>{headings}</tr></thead>\n<tbody>\n{rows}</tbody></table></div>\n"
        )
    };
    let tables: String = results.streams().into_iter().map(table).collect();
    let tinted = if best.is_empty() { "" } else { "Tinted: the least score of a study. " };
    format!("{tables}<p class=\"small\">{tinted}Small figures are the shortest and the longest run.</p>\n")
}

fn facts(results: &Results) -> String {
    let code = |line: &str| format!("<code>{}</code>", escape(line));
    let facts = [
        (results.sweep.input_label, escape(&results.input)),
        ("Command", code(&results.command_line)),
        ("Machine", escape(&results.machine)),
        ("Version", format!("lightfold {}", env!("CARGO_PKG_VERSION"))),
    ];
    let commands = results.commands.iter().map(|(makes, line)| (*makes, code(line)));
    let fact = |(name, value)| format!("<dt>{}</dt><dd>{value}</dd>\n", escape(name));
    facts.into_iter().chain(commands).map(fact).collect()
}

/// Table of points, with columns for the knobs and measures that any of them has.
pub struct PointTable<'a> {
    pub headings: Vec<&'a str>,
    pub rows: Vec<(&'a Measured, Vec<Cell>)>,
}

/// Text of a cell, and its shortest and longest run if there are several.
type Cell = (String, Option<String>);

pub fn table_of(results: &Results, stream: Option<StreamKind>) -> PointTable<'_> {
    let points: Vec<&Measured> = results.measured.iter().filter(|of| of.point.stream == stream).collect();
    let has = |name: &str| points.iter().any(|of| of.point.value(name).is_some());
    let knobs: Vec<&str> = results.sweep.knobs.iter().map(|knob| knob.name).filter(|name| has(name)).collect();
    let shown = results.sweep.measures.iter().filter(|measure| !measure.heading.is_empty());
    let measures: Vec<&Measure> =
        shown.filter(|measure| points.iter().any(|of| of.number(measure.name).is_some())).collect();
    let row = |point: &&'_ Measured| {
        let values = knobs.iter().map(|name| point.point.value(name).unwrap_or("default").to_owned());
        values.map(|text| (text, None)).chain(measures.iter().map(|measure| cell(point, measure))).collect()
    };
    let rows = points.iter().map(|point| (*point, row(point))).collect();
    let headings = knobs.iter().copied().chain(measures.iter().map(|measure| measure.heading)).collect();
    PointTable { headings, rows }
}

fn cell(point: &Measured, measure: &Measure) -> Cell {
    let Some(value) = point.number(measure.name) else { return ("–".to_owned(), None) };
    let print = |value: f64| print(value, measure.format);
    let runs = measure.runs.map_or(0, |runs| point.runs(runs).len());
    let spread = point.spread(measure.name).filter(|_| runs > 1);
    (print(value), spread.map(|spread| format!("{}–{}", print(spread.low), print(spread.high))))
}

fn print(value: f64, format: Format) -> String {
    match format {
        _ if value.is_infinite() => "lossless".to_owned(),
        Format::Bytes => number::bytes(value),
        Format::Decimals(decimals) => format!("{value:.decimals$}"),
        Format::Percent => format!("{:.2}", 100.0 * value),
        Format::Even => number::even(value),
    }
}

impl PointTable<'_> {
    pub fn text(&self) -> String {
        let mut table = Table::new(&format!(">{}", self.headings.join("|>")));
        for (_, cells) in &self.rows {
            table.row(cells.iter().map(|(text, _)| text.clone()));
        }
        table.to_string()
    }
}

/// Returns all measures of a point that have a heading, as text with their headings.
pub fn measure_words(point: &Measured) -> String {
    let shown = point.kind.measures.iter().filter(|measure| !measure.heading.is_empty());
    let words = shown.filter_map(|measure| {
        Some(format!("{} {}", measure.heading, print(point.number(measure.name)?, measure.format)))
    });
    words.collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::tradeoff::findings;
    use crate::report::tradeoff::point::Value;
    use crate::report::tradeoff::tests::sample;

    /// Content of the page of a coding sweep besides the points.
    fn extras(results: &Results) -> Extras {
        let tiles = sample::tiles();
        let mut figures = figures::bounds(results);
        figures.extend(crate::report::tile_psnr::figure(&tiles, "effort fast, domain log"));
        Extras { figures, findings: findings::judge(results, Some(&tiles)) }
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
        for bad in ["<script", "<b>", "<i>", "NaN", "src=\"h", "href=\"h"] {
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
        let page = html(&results, (&[], ""), &findings::judge(&results, None)).unwrap();
        assert!(page.contains("nothing to draw") && page.contains("Not measured: "), "{page}");
        assert!(page.contains("0 points in 0 grids") && !page.contains("<ol"), "{page}");
    }

    /// Returns the page of the sample results after a change.
    fn page_of(change: impl FnOnce(&mut Results)) -> String {
        let mut results = sample::paper();
        change(&mut results);
        html(&results, (&[], ""), &extras(&results).findings).unwrap()
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
        assert!(both.contains("<pre><code>lightfold encode scene color-cell=128 psnr=30</code></pre>"), "{both}");
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
    fn the_answer_comes_first_and_findings_without_figures_are_one_line() {
        let page = page_of(|results| results.measured.retain(|of| of.point.stream == Some(StreamKind::Color)));
        let body = page.find("</nav>").unwrap();
        let place =
            |what: &str| page[body..].find(what).map(|at| body + at).unwrap_or_else(|| panic!("{what}: {page}"));
        let order = [">Answer</h2>", ">Measured</h2>", ">Figures</h2>", ">Findings", ">All points</h2>", ">How this"]
            .map(place);
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
