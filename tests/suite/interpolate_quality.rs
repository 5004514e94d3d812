//! Regression test of interpolated views against tests/baselines/interpolate.csv, one row for each scene and acquisition.
//!
//! `cargo test --test suite interpolate_quality::write_baselines -- --ignored` rewrites the file after an intended change.

use std::fmt::Write as _;

use codec::image::ToneMap;
use codec::math::{Camera, Lens};
use codec::monitor::Silent;
use epipolar::acquire::{AcquireSettings, Acquisition};
use epipolar::brute_force;
use epipolar::fill::HoleFilling;
use epipolar::interpolate::InterpolateSettings;
use epipolar::pipeline::{Request, RowsAtOnce, Settings, interpolate};
use epipolar::source::MAX_LAYERS;
use epipolar::view_store::Storage;
use epipolar::views::{OutputViews, Spread};
use evaluate::reference::Truth;
use evaluate::similarity::Similarity;
use scene::capture::SamplePattern;
use scene::{DemoKind, Play, Scene};

const FILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/baselines/interpolate.csv");
const HEAD: &str = "scene,acquisition,psnr_db,hole_pixels,source_pixels,lines,traced_pixels";
/// Tolerance in dB, and as a factor of counts: logarithms and square roots of other processors may move an edge.
const SLACK_DB: f64 = 0.05;
const SLACK: f64 = 1.02;

struct Row {
    name: String,
    psnr_db: f64,
    counts: [u64; 4],
}

/// Name, acquisition of sources, maximum number of layers, and hole filling.
type Way = (&'static str, Acquisition, usize, HoleFilling);

const WAYS: [Way; 4] = [
    ("center", Acquisition::Center, MAX_LAYERS, HoleFilling::Blank),
    ("dual", Acquisition::Dual, MAX_LAYERS, HoleFilling::Blank),
    ("hierarchical", Acquisition::Hierarchical, MAX_LAYERS, HoleFilling::Blank),
    // One layer has no surfaces behind the nearest, so there are holes to fill.
    ("center of one layer and filled", Acquisition::Center, 1, HoleFilling::Trace),
];

fn row(kind: DemoKind, (name, acquisition, layers, holes): Way) -> Row {
    let scene = Scene::open(kind.name(), Play::All).unwrap().0.at(0.0);
    // The camera of the other scenes would see nothing of the courtyard; its camera looks at the fence.
    let [eye, target] = match kind {
        DemoKind::Courtyard => [[-1.5, 1.4, -1.5], [-1.3, 1.2, 4.0]],
        _ => [[0.0, 1.5, 0.2], [2.0, 1.3, 0.0]],
    };
    let camera = Camera::look_at(eye.into(), target.into(), [0.0, 1.0, 0.0].into(), Lens::new(60.0)).unwrap();
    let views =
        OutputViews::new(camera.with_aspect(4.0 / 3.0), [80, 60], 9, Spread::Baseline(0.8), f64::INFINITY).unwrap();
    let samples = SamplePattern::new(4).unwrap();
    let settings = Settings {
        acquire: AcquireSettings { acquisition, layers, ..AcquireSettings::new(samples.clone()) },
        interpolate: InterpolateSettings::default(),
        holes,
        at_once: RowsAtOnce { acquired: 16, interpolated: 8 },
        storage: Storage::Memory,
        keeps_unfilled: true,
    };
    let mut sum = Similarity::empty();
    let summary = interpolate(&scene, &Request::all(&views, &settings), &Silent, |view, picture| {
        let color = brute_force::render(&scene, (&views, views.offsets_m[view]), &samples, &Silent)?;
        sum.merge(&Similarity::of(&picture.filled, &Truth { color, material: None }, ToneMap::default())?)
    });
    let counters = summary.unwrap().counters;
    let counts = [counters.hole_pixels, counters.source_pixels, counters.lines, counters.traced_pixels];
    Row { name: format!("{},{name}", kind.name()), psnr_db: sum.all.psnr_db(), counts }
}

fn rows() -> Vec<Row> {
    let kinds = [DemoKind::Courtyard, DemoKind::Interior, DemoKind::Mirrors, DemoKind::Cornell];
    kinds.into_iter().flat_map(|kind| WAYS.map(|way| row(kind, way))).collect()
}

#[test]
fn views_are_no_worse_than_before() {
    let text = std::fs::read_to_string(FILE).unwrap();
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some(HEAD));
    let rows = rows();
    assert_eq!(lines.clone().count(), rows.len());
    for (line, row) in lines.zip(rows) {
        let fields: Vec<&str> = line.split(',').collect();
        assert_eq!(fields[..2].join(","), row.name);
        let before: f64 = fields[2].parse().unwrap();
        assert!(row.psnr_db >= before - SLACK_DB, "{}: {:.2} dB, {before} before", row.name, row.psnr_db);
        for (count, before) in row.counts.iter().zip(&fields[3..]) {
            let before: f64 = before.parse().unwrap();
            assert!(*count as f64 <= before * SLACK + 8.0, "{}: {count}, {before} before", row.name);
        }
    }
}

#[test]
#[ignore = "writes tests/baselines/interpolate.csv"]
fn write_baselines() {
    let mut text = format!("{HEAD}\n");
    for Row { name, psnr_db, counts: [holes, pixels, lines, traced] } in rows() {
        writeln!(text, "{name},{psnr_db:.3},{holes},{pixels},{lines},{traced}").unwrap();
    }
    std::fs::write(FILE, text).unwrap();
}
