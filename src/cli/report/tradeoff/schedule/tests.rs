use std::cell::RefCell;
use std::ffi::OsString;
use std::path::Path;

use serde_json::{Value, json};
use tempfile::TempDir;

use super::*;
use crate::child::shell_line;
use crate::report::tradeoff::coding::{CODING, CodingBench, Input};
use crate::report::tradeoff::plan::{Sweep, plan};
use crate::report::tradeoff::point::Value as Stored;
use codec::error::Error;
use codec::image::StreamKind;
use codec::monitor::Silent;

/// Runner without processes: records the command lines, advances a clock, and returns reports like those of the
/// commands.
#[derive(Default)]
struct Fake {
    lines: RefCell<Vec<String>>,
    clock: RefCell<f64>,
    /// Index of the run that ends with an error, from 0.
    stops_at: Option<usize>,
    /// Commands that contain this text fail.
    fails: Option<&'static str>,
    /// Additional seconds of commands whose line contains these words.
    slow: Option<(&'static str, f64)>,
}

impl Fake {
    /// Returns the subcommands that ran, each with its values of `color-cell`, `psnr` and `max-error`.
    fn told(&self) -> Vec<String> {
        let of = |line: &String, name: &str| {
            let value = line.split(&format!("--{name}=")).nth(1)?;
            Some(value.split(' ').next()?.to_owned())
        };
        let told = self.lines.borrow();
        told.iter()
            .map(|line| {
                let command = line.split(' ').nth(1).unwrap();
                let values = ["color-cell", "psnr", "max-error"].iter().filter_map(|name| of(line, name));
                std::iter::once(command.to_owned()).chain(values).collect::<Vec<_>>().join(" ")
            })
            .collect()
    }

    fn encodes(&self) -> Vec<String> {
        self.told().into_iter().filter_map(|line| line.strip_prefix("encode ").map(str::to_owned)).collect()
    }
}

impl Runner for Fake {
    fn run(&self, words: &[OsString]) -> Result<Value> {
        let line = shell_line(words);
        if self.stops_at == Some(self.lines.borrow().len()) {
            return Err(Error::Interrupted);
        }
        *self.clock.borrow_mut() += 1.0;
        if self.fails.is_some_and(|words| line.contains(words)) {
            return Err(Error::invalid(format!("{line}: it broke")));
        }
        *self.clock.borrow_mut() += self.slow.filter(|(words, _)| line.contains(words)).map_or(0.0, |(_, more)| more);
        let number = self.lines.borrow().len();
        // Each option makes the output smaller.
        let bytes = 1000 - line.replace(" --no-compression", "").len();
        self.lines.borrow_mut().push(line);
        let quality = json!({ "psnr_db": null, "psnr_db_is": "inf", "min_cell_psnr_db": 41.5, "ssim": 0.9, "max_error_codes": 3, "max_error_m": 0.5 });
        Ok(match words[0].to_str().unwrap() {
            "encode" => json!({ "seconds": number, "bytes": bytes, "raw_bytes": 5000, "peak_memory_bytes": 77 }),
            "decode" => json!({ "seconds": 0.0, "frames": 36, "pixels": 100, "updated_pixels": 40, "device": "cpu" }),
            "diff" => json!({ "color": quality, "depth": quality }),
            "pack" => json!({ "bytes": bytes / 2 }),
            other => panic!("{other}"),
        })
    }

    fn now_seconds(&self) -> f64 {
        *self.clock.borrow()
    }
}

fn input() -> Input {
    Input {
        path: "scene".into(),
        encoder: "encode",
        kinds: vec![(StreamKind::Color, 6), (StreamKind::Depth, 6)],
        encode: Vec::new(),
        diff: Vec::new(),
        decode: Vec::new(),
        made_of: 7,
    }
}

fn studies(sweeps: &[&str]) -> Vec<Study> {
    let sweeps: Vec<_> = sweeps.iter().map(|text| Sweep::parse(text).unwrap()).collect();
    let kinds = [StreamKind::Color, StreamKind::Depth];
    plan(&kinds, &sweeps, None, &[]).unwrap().studies
}

/// Measures into a folder, starting from its existing results.
fn run(fake: &Fake, sweeps: &[&str], extent: Extent, folder: &Path) -> Result<(Schedule, Store)> {
    let (input, mut store) = (input(), Store::open(&CODING, folder, Some(7)).unwrap());
    let mut bench = CodingBench::new(&input, Path::new("work"));
    let lab = Lab { runner: fake, bench: &mut bench, store: &mut store };
    let outcome = measure(&studies(sweeps), extent, lab, &Silent)?;
    Ok((outcome, store))
}

fn all(repeats: u32) -> Extent {
    Extent { repeats, budget_seconds: None }
}

#[test]
fn rounds_go_to_and_fro_after_a_first_pass_that_is_not_timed() {
    let (fake, folder) = (Fake::default(), TempDir::new().unwrap());
    let (outcome, store) = run(&fake, &["psnr=30,40,50"], all(3), folder.path()).unwrap();
    // The survey needs no second encoding for temporal coding: colour without blocks is temporal coding already.
    assert_eq!(fake.encodes(), ["30", "40", "50", "30", "40", "50", "50", "40", "30", "30", "40", "50"]);
    let point = &["encode 30", "decode", "diff", "pack"].map(str::to_owned);
    assert_eq!(&fake.told()[..4], point);
    assert_eq!(&fake.told()[12..16], ["encode 30", "decode", "encode 40", "decode"]);
    assert!(fake.lines.borrow()[1].contains("--repeat=1 "), "{}", fake.lines.borrow()[1]);
    assert!(fake.lines.borrow()[13].contains("--repeat=200 "), "{}", fake.lines.borrow()[13]);
    assert_eq!(outcome, Schedule { studies: studies(&["psnr=30,40,50"]), left_out: Vec::new(), failed: Vec::new() });
    let runs: Vec<_> = store.rows.iter().map(|row| row.measured.runs("encode_runs").to_vec()).collect();
    assert_eq!(runs, [[12.0, 22.0, 24.0], [14.0, 20.0, 26.0], [16.0, 18.0, 28.0]]);
    let row = &store.rows[0];
    let counts = ["frames", "images", "encode_peak_bytes"].map(|name| row.measured.count(name));
    assert_eq!(counts, [6, 36, 77]);
    assert_eq!(["psnr_db", "min_psnr_db"].map(|name| row.measured.number(name)), [Some(f64::INFINITY), Some(41.5)]);
    assert_eq!(row.command, "lightfold encode scene --stream=color --psnr=30 --no-compression --clip -o point.lfold");
}

#[test]
fn sizes_of_stages_are_encoded_once_for_all_points() {
    let (fake, folder) = (Fake::default(), TempDir::new().unwrap());
    let (_, store) = run(&fake, &["max-error=0,50", "lzma2=none,9"], all(1), folder.path()).unwrap();
    let lines = fake.lines.borrow();
    let count = |words: &str| lines.iter().filter(|line| line.contains(words)).count();
    assert_eq!(count("--depth-codec=aabb"), 1, "coding in time is the same for all bounds");
    assert_eq!(count("--lzma2=6"), 2, "what has LZMA2 already is not packed");
    // Four points are encoded twice each. Without LZMA2, two of them are the same as other known points.
    assert_eq!(count("encode scene"), 4 * 2 + 1);
    for row in &store.rows {
        let [spatial, container, lzma2] =
            ["bytes_spatial", "bytes_container", "bytes_lzma2"].map(|name| row.measured.count(name));
        match row.measured.point.value("lzma2") {
            Some("9") => assert!(lzma2 == container && spatial > container),
            _ => assert!(spatial == container && lzma2 < container),
        }
    }
}

#[test]
fn a_second_time_nothing_runs_and_more_repeats_add_rounds() {
    let folder = TempDir::new().unwrap();
    let sweeps = ["psnr=30,40"];
    let (_, first) = run(&Fake::default(), &sweeps, all(2), folder.path()).unwrap();
    let again = Fake::default();
    let (_, second) = run(&again, &sweeps, all(2), folder.path()).unwrap();
    assert_eq!((again.told().len(), &second.rows), (0, &first.rows));
    let more = Fake::default();
    let (_, third) = run(&more, &sweeps, all(3), folder.path()).unwrap();
    assert_eq!(more.told(), ["encode 30", "decode", "encode 40", "decode"]);
    assert_eq!(third.rows[0].measured.runs("encode_runs")[..2], *first.rows[0].measured.runs("encode_runs"));
    let wider = Fake::default();
    let (_, store) = run(&wider, &["psnr=30,35,40"], all(3), folder.path()).unwrap();
    assert_eq!(wider.encodes(), ["35"; 4]);
    assert_eq!(store.rows.len(), 3);
}

#[test]
fn wherever_it_stops_it_goes_on() {
    let sweeps = ["psnr=30,40"];
    let whole = Fake::default();
    let (_, wanted) = run(&whole, &sweeps, all(2), TempDir::new().unwrap().path()).unwrap();
    let runs = whole.told().len();
    for stops_at in 0..runs {
        let folder = TempDir::new().unwrap();
        let stopped = Fake { stops_at: Some(stops_at), ..Fake::default() };
        assert!(matches!(run(&stopped, &sweeps, all(2), folder.path()), Err(Error::Interrupted)));
        let rest = Fake::default();
        let (_, store) = run(&rest, &sweeps, all(2), folder.path()).unwrap();
        // At most the interrupted step runs twice.
        assert!(rest.told().len() <= runs - stops_at + 3, "{stops_at}: {:?}", rest.told());
        assert_eq!(store.rows.len(), wanted.rows.len());
        for (row, wanted) in store.rows.iter().zip(&wanted.rows) {
            for name in ["bytes_container", "bytes_lzma2", "psnr_db", "ssim"] {
                assert_eq!(row.measured.number(name), wanted.measured.number(name), "{name}");
            }
            assert_eq!((row.measured.runs("encode_runs").len(), row.measured.runs("decode_runs").len()), (2, 2));
        }
    }
}

#[test]
fn a_budget_adds_whole_values_coarse_to_fine_and_says_what_it_left_out() {
    // The survey of a point takes 4 s and each run 2 s.
    let sweeps = ["psnr=10,20,30,40,50", "color-cell=8,16,32"];
    let within = |seconds: f64, repeats: u32| {
        let (fake, folder) = (Fake::default(), TempDir::new().unwrap());
        let extent = Extent { repeats, budget_seconds: Some(seconds) };
        let (outcome, store) = run(&fake, &sweeps, extent, folder.path()).unwrap();
        let grid: Vec<_> = outcome.studies[0].axes.iter().map(|axis| axis.values.join(",")).collect();
        let points = outcome.studies[0].points();
        // The grid has no holes.
        assert!(points.iter().all(|point| store.runs(point) >= 1));
        assert_eq!(points.len(), store.rows.len());
        (grid, outcome.left_out, fake.now_seconds())
    };
    let (grid, left_out, _) = within(1e6, 2);
    assert_eq!((grid, left_out), (vec!["10,20,30,40,50".to_owned(), "8,16,32".to_owned()], Vec::new()));
    // Six points with one run each take 36 s.
    let (grid, left_out, took) = within(40.0, 1);
    assert_eq!(grid, ["10,30,50", "8,32"]);
    assert_eq!(
        left_out,
        [
            "Study color-psnr-color-cell: psnr 20, 40 did not fit into 40 s.",
            "Study color-psnr-color-cell: color-cell 16 did not fit into 40 s."
        ]
    );
    assert!(took <= 40.0, "{took}");
    // Two runs of the ends come before more values; four points take 32 s, or 40 s with three runs.
    let (grid, left_out, took) = within(39.0, 3);
    assert_eq!(grid, ["10,50", "8,32"]);
    let runs = left_out.last().unwrap();
    assert!(runs.contains("of 2 runs of each point instead of 3"), "{left_out:?}");
    assert!(took <= 39.0, "{took}");
    // Even the smallest budget allows one run of one point.
    let (grid, left_out, took) = within(1.0, 3);
    assert_eq!((grid, took), (vec!["10".to_owned(), "8".to_owned()], 6.0));
    assert_eq!(left_out[0], "Study color-psnr-color-cell: psnr 20, 30, 40, 50 did not fit into 1 s.");
    assert_eq!((left_out.len(), left_out[3].as_str()), (4, "It took 6.0 s instead of 1 s."));
    // If the ends of the axes do not all fit, some of them do.
    let (grid, _, took) = within(14.0, 1);
    assert_eq!(grid, ["10,50", "8"]);
    assert!(took <= 14.0, "{took}");
}

#[test]
fn a_budget_counts_from_the_start_of_the_program() {
    let (fake, folder) = (Fake::default(), TempDir::new().unwrap());
    *fake.clock.borrow_mut() = 90.0;
    let extent = Extent { repeats: 1, budget_seconds: Some(102.0) };
    let (outcome, _) = run(&fake, &["psnr=30,40,50"], extent, folder.path()).unwrap();
    assert_eq!(outcome.studies[0].axes[0].values, ["30", "50"]);
    assert_eq!(fake.now_seconds(), 102.0);
}

#[test]
fn a_point_that_no_longer_fits_is_not_begun() {
    let (fake, folder) = (Fake { slow: Some(("--repeat=200", 20.0)), ..Fake::default() }, TempDir::new().unwrap());
    // The survey suggests 2 s per run, but each run takes 22 s.
    let extent = Extent { repeats: 1, budget_seconds: Some(45.0) };
    let (outcome, store) = run(&fake, &["psnr=10,20,30"], extent, folder.path()).unwrap();
    let runs: Vec<_> = store.rows.iter().map(|row| row.measured.runs("encode_runs").len()).collect();
    assert_eq!(runs, [1, 0, 1], "12 s of first passes, 22 s, and 22 s that nobody could know of");
    let last = store.rows[1].measured.point.to_string();
    assert_eq!(outcome.left_out[0], format!("Not timed, since it did not fit into 45 s: {last}."));
    assert_eq!(outcome.left_out[1], "It took 56.0 s instead of 45 s.");
}

#[test]
fn what_is_measured_costs_nothing_and_what_is_missing_costs_what_it_did() {
    let folder = TempDir::new().unwrap();
    let sweeps = ["psnr=10,20,30,40,50", "color-cell=8,16,32"];
    run(&Fake::default(), &sweeps, all(2), folder.path()).unwrap();
    let again = Fake::default();
    *again.clock.borrow_mut() = 9.0;
    let extent = Extent { repeats: 2, budget_seconds: Some(1.0) };
    let (outcome, _) = run(&again, &sweeps, extent, folder.path()).unwrap();
    assert_eq!((again.told().len(), outcome.left_out), (0, Vec::new()));
    assert_eq!(outcome.studies, studies(&sweeps));
    // The medians of the first process show that two more values, each of 3 points, do not fit.
    let mut store = Store::open(&CODING, folder.path(), Some(7)).unwrap();
    for row in &mut store.rows {
        row.measured.set("encode_runs", Stored::Runs(vec![1.0; 2]));
        row.measured.set("decode_runs", Stored::Runs(vec![0.005; 2]));
    }
    store.save().unwrap();
    let more = Fake::default();
    let extent = Extent { repeats: 2, budget_seconds: Some(30.0) };
    let (outcome, store) =
        run(&more, &["psnr=10,20,30,40,50,60,70", "color-cell=8,16,32"], extent, folder.path()).unwrap();
    assert!(more.now_seconds() <= 30.0, "{}", more.now_seconds());
    assert_eq!(outcome.studies[0].axes[0].values, ["10", "20", "30", "40", "50", "70"]);
    assert_eq!(outcome.left_out[0], "Study color-psnr-color-cell: psnr 60 did not fit into 30 s.");
    assert_eq!(store.rows.len(), 18);
}

#[test]
fn a_point_that_fails_leaves_a_hole_and_is_tried_again() {
    let folder = TempDir::new().unwrap();
    let sweeps = ["psnr=30,40,50"];
    let broken = Fake { fails: Some("--psnr=40"), ..Fake::default() };
    let (outcome, store) = run(&broken, &sweeps, all(2), folder.path()).unwrap();
    let [FailedPoint { point, error: said, .. }] = &outcome.failed[..] else { panic!("{outcome:?}") };
    assert_eq!(point.to_string(), "color with psnr=40");
    assert!(said.contains("--psnr=40") && said.ends_with("it broke"), "{said}");
    assert_eq!(broken.encodes().iter().filter(|psnr| *psnr == "40").count(), 0, "the fake keeps no line of a failure");
    assert_eq!(store.rows.iter().map(|row| row.measured.runs("encode_runs").len()).collect::<Vec<_>>(), [2, 2]);
    let mended = Fake::default();
    let (outcome, store) = run(&mended, &sweeps, all(2), folder.path()).unwrap();
    assert_eq!((mended.encodes(), outcome.failed.len()), (vec!["40".to_owned(); 3], 0));
    assert_eq!(store.rows.len(), 3);
}

#[test]
fn a_point_that_fails_when_it_is_timed_keeps_what_is_known_of_it() {
    let folder = TempDir::new().unwrap();
    let broken = Fake { fails: Some("--repeat=200 --threads=2"), ..Fake::default() };
    let (outcome, store) = run(&broken, &["psnr=30", "threads=1,2"], all(2), folder.path()).unwrap();
    assert_eq!(outcome.failed.len(), 1, "it is not tried in the second round");
    assert_eq!(store.rows.iter().map(|row| row.measured.runs("encode_runs").len()).collect::<Vec<_>>(), [2, 0]);
    // The same with a budget.
    let extent = Extent { repeats: 2, budget_seconds: Some(1e6) };
    let (outcome, _) = run(&broken, &["psnr=30", "threads=1,2"], extent, folder.path()).unwrap();
    assert_eq!((outcome.failed.len(), outcome.left_out.len()), (1, 0));
}

#[test]
fn where_every_point_fails_the_first_error_is_told() {
    for budget_seconds in [None, Some(100.0)] {
        let (fake, folder) = (Fake { fails: Some("encode "), ..Fake::default() }, TempDir::new().unwrap());
        let error = run(&fake, &["psnr=30,40,50"], Extent { repeats: 2, budget_seconds }, folder.path()).unwrap_err();
        assert!(error.to_string().contains("--psnr=30"), "{error}");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}

#[test]
fn sweeps_into_one_folder_keep_their_studies() {
    let folder = TempDir::new().unwrap();
    for (sweeps, names) in [
        (&["psnr=30,40"][..], &["color-psnr"; 2][..]),
        (&["color-cell=8,16"], &["color-psnr", "color-psnr", "color-color-cell", "color-color-cell"]),
    ] {
        let (_, store) = run(&Fake::default(), sweeps, all(1), folder.path()).unwrap();
        assert_eq!(store.rows.iter().map(|row| row.studies.join(" ")).collect::<Vec<_>>(), names);
    }
    // A point of two studies belongs to both.
    let quick = |name: &str| {
        let mut studies = studies(&["psnr=30,50"]);
        studies[0].name = name.to_owned();
        let (input, fake, mut store) =
            (input(), Fake::default(), Store::open(&CODING, folder.path(), Some(7)).unwrap());
        let mut bench = CodingBench::new(&input, Path::new("work"));
        let lab = Lab { runner: &fake, bench: &mut bench, store: &mut store };
        measure(&studies, all(1), lab, &Silent).unwrap();
        store.rows[0].studies.clone()
    };
    assert_eq!(quick("cells"), ["color-psnr", "cells"]);
}

#[test]
fn a_study_that_does_not_fit_is_left_out_as_a_whole() {
    let (fake, folder) = (Fake::default(), TempDir::new().unwrap());
    let extent = Extent { repeats: 1, budget_seconds: Some(20.0) };
    let (outcome, _) = run(&fake, &["psnr=30,50", "max-error=0,50"], extent, folder.path()).unwrap();
    assert_eq!(outcome.studies.len(), 1);
    assert!(
        outcome.left_out[0].starts_with("Study depth-max-error was left out: its 2 points"),
        "{:?}",
        outcome.left_out
    );
}

#[test]
fn values_are_tried_from_the_middle_of_the_longest_stretch() {
    let mut tried = vec![false; 8];
    (tried[0], tried[7]) = (true, true);
    let mut order = Vec::new();
    while let Some(at) = farthest(&tried) {
        order.push(at);
        tried[at] = true;
    }
    assert_eq!(order, [3, 5, 1, 2, 4, 6]);
    assert_eq!(farthest(&[]), None);
}
