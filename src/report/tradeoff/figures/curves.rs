//! Rate and distortion, time and distortion, rate and time: all points of a kind with their Pareto front, whose points are
//! named (GDC figure 5).

use super::{Figure, Mark, sheet, times};
use crate::dataset::stream::StreamKind;
use crate::report::plot::axis;
use crate::report::plot::chart::{Chart, Kind, Series};
use crate::report::plot::marker::Look;
use crate::report::tradeoff::knob;
use crate::report::tradeoff::pareto;
use crate::report::tradeoff::point::Measured;
use crate::report::tradeoff::study::{Results, Study};

/// Size of the charts in pixels, with their legends.
const CHART: [u32; 2] = [980, 460];

/// What is read off an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Measure {
    Rate,
    Time,
    Distortion,
}

impl Measure {
    fn of(self, point: &Measured) -> Option<f64> {
        match self {
            Measure::Rate => Some(point.ratio_percent()),
            Measure::Time => point.decode_ms_per_frame(),
            Measure::Distortion => Some(point.quality.psnr_db),
        }
    }

    fn axis(self, values: &[f64]) -> axis::Axis {
        let each = values.iter().copied();
        match self {
            Measure::Rate => axis::Axis::logarithmic("container (% of raw footage)", each),
            Measure::Time => axis::Axis::logarithmic("decoding (ms a frame)", each),
            Measure::Distortion => {
                let axis = axis::Axis::without_zero("PSNR (dB)", each);
                if values.contains(&f64::INFINITY) { axis.with_infinite("lossless") } else { axis }
            }
        }
    }
}

/// A figure.
struct View {
    name: &'static str,
    title: &'static str,
    /// What is across, of which less is better.
    across: Measure,
    up: Measure,
    /// Where points are better.
    better: &'static str,
}

const VIEWS: [View; 3] = [
    View {
        name: "rate-distortion",
        title: "Rate and distortion",
        across: Measure::Rate,
        up: Measure::Distortion,
        better: "to the left and above",
    },
    View {
        name: "time-distortion",
        title: "Decoding time and distortion",
        across: Measure::Time,
        up: Measure::Distortion,
        better: "to the left and above",
    },
    View {
        name: "rate-time",
        title: "Rate and decoding time",
        across: Measure::Rate,
        up: Measure::Time,
        better: "to the left and below",
    },
];

/// A point with its place.
struct Placed<'a> {
    point: &'a Measured,
    x: f64,
    y: f64,
}

/// The figures of each kind with at least two points.
pub(super) fn figures(results: &Results) -> Vec<Figure> {
    let kinds = StreamKind::ALL.into_iter();
    kinds.flat_map(|kind| VIEWS.iter().filter_map(move |view| figure(results, kind, view))).collect()
}

fn figure(results: &Results, kind: StreamKind, view: &View) -> Option<Figure> {
    let of_kind = results.measured.iter().filter(|point| point.point.kind == kind);
    let points: Vec<Placed<'_>> = of_kind
        .filter_map(|point| Some(Placed { point, x: view.across.of(point)?, y: view.up.of(point)? }))
        .filter(|placed| placed.x.is_finite() && !placed.y.is_nan())
        .collect();
    // Where all is lossless there is no distortion to see.
    if points.len() < 2 || points.iter().all(|placed| placed.y.is_infinite()) {
        return None;
    }
    let quality = |y: f64| if view.up == Measure::Distortion { y } else { -y };
    let front = pareto::front(&points.iter().map(|placed| (placed.x, quality(placed.y))).collect::<Vec<_>>());
    let studies: Vec<&Study> = results.studies.iter().filter(|study| study.kind == kind).collect();

    let values = |of: fn(&Placed<'_>) -> f64| points.iter().map(of).collect::<Vec<f64>>();
    let (x, y) = (view.across.axis(&values(|placed| placed.x)), view.up.axis(&values(|placed| placed.y)));
    let key = front.iter().enumerate().map(|(rank, &at)| ((rank + 1).to_string(), points[at].point.point.words()));
    let chart = Chart {
        series: series(&studies, &points, &front),
        legend: "Study".to_owned(),
        front: front.iter().map(|&at| [points[at].x, points[at].y]).collect(),
        key: key.collect(),
        key_title: "Pareto front".to_owned(),
        ..Chart::new("", x, y)
    };
    let lossless = if view.up == Measure::Distortion && points.iter().any(|placed| placed.y.is_infinite()) {
        " What is lossless has a line of its own, to which the front is dotted: no decibels lie between."
    } else {
        ""
    };
    let psnr = match (view.up, kind) {
        (Measure::Distortion, StreamKind::Depth) => " PSNR is that of all samples, in 16-bit logarithmic codes.",
        (Measure::Distortion, _) => " PSNR is that of all samples.",
        _ => " Quality is not in this figure.",
    };
    let caption = format!(
        "Every point of {} measured, {} is better. The dashed line joins the Pareto front: points that no other beats in one \
         without losing in the other. Its points are numbered, and listed beside the chart. Thin lines join the points of a \
         study of one knob.{lossless}{psnr}",
        kind.name(),
        view.better,
    );
    let shows_time = [view.across, view.up].contains(&Measure::Time);
    let note = if shows_time { times(points.iter().map(|placed| placed.point)) } else { None };
    let lines: Vec<String> = [format!("{}, {} points", results.input, points.len())].into_iter().chain(note).collect();
    let title = format!("{} of {}", view.title, kind.name());
    let drawing = sheet(&title, &lines, vec![vec![chart.draw(CHART[0], CHART[1])]]);
    Some(Figure { name: format!("{}-{}", kind.name(), view.name), caption, drawing })
}

/// A series for each study; points that belong to several are with the first.
fn series(studies: &[&Study], points: &[Placed<'_>], front: &[usize]) -> Vec<Series> {
    let named = |at: usize| front.iter().position(|&on| on == at).map(|rank| (rank + 1).to_string());
    let members: Vec<_> = studies.iter().map(|study| study.points()).collect();
    let home = |placed: &Placed<'_>| members.iter().position(|points| points.contains(&placed.point.point));
    let homes: Vec<Option<usize>> = points.iter().map(home).collect();
    let of_study = |(number, study): (usize, &&Study)| {
        let mut own: Vec<usize> = (0..points.len()).filter(|&at| homes[at] == Some(number)).collect();
        let kind = match study.varied().as_slice() {
            [axis] if axis.numbers().is_some() => {
                let value = |at: usize| points[at].point.point.value(axis.knob).and_then(knob::number);
                own.sort_by(|&a, &b| value(a).partial_cmp(&value(b)).unwrap_or(std::cmp::Ordering::Equal));
                Kind::Thread
            }
            _ => Kind::Points,
        };
        let mark = |&at: &usize| Mark { x: points[at].x, y: points[at].y, spread: None, name: named(at) };
        let marks = own.iter().map(mark).collect();
        Series { name: study.title.clone(), kind, look: Look::of(number), marks }
    };
    let all = studies.iter().enumerate().map(of_study);
    all.filter(|series| !series.marks.is_empty()).collect()
}
