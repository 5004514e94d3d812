//! `decode --keep-going` writes every intact image of a damaged container and lists the others.

use std::collections::BTreeSet;
use std::path::Path;
use std::process::Command;

use codec::color::{SearchSettings, Target};
use codec::container::{Compression, Reader};
use codec::decode::Decoder;
use codec::depth::TemporalSettings;
use codec::streams::ColorBlocks;
use serde_json::Value;
use tempfile::TempDir;

use crate::samples::{self, Shape};

/// Number of images in [`container`].
const IMAGES: usize = 81;

/// Returns a container of depth, colour and material by several codecs, with two units per stream and about three chunks per
/// unit.
fn container() -> Vec<u8> {
    let shape = |face| Shape { face, size: [9, 9], unit: [8, 12], first_frame: 3, frame_count: 9 };
    let settings = TemporalSettings { window: 2, epsilon: 90, max_aabbs: 4, keyframe_interval: 3 };
    let search = SearchSettings { target: Target::Psnr(38.0), ..SearchSettings::default() };
    let size = [9, 9];
    let (codes, bytes) = (samples::moving_codes(size, 9, 5), samples::drifting_bytes(size, 9));
    let streams = [
        samples::depth(shape(0), [0.5, 8.0], &codes, settings),
        samples::depth_in_blocks(shape(1), &codes, settings),
        samples::color8_in_chunks(shape(0), &bytes, search, 1),
        samples::color8_in_blocks(shape(1), ColorBlocks::Bc7, &bytes, search, 35.0),
        samples::color8_transform(shape(2), &bytes, search, 4),
        samples::material(shape(0), &samples::patched_materials(size, 9), settings),
        // Every face has all kinds, as in a dataset with a manifest.
        samples::depth(shape(2), [0.5, 8.0], &codes, settings),
        samples::material(shape(1), &samples::patched_materials(size, 9), settings),
        samples::material(shape(2), &samples::patched_materials(size, 9), settings),
    ];
    samples::container(0, samples::probe("00", 11), &streams, Compression::None)
}

/// Runs a command line in a folder. Returns exit code, standard output and standard error.
fn run(line: &str, folder: &Path) -> (i32, String, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_lightfold"));
    let output = command.args(line.split(' ')).current_dir(folder).output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (output.status.code().unwrap(), text(output.stdout), text(output.stderr))
}

fn files_below(folder: &Path) -> BTreeSet<String> {
    fn walk(folder: &Path, base: &Path, found: &mut BTreeSet<String>) {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                walk(&path, base, found);
            } else {
                found.insert(path.strip_prefix(base).unwrap().to_str().unwrap().to_owned());
            }
        }
    }
    let mut found = BTreeSet::new();
    walk(folder, folder, &mut found);
    found
}

/// Returns (kind, face, frame) of every image that can be decoded on its own.
fn intact(file: Vec<u8>) -> BTreeSet<(String, String, u32)> {
    let decoder = Decoder::new(Reader::from_memory(file).unwrap()).unwrap();
    let mut found = BTreeSet::new();
    for stream in decoder.streams() {
        for frame in stream.frames.iter() {
            if decoder.face(stream).decode(frame).is_ok() {
                found.insert((stream.kind.name().to_owned(), stream.face.name().to_owned(), frame));
            }
        }
    }
    found
}

fn listed(missing: &Value) -> BTreeSet<(String, String, u32)> {
    let mut found = BTreeSet::new();
    for missing in missing.as_array().unwrap() {
        let name = |key: &str| missing[key].as_str().unwrap().to_owned();
        for range in missing["frames"].as_array().unwrap() {
            for frame in range[0].as_u64().unwrap()..=range[1].as_u64().unwrap() {
                found.insert((name("kind"), name("face"), frame as u32));
            }
        }
    }
    found
}

#[test]
fn one_damaged_chunk_costs_the_images_that_need_it_and_no_other() {
    let file = container();
    let chunks = Reader::from_memory(file.clone()).unwrap().index().chunks.clone();
    let folder = TempDir::new().unwrap();
    std::fs::write(folder.path().join("good.lfold"), &file).unwrap();
    let (code, _, _) = run("decode good.lfold -o good", folder.path());
    assert_eq!(code, 0);
    let all = files_below(&folder.path().join("good"));
    let leads_into = |stream: u32| stream == 2;
    let mut lost_before = 0;
    for (at, chunk) in chunks.iter().enumerate() {
        let mut damaged = file.clone();
        damaged[chunk.offset as usize + chunk.stored_bytes as usize / 2] ^= 0x10;
        // Chunks with equal bytes are stored once, so they are all damaged.
        let hit: Vec<_> = chunks.iter().filter(|other| other.offset == chunk.offset).collect();
        let expected = intact(damaged.clone());
        std::fs::write(folder.path().join("bad.lfold"), &damaged).unwrap();
        let out = format!("out{at}");
        let (code, report, said) = run(&format!("decode bad.lfold -o {out} --keep-going --json"), folder.path());
        assert_eq!(code, 2, "chunk {at}: {said}");
        assert_eq!(said.lines().count(), 1, "{said}");
        assert!(said.contains("bad.lfold: ") && said.contains("all others are intact"), "{said}");
        let report: Value = serde_json::from_str(&report).unwrap();
        let missing = listed(&report["missing"]);
        assert!(missing.is_disjoint(&expected) && missing.len() + expected.len() == IMAGES, "chunk {at}: {missing:?}");
        assert_eq!(report["frames"], expected.len());
        let rows = report["damaged"].as_array().unwrap();
        assert_eq!(rows.len(), hit.len(), "{rows:?}");
        for (row, chunk) in rows.iter().zip(hit) {
            assert_eq!(row["offset"], chunk.offset);
            assert_eq!(row["stream"], chunk.key.stream);
            assert_eq!(row["unit"], chunk.key.unit);
            assert_eq!(row["frames"][0], chunk.key.first_frame);
            assert!(row["reason"].as_str().unwrap().contains("CRC-32"), "{row}");
        }
        // If only one chunk is damaged, earlier frames are lost only in colour cells that interpolate to the next chunk's first
        // keyframe.
        if rows.len() == 1 {
            let first = missing.iter().map(|(_, _, frame)| *frame).min().unwrap();
            assert!(first == chunk.key.first_frame || leads_into(chunk.key.stream) && first < chunk.key.first_frame);
            lost_before += u32::from(first < chunk.key.first_frame);
        }
        // The written images equal those of the intact file, and the manifest lists the missing images.
        let written = files_below(&folder.path().join(&out));
        assert_eq!(written.len(), expected.len() + 1);
        for name in written.iter().filter(|name| *name != "lightfield.json") {
            assert!(all.contains(name), "{name}");
            let read = |folder_name: &str| std::fs::read(folder.path().join(folder_name).join(name)).unwrap();
            assert_eq!(read(&out), read("good"), "{name}");
        }
        let manifest = std::fs::read_to_string(folder.path().join(&out).join("lightfield.json")).unwrap();
        let manifest: Value = serde_json::from_str(&manifest).unwrap();
        assert_eq!(listed(&manifest["extra"]["missing"]), missing);
        // `--null` reports the same damage.
        let (code, report, _) = run("decode bad.lfold --null --keep-going --json", folder.path());
        let report: Value = serde_json::from_str(&report).unwrap();
        assert_eq!((code, &report["frames"]), (2, &expected.len().into()));
        assert_eq!(listed(&report["missing"]), missing);
        assert_eq!(report["damaged"].as_array().unwrap(), rows);
    }
    assert!(lost_before > 0, "no chunk of colour leads into the next");
}

#[test]
fn all_damaged_units_of_an_image_are_listed_and_people_can_read_it() {
    let mut file = container();
    let chunks = Reader::from_memory(file.clone()).unwrap().index().chunks.clone();
    let mut expected = BTreeSet::new();
    for chunk in chunks.iter().filter(|chunk| chunk.key.stream == 0) {
        file[chunk.offset as usize] ^= 1;
    }
    for chunk in &chunks {
        if file[chunk.offset as usize..][..chunk.stored_bytes as usize]
            != container()[chunk.offset as usize..][..chunk.stored_bytes as usize]
        {
            expected.insert((chunk.key.stream, chunk.key.unit, chunk.key.first_frame));
        }
    }
    let folder = TempDir::new().unwrap();
    std::fs::write(folder.path().join("bad.lfold"), &file).unwrap();
    let (code, _, said) = run("decode bad.lfold -o out --keep-going", folder.path());
    assert_eq!(code, 2);
    // Chunks with equal bytes share a line.
    let chunks_of = |line: &str| match line.split_once(" and ").and_then(|(_, rest)| rest.split_once(" chunk")) {
        Some((more, _)) => 1 + more.parse::<usize>().unwrap(),
        None => 1,
    };
    let listed: usize = said.lines().filter(|line| line.starts_with("  stream ")).map(chunks_of).sum();
    assert_eq!(listed, expected.len(), "{said}");
    assert!(expected.len() >= 6, "{expected:?}");
    assert!(said.contains("  stream 0 (depth of probe 00 face px), unit 1, frames 3-"), "{said}");
    // Damage is not progress, so `--quiet` lists it as well.
    let (_, _, quiet) = run("decode bad.lfold --null --keep-going --quiet", folder.path());
    assert!(quiet.contains("  stream 0 (depth of probe 00 face px), unit 1, frames 3-"), "{quiet}");
    // No image of the damaged stream is intact, so no folder is created.
    let (code, _, said) = run("decode bad.lfold --stream depth --face px --keep-going -o none", folder.path());
    assert_eq!(code, 2);
    assert!(said.contains("none of the 9 images is intact"), "{said}");
    assert!(!folder.path().join("none").exists());
    // Output to a pattern, for selected frames.
    let pattern = "decode bad.lfold --stream color --face px --frames 4-6 --keep-going -o color.%04d.exr";
    assert_eq!(run(pattern, folder.path()).0, 0);
    assert!(folder.path().join("color.0006.exr").is_file());
    // Without the option, the first damaged chunk is an error, and nothing is written.
    let (code, _, said) = run("decode bad.lfold -o strict", folder.path());
    assert_eq!((code, said.lines().count()), (2, 1), "{said}");
    assert!(!folder.path().join("strict").exists());
}

#[test]
fn a_sound_container_has_nothing_damaged_and_other_devices_are_refused() {
    let folder = TempDir::new().unwrap();
    std::fs::write(folder.path().join("good.lfold"), container()).unwrap();
    let (code, report, _) = run("decode good.lfold --null --keep-going --json", folder.path());
    let report: Value = serde_json::from_str(&report).unwrap();
    assert_eq!((code, &report["damaged"], &report["missing"]), (0, &Value::Array(vec![]), &Value::Array(vec![])));
    assert_eq!(report["frames"], IMAGES);
    let (code, _, said) = run("decode good.lfold --null --keep-going --device gpu", folder.path());
    assert_eq!(code, 2);
    assert!(said.contains("--keep-going decodes on the CPU"), "{said}");
}

#[test]
fn an_old_file_of_a_missing_image_does_not_stay() {
    let folder = TempDir::new().unwrap();
    let (good, mut bad) = (container(), container());
    std::fs::write(folder.path().join("good.lfold"), &good).unwrap();
    let chunk = Reader::from_memory(good).unwrap().index().stream_chunks(0)[1];
    bad[chunk.offset as usize] ^= 1;
    std::fs::write(folder.path().join("bad.lfold"), &bad).unwrap();
    for out in ["decode {} -o out", "decode {} --stream depth --face px -o files/depth.%04d.exr"] {
        assert_eq!(run(&out.replace("{}", "good.lfold"), folder.path()).0, 0);
        let at = folder.path().join(if out.ends_with("out") { "out" } else { "files" });
        std::fs::write(at.join("depth.exr"), "of somebody else").unwrap();
        let before = files_below(&at);
        let (code, report, said) =
            run(&format!("{} --keep-going --json", out.replace("{}", "bad.lfold")), folder.path());
        assert_eq!(code, 2, "{said}");
        let missing = listed(&serde_json::from_str::<Value>(&report).unwrap()["missing"]);
        let gone: BTreeSet<_> = before.difference(&files_below(&at)).cloned().collect();
        assert!(!missing.is_empty() && gone.len() == missing.len(), "{gone:?}");
        for (kind, _, frame) in &missing {
            assert!(gone.iter().any(|name| name.ends_with(&format!("{kind}.{frame:04}.exr"))), "{gone:?}");
        }
        assert!(said.contains(&format!("removed {} older files", gone.len())), "{said}");
    }
}
