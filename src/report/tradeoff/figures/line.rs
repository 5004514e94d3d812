//! One knob: what each of its values costs and gives.

use super::{Figure, Mark, axis_of, extents, label_of, point_at, seconds_per_frame_ms, sheet, subtitle, timed};
use crate::dataset::stream::StreamKind;
use crate::report::plot::Drawing;
use crate::report::plot::axis;
use crate::report::plot::chart::{Chart, Kind, Series};
use crate::report::plot::marker::Look;
use crate::report::plot::number;
use crate::report::tradeoff::point::Measured;
use crate::report::tradeoff::study::{Axis, Results, Study};

/// Size of each chart in pixels.
const CHART: [u32; 2] = [500, 320];

/// Measured points of a study along its one axis, each with its place.
pub(super) fn points<'a>(results: &'a Results, study: &Study, axis: &Axis) -> Vec<(f64, &'a Measured)> {
    let (_, numbers) = axis_of(axis);
    let point = |value: &String| results.of(&point_at(study, [(axis.knob, value.clone())]));
    let mut found: Vec<(f64, &Measured)> =
        axis.values.iter().zip(numbers).filter_map(|(value, x)| Some((x, point(value)?))).collect();
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    found
}

/// A chart of one or more series along a knob.
pub(super) fn chart(title: &str, axis: &Axis, series: Vec<(&str, Vec<Mark>)>) -> Option<Chart> {
    let (x, _) = axis_of(axis);
    let kind = if axis.numbers().is_some() { Kind::Line } else { Kind::Points };
    let mut values = extents(series.iter().flat_map(|(_, marks)| marks));
    values.retain(|value| !value.is_nan());
    if values.is_empty() {
        return None;
    }
    let decibels = title.ends_with("(dB)");
    let each = values.iter().copied();
    let mut y = if decibels { axis::Axis::without_zero(title, each) } else { axis::Axis::linear(title, each) };
    if values.iter().any(|value| value.is_infinite()) {
        y = y.with_infinite("lossless");
    }
    let series = series.into_iter().filter(|(_, marks)| !marks.is_empty()).enumerate();
    let series =
        series.map(|(at, (name, marks))| Series { name: name.to_owned(), kind, look: Look::of(at), marks }).collect();
    Some(Chart { series, ..Chart::new(format!("{title} by {}", label_of(axis)), x, y) })
}

/// Sizes, quality and times along the axis.
pub(super) fn figure(results: &Results, study: &Study, axis: &Axis) -> Option<Figure> {
    let points = points(results, study, axis);
    let largest = points.iter().map(|(_, point)| point.sizes.container.max(point.sizes.lzma2)).max()?;
    let unit = number::bytes_unit(largest as f64);
    let of = |value: &dyn Fn(&Measured) -> Option<f64>| -> Vec<Mark> {
        points.iter().filter_map(|(x, point)| Some(Mark { x: *x, y: value(point)?, ..Mark::default() })).collect()
    };
    let size = |bytes: u64| Some(bytes as f64 / unit.size);
    let bytes = vec![
        ("container", of(&|point| size(point.sizes.container))),
        ("with LZMA2", of(&|point| size(point.sizes.lzma2))),
    ];
    let all_samples = if study.kind == StreamKind::Color { "all samples" } else { "" };
    let mut psnr = vec![(all_samples, of(&|point| Some(point.quality.psnr_db)))];
    if study.kind == StreamKind::Color {
        psnr.push(("worst cell", of(&|point| point.quality.min_psnr_db)));
    }
    let error = vec![("", of(&|point| point.quality.max_error_codes.map(f64::from)))];
    let ssim = vec![("", of(&|point| point.quality.ssim))];
    let decode = points.iter().filter_map(|(x, point)| timed(*x, &point.decode, seconds_per_frame_ms(point))).collect();
    let encode = points.iter().filter_map(|(x, point)| timed(*x, &point.encode, 1.0)).collect();
    let charts = [
        chart(&format!("Bytes ({})", unit.name), axis, bytes),
        chart("PSNR (dB)", axis, psnr),
        if study.kind == StreamKind::Color {
            chart("SSIM", axis, ssim)
        } else {
            let steps = if study.kind == StreamKind::Depth { "16-bit codes" } else { "8-bit steps" };
            chart(&format!("Largest error ({steps})"), axis, error)
        },
        chart("Decoding (ms a frame)", axis, vec![("", decode)]),
        chart("Encoding (s)", axis, vec![("", encode)]),
    ];
    let drawn: Vec<Drawing> = charts.into_iter().flatten().map(|chart| chart.draw(CHART[0], CHART[1])).collect();
    let rows: Vec<Vec<Drawing>> = drawn.chunks(3).map(<[Drawing]>::to_vec).collect();
    let caption = format!(
        "{}: bytes, quality and time by {}. Encoding includes reading the source; decoding is that of the container, without \
         LZMA2. Times are medians; bars span the shortest and the longest run, and a bar without an end is cut.",
        study.title,
        label_of(axis)
    );
    let measured = points.iter().map(|(_, point)| *point);
    let drawing = sheet(&study.title, &subtitle(results, study, &[], measured), rows);
    Some(Figure { name: study.name.clone(), caption, drawing })
}
