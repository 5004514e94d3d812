//! Decoding by the error bound, beside depth without modelling functions (GDC figure 8).

use super::line::{chart, points};
use super::{Figure, Mark, extents, seconds_per_frame_ms, sheet, subtitle, timed};
use crate::report::plot::axis;
use crate::report::plot::chart::Rule;
use crate::report::tradeoff::point::Measured;
use crate::report::tradeoff::runs;
use crate::report::tradeoff::study::{Axis, Results, Study};

/// Size of each chart in pixels.
const CHART: [u32; 2] = [500, 330];

/// Decoding time, throughput and changed pixels by the bound; none for other knobs or where nothing was timed.
pub(super) fn figure(results: &Results, study: &Study, axis: &Axis) -> Option<Figure> {
    if axis.knob != "max-error" {
        return None;
    }
    let points = points(results, study, axis);
    let base = runs::in_boxes(results, &study.fixed);
    let charts = [
        panel("Decoding (ms a frame)", axis, &points, base, |x, point| {
            timed(x, &point.decode, seconds_per_frame_ms(point))
        }),
        panel("Throughput (Mpixel/s)", axis, &points, base, |x, point| {
            Some(Mark { x, y: point.megapixels_per_second()?, ..Mark::default() })
        }),
        panel("Pixels written (% of those shown)", axis, &points, base, |x, point| {
            Some(Mark { x, y: point.changed_percent(), ..Mark::default() })
        }),
    ];
    let row: Vec<_> = charts.into_iter().collect::<Option<_>>()?;
    let title = "Decoding by error bound (GDC figure 8)";
    let beside = match base {
        Some(_) => " The dashed line is depth in boxes of codes as they are, without modelling functions.",
        None => " Depth without modelling functions (--depth-codec aabb) was not measured.",
    };
    let caption = format!(
        "Time of decoding a frame (all probes and faces), pixels shown in a second and the part of them that was \
         written, by the bound E on the error of every pixel. Points are medians, bars span the shortest and the longest \
         run; a bar without an end is cut.{beside}"
    );
    let measured = points.iter().map(|(_, point)| *point);
    let drawing = sheet(title, &subtitle(results, study, &[], measured), vec![row]);
    Some(Figure { name: format!("{}-decoding", study.name), caption, drawing })
}

fn panel(
    title: &str,
    along: &Axis,
    points: &[(f64, &Measured)],
    base: Option<&Measured>,
    mark: impl Fn(f64, &Measured) -> Option<Mark>,
) -> Option<crate::report::plot::Drawing> {
    let marks: Vec<Mark> = points.iter().filter_map(|(x, point)| mark(*x, point)).collect();
    let base = base.and_then(|base| mark(0.0, base)).map(|mark| mark.y).filter(|y| y.is_finite());
    let values: Vec<f64> = extents(marks.iter()).into_iter().chain(base).collect();
    let mut chart = chart(title, along, vec![("modelling functions", marks)])?;
    chart.y = axis::Axis::linear(title, values);
    chart.rules = base.into_iter().map(|y| Rule { y, name: "boxes of codes".to_owned() }).collect();
    Some(chart.draw(CHART[0], CHART[1]))
}
