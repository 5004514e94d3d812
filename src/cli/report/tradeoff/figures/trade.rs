//! Figures of one measure against another: all points of a kind of stream with their Pareto front, whose points are
//! labelled (CALF figure 9, GDC figure 5).

use super::common::{Mark, axis_of, times};
use crate::report::plot::Figure;
use crate::report::plot::chart::{Chart, Kind, Series};
use crate::report::plot::labels::sheet;
use crate::report::plot::marker::Look;
use crate::report::tradeoff::kind::{Better, Trade, TradeAxis};
use crate::report::tradeoff::point::{Measured, words};
use crate::report::tradeoff::study::{Results, Study};
use codec::image::StreamKind;

const CHART: [u32; 2] = [980, 460];

struct PlacedPoint<'a> {
    point: &'a Measured,
    x: f64,
    y: f64,
}

pub fn figures(results: &Results) -> Vec<Figure> {
    let streams = results.streams().into_iter();
    streams
        .flat_map(|stream| results.sweep.trades.iter().filter_map(move |trade| figure(results, stream, trade)))
        .collect()
}

fn figure(results: &Results, stream: Option<StreamKind>, trade: &Trade) -> Option<Figure> {
    let own = results.measured.iter().filter(|point| point.point.stream == stream);
    let points: Vec<PlacedPoint<'_>> = own
        .filter_map(|point| {
            let [x, y] = [&trade.across, &trade.up].map(|axis| point.drawn(axis.measure));
            Some(PlacedPoint { point, x: x?, y: y? })
        })
        .filter(|placed| placed.x.is_finite() && !placed.y.is_nan())
        .collect();
    // There is no distortion to plot if all points are lossless.
    if points.len() < 2 || points.iter().all(|placed| placed.y.is_infinite()) {
        return None;
    }
    let is_more = trade.better == Better::More;
    let quality = |y: f64| if is_more { y } else { -y };
    let front = front_of(&points.iter().map(|placed| (placed.x, quality(placed.y))).collect::<Vec<_>>());
    let studies: Vec<&Study> = results.studies.iter().filter(|study| study.stream == stream).collect();
    let values = |of: fn(&PlacedPoint<'_>) -> f64| points.iter().map(of).collect::<Vec<f64>>();
    let x = axis_of(trade.across.scale, trade.across.label, &values(|placed| placed.x));
    let y = axis_of(trade.up.scale, trade.up.label, &values(|placed| placed.y));
    let key = front.iter().enumerate().map(|(rank, &at)| ((rank + 1).to_string(), points[at].point.point.words()));
    // Sweeps without streams have one study.
    let (series, legend, joined) = match stream {
        None => (by_last_knob(&studies, &points, &front), "Settings", "that differ in the last knob only"),
        Some(_) => (by_study(&studies, &points, &front), "Study", "of a study of one knob"),
    };
    let chart = Chart {
        series,
        legend: legend.to_owned(),
        front: front.iter().map(|&at| [points[at].x, points[at].y]).collect(),
        key: key.collect(),
        key_title: "Pareto front".to_owned(),
        ..Chart::new("", x, y)
    };
    let lossless = match points.iter().any(|placed| placed.y.is_infinite()) {
        true => " Lossless points have a line of their own, to which the front is dotted.",
        false => "",
    };
    let above = if is_more { "above" } else { "below" };
    let caption = format!(
        "All points{}; points to the left and {above} are better. The dashed line joins the Pareto front: points that no other \
         beats in one measure without losing in the other. Its points are numbered, and listed beside the chart. Thin lines \
         join points {joined}.{lossless}{}",
        stream.map_or_else(String::new, |stream| format!(" of {}", stream.name())),
        trade.note,
    );
    let mut lines = vec![format!("{}, {} points", results.input, points.len())];
    let has_runs = |axis: &TradeAxis| results.sweep.measure(axis.measure).is_some_and(|of| of.runs.is_some());
    if has_runs(&trade.across) || has_runs(&trade.up) {
        lines.extend(times(points.iter().map(|placed| placed.point)));
    }
    let title = stream.map_or_else(|| trade.title.to_owned(), |stream| format!("{} of {}", trade.title, stream.name()));
    let drawing = sheet(&title, &lines, vec![vec![chart.draw(CHART[0], CHART[1])]]);
    let stem = stream.map_or(results.sweep.stem, StreamKind::name);
    Some(Figure { name: format!("{stem}-{}", trade.name), caption, drawing })
}

fn mark(points: &[PlacedPoint<'_>], front: &[usize], at: usize) -> Mark {
    let name = front.iter().position(|&on| on == at).map(|rank| (rank + 1).to_string());
    Mark { x: points[at].x, y: points[at].y, spread: None, name }
}

/// Returns a series per study. Points of several studies belong to the first.
fn by_study(studies: &[&Study], points: &[PlacedPoint<'_>], front: &[usize]) -> Vec<Series> {
    let members: Vec<_> = studies.iter().map(|study| study.points()).collect();
    let home = |placed: &PlacedPoint<'_>| members.iter().position(|points| points.contains(&placed.point.point));
    let homes: Vec<Option<usize>> = points.iter().map(home).collect();
    let of_study = |(number, study): (usize, &&Study)| {
        let mut own: Vec<usize> = (0..points.len()).filter(|&at| homes[at] == Some(number)).collect();
        let kind = match study.varied().as_slice() {
            [axis] if axis.numbers().is_some() => {
                let value = |at: usize| points[at].point.point.number(axis.knob);
                own.sort_by(|&a, &b| value(a).partial_cmp(&value(b)).unwrap_or(std::cmp::Ordering::Equal));
                Kind::Thread
            }
            _ => Kind::Points,
        };
        let marks = own.into_iter().map(|at| mark(points, front, at)).collect();
        Series { name: study.title.clone(), kind, look: Look::of(number), marks }
    };
    let all = studies.iter().enumerate().map(of_study);
    all.filter(|series| !series.marks.is_empty()).collect()
}

/// Returns a series per setting of all knobs except the last of the study.
fn by_last_knob(studies: &[&Study], points: &[PlacedPoint<'_>], front: &[usize]) -> Vec<Series> {
    let last = studies.first().and_then(|study| study.axes.last()).map_or("", |axis| axis.knob);
    let mut all: Vec<Series> = Vec::new();
    for (at, placed) in points.iter().enumerate() {
        let name = words(&placed.point.point.without(last)).unwrap_or_default();
        let mark = mark(points, front, at);
        match all.iter_mut().find(|series| series.name == name) {
            Some(series) => series.marks.push(mark),
            None => all.push(Series { name, kind: Kind::Thread, look: Look::of(all.len()), marks: vec![mark] }),
        }
    }
    all
}

/// Returns the indices of the (cost, quality) points on the Pareto front, in order of cost. A point is on the front if
/// no other has at most its cost and at least its quality, with one of them better. Of equal points, the first is kept.
///
/// Points with NaN are never on the front. Infinite quality is better than any other.
fn front_of(points: &[(f64, f64)]) -> Vec<usize> {
    let mut order: Vec<usize> =
        (0..points.len()).filter(|&at| !points[at].0.is_nan() && !points[at].1.is_nan()).collect();
    // Sorts by cost, then by decreasing quality. The sort is stable: the first of equal points stays first.
    order.sort_by(|&a, &b| points[a].0.total_cmp(&points[b].0).then(points[b].1.total_cmp(&points[a].1)));
    let mut best = None;
    order.retain(|&at| {
        let leads = best.is_none_or(|best| points[at].1 > best);
        best = if leads { Some(points[at].1) } else { best };
        leads
    });
    order
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn the_front_rises() {
        let points = [(3.0, 40.0), (1.0, 30.0), (2.0, 29.0), (3.0, 41.0), (9.0, f64::INFINITY), (9.5, f64::INFINITY)];
        assert_eq!(front_of(&points), [1, 3, 4]);
        assert_eq!(front_of(&[(1.0, 1.0), (1.0, 1.0), (f64::NAN, 9.0)]), [0]);
        assert_eq!(front_of(&[]), [0usize; 0]);
    }

    proptest! {
        #[test]
        fn exactly_what_is_dominated_is_off_the_front(
            points in prop::collection::vec((0u8..12, 0u8..12), 0..24),
        ) {
            let points: Vec<(f64, f64)> = points.into_iter().map(|(a, b)| (f64::from(a), f64::from(b))).collect();
            let found = front_of(&points);
            for (at, &(cost, quality)) in points.iter().enumerate() {
                let better = points.iter().enumerate().any(|(other, &(c, q))| {
                    c <= cost && q >= quality && (c < cost || q > quality || other < at)
                });
                prop_assert_eq!(found.contains(&at), !better, "{:?} {:?}", points, found);
            }
        }
    }
}
