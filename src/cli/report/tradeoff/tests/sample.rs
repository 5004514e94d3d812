//! Points of the papers' studies, and tiles.

use crate::report::tradeoff::kind::CODING;
use crate::report::tradeoff::point::{Measured, Point, Value};
use crate::report::tradeoff::study::{Axis, Results, Study, Weights, all_points};
use codec::depth::domain::Domain;
use codec::depth::tile_psnr::TilePsnr;
use codec::effort::Effort;
use codec::image::StreamKind;

/// A depth point with the given settings, bytes and decoding time in seconds.
pub fn measured(settings: &[(&'static str, &str)], bytes: u64, seconds: f64) -> Measured {
    let settings = settings.iter().map(|(name, value)| (*name, (*value).to_owned())).collect();
    let mut of = Measured::new(&CODING, Point::new(&CODING, Some(StreamKind::Depth), settings));
    for (name, count) in [
        ("bytes_raw", 20_000_000),
        ("bytes_temporal", bytes * 2),
        ("bytes_spatial", bytes),
        ("bytes_container", bytes),
        ("bytes_lzma2", bytes / 2),
        ("max_error_codes", 50),
        ("frames", 30),
        ("images", 180),
        ("pixels", 180 * 256 * 256),
        ("updated_pixels", 60 * 256 * 256),
        ("decode_passes", 9),
        ("encode_peak_bytes", 50_000_000),
        ("decode_peak_bytes", 20_000_000),
    ] {
        of.set(name, Value::Count(count));
    }
    of.set("psnr_db", Value::Number(60.0));
    of.set("max_error_m", Value::Number(0.01));
    of.set("encode_runs", Value::Runs(vec![1.0, 1.1, 0.9]));
    of.set("decode_runs", Value::Runs(vec![seconds * 0.97, seconds, seconds * 1.05]));
    of
}

/// A study of all combinations of values of some knobs.
pub fn study(name: &str, kind: StreamKind, axes: &[(&str, &[&str])]) -> Study {
    let axis = |(name, values): &(&str, &[&str])| Axis {
        knob: CODING.knob(name).map_or("", |knob| knob.name),
        values: values.iter().map(|value| (*value).to_owned()).collect(),
    };
    Study {
        name: name.to_owned(),
        title: format!("Study {name}"),
        sweep: &CODING,
        stream: Some(kind),
        axes: axes.iter().map(axis).collect(),
        fixed: vec![],
    }
}

pub fn results(studies: Vec<Study>, mut of: impl FnMut(&Point) -> Option<Measured>) -> Results {
    let points = all_points(&studies);
    Results {
        sweep: &CODING,
        about: "Less is better for bytes, time and score.".to_owned(),
        commands: vec![],
        input: "scene/lightfield.json".to_owned(),
        command_line: "lightfold tradeoff scene/lightfield.json --preset paper -o out".to_owned(),
        machine: "A Processor, 2 threads, 8 GiB of memory, linux".to_owned(),
        measured: points.iter().filter_map(|point| Some(of(point)?.at(point.clone()))).collect(),
        point_commands: points.iter().map(|point| format!("lightfold encode scene {}", point.words())).collect(),
        studies,
        left_out: vec![],
        weights: Weights::default(),
    }
}

/// Values of a point of the papers' studies that agree with all claims of the papers.
pub fn as_in_the_papers(point: &Point) -> Measured {
    let number = |name: &str| point.number(name);
    if point.stream == Some(StreamKind::Color) {
        let (cell, psnr) = (number("color-cell").unwrap_or(64.0), number("psnr").unwrap_or(40.0));
        let bytes = 1e5 * 10f64.powf((psnr - 30.0) / 15.0) * (1.0 + 1.0 / cell);
        let mut of = measured(&[], bytes as u64, 0.05 * (1.0 + 30.0 / cell));
        of = of.without("max_error_codes").without("max_error_m");
        of.set("psnr_db", Value::Number(psnr + 3.0));
        of.set("min_psnr_db", Value::Number(psnr));
        of.set("ssim", Value::Number(0.99));
        return of;
    }
    let (limit, window) = (number("max-aabbs").unwrap_or(8.0), number("depth-window").unwrap_or(1.0));
    let error = if point.value("depth-codec") == Some("aabb") { 0.0 } else { number("max-error").unwrap_or(50.0) };
    let bytes = 4e6 * (1.0 + 0.5 / limit) * window.powf(0.8) / (1.0 + error / 60.0);
    let boxes = point.value("depth-codec") == Some("aabb") || point.value("max-aabbs").is_some();
    let slower = if boxes { 4.0 } else { 1.0 };
    let seconds = 0.04 * slower * window.sqrt() * (1.0 + 0.03 * limit) / (1.0 + error / 400.0);
    let mut of = measured(&[], bytes as u64, seconds);
    let psnr = if error == 0.0 { f64::INFINITY } else { 96.0 - 20.0 * (1.0 + error / 3.0).log10() };
    of.set("psnr_db", Value::Number(psnr));
    of.set("max_error_codes", Value::Count(error as u64));
    of
}

/// PSNR of tiles: most are smooth, some have an edge, some have noise.
pub fn tiles() -> TilePsnr {
    let mut all = TilePsnr::default();
    let domain = Domain::log();
    let picture: Vec<u16> = (0..64u32 * 64)
        .map(|at| {
            let (x, y) = (at % 64, at / 64);
            let noise = x.wrapping_mul(2_654_435_761).wrapping_add(y.wrapping_mul(40_503)) >> 7;
            match (x / 8 + y / 8) % 4 {
                0 => 30_000 + x * 40 + y * 25,
                1 => 20_000 + (x * x + 3 * y * y) / 2,
                2 => {
                    if x % 8 > y % 8 {
                        41_000 + 9 * x
                    } else {
                        9_000 + 5 * y
                    }
                }
                _ => {
                    if (x * 7 + y * 3) % 5 > 2 {
                        36_000 + noise % 90
                    } else {
                        22_000 + noise % 60
                    }
                }
            }
            .min(65_534) as u16
        })
        .collect();
    for y in (0..64).step_by(8) {
        all.add(&TilePsnr::of_row(&picture, 64, y, (&domain, Effort::Fast)));
    }
    all
}

/// The papers' studies with results that agree with the papers.
pub fn paper() -> Results {
    let five: &[&str] = &["1", "2", "4", "8", "16"];
    let bound =
        study("bound", StreamKind::Depth, &[("max-error", &["0", "10", "25", "50", "100", "200", "400", "800"])]);
    results(
        vec![
            study("boxes", StreamKind::Depth, &[("depth-window", five), ("max-aabbs", five)]),
            study(
                "cells",
                StreamKind::Color,
                &[("color-cell", &["8", "16", "32", "64", "128"]), ("psnr", &["30", "35", "40", "45", "50"])],
            ),
            Study { fixed: vec![("depth-codec", "quadtree".to_owned())], ..bound },
            study("codecs", StreamKind::Depth, &[("depth-codec", &["aabb"])]),
        ],
        |point| Some(as_in_the_papers(point)),
    )
}
