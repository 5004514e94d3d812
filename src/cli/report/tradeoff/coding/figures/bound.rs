//! Decoding time by error bound, compared with depth without modelling functions (GDC figure 8).

use crate::report::plot::chart::Rule;
use crate::report::plot::{Drawing, axis};
use crate::report::tradeoff::coding::runs;
use crate::report::tradeoff::figures::{Along, Figure, along, extents, sheet, subtitle};
use crate::report::tradeoff::kind::{Measured, Panel, PanelLine, Scale};
use crate::report::tradeoff::study::{Axis, Results, Study};

const CHART: [u32; 2] = [500, 330];

const fn line(measure: &'static str) -> PanelLine {
    PanelLine { label: "within the bound", measure }
}

const PANELS: [Panel; 3] = [
    Panel::new("Decoding (ms a frame)", Scale::Linear, &[line("decode_ms_per_frame")]),
    Panel::new("Throughput (Mpixel/s)", Scale::Linear, &[line("megapixels_per_second")]),
    Panel::new("Pixels written (% of those shown)", Scale::Linear, &[line("changed_percent")]),
];

/// Returns a figure for each timed study that varies only the error bound.
pub fn figures(results: &Results) -> Vec<Figure> {
    let of = |study: &Study| match study.varied().as_slice() {
        [axis] if axis.knob == "max-error" => figure(results, study, axis),
        _ => None,
    };
    results.studies.iter().filter_map(of).collect()
}

fn figure(results: &Results, study: &Study, axis: &Axis) -> Option<Figure> {
    let along = along(results, study, axis);
    let base = runs::in_boxes(results, &study.fixed);
    let row: Vec<Drawing> = PANELS.iter().map(|panel| draw(panel, &along, base)).collect::<Option<_>>()?;
    let beside = match base {
        Some(_) => " The dashed line is depth in boxes of codes, without modelling functions.",
        None => " Depth without modelling functions (depth-codec aabb) was not measured.",
    };
    let caption = format!(
        "Time of decoding a frame (all probes and faces), pixels shown in a second and the part of them that was \
         written, by the bound E on the error of every pixel. Points are medians, bars span the shortest and the longest \
         run; a bar without an end is cut.{beside}"
    );
    let measured = along.points.iter().map(|of| of.point);
    let lines = subtitle(results, study, &[], measured);
    let drawing = sheet("Decoding by error bound (GDC figure 8)", &lines, vec![row]);
    Some(Figure { name: format!("{}-decoding", study.name), caption, drawing })
}

fn draw(panel: &Panel, along: &Along<'_>, base: Option<&Measured>) -> Option<Drawing> {
    let mut chart = along.chart(panel)?;
    let base = base.and_then(|base| base.number(panel.lines.first()?.measure)).filter(|y| y.is_finite());
    let marks = chart.series.iter().flat_map(|series| &series.marks);
    chart.y = axis::Axis::linear(panel.title, extents(marks).into_iter().chain(base).collect::<Vec<_>>());
    chart.rules = base.into_iter().map(|y| Rule { y, name: "boxes of codes".to_owned() }).collect();
    Some(chart.draw(CHART[0], CHART[1]))
}
