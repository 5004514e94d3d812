//! Rate and distortion, time and distortion: all points of a kind with their Pareto front, whose points are named (GDC
//! figure 5).

use super::{Figure, Mark, sheet};
use crate::dataset::stream::StreamKind;
use crate::report::plot::axis;
use crate::report::plot::chart::{Chart, Kind, Series};
use crate::report::plot::marker::Look;
use crate::report::tradeoff::pareto;
use crate::report::tradeoff::point::{Measured, Point};
use crate::report::tradeoff::study::Results;

/// Size of the charts in pixels, with their legends.
const CHART: [u32; 2] = [980, 460];

/// What a point costs.
struct Cost {
    name: &'static str,
    title: &'static str,
    axis: &'static str,
    of: fn(&Measured) -> Option<f64>,
}

const COSTS: [Cost; 2] = [
    Cost {
        name: "rate-distortion",
        title: "Rate and distortion",
        axis: "container (% of raw footage)",
        of: |point| Some(point.ratio_percent()),
    },
    Cost {
        name: "time-distortion",
        title: "Decoding time and distortion",
        axis: "decoding (ms a frame)",
        of: Measured::decode_ms_per_frame,
    },
];

/// Both figures for each kind with at least two points.
pub(super) fn figures(results: &Results) -> Vec<Figure> {
    let kinds = StreamKind::ALL.into_iter();
    kinds.flat_map(|kind| COSTS.iter().filter_map(move |cost| figure(results, kind, cost))).collect()
}

fn figure(results: &Results, kind: StreamKind, cost: &Cost) -> Option<Figure> {
    let of_kind = results.measured.iter().filter(|point| point.point.kind == kind);
    let points: Vec<(&Measured, f64, f64)> = of_kind
        .filter_map(|point| Some((point, (cost.of)(point)?, point.quality.psnr_db)))
        .filter(|(_, cost, db)| cost.is_finite() && !db.is_nan())
        .collect();
    if points.len() < 2 {
        return None;
    }
    let front = pareto::front(&points.iter().map(|(_, cost, db)| (*cost, *db)).collect::<Vec<_>>());
    let named = |at: usize| front.iter().position(|&on| on == at).map(|rank| (rank + 1).to_string());

    let studies: Vec<_> = results.studies.iter().filter(|study| study.kind == kind).collect();
    let belongs = |point: &Point| studies.iter().position(|study| study.points().contains(point));
    let home: Vec<Option<usize>> = points.iter().map(|(point, ..)| belongs(&point.point)).collect();
    let series: Vec<Series> = studies
        .iter()
        .enumerate()
        .map(|(number, study)| {
            let own = points.iter().enumerate().filter(|(at, _)| home[*at] == Some(number));
            let marks = own.map(|(at, (_, cost, db))| Mark { x: *cost, y: *db, spread: None, name: named(at) });
            Series { name: study.title.clone(), kind: Kind::Points, look: Look::of(number), marks: marks.collect() }
        })
        .filter(|series| !series.marks.is_empty())
        .collect();

    let mut y = axis::Axis::without_zero("PSNR (dB)", points.iter().map(|(.., db)| *db));
    if points.iter().any(|(.., db)| db.is_infinite()) {
        y = y.with_infinite("lossless");
    }
    let x = axis::Axis::logarithmic(cost.axis, points.iter().map(|(_, cost, _)| *cost));
    let title = format!("{} of {}", cost.title, kind.name());
    let chart = Chart {
        series,
        legend: "Study".to_owned(),
        front: front.iter().map(|&at| [points[at].1, points[at].2]).collect(),
        key: front
            .iter()
            .enumerate()
            .map(|(rank, &at)| ((rank + 1).to_string(), settings(&points[at].0.point)))
            .collect(),
        key_title: "Pareto front".to_owned(),
        ..Chart::new("", x, y)
    };
    let caption = format!(
        "Every point of {} measured, to the left and above is better. The dashed line joins the Pareto front: points that \
         no other beats in one without losing in the other. {} PSNR is that of all samples{}.",
        kind.name(),
        "Its points are numbered, and listed beside the chart.",
        if kind == StreamKind::Depth { ", in 16-bit logarithmic codes" } else { "" }
    );
    let subtitle = format!("{}, {} points", results.input, points.len());
    let drawing = sheet(&title, &subtitle, vec![vec![chart.draw(CHART[0], CHART[1])]]);
    Some(Figure { name: format!("{}-{}", kind.name(), cost.name), caption, drawing })
}

/// A point's settings, as short as they are on the command line.
fn settings(point: &Point) -> String {
    let words: Vec<String> = point.settings.iter().map(|(name, value)| format!("{name}={value}")).collect();
    if words.is_empty() { "usual settings".to_owned() } else { words.join(" ") }
}
