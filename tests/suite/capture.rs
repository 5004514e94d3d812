//! `capture`: its output is a dataset that the other commands read and in which `inspect --check` suspects nothing. The bytes
//! depend only on the scene and the options, however often the capture was interrupted.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use codec::image::{Face, ReadLimits, StreamKind};
use codec::monitor::Silent;
use footage::convention::Verdict;
use footage::dataset::source::{Source, SourceOptions};
use footage::dataset::{DepthKind, Manifest};
use footage::image_files::exr;
use scene::{DemoKind, DemoScene, FootagePlan};
use tempfile::TempDir;

use crate::commands::{fine, lightfold, refused};
use crate::convention::checked;

/// Three probes, one of them rotated by an angle that is not a multiple of 90 degrees.
const CAMERAS: &str = r#"{ "lightfold_cameras": 1, "cameras": [
    { "position": [0, 1.5, 0] },
    { "name": "left", "position": [-0.25, 1.4, 0.2] },
    { "name": "turned", "position": [0.2, 1.6, -0.3], "orientation": [0.18257418583505536, 0.3651483716701107,
      0.5477225575051661, 0.7302967433402214] } ] }"#;

fn place() -> TempDir {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("cameras.json"), CAMERAS).unwrap();
    folder
}

/// Returns the paths, relative to a folder, and the contents of all files below it, sorted.
pub fn files(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    fn collect(root: &Path, folder: &Path, found: &mut Vec<(PathBuf, Vec<u8>)>) {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                collect(root, &path, found);
            } else {
                found.push((path.strip_prefix(root).unwrap().to_owned(), fs::read(&path).unwrap()));
            }
        }
    }
    let mut found = Vec::new();
    collect(folder, folder, &mut found);
    found.sort();
    found
}

#[track_caller]
fn nothing_is_suspect(folder: &Path) {
    let report = checked(folder);
    let suspected: Vec<_> = report.findings.iter().filter(|finding| finding.verdict == Verdict::Suspect).collect();
    assert!(suspected.is_empty(), "{suspected:#?}");
    let fine = report.findings.iter().filter(|finding| finding.verdict == Verdict::Fine).count();
    assert!(fine >= 3, "little was found out: {report:#?}");
}

#[test]
fn captures_are_datasets_of_which_nothing_is_suspect() {
    let place = place();
    for (name, options) in [("distance", ""), ("planar", " --depth planar")] {
        let line =
            format!("capture courtyard --cameras cameras.json --frames 6-7 --size 64 --samples 4{options} -o {name}");
        fine(&line, place.path());
        nothing_is_suspect(&place.path().join(name));
        fine(&format!("encode {name} --clip --max-error 0 --psnr 50 -o {name}.lfold"), place.path());
        fine(&format!("diff {name} {name}.lfold --allow-clipping --max-error 1 --min-cell-psnr 49.9"), place.path());
    }
    // Planar depth labelled as distance is suspected, and distance labelled as planar.
    for (name, kind) in [("distance", DepthKind::Planar), ("planar", DepthKind::Distance)] {
        let folder = place.path().join(name);
        let mut manifest = Manifest::read(&folder).unwrap();
        manifest.depth.as_mut().unwrap().kind = kind.into();
        fs::write(folder.join("lightfield.json"), manifest.to_json().unwrap()).unwrap();
        let report = checked(&folder);
        assert!(report.findings.iter().any(|finding| finding.verdict == Verdict::Suspect), "{name}: {report:#?}");
    }
    // With the correct labels, both datasets have the same surfaces.
    for (name, kind) in [("distance", DepthKind::Distance), ("planar", DepthKind::Planar)] {
        let folder = place.path().join(name);
        let mut manifest = Manifest::read(&folder).unwrap();
        manifest.depth.as_mut().unwrap().kind = kind.into();
        fs::write(folder.join("lightfield.json"), manifest.to_json().unwrap()).unwrap();
    }
    fine("diff distance planar --stream depth --max-error 1", place.path());
}

#[test]
fn a_capture_is_what_the_demo_captures() {
    let place = place();
    let plan = FootagePlan { kind: DemoKind::Street, frames: 2, face_size: 24, probes: 1 };
    plan.write(&place.path().join("demo"), &Silent).unwrap();
    fine("capture street --position 0,1.5,0 --frames 0-1 --size 24 -o a/cap --threads 3", place.path());
    assert_eq!(files(&place.path().join("demo")), files(&place.path().join("a/cap")));
    assert_eq!(fs::read_dir(place.path().join("a")).unwrap().count(), 1, "something is left beside it");
}

#[test]
fn shards_capture_the_files_of_one_run() {
    let place = place();
    let line = "capture courtyard --cameras cameras.json --frames 6-7 --size 16 --samples 1";
    fine(&format!("{line} -o whole"), place.path());
    let whole = files(&place.path().join("whole"));
    let shard = |number: u32, count: u32, folder: &str| {
        let output = fine(&format!("{line} --shard {number}/{count} -o {folder} --json"), place.path());
        let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        report["images"].as_u64().unwrap()
    };
    // Runs three shards at the same time, then one of them again.
    let together = std::thread::scope(|scope| {
        let started = [3, 1, 2].map(|number| scope.spawn(move || shard(number, 3, "parts")));
        started.map(|one| one.join().unwrap())
    });
    assert_eq!(together.iter().sum::<u64>(), 72);
    shard(1, 3, "parts");
    assert!(files(&place.path().join("parts")) == whole, "other files than one run");
    // Shard 2 of 5 has 7 of 36 views, with 2 images each, from more than one probe.
    assert_eq!(shard(2, 5, "some"), 14);
    let some = files(&place.path().join("some"));
    assert!(some.len() == 15 && some.iter().all(|file| whole.contains(file)), "{}", some.len());
    assert_eq!(fs::read_dir(place.path()).unwrap().count(), 4, "something is left beside them");
    let early = lightfold(&["encode", "some", "-o", "a.lfold"], place.path());
    assert_eq!(early.status.code(), Some(75), "{}", String::from_utf8_lossy(&early.stderr));
    let said = refused(&format!("{line} --shard 1/37 -o parts"), place.path());
    assert!(said.contains("--shard 1/37: there can be at most 36 shards, one for each view"), "{said}");
    let said = refused(&format!("{} --shard 1/3 -o parts", line.replace("6-7", "6")), place.path());
    assert!(said.contains("the folder has a different dataset"), "{said}");
    assert!(files(&place.path().join("parts")) == whole, "a refusal changed them");
}

#[test]
fn all_kinds_of_images_are_captured_and_those_alone() {
    let place = place();
    let report = fine(
        "capture courtyard --cameras cameras.json --frames 3 --size 16 --aov depth,normal,material --samples 1 -o all --json",
        place.path(),
    );
    let report: serde_json::Value = serde_json::from_slice(&report.stdout).unwrap();
    assert_eq!((&report["images"], &report["probes"], &report["frames"]), (&72.into(), &3.into(), &1.into()));
    // With one sample per pixel, one ray gives both colour and depth.
    assert_eq!(report["rays"], 18 * 256);
    assert!(report["near_m"].as_f64().unwrap() > 0.9 && report["far_m"].as_f64().unwrap() < 100.0, "{report}");
    assert!(report["rays_per_second"].as_f64().unwrap() > 0.0 && report["seconds"].as_f64().unwrap() > 0.0);
    let images = files(&place.path().join("all")).into_iter().filter(|(path, _)| path.extension().unwrap() == "exr");
    assert_eq!(report["bytes"], images.map(|(_, bytes)| bytes.len()).sum::<usize>());
    let at = |kind: &str| place.path().join(format!("all/probe_00/face_ny/{kind}.0003.exr"));
    let normal = exr::read_material(&at("normal"), ["X", "Y", "Z"], &ReadLimits::default()).unwrap();
    // Face ny shows the terrace from above.
    assert_eq!(normal.get(2, 2), [0.0, 1.0, 0.0]);
    let material = exr::read_material(&at("material"), ["reflect", "refract", "ior"], &ReadLimits::default()).unwrap();
    assert!(material.data().iter().all(|pixel| *pixel == [0.0, 0.0, 1.0]));
    let source = Source::open(&place.path().join("all"), &SourceOptions::default()).unwrap();
    let kinds = |kind| source.groups().iter().filter(|group| group.kind == kind).count();
    assert_eq!([StreamKind::Color, StreamKind::Depth, StreamKind::Material].map(kinds), [18, 18, 18]);
    fine("encode all --clip -o all.lfold", place.path());
    for (options, expected) in [
        ("--aov none", vec!["color"]),
        ("--no-color", vec!["depth"]),
        ("--aov normal,depth --no-color", vec!["depth", "normal"]),
    ] {
        fine(&format!("capture courtyard --position 0,1.5,0 --frames 3 --size 8 {options} -o some"), place.path());
        let mut found: Vec<String> = files(&place.path().join("some/probe_00/face_px"))
            .iter()
            .map(|(path, _)| path.to_str().unwrap().split('.').next().unwrap().to_owned())
            .collect();
        found.sort();
        assert_eq!(found, expected);
        fs::remove_dir_all(place.path().join("some")).unwrap();
    }
}

#[test]
fn panoramas_and_viewers_are_captured_too() {
    let place = place();
    fine(
        "capture courtyard --position 0,1.5,0 --frames 3 --size 256 --samples 1 --projection equirect -o pano",
        place.path(),
    );
    let manifest = Manifest::read(&place.path().join("pano")).unwrap();
    assert_eq!((manifest.size, manifest.files.depth.as_deref()), ([256, 128], Some("probe_{probe}/depth.%04d.exr")));
    fine("encode pano --clip -o pano.lfold", place.path());
    // Its faces equal those of a cube map from the same position, except at edges.
    fine("capture courtyard --position 0,1.5,0 --frames 3 --size 64 --samples 1 -o cube", place.path());
    let faces = ["pano", "cube"].map(|name| {
        let options = SourceOptions { face_size: (name == "pano").then_some(64), ..SourceOptions::default() };
        let source = Source::open(&place.path().join(name), &options).unwrap();
        let group =
            source.groups().iter().find(|group| group.kind == StreamKind::Depth && group.faces.contains(&Face::Pz));
        let group = group.unwrap();
        let at = group.faces.iter().position(|face| *face == Face::Pz).unwrap();
        source.read_depth(group, 3).unwrap().swap_remove(at)
    });
    let alike = faces[0].data().iter().zip(faces[1].data()).filter(|(a, b)| (*a / *b - 1.0).abs() < 0.05 || a == b);
    assert!(alike.count() > 64 * 64 * 8 / 10);
    let views = r#"{ "cameras": [ { "eye": [0, 1.5, 0], "look_at": [0, 1.5, 2], "fov_y_deg": 90, "aspect": 1.5 } ] }"#;
    fs::write(place.path().join("views.json"), views).unwrap();
    fine("capture courtyard --cameras views.json --frames 3 --size 64 --samples 1 -o view", place.path());
    let manifest = Manifest::read(&place.path().join("view")).unwrap();
    assert_eq!(manifest.size, [96, 64]);
    let view = exr::read_depth(
        &place.path().join("view/probe_00/depth.0003.exr"),
        &Default::default(),
        &ReadLimits::default(),
    );
    let (view, cube) = (view.unwrap(), &faces[1]);
    // Faces are stored mirrored, as seen from outside the cube.
    for (col, row) in (0..64).flat_map(|row| (0..64).map(move |col| (col, row))) {
        let (found, expected) = (view.get(16 + col, row), cube.get(63 - col, row));
        assert!(found == expected || (found / expected - 1.0).abs() < 1e-5, "{col} {row}: {found} {expected}");
    }
    fine("encode view --clip -o view.lfold", place.path());
}

#[test]
fn mirrors_and_glass_are_in_the_material() {
    let place = place();
    let (at, _) = DemoScene::new(DemoKind::Mirrors).probe_region();
    let line = format!("capture mirrors --position {},{},{} --frames 0-1 --size 48 --aov material", at.x, at.y, at.z);
    fine(&format!("{line} --samples 1 -o cap"), place.path());
    let (mut mirror, mut glass, mut opaque) = (0, 0, 0);
    for face in Face::CUBE {
        let path = place.path().join(format!("cap/probe_00/face_{}/material.0000.exr", face.name()));
        let plane = exr::read_material(&path, ["reflect", "refract", "ior"], &ReadLimits::default()).unwrap();
        for &[reflect, refract, ior] in plane.data() {
            match (reflect, refract, ior) {
                (1.0, 0.0, 1.0) => mirror += 1,
                (0.0, 0.0, 1.0) => opaque += 1,
                _ => {
                    // `reflect` and `refract` are half floats, so their sum is 1 only within rounding.
                    assert!((reflect + refract - 1.0).abs() < 1e-3 && ior > 1.2, "{reflect} {refract} {ior}");
                    glass += 1;
                }
            }
        }
    }
    assert!(mirror > 50 && glass > 50 && opaque > 1000, "{mirror} {glass} {opaque}");
    fine("encode cap --clip -o cap.lfold", place.path());
}

/// Cameras from standard input, a file and a dataset give the same capture.
#[test]
fn cameras_come_from_a_pipe_and_from_a_dataset() {
    let place = place();
    let line = "capture courtyard --frames 3 --size 8 --samples 1 -q";
    fine(&format!("{line} --cameras cameras.json -o a"), place.path());
    fine(&format!("{line} --cameras a/lightfield.json -o b"), place.path());
    fine(&format!("{line} --cameras a -o c"), place.path());
    let mut command = Command::new(env!("CARGO_BIN_EXE_lightfold"));
    command.args(line.split(' ')).args(["--cameras", "-", "-o", "d"]).current_dir(place.path());
    let mut child = command.stdin(Stdio::piped()).spawn().unwrap();
    child.stdin.take().unwrap().write_all(CAMERAS.as_bytes()).unwrap();
    assert!(child.wait().unwrap().success());
    let first = files(&place.path().join("a"));
    for other in ["b", "c", "d"] {
        assert_eq!(files(&place.path().join(other)), first, "{other}");
    }
}

#[test]
fn what_cannot_be_captured_is_refused_in_a_sentence() {
    let place = place();
    let write = |name: &str, text: &str| fs::write(place.path().join(name), text).unwrap();
    write("empty.json", "");
    write("none.json", r#"{"lightfold_cameras": 1, "cameras": []}"#);
    write("late.json", r#"{"lightfold_cameras": 1, "cameras": [{"position": [0, 1, 0], "frames": [5, 9]}]}"#);
    write("eye.json", r#"{"cameras": [{"eye": [0, 1, 0], "look_at": [1, 1, 0], "fov_y_deg": 50, "aspect": 2}]}"#);
    write("scene.txt", "no scene");
    let here = "capture courtyard --position 0,1.5,0 --frames 0 -o out";
    for (line, says) in [
        (format!("{here} --size 0"), "neither a number of pixels"),
        (format!("{here} --size 99999"), "16384"),
        (format!("{here} --size 8x4"), "square"),
        (format!("{here} --size 7 --projection equirect"), "even"),
        (format!("{here} --size 8x8 --projection equirect"), "twice as wide"),
        (format!("{here} --projection equirect --depth planar --size 8"), "no planar depth"),
        (format!("{here} --projection perspective"), "no field of view"),
        (format!("{here} --projection perspective --fov 180"), "between 0 and 180"),
        (format!("{here} --fov 50"), "only for perspective"),
        (format!("{here} --samples 0"), "samples"),
        (format!("{here} --aov none,depth"), "cannot be combined with other outputs"),
        (format!("{here} --aov none --no-color"), "colour, depth or material"),
        (format!("{here} --far 0"), "metres above 0"),
        (format!("{here} --fps 0"), "frames per second"),
        ("capture courtyard --position 0,1.5,0 --frames 3-2 -o out".into(), "3-2"),
        ("capture courtyard --position 0,nan,0 -o out".into(), "three finite numbers"),
        ("capture courtyard -o out".into(), "--cameras"),
        ("capture courtyard --cameras empty.json -o out".into(), "JSON"),
        ("capture courtyard --cameras none.json -o out".into(), "at least one"),
        ("capture courtyard --cameras missing.json -o out".into(), "missing.json"),
        ("capture courtyard --cameras late.json --frames 0-3 -o out".into(), "is defined for frames 5-9"),
        ("capture courtyard --cameras eye.json --size 30x30 -o out".into(), "aspect ratio 2"),
        ("capture scene.txt --position 0,0,0 -o out".into(), "scene.txt"),
        ("capture castle --position 0,0,0 -o out".into(), "castle"),
        ("capture courtyard --position 0,1.5,0 --size 8 --frames 0 -o cameras.json".into(), "a folder was expected"),
    ] {
        let said = refused(&line, place.path());
        assert!(said.contains(says), "{line}: {said}");
        assert!(!place.path().join("out").exists(), "{line}");
        let left = fs::read_dir(place.path())
            .unwrap()
            .filter(|entry| entry.as_ref().unwrap().file_name().to_str().unwrap().ends_with(".partial"));
        assert_eq!(left.count(), 0, "{line}");
    }
}

#[test]
fn a_dataset_is_not_mixed_with_another() {
    let place = place();
    let capture = "capture courtyard --samples 1 -q -o out";
    fine(&format!("{capture} --size 8 --cameras cameras.json --frames 3-4"), place.path());
    let before = files(&place.path().join("out"));
    for other in [
        "--position 0,1.5,0 --frames 3-4",
        "--cameras cameras.json --frames 3",
        "--cameras cameras.json --frames 3-4 --aov none",
        "--cameras cameras.json --frames 3-4 --projection equirect",
    ] {
        let said = refused(&format!("{capture} --size 8 {other}"), place.path());
        assert!(said.contains("mixed"), "{other}: {said}");
    }
    let said = refused(&format!("{capture} --cameras out/lightfield.json"), place.path());
    assert!(said.contains("overwritten"), "{said}");
    assert_eq!(files(&place.path().join("out")), before);
    // A capture that writes every image of the existing dataset replaces it.
    fine(&format!("{capture} --size 12 --cameras cameras.json --frames 3-4 --aov depth,normal"), place.path());
    assert_eq!(Manifest::read(&place.path().join("out")).unwrap().size, [12, 12]);
    assert_eq!(files(&place.path().join("out")).len(), before.len() + 36);
    assert_eq!(fs::read_dir(place.path()).unwrap().count(), 2, "something is left beside it");
}

fn said(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

#[cfg(unix)]
mod stopped {
    use super::*;
    use std::time::{Duration, Instant};

    const LEFT: &str = ".cap.capture.partial";

    fn command(place: &TempDir, more: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_lightfold"));
        let line = "capture courtyard --cameras cameras.json --frames 0-7 --size 48 --samples 4 -o cap";
        command.args(line.split(' ')).args(more).current_dir(place.path());
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        command
    }

    fn images(folder: &Path) -> usize {
        let Ok(entries) = fs::read_dir(folder) else { return 0 };
        let count = |path: PathBuf| {
            if path.is_dir() { images(&path) } else { usize::from(path.extension().is_some_and(|end| end == "exr")) }
        };
        entries.flatten().map(|entry| count(entry.path())).sum()
    }

    /// Starts a capture, and sends a signal once it has written at least `at` images.
    fn stop(place: &TempDir, more: &[&str], signal: &str, at: usize) -> Output {
        let mut child = command(place, more).spawn().unwrap();
        let start = Instant::now();
        while images(&place.path().join(LEFT)) < at {
            assert!(child.try_wait().unwrap().is_none(), "it ended too soon");
            assert!(start.elapsed() < Duration::from_secs(120), "it did not begin");
            std::thread::sleep(Duration::from_millis(1));
        }
        assert!(Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap().success());
        child.wait_with_output().unwrap()
    }

    fn whole(place: &TempDir) -> Vec<(PathBuf, Vec<u8>)> {
        let done = command(place, &["--threads", "1"]).output().unwrap();
        assert!(done.status.success(), "{}", said(&done));
        let all = files(&place.path().join("cap"));
        assert_eq!(all.len(), 3 * 6 * 8 * 2 + 1);
        fs::remove_dir_all(place.path().join("cap")).unwrap();
        all
    }

    #[test]
    fn captures_go_on_where_they_were_stopped_and_end_in_the_same_bytes() {
        let place = place();
        let whole = whole(&place);
        for (signal, code, at) in [("-INT", Some(130), 20), ("-TERM", Some(130), 1), ("-KILL", None, 90)] {
            let stopped = stop(&place, &[], signal, at);
            let words = said(&stopped);
            assert_eq!(stopped.status.code(), code, "{words}");
            assert!(!place.path().join("cap").exists());
            if code.is_some() {
                let end = " of 288 images are kept in .cap.capture.partial; the same command with --resume continues\n";
                assert!(words.starts_with("lightfold: interrupted; ") && words.ends_with(end), "{words}");
            }
            // Kills the resumed capture, too, after at least 10 more images.
            let there = images(&place.path().join(LEFT));
            stop(&place, &["--resume", "-q"], "-KILL", there + 10);
            let there = images(&place.path().join(LEFT));
            let resumed = command(&place, &["--resume", "--json"]).output().unwrap();
            assert!(resumed.status.success(), "{}", said(&resumed));
            let report: serde_json::Value = serde_json::from_slice(&resumed.stdout).unwrap();
            // A killed process may have written images that it has not recorded yet.
            let taken = report["resumed_images"].as_u64().unwrap();
            assert!(taken > 0 && taken <= there as u64 && report["images"] == 288, "{there}: {report}");
            let words = said(&resumed);
            assert!(words.contains(&format!("cap: resuming with {taken} of 288 images\n")), "{words}");
            assert!(files(&place.path().join("cap")) == whole, "{signal}: other bytes");
            assert_eq!(fs::read_dir(place.path()).unwrap().count(), 2, "something is left beside it");
            fs::remove_dir_all(place.path().join("cap")).unwrap();
        }
    }

    #[test]
    fn only_the_same_capture_goes_on_and_only_sound_images_are_kept() {
        let place = place();
        let whole = whole(&place);
        stop(&place, &[], "-INT", 40);
        let there = images(&place.path().join(LEFT));
        let refused = |more: &[&str], says: &str| {
            let output = command(&place, more).output().unwrap();
            assert_eq!(output.status.code(), Some(2));
            let words = said(&output);
            assert!(words.contains("cap: cannot resume the unfinished capture") && words.contains(says), "{words}");
            assert_eq!(images(&place.path().join(LEFT)), there);
        };
        refused(&["--resume", "--far", "9"], "--far was none and is 9 m now");
        refused(&["--resume", "--no-color"], "what is captured was color, depth and is depth now");
        fs::write(place.path().join("cameras.json"), CAMERAS.replace("1.6", "1.7")).unwrap();
        refused(&["--resume"], "the choice of cameras was");
        fs::write(place.path().join("cameras.json"), CAMERAS).unwrap();
        // Images that are truncated, empty, filled with zeros and missing.
        let found = files(&place.path().join(LEFT));
        let damaged: Vec<_> =
            found.iter().filter(|(path, _)| path.extension().is_some_and(|end| end == "exr")).collect();
        let at = |index: usize| place.path().join(LEFT).join(&damaged[index].0);
        fs::write(at(0), &damaged[0].1[..damaged[0].1.len() / 2]).unwrap();
        fs::write(at(1), "").unwrap();
        fs::write(at(2), vec![0; damaged[2].1.len()]).unwrap();
        fs::remove_file(at(3)).unwrap();
        let resumed = command(&place, &["--resume", "--json"]).output().unwrap();
        let report: serde_json::Value = serde_json::from_slice(&resumed.stdout).unwrap();
        assert_eq!(report["resumed_images"], there - 4, "{}", said(&resumed));
        assert!(files(&place.path().join("cap")) == whole, "other bytes");
    }

    #[test]
    fn one_that_begins_anew_says_what_it_replaces_and_two_refuse_each_other() {
        let place = place();
        let whole = whole(&place);
        let nothing = command(&place, &["--resume"]).output().unwrap();
        assert!(said(&nothing).contains("cap: nothing to resume"), "{}", said(&nothing));
        assert!(files(&place.path().join("cap")) == whole, "other bytes");
        fs::remove_dir_all(place.path().join("cap")).unwrap();
        stop(&place, &[], "-INT", 5);
        let there = images(&place.path().join(LEFT));
        let mut first = command(&place, &["--threads", "1"]).spawn().unwrap();
        let start = Instant::now();
        // The number of images drops once the capture has begun to replace the unfinished one.
        while images(&place.path().join(LEFT)) >= there && start.elapsed() < Duration::from_secs(60) {
            std::thread::sleep(Duration::from_micros(200));
        }
        assert!(Command::new("kill").args(["-STOP", &first.id().to_string()]).status().unwrap().success());
        let second = command(&place, &["--resume"]).output().unwrap();
        assert!(Command::new("kill").args(["-CONT", &first.id().to_string()]).status().unwrap().success());
        assert!(said(&second).contains("another lightfold process is writing it"), "{}", said(&second));
        let mut words = String::new();
        std::io::Read::read_to_string(first.stderr.as_mut().unwrap(), &mut words).unwrap();
        assert!(first.wait().unwrap().success(), "{words}");
        assert!(words.contains(&format!("cap: replacing an unfinished capture of {there} images")), "{words}");
        assert!(files(&place.path().join("cap")) == whole, "other bytes");
    }
}
