//! Sequences of commands, as in a shell script: each command reads the output of the previous one.

use std::path::Path;
use std::process::{Command, Output};

use codec::image::{Face, Plane};
use half::f16;
use tempfile::TempDir;

use crate::footage::Footage;

pub fn lightfold(arguments: &[&str], folder: &Path) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_lightfold"));
    command.args(arguments).current_dir(folder).output().unwrap()
}

/// Runs a command line that must succeed.
pub fn fine(line: &str, folder: &Path) -> Output {
    let output = lightfold(&line.split_whitespace().collect::<Vec<_>>(), folder);
    assert!(output.status.success(), "{line}: {}", String::from_utf8_lossy(&output.stderr));
    output
}

/// Returns the expected exit code of an error: 75 if a retry may succeed, because an image is missing or another process holds a
/// file; 2 otherwise.
pub fn code_of(said: &str) -> i32 {
    // Notes may precede the error.
    let said = said.trim_end().lines().last().unwrap_or_default().to_lowercase();
    let is_typed = said.contains("there is no such file or folder")
        || said.contains("there is no folder")
        || said.contains("a scene file (");
    let is_missing = !is_typed && (said.contains("no such file") || said.contains("the file does not exist"))
        || said.ends_with("no file matches this pattern");
    let is_busy = said.contains(": another ");
    if is_missing || is_busy { 75 } else { 2 }
}

/// Runs a command line that must be refused. Returns its standard error.
pub fn refused(line: &str, folder: &Path) -> String {
    let output = lightfold(&line.split_whitespace().collect::<Vec<_>>(), folder);
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(code_of(&said)), "{line}: {said}");
    said
}

/// Writes a cube map whose faces have depth ranges that differ by factors of 10.
fn cube(folder: &Path) {
    let depth = |face: Face, frame: u32| {
        let scale = 10f32.powi(face as i32);
        Plane::from_fn(16, 16, |x, y| scale * (1.0 + (x * y + frame) as f32 * 0.01))
    };
    Footage { faces: &Face::CUBE, frames: [0, 3], depth: Some(&depth), ..Footage::new(16, 16) }.write(folder);
}

#[test]
fn faces_encoded_one_by_one_and_packed_decode_to_what_they_were() {
    let folder = TempDir::new().unwrap();
    cube(folder.path());
    let mut inputs = Vec::new();
    for face in Face::CUBE.map(Face::name) {
        let sequence = format!("probe_00/face_{face}/depth.%04d.exr");
        fine(&format!("encode-depth {sequence} --face {face} --max-error 0 -o {face}.lfold"), folder.path());
        inputs.push(format!("{face}.lfold"));
    }
    fine(&format!("pack {} -o all.lfold", inputs.join(" ")), folder.path());
    fine("decode all.lfold -o decoded", folder.path());
    fine("diff all.lfold decoded --exact", folder.path());
    fine("diff . decoded --max-error 0", folder.path());
}

#[test]
fn a_single_image_can_be_named() {
    let folder = TempDir::new().unwrap();
    cube(folder.path());
    fine("encode . -o a.lfold", folder.path());
    fine("decode a.lfold --face px --frames 2 -o one.exr", folder.path());
    assert!(folder.path().join("one.exr").is_file());
    fine("diff one.exr probe_00/face_px/depth.0002.exr --kind depth --max-error 65535", folder.path());
    assert!(refused("decode a.lfold --face px -o one.exr", folder.path()).contains("one file for 4 images"));
    assert!(refused("decode a.lfold -o -", folder.path()).contains("folder"));
    assert!(refused("decode a.lfold --face px -o a%04d%04d.exr", folder.path()).contains("a%04d%04d.exr"));
}

fn said(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

/// Writes four frames of a face with linear RGB up to 15.
fn bright(folder: &Path) {
    let color = |_: Face, frame: u32| {
        Plane::from_fn(16, 16, |x, y| [x as f32, y as f32 / 16.0, frame as f32 / 4.0].map(f16::from_f32))
    };
    let depth = |_: Face, _: u32| Plane::from_fn(16, 16, |x, y| 1.0 + (x * y) as f32 * 0.01);
    Footage { frames: [0, 3], color: Some(&color), depth: Some(&depth), ..Footage::new(16, 16) }.write(folder);
}

#[test]
fn clipped_light_and_missing_manifests_are_said_also_to_the_quiet() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    bright(at);
    // Red is 2 to 15 in 14 of 16 columns of 4 images.
    let clipped = 14 * 16 * 4;
    let encoded = said(&fine("encode . -o codes.lfold -q --clip", at));
    assert!(encoded.contains(&format!("{clipped} of 1024 colour pixels")), "{encoded}");
    assert_eq!(said(&fine("encode . -o a.lfold --hdr -q", at)), "");
    let decoded = said(&fine("decode a.lfold --stream color --format png -o out -q", at));
    // Coding errors may raise a value of 1 above 1.
    let count = decoded.strip_prefix("out: ").and_then(|words| words.split(' ').next()?.parse::<u32>().ok());
    assert!(count.is_some_and(|count| (clipped..1024).contains(&count)), "{decoded}");
    assert!(decoded.contains("clipped"), "{decoded}");
    assert!(at.join("out/lightfield.json").is_file());
    fine("diff a.lfold out", at);
    let codes = said(&fine("decode a.lfold --stream depth --format png -o codes -q", at));
    assert!(codes.contains("lightfield.json was not written") && !codes.contains("older"), "{codes}");
    assert!(!at.join("codes/lightfield.json").exists());
    let over = said(&fine("decode a.lfold --stream depth --format png -o out -q", at));
    assert!(over.contains("an older one is kept"), "{over}");
    assert_eq!(said(&fine("decode a.lfold -o exact -q", at)), "");
    let report: serde_json::Value =
        serde_json::from_slice(&fine("encode . -o b.lfold --json --clip", at).stdout).unwrap();
    assert_eq!((&report["images"], &report["frames"]), (&8.into(), &8.into()));
}

#[test]
fn names_of_images_that_are_not_written_are_refused() {
    let folder = TempDir::new().unwrap();
    bright(folder.path());
    fine("encode . -o a.lfold --hdr", folder.path());
    for name in ["pp.tif", "pp.####.jpg", "pp.%04d.webp", "pp.EXR"] {
        let said = refused(&format!("decode a.lfold --stream color -o {name}"), folder.path());
        assert!(said.contains(".exr or .png"), "{said}");
        assert!(!folder.path().join(name).exists(), "{name}");
    }
    fine("decode a.lfold --frames 0 -o film.v2", folder.path());
    let frames = "probe_00/face_px/color.0000.exr probe_00/face_px/color.0001.exr";
    assert!(refused(&format!("encode-color {frames} -o b.lfold"), folder.path()).contains("color.%04d.exr"));
}

#[test]
fn what_an_option_does_not_reach_is_said() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    bright(at);
    let blocks = said(&fine("encode . -o a.lfold --color-block bc7 --psnr 50 --clip", at));
    assert!(blocks.contains("at least 40 dB (--psnr-final)"), "{blocks}");
    assert!(!said(&fine("encode . -o a.lfold --color-block bc7 --clip", at)).contains("--psnr-final"));
    assert!(refused("encode . -o b.lfold --white 300", at).contains("--hdr"));
    let memory = "encode . -o b.lfold --stream color --memory 1k --color-chunk";
    assert!(refused(&format!("{memory} 2"), at).contains("a smaller --color-chunk"));
    assert!(!refused(&format!("{memory} 1"), at).contains("smaller"));
    fine("encode . -o c.lfold --clip", at);
    let packed = said(&fine("pack c.lfold --zstd -o d.lfold", at));
    assert!(packed.contains("no smaller"), "{packed}");
}

#[test]
fn an_output_that_is_an_input_is_refused() {
    let folder = TempDir::new().unwrap();
    cube(folder.path());
    let frame = "probe_00/face_px/depth.0001.exr";
    let before = std::fs::read(folder.path().join(frame)).unwrap();
    let said = refused(&format!("encode-depth probe_00/face_px/depth.%04d.exr -o {frame}"), folder.path());
    assert!(said.contains("the output is a container, not an image"), "{said}");
    assert!(refused("encode . -o lightfield.json", folder.path()).contains("overwritten"));
    assert_eq!(std::fs::read(folder.path().join(frame)).unwrap(), before);
}

#[test]
fn frames_that_are_not_there_are_refused() {
    let folder = TempDir::new().unwrap();
    cube(folder.path());
    assert!(refused("encode . --frames 2-9 -o a.lfold", folder.path()).contains("0-3"));
    fine("encode . -o a.lfold", folder.path());
    assert!(refused("decode a.lfold --frames 2-9 --null", folder.path()).contains("0-3"));
    assert!(!folder.path().join("b.lfold").exists());
}

#[test]
fn a_failed_decode_leaves_nothing_and_a_second_one_joins_the_first() {
    let folder = TempDir::new().unwrap();
    cube(folder.path());
    fine("encode . -o a.lfold", folder.path());
    let long = "n".repeat(300);
    refused(&format!("decode a.lfold -o out/{long}"), folder.path());
    let left: Vec<_> = std::fs::read_dir(folder.path().join("out")).map_or(Vec::new(), |entries| entries.collect());
    assert!(left.is_empty(), "{left:?}");
    fine("decode a.lfold --face px -o out", folder.path());
    let again = fine("decode a.lfold --face nx -o out", folder.path());
    assert!(String::from_utf8(again.stderr).unwrap().contains("contains a dataset"));
    assert!(folder.path().join("out/probe_00/face_px/depth.0003.exr").is_file());
    assert!(folder.path().join("out/probe_00/face_nx/depth.0003.exr").is_file());
}

#[test]
fn a_source_is_not_replaced_by_its_decoded_images() {
    let folder = TempDir::new().unwrap();
    cube(folder.path());
    fine("encode . -o a.lfold", folder.path());
    let manifest = || std::fs::read(folder.path().join("lightfield.json")).unwrap();
    let before = manifest();
    assert!(refused("decode a.lfold -o .", folder.path()).contains("that lightfold did not decode"));
    assert_eq!(manifest(), before);
}

#[test]
fn a_container_does_not_get_the_name_of_an_image() {
    let folder = TempDir::new().unwrap();
    cube(folder.path());
    for name in ["a.png", "a.EXR"] {
        assert!(
            refused(&format!("encode . -o {name}"), folder.path()).contains("the output is a container, not an image")
        );
        assert!(!folder.path().join(name).exists());
    }
}

#[cfg(target_os = "linux")]
#[test]
fn an_error_that_cannot_be_printed_keeps_its_exit_code() {
    let folder = TempDir::new().unwrap();
    let full = || std::fs::File::options().write(true).open("/dev/full").unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_lightfold"));
    let status = command.args(["inspect", "nothing"]).current_dir(folder.path()).stderr(full()).status().unwrap();
    assert_eq!(status.code(), Some(2));
}

#[cfg(unix)]
#[test]
fn a_container_is_read_from_a_pipe_that_has_a_name() {
    let folder = TempDir::new().unwrap();
    cube(folder.path());
    fine("encode . -o a.lfold", folder.path());
    let bash = "lightfold=$0; \"$lightfold\" inspect <(cat a.lfold) --json && \"$lightfold\" inspect - </dev/zero";
    let mut command = Command::new("bash");
    let output =
        command.args(["-c", bash, env!("CARGO_BIN_EXE_lightfold")]).current_dir(folder.path()).output().unwrap();
    assert!(String::from_utf8_lossy(&output.stdout).contains("\"streams\""));
    assert_eq!(output.status.code(), Some(2), "an endless input is no container");
}
