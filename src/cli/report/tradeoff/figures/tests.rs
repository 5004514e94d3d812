use std::collections::BTreeSet;

use proptest::prelude::*;

use super::common::{Mark, extents};
use super::*;
use crate::report::plot::drawing::{Anchor, Direction, Shape, Text};
use crate::report::plot::{Drawing, font, save};
use crate::report::tile_psnr;
use crate::report::tradeoff::point::{Measured, Point, Value};
use crate::report::tradeoff::tests::sample;
use codec::image::StreamKind;

/// Returns left, top, right and bottom of the area that a text's capitals cover.
fn bounds([x, y]: [f64; 2], text: &Text) -> [f64; 4] {
    let (width, height) = (text.width(), text.em * font::CAP_PER_EM);
    let before = match text.anchor {
        Anchor::Start => 0.0,
        Anchor::Middle => width / 2.0,
        Anchor::End => width,
    };
    match text.direction {
        Direction::Across => [x - before, y - height, x - before + width, y],
        Direction::Up => [x - height, y + before - width, x, y + before],
    }
}

/// Fails if a shape lies outside the drawing, a coordinate is not finite, or two texts overlap.
fn check(name: &str, drawing: &Drawing) {
    let (width, height) = (f64::from(drawing.width), f64::from(drawing.height));
    let inside = |[x, y]: [f64; 2]| (-0.5..=width + 0.5).contains(&x) && (-0.5..=height + 0.5).contains(&y);
    let mut texts: Vec<([f64; 4], &str)> = Vec::new();
    for shape in &drawing.shapes {
        let fine = match shape {
            Shape::Line { through, .. } => through.iter().all(|spot| inside(*spot)),
            Shape::Rectangle { from, to, .. } => inside(*from) && inside(*to),
            Shape::Polygon { corners, .. } => corners.iter().all(|spot| inside(*spot)),
            Shape::Disc { at, .. } => inside(*at),
            Shape::Text { at, text } => {
                let [left, top, right, bottom] = bounds(*at, text);
                texts.push(([left, top, right, bottom], &text.text));
                inside([left, top]) && inside([right, bottom])
            }
        };
        assert!(fine, "{name}: outside of {width}x{height}: {shape:?}");
    }
    for (at, (a, one)) in texts.iter().enumerate() {
        for (b, other) in &texts[at + 1..] {
            let apart = a[2] <= b[0] || b[2] <= a[0] || a[3] <= b[1] || b[3] <= a[1];
            assert!(apart, "{name}: {one:?} at {a:?} lies over {other:?} at {b:?}");
        }
    }
}

/// Fails if elements are not closed in order, or a numeric attribute is not a number.
fn check_xml(name: &str, svg: &str) {
    let mut open: Vec<&str> = Vec::new();
    for tag in svg.split('<').skip(1).map(|rest| rest.split_once('>').expect("tags end").0) {
        if let Some(closed) = tag.strip_prefix('/') {
            assert_eq!(open.pop(), Some(closed), "{name}");
        } else if !tag.ends_with('/') {
            open.push(tag.split_whitespace().next().unwrap());
        }
        assert_eq!(tag.matches('"').count() % 2, 0, "{name}: {tag}");
        assert!(!tag.contains("NaN") && !tag.contains("inf"), "{name}: {tag}");
        // Longer numbers would be coordinates that were clamped to the bound.
        let longest = tag.split(|letter: char| !letter.is_ascii_digit()).map(str::len).max();
        assert!(longest <= Some(6), "{name}: {tag}");
    }
    assert!(open.is_empty(), "{name}: {open:?}");
    for entity in svg.split('&').skip(1) {
        let known = ["amp;", "lt;", "gt;", "quot;", "apos;", "#39;"];
        assert!(known.iter().any(|known| entity.starts_with(known)), "{name}: &{}", &entity[..entity.len().min(9)]);
    }
}

fn check_all(results: &Results) -> Vec<Figure> {
    let mut figures = all(results);
    figures.extend(super::bounds(results));
    let names: BTreeSet<&str> = figures.iter().map(|figure| figure.name.as_str()).collect();
    assert_eq!(names.len(), figures.len(), "{names:?}");
    for figure in &figures {
        check(&figure.name, &figure.drawing);
        check_xml(&figure.name, &save::to_svg(&figure.drawing).unwrap());
        assert!(!figure.caption.contains("NaN") && figure.caption.ends_with('.'), "{}", figure.caption);
    }
    figures
}

#[test]
fn the_papers_figures_are_drawn() {
    let mut figures = check_all(&sample::paper());
    figures.extend(tile_psnr::figure(&sample::tiles(), "effort fast, domain log"));
    let names: Vec<&str> = figures.iter().map(|figure| figure.name.as_str()).collect();
    let expected = [
        "boxes",
        "cells",
        "bound",
        "color-rate-distortion",
        "color-time-distortion",
        "color-rate-time",
        "depth-rate-distortion",
        "depth-time-distortion",
        "depth-rate-time",
        "bound-decoding",
        "tile-psnr",
    ];
    assert_eq!(names, expected);
    assert!(figures.iter().all(|figure| !figure.caption.contains("usual")));
    let cells = &figures[1].caption;
    assert!(
        cells.contains("least bytes and time have color-cell=128 psnr=30, but points differ in quality"),
        "{cells}"
    );
    let tiles = figures.last().unwrap();
    assert!(tiles.caption.contains("effort fast, domain log"), "{}", tiles.caption);
    let boxes = &figures[0];
    assert!(boxes.caption.contains("best score has depth-window=1 max-aabbs=2"), "{}", boxes.caption);
    let svg = save::to_svg(&boxes.drawing).unwrap();
    for said in ["Times: medians of 3 runs", "all probes and faces", "other settings by default", "\n1.00\n"] {
        assert!(svg.contains(said), "{said}");
    }
    for said in ["AABB limit", "depth window (frames)", "Container (MB)", "Decoding (ms a frame)", "Score: size^0.25"] {
        assert!(svg.contains(said), "{said}");
    }
}

#[test]
fn pixels_are_not_blank_and_have_the_stated_size() {
    for figure in all(&sample::paper()).iter().take(2) {
        let pixels = save::to_pixels(&figure.drawing, 1).unwrap();
        assert_eq!((pixels.width(), pixels.height()), (figure.drawing.width, figure.drawing.height));
        let colours: BTreeSet<[u8; 3]> = pixels.data().iter().copied().collect();
        assert!(colours.len() > 100, "{}: {} colours", figure.name, colours.len());
        assert_eq!(pixels, save::to_pixels(&figure.drawing, 1).unwrap());
    }
}

/// Results with unusual content, by name.
fn odd() -> Vec<(&'static str, Results)> {
    let depth = StreamKind::Depth;
    let usual = |point: &Point| Some(sample::as_in_the_papers(point));
    let window: &[&str] = &["1", "2", "4", "8", "16"];
    let of = |axes: &[(&str, &[&str])], of: &dyn Fn(&Point) -> Option<Measured>| {
        sample::results(vec![sample::study("odd", depth, axes)], of)
    };
    let twenty: Vec<String> = (1..=20).map(|limit| limit.to_string()).collect();
    let twenty: Vec<&str> = twenty.iter().map(String::as_str).collect();
    let mut long = of(&[("depth-codec", &["quadtree", "aabb"]), ("depth-domain", &["log", "linear"])], &usual);
    long.input = "a folder with a name of more than sixty letters/and <another> & \"one\"/lightfield.json".repeat(2);
    long.studies[0].title =
        "A study whose title is so long that no picture is wide enough to show all of it ".repeat(3);
    for axis in &mut long.studies[0].axes {
        axis.values
            .iter_mut()
            .for_each(|value| *value = format!("{value} with words up to sixty letters, which is long"));
    }
    let points = long.studies[0].points();
    long.measured = points.into_iter().map(|point| sample::measured(&[], 5, 0.1).at(point)).collect();
    vec![
        ("one point", of(&[("depth-window", &["1"])], &usual)),
        ("one by seven", of(&[("depth-window", &["4"]), ("max-aabbs", &["1", "2", "3", "4", "6", "8", "16"])], &usual)),
        (
            "holes",
            of(&[("depth-window", window), ("max-aabbs", window)], &|point| {
                let odd = point.value("depth-window") == Some("4") || point.value("max-aabbs") == Some("1");
                (!odd).then(|| sample::as_in_the_papers(point))
            }),
        ),
        ("nothing measured", of(&[("depth-window", window), ("max-aabbs", window)], &|_| None)),
        (
            "one measured",
            of(&[("depth-window", window), ("max-aabbs", window)], &|point| {
                (point.value("depth-window") == point.value("max-aabbs") && point.value("max-aabbs") == Some("8"))
                    .then(|| sample::measured(&[], 77, 0.2))
            }),
        ),
        ("equal", of(&[("depth-window", window), ("max-aabbs", window)], &|_| Some(sample::measured(&[], 1000, 0.5)))),
        ("zeros", of(&[("depth-window", window), ("max-aabbs", window)], &|_| Some(sample::measured(&[], 0, 0.0)))),
        ("zeros in a row", of(&[("max-error", &["0", "10", "20"])], &|_| Some(sample::measured(&[], 0, 0.0)))),
        (
            "untimed",
            of(&[("max-error", &["0", "10", "20"])], &|point| {
                let mut of = sample::as_in_the_papers(point);
                of = of.without("decode_runs").without("encode_runs");
                Some(of)
            }),
        ),
        (
            "lossless",
            of(&[("max-error", &["0", "10", "20"])], &|point| {
                let mut of = sample::as_in_the_papers(point);
                of.set("psnr_db", Value::Number(f64::INFINITY));
                Some(of)
            }),
        ),
        ("twenty series", of(&[("max-aabbs", &twenty), ("depth-window", &twenty)], &usual)),
        ("words", of(&[("depth-codec", &["quadtree", "aabb", "bc4w"])], &usual)),
        (
            "three axes",
            of(
                &[("depth-window", window), ("max-aabbs", &["1", "4"]), ("effort", &["fast", "normal", "exhaustive"])],
                &usual,
            ),
        ),
        (
            "six combinations",
            of(
                &[
                    ("depth-window", window),
                    ("max-aabbs", &["1", "4"]),
                    ("depth-tile", &["1", "2", "3", "4", "5", "6"]),
                ],
                &usual,
            ),
        ),
        ("long", long),
        (
            "huge",
            of(&[("depth-window", window), ("max-aabbs", window)], &|point| {
                let mut of = sample::as_in_the_papers(point);
                of.set("bytes_container", Value::Count(u64::MAX / 2));
                of.set("decode_runs", Value::Runs(vec![1e9, 2e9]));
                Some(of)
            }),
        ),
    ]
}

#[test]
fn odd_results_are_drawn_without_overlaps_and_without_places_that_are_no_numbers() {
    for (name, results) in odd() {
        let figures = check_all(&results);
        let none = ["one point", "nothing measured"].contains(&name);
        assert_eq!(figures.is_empty(), none, "{name}");
        if name == "six combinations" {
            assert!(figures[0].caption.contains("2 more combinations"), "{}", figures[0].caption);
        }
        if name == "holes" {
            assert!(save::to_svg(&figures[0].drawing).unwrap().contains("\nnone\n"));
        }
        let names: Vec<&str> = figures.iter().map(|figure| figure.name.as_str()).collect();
        if name == "lossless" {
            assert!(names.contains(&"depth-rate-time") && !names.iter().any(|name| name.contains("distortion")));
            assert!(save::to_svg(&figures[0].drawing).unwrap().contains("\nlossless\n"));
        }
    }
}

/// Counts the lines of a given width in a figure; each series of its chart draws its own lines.
fn lines_of_width(figure: &Figure, width: f64) -> usize {
    let is = |shape: &&Shape| matches!(shape, Shape::Line { stroke, .. } if stroke.width == width);
    figure.drawing.shapes.iter().filter(is).count()
}

#[test]
fn points_of_one_number_are_joined_thinly_and_words_are_not_joined() {
    let of = |axes: &[(&str, &[&str])]| {
        let study = sample::study("joined", StreamKind::Depth, axes);
        all(&sample::results(vec![study], |point| Some(sample::as_in_the_papers(point))))
    };
    let threads = |figures: &[Figure]| lines_of_width(figures.last().unwrap(), 0.9);
    assert_eq!(threads(&of(&[("max-error", &["0", "10", "20"])])), 1);
    assert_eq!(threads(&of(&[("depth-codec", &["quadtree", "aabb"])])), 0);
    assert_eq!(threads(&of(&[("max-error", &["0", "10"]), ("depth-tile", &["1", "2"])])), 0);
    let grid = |columns: (&str, &[&str])| lines_of_width(&of(&[("max-error", &["5", "10"]), columns])[0], 1.8);
    assert!(grid(("depth-tile", &["1", "2"])) > grid(("depth-domain", &["log", "linear"])));
}

#[test]
fn spreads_count_from_their_least_end() {
    let mark = |y: f64, spread| Mark { y, spread: Some(spread), ..Mark::default() };
    let marks = [mark(10.0, (7.0, 11.0)), mark(12.0, (11.5, 90.0))];
    assert_eq!(extents(marks.iter()), [10.0, 7.0, 11.0, 12.0, 11.5, 24.0]);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn any_figures_can_be_drawn(
        values in prop::collection::vec(
            (any::<bool>(), 0u64..1 << 50, prop_oneof![Just(0.0), 1e-9f64..1e5],
                prop_oneof![Just(f64::INFINITY), Just(f64::NAN), 0.0f64..120.0]),
            12,
        ),
    ) {
        let mut rest = values.into_iter();
        let axes: &[(&str, &[&str])] = &[("depth-window", &["1", "2", "4"]), ("max-aabbs", &["1", "4", "8", "16"])];
        let results = sample::results(vec![sample::study("any", StreamKind::Depth, axes)], |_| {
            let (there, bytes, seconds, db) = rest.next()?;
            let mut of = sample::measured(&[], bytes, seconds);
            of.set("psnr_db", Value::Number(db));
            there.then_some(of)
        });
        for figure in all(&results) {
            check_xml(&figure.name, &save::to_svg(&figure.drawing).unwrap());
        }
    }
}

#[test]
#[ignore = "writes figures to look at into the folder that LIGHTFOLD_FIGURES names"]
fn write_figures() {
    let folder = std::path::PathBuf::from(std::env::var("LIGHTFOLD_FIGURES").unwrap());
    let named = odd().into_iter().chain([("paper", sample::paper())]);
    for (name, results) in named {
        let folder = folder.join(name.replace(' ', "-"));
        std::fs::create_dir_all(&folder).unwrap();
        let extras = crate::report::tradeoff::page::Extras::default();
        crate::report::tradeoff::page::write(&results, &extras, &folder).unwrap();
    }
}
