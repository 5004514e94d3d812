//! Outputs that cannot be written, and temporary files of killed commands.

use std::path::Path;
use std::process::{Command, Stdio};

use codec::monitor::Silent;
use scene::{DemoKind, FootagePlan};
use tempfile::TempDir;

use crate::commands::{fine, lightfold, refused};

/// Command lines to which the path of an output file is appended. Their inputs do not exist, because outputs are checked before
/// inputs.
const FILES: &[&str] = &[
    "encode none -o",
    "encode-color none.%04d.exr -o",
    "encode-depth none.%04d.exr -o",
    "quadtree none.%04d.exr -o",
    "bc4w none.%04d.exr -o",
    "pack none.lfold -o",
    "place none.glb --region=0,0,0,1,1,1 -o",
    "place none.glb --region=0,0,0,1,1,1 -o c.json --csv",
    "scan none -o",
    "train-color none.lfold -o",
    "train-depth none.lfold -o",
    "init none -o",
    "quilt none.%d.png -o",
    "simplify none -o",
    "render none.lfold --eye 0,0,0 --look-at 0,0,1 --null --trace",
    "render none.lfold --eye 0,0,0 --look-at 0,0,1 --null --contact-sheet",
    "interpolate none.glb --eye 0,1,0 --look-at 2,1,0 --views 2 --null --compare --csv",
    "interpolate none.glb --eye 0,1,0 --look-at 2,1,0 --views 2 --null --cameras-out",
];
const FOLDERS: &[&str] = &[
    "demo -o",
    "capture none.glb --position 0,1,0 -o",
    "decode none.lfold -o",
    "render none.lfold --eye 0,0,0 --look-at 0,0,1 -o",
    "render none.lfold --reference none --null --error-map",
    "interpolate none.glb --eye 0,1,0 --look-at 2,1,0 --views 2 -o",
    "cameras none.json --format colmap -o",
    "inspect none.lfold --plot",
    "simplify none -o a.glb --plot",
    "view none.lfold --export",
    "tradeoff none --sweep depth-window=1 -o",
    "man",
];

fn words<'a>(line: &'a str, output: &'a str) -> Vec<&'a str> {
    line.split(' ').chain([output]).collect()
}

#[test]
fn refuses_names_that_no_file_can_have_before_the_work() {
    let folder = TempDir::new().unwrap();
    let (long, deep) = ("n".repeat(70_000), format!("new/{}/a", "n".repeat(300)));
    for line in FILES.iter().chain(FOLDERS) {
        for name in [&long, &deep] {
            let output = lightfold(&words(line, name), folder.path());
            let said = String::from_utf8(output.stderr).unwrap();
            let says = said.contains("its name is too long for the file system");
            assert!(output.status.code() == Some(2) && says && said.len() < 400, "{line}: {said:.400}");
        }
    }
    for line in FILES {
        let said = refused(&format!("{line} gone/a"), folder.path());
        assert!(said.contains("gone/a: there is no folder gone") && said.lines().count() == 1, "{line}: {said}");
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
#[cfg(unix)]
fn refuses_standard_output_that_is_closed() {
    let folder = TempDir::new().unwrap();
    let on_stdout = FILES.iter().chain(&["decode none.lfold -o", "render none.lfold -o", "cameras none.json -o"]);
    for line in on_stdout {
        let script = format!("{} {line} - >&-", env!("CARGO_BIN_EXE_lightfold"));
        let output = Command::new("sh").args(["-c", &script]).current_dir(folder.path()).output().unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        let says = said.starts_with("lightfold: standard output is closed") && said.lines().count() == 1;
        assert!(output.status.code() == Some(2) && says, "{line}: {said}");
    }
    // Writing to /dev/null is allowed: the user discards the result on purpose.
    FootagePlan { kind: DemoKind::Courtyard, frames: 1, face_size: 8, probes: 1 }
        .write(&folder.path().join("scene"), &Silent)
        .unwrap();
    let script = format!("{} encode scene --clip -o - >/dev/null", env!("CARGO_BIN_EXE_lightfold"));
    assert!(Command::new("sh").args(["-c", &script]).current_dir(folder.path()).status().unwrap().success());
}

fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap();
    let mut names: Vec<String> = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
#[cfg(unix)]
fn the_next_run_removes_what_a_killed_one_left() {
    let folder = TempDir::new().unwrap();
    let plan = FootagePlan { kind: DemoKind::Courtyard, frames: 40, face_size: 64, probes: 1 };
    plan.write(&folder.path().join("scene"), &Silent).unwrap();
    fine("encode scene --clip -o a.lfold -q", folder.path());
    let is_left = |name: &String| name.starts_with(".lightfold.");
    for into in ["out", "there"] {
        let place = if into == "there" { folder.path().join(into) } else { folder.path().to_path_buf() };
        std::fs::create_dir_all(&place).unwrap();
        let mut command = Command::new(env!("CARGO_BIN_EXE_lightfold"));
        command.args(["decode", "a.lfold", "-q", "-o", into]).current_dir(folder.path()).stderr(Stdio::null());
        let mut child = command.spawn().unwrap();
        while !names(&place).iter().any(is_left) {
            assert!(child.try_wait().unwrap().is_none(), "it ended too soon");
            std::thread::yield_now();
        }
        child.kill().unwrap();
        child.wait().unwrap();
        assert!(names(&place).iter().any(is_left), "it was not killed in time");
        fine(&format!("decode a.lfold -q -o {into}"), folder.path());
        assert!(!names(&place).iter().any(is_left));
        assert!(folder.path().join(into).join("lightfield.json").is_file());
    }
    assert_eq!(names(folder.path()), ["a.lfold", "out", "scene", "there"]);
}

/// `scripts/test` runs this test where the system lets a user mount a file system.
#[test]
#[ignore = "mounts a disk (unshare -rm)"]
#[cfg(unix)]
fn pictures_on_a_full_disk_are_named_as_the_user_did() {
    let folder = TempDir::new().unwrap();
    let place = folder.path();
    FootagePlan { kind: DemoKind::Courtyard, frames: 4, face_size: 64, probes: 1 }
        .write(&place.join("scene"), &Silent)
        .unwrap();
    fine("encode scene --clip -o a.lfold -q", place);
    std::fs::create_dir(place.join("out")).unwrap();
    let views = "--eye 0,1,0 --look-at 2,1,0 --views 9 --baseline 0.3 --size 64";
    for (line, file) in [
        ("decode a.lfold --format png -o out/d".to_owned(), "out/d/"),
        ("decode a.lfold -o out/d".to_owned(), "out/d/"),
        ("render a.lfold --eye 0,1.5,0 --look-at 1,1.5,0 --size 64 --frames 0-3 -o out/r.%d.png".to_owned(), "out/r."),
        (format!("interpolate interior {views} -o out/v/%04d.png"), "out/v/00"),
        ("capture interior --position=0,1.5,0 --size 64 --frames 0-3 -o out/c".to_owned(), "out/c/"),
    ] {
        let script = format!("mount -t tmpfs -o size=8k none out && {} {line} -q", env!("CARGO_BIN_EXE_lightfold"));
        let output = Command::new("unshare").args(["-rm", "sh", "-c", &script]).current_dir(place).output().unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(75), "{line}: {said}");
        assert!(said.contains(file) && said.contains("No space left on device"), "{line}: {said}");
        assert!(!said.split(';').next().unwrap().contains("begun") && !said.contains("files/"), "{line}: {said}");
    }
}
