//! Entropy tables trained on containers, and encodes that use them.

use std::fs;

use codec::color::transform::{TableSet, Transform};
use codec::color::{SearchSettings, Target};
use codec::container::Compression;
use codec::decode::Decoder;
use codec::effort::Effort;
use codec::entropy::table_text;
use codec::image::{ColorPlane, Face, Plane};
use codec::memory::Budget;
use codec::monitor::Silent;
use codec::streams::{CodecHeader, ColorFormat};
use footage::encode::EncodeSettings;
use footage::train::{self, TrainSettings, TrainSummary, train};
use half::f16;
use serde_json::Value;
use tempfile::TempDir;

use crate::commands::{fine, refused};
use crate::footage::{Footage, Random};
use crate::roundtrip::{check_color8, check_half, decoder, encoded};

const HALF: ColorFormat = ColorFormat::Half { white_cd_m2: 100.0 };

/// Returns a ramp with noise that differs in each frame and increases to the right.
fn noisy(_: Face, frame: u32) -> ColorPlane {
    let mut random = Random(u64::from(frame));
    Plane::from_fn(192, 160, |x, y| {
        // The sum of four uniform numbers is approximately normally distributed.
        let noise = (0..4).map(|_| random.below(1000) as f32 / 1000.0 - 0.5).sum::<f32>() * x as f32 * 0.0004;
        let light = (x + 2 * y) as f32 / 1600.0;
        [light + noise, 0.6 * light + noise, 0.1 + 0.7 * noise].map(|value| f16::from_f32(value.max(0.0)))
    })
}

/// A PSNR at which the noise takes many times the bytes of a table.
const PSNR_DB: f64 = 46.0;

fn settings(color: ColorFormat) -> EncodeSettings {
    let search = SearchSettings { target: Target::Psnr(PSNR_DB), effort: Effort::Fast, ..SearchSettings::default() };
    EncodeSettings { color, search, compression: Compression::None, ..EncodeSettings::default() }
}

fn footage(inputs: &[Decoder]) -> train::Footage<'_> {
    train::Footage::find::<Transform>(inputs).unwrap()
}

pub fn trained(inputs: &[Decoder], sets: usize) -> (Vec<TableSet>, TrainSummary) {
    let settings = TrainSettings { sets, memory: Budget::UNLIMITED };
    let trained = train::<Transform>(footage(inputs), None, settings, &Silent).unwrap();
    (table_text::read(trained.text.as_bytes()).unwrap(), trained.summary)
}

fn stored_tables(decoder: &Decoder) -> Vec<TableSet> {
    let CodecHeader::Color(header) = &decoder.streams()[0].header else { panic!("colour was expected") };
    header.tables().unwrap().own().to_vec()
}

#[test]
fn noisy_footage_gets_smaller_with_its_own_tables_and_keeps_its_promise() {
    let folder = TempDir::new().unwrap();
    let source = Footage { color: Some(&noisy), frames: [0, 11], ..Footage::new(192, 160) }.open(folder.path());
    for color in [EncodeSettings::default().color, HALF] {
        let plain = encoded(&source, &settings(color));
        let (sets, summary) = trained(&[decoder(&plain)], 1);
        assert_eq!((sets.len(), summary.payloads), (1, 9), "a payload for each cell: {summary:?}");
        let with_tables = EncodeSettings { color_tables: Some(sets[0].clone()), ..settings(color) };
        let own = encoded(&source, &with_tables);
        assert_eq!(stored_tables(&decoder(&own)), sets);
        // The size of the container includes the table.
        assert!(own.len() < plain.len(), "{} bytes, {} with the built-in tables", own.len(), plain.len());
        assert!(summary.trained_payload_bytes + summary.table_bytes < summary.payload_bytes, "{summary:?}");
        match color {
            ColorFormat::EightBit(_) => drop(check_color8(&source, &own, PSNR_DB)),
            ColorFormat::Half { .. } => check_half(&source, &own, PSNR_DB),
        }
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        assert!(pool.install(|| encoded(&source, &with_tables)) == own, "other bytes on one thread");
        assert!(pool.install(|| trained(&[decoder(&plain)], 1)).0 == sets, "other tables on one thread");
        // Payloads coded with own tables are counted with these tables.
        let again = trained(&[decoder(&own)], 1).1;
        assert_eq!(again.payload_bytes, payload_bytes(&decoder(&own)));
        assert!(again.trained_payload_bytes <= again.payload_bytes + again.payloads, "{again:?}");
    }
}

fn payload_bytes(decoder: &Decoder) -> u64 {
    decoder.reader().index().chunks.iter().map(|chunk| u64::from(chunk.raw_bytes)).sum()
}

#[test]
fn bytes_and_half_floats_train_common_sets() {
    let folder = TempDir::new().unwrap();
    let source = Footage { color: Some(&noisy), frames: [0, 5], ..Footage::new(192, 160) }.open(folder.path());
    let inputs = [EncodeSettings::default().color, HALF].map(|color| decoder(&encoded(&source, &settings(color))));
    let (sets, both) = trained(&inputs, 3);
    assert_eq!((sets.len(), both.sets, both.payloads), (3, 3, 18));
    let alone = inputs.map(|input| trained(&[input], 1).1);
    assert_eq!(both.symbols, alone[0].symbols + alone[1].symbols);
    assert_eq!(both.payload_bytes, alone[0].payload_bytes + alone[1].payload_bytes);
}

#[test]
fn commands_train_and_use_tables() {
    let folder = TempDir::new().unwrap();
    let place = folder.path();
    Footage { color: Some(&noisy), frames: [0, 5], ..Footage::new(192, 160) }.write(place);
    let encode = "encode . --psnr 38 --effort fast --stream color";
    fine(&format!("{encode} -o plain.lfold"), place);
    let report = fine("train-color plain.lfold -o tables.txt --json", place);
    let report: Value = serde_json::from_slice(&report.stdout).unwrap();
    assert_eq!((report["sets"].as_u64(), report["payloads"].as_u64()), (Some(1), Some(9)));
    assert!(report["symbols"].as_u64().unwrap() > 1000 && report["table_bytes"].as_u64().unwrap() > 1000);
    let printed = fine("train-color plain.lfold -o -", place).stdout;
    assert!(printed == fs::read(place.join("tables.txt")).unwrap());

    let with_tables = format!("{encode} --color-tables tables.txt");
    fine(&format!("{with_tables} -o a.lfold"), place);
    fine(&format!("{with_tables} -o b.lfold --threads 1"), place);
    assert!(fs::read(place.join("a.lfold")).unwrap() == fs::read(place.join("b.lfold")).unwrap());
    let inspected = String::from_utf8(fine("inspect a.lfold", place).stdout).unwrap();
    assert!(inspected.contains("transform with 1 table set"), "{inspected}");
    fine("decode a.lfold -o decoded", place);
    fine("diff a.lfold decoded --exact", place);

    fine("train-color plain.lfold -o two.txt --sets 2", place);
    fine(&format!("{encode} --color-codec cells -o cells.lfold"), place);
    fs::write(place.join("wrong.txt"), "0 1 1\n1 x").unwrap();
    fs::write(place.join("short.txt"), "# nothing\n").unwrap();
    for (line, words) in [
        (
            format!("{encode} -o x.lfold --color-tables two.txt"),
            "two.txt: 2 table sets, one was expected: train with --sets 1",
        ),
        (format!("{encode} -o x.lfold --color-tables wrong.txt"), "wrong.txt: line 2: a decimal number was expected"),
        (
            format!("{encode} -o x.lfold --color-tables short.txt"),
            "short.txt: line 2: the text ends where a number was",
        ),
        (
            format!("{encode} -o x.lfold --color-tables plain.lfold"),
            "plain.lfold: line 1: a decimal number was expected",
        ),
        (format!("{encode} -o x.lfold --color-tables missing.txt"), "missing.txt: there is no such file or folder"),
        (format!("{with_tables} -o x.lfold --color-codec cells"), "--color-tables needs --color-codec transform"),
        ("train-color cells.lfold -o x.txt".into(), "cells.lfold: no colour of the transform codec"),
        ("train-color plain.lfold cells.lfold -o x.txt".into(), "cells.lfold: no colour of the transform codec"),
        ("train-color tables.txt -o x.txt".into(), "tables.txt"),
        ("train-color plain.lfold -o plain.lfold".into(), "an input file would be overwritten"),
        ("train-color plain.lfold -o x.txt --memory 10k".into(), "--memory 10000: training needs up to"),
        ("train-color plain.lfold -o - --json".into(), "--json and -o - would both write"),
    ] {
        let said = refused(&line, place);
        assert!(said.contains(words) && said.lines().count() == 1, "{line}: {said}");
    }
    assert!(!place.join("x.lfold").exists() && !place.join("x.txt").exists());
}

#[test]
fn more_sets_than_payloads_are_refused() {
    let folder = TempDir::new().unwrap();
    let source = Footage { color: Some(&noisy), frames: [0, 0], ..Footage::new(192, 160) }.open(folder.path());
    let one_cell = EncodeSettings { cell: 192, ..settings(EncodeSettings::default().color) };
    let inputs = [decoder(&encoded(&source, &one_cell))];
    let settings = TrainSettings { sets: 2, memory: Budget::UNLIMITED };
    let error = train::<Transform>(footage(&inputs), None, settings, &Silent).unwrap_err().to_string();
    assert_eq!(error, "`sets` 2: the inputs have only 1 payloads");
}

/// Returns noise on a slope, with the same statistics in all frames.
fn rough(_: Face, frame: u32) -> Plane<f32> {
    let mut random = Random(u64::from(frame) + 9);
    Plane::from_fn(192, 160, |x, y| 2.0 + (x + y) as f32 / 300.0 + random.below(1000) as f32 * 3e-5)
}

#[test]
fn commands_train_and_use_tables_of_depth() {
    let folder = TempDir::new().unwrap();
    let place = folder.path();
    Footage { depth: Some(&rough), frames: [0, 5], ..Footage::new(192, 160) }.write(place);
    let encode = "encode . --max-error 3 --stream depth";
    fine(&format!("{encode} -o plain.lfold"), place);
    fine("encode . --max-error 5 --stream depth -o other.lfold", place);
    let report = fine("train-depth plain.lfold -o tables.txt --sets 2 --held-out other.lfold --json", place);
    let report: Value = serde_json::from_slice(&report.stdout).unwrap();
    assert_eq!(
        (report["sets"].as_u64(), report["payloads"].as_u64()),
        (Some(2), Some(6)),
        "tiles of 128, two of which close a chunk early: {report}"
    );
    let of = |name: &str| report[name].as_u64().unwrap();
    assert!(of("trained_payload_bytes") < of("payload_bytes"), "{report}");
    let held_out = |name: &str| report["held_out"][name].as_u64().unwrap();
    assert_eq!(held_out("payloads"), 5);
    assert!(held_out("payload_bytes") < of("payload_bytes"), "a greater bound takes fewer bytes: {report}");
    assert!(
        held_out("trained_payload_bytes").abs_diff(held_out("payload_bytes")) < of("payload_bytes") / 5,
        "{report}"
    );
    fine(&format!("{encode} -o own.lfold --depth-tables tables.txt"), place);
    fine("diff . own.lfold --stream depth --max-error 3", place);
    let inspected = String::from_utf8(fine("inspect own.lfold", place).stdout).unwrap();
    assert!(inspected.contains(", 2 table sets"), "{inspected}");
    let bytes = |name: &str| fs::read(place.join(name)).unwrap().len() as u64;
    assert!(bytes("own.lfold") < bytes("plain.lfold") + of("table_bytes"), "payloads are no smaller");
    for (command, words) in [
        ("train-color plain.lfold -o x.txt", "plain.lfold: no colour of the transform codec"),
        (
            "train-depth plain.lfold -o x.txt --held-out plain.lfold",
            "--held-out plain.lfold: this container is also used for training",
        ),
        (&format!("{encode} --depth-codec quadtree --depth-tables tables.txt -o x.lfold"), "--depth-tables needs"),
        (
            &format!("{encode} --depth-tables plain.lfold -o x.lfold"),
            "plain.lfold: line 1: a decimal number was expected",
        ),
    ] {
        assert!(refused(command, place).contains(words), "{command}: {}", refused(command, place));
    }
}
