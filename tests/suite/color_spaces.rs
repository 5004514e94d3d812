//! Colour spaces, clipping, presets and missing frames of `encode`, and how `decode`, `diff` and `inspect` handle them.

use std::path::Path;

use codec::image::{ChannelSelect, ColorPlane, Face, Plane, Primaries, ReadLimits};
use footage::image_files::{exr, png};
use half::f16;
use tempfile::TempDir;

use crate::commands::{fine, lightfold, refused};
use crate::footage::Footage;

const SIDE: u32 = 32;

/// Returns smooth, saturated linear RGB, scaled by `most`.
fn light(frame: u32, most: f32) -> ColorPlane {
    Plane::from_fn(SIDE, SIDE, |x, y| {
        let [x, y, t] = [x as f32 / SIDE as f32, y as f32 / SIDE as f32, frame as f32 / 10.0];
        [x * x, y * (1.0 - x) + 0.01, 0.05 + 0.5 * t * y].map(|value| f16::from_f32(most * value))
    })
}

/// Returns finite half floats of both signs and all exponents, including subnormals.
fn all_magnitudes(frame: u32) -> ColorPlane {
    const INFINITE: u32 = 0x7c00;
    Plane::from_fn(SIDE, SIDE, |x, y| {
        [0, 1, 2].map(|channel| {
            let at = 3 * ((frame * SIDE + y) * SIDE + x) + channel;
            f16::from_bits((7 * at % INFINITE) as u16 | if at.is_multiple_of(2) { 0 } else { 0x8000 })
        })
    })
}

/// Writes a dataset of one face whose colour files state `primaries`.
fn write(folder: &Path, most: f32, primaries: Primaries) {
    write_light(folder, &|frame| light(frame, most), primaries);
}

fn write_light(folder: &Path, light: &dyn Fn(u32) -> ColorPlane, primaries: Primaries) {
    let depth = |_: Face, _: u32| Plane::from_fn(SIDE, SIDE, |x, _| 2.0 + x as f32 * 0.1);
    let color = |_: Face, frame: u32| light(frame);
    Footage { frames: [0, 2], depth: Some(&depth), color: Some(&color), ..Footage::new(SIDE, SIDE) }.write(folder);
    for frame in 0..3 {
        exr::write_color_of(&folder.join(file_of(frame)), &light(frame), primaries).unwrap();
    }
}

fn file_of(frame: u32) -> String {
    FIRST.replace("0000", &format!("{frame:04}"))
}

fn read(path: &Path) -> (ColorPlane, Primaries) {
    exr::read_color_and_primaries(path, &ChannelSelect::Auto, &ReadLimits::default()).unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

/// Runs a command line. Returns its exit code, and standard output followed by standard error.
fn run(line: &str, folder: &Path) -> (i32, String) {
    let output = lightfold(&line.split(' ').collect::<Vec<_>>(), folder);
    (output.status.code().unwrap(), text(&output.stdout) + &text(&output.stderr))
}

const FIRST: &str = "probe_00/face_px/color.0000.exr";

#[test]
fn acescg_comes_back_as_it_was() {
    let at = TempDir::new().unwrap();
    let at = at.path();
    let acescg = Primaries::ACESCG.to_array();
    // Lossless: both sides are half floats, so an error below half the distance of adjacent half floats means equal bits.
    for light in [&all_magnitudes as &dyn Fn(u32) -> ColorPlane, &|frame| light(frame, 8.0)] {
        write_light(at, light, Primaries::ACESCG);
        fine("encode . -o a.lfold --hdr --color-codec cells --psnr 200", at);
        for line in ["decode a.lfold -o decoded", "decode a.lfold -o decoded --color-space acescg"] {
            fine(line, at);
            for frame in 0..3 {
                let (found, stated) = read(&at.join("decoded").join(file_of(frame)));
                let bits = |plane: &ColorPlane| -> Vec<u16> {
                    plane.data().as_flattened().iter().map(|value| value.to_bits()).collect()
                };
                assert_eq!((bits(&found), stated.to_array()), (bits(&light(frame)), acescg), "{line}, frame {frame}");
            }
        }
    }
    // Lossy: the quality bound of the container holds in its own metric.
    for promised_db in [45, 60, 80] {
        for codec in ["transform", "cells"] {
            fine(&format!("encode . -o a.lfold --hdr --color-codec {codec} --psnr {promised_db}"), at);
            fine("decode a.lfold -o decoded", at);
            let (_, stated) = read(&at.join("decoded").join(FIRST));
            assert_eq!(stated.to_array(), acescg);
            for side in ["a.lfold", "decoded"] {
                fine(&format!("diff . {side} --stream color --min-cell-psnr {promised_db}"), at);
            }
        }
    }
}

#[test]
fn light_of_other_primaries_stays_what_it_is() {
    let at = TempDir::new().unwrap();
    let at = at.path();
    write(at, 8.0, Primaries::ACESCG);
    fine("encode . -o a.lfold --hdr --psnr 60", at);
    fine("decode a.lfold -o decoded", at);
    let (found, _) = read(&at.join("decoded").join(FIRST));
    let manifest = std::fs::read_to_string(at.join("decoded/lightfield.json")).unwrap();
    assert!(manifest.contains("\"acescg\""), "{manifest}");
    assert!(text(&fine("inspect a.lfold", at).stdout).contains("light of acescg"));

    // The same colours in another colour space.
    fine("decode a.lfold -o rec709 --color-space linear-rec709", at);
    let (converted, primaries) = read(&at.join("rec709").join(FIRST));
    assert!(primaries.is_rec709());
    let matrix = Primaries::ACESCG.conversion_to(Primaries::REC709).unwrap();
    assert_eq!(converted, matrix.convert_plane(&found));
    fine("diff . rec709 --hdr --min-cell-psnr 30", at);
    fine("diff rec709 a.lfold --min-cell-psnr 50", at);

    // Rendered EXR files state their primaries; decoded PNG files are sRGB.
    fine("render a.lfold --eye 0,1,2 --look-at 3,1,2 --size 16 -o view.exr -q", at);
    assert_eq!(exr::read_primaries(&at.join("view.exr")).unwrap(), Primaries::ACESCG);
    fine("decode a.lfold -o png --format png --stream color", at);
    let codes = png::read_rgba8(&at.join("png").join(FIRST.replace("exr", "png")), &ReadLimits::default()).unwrap();
    let tone = codec::image::ToneMap::default();
    let shown = converted.get(3, 20).map(|value| tone.code(value.to_f32()));
    assert_eq!(codes.get(3, 20)[..3], shown);
}

#[test]
fn files_of_two_sets_of_primaries_are_refused_unless_a_space_is_named() {
    let at = TempDir::new().unwrap();
    let at = at.path();
    write(at, 0.9, Primaries::REC2020);
    exr::write_color(&at.join(FIRST.replace("0000", "0001")), &light(1, 0.9)).unwrap();
    let said = refused("encode . -o a.lfold", at);
    assert!(said.contains("chromaticities") && said.contains("--color-space") && said.contains("color.0001"), "{said}");
    fine("encode . -o a.lfold --color-space linear-p3-d65", at);
    assert!(text(&fine("inspect a.lfold", at).stdout).contains("light of linear-p3-d65"));
    // The colour space of the manifest overrides the chromaticities of the files.
    let manifest = at.join("lightfield.json");
    let stated = std::fs::read_to_string(&manifest)
        .unwrap()
        .replace("\"files\"", "\"color\": {\"space\": \"aces2065-1\"}, \"files\"");
    std::fs::write(&manifest, stated).unwrap();
    fine("encode . -o a.lfold", at);
    assert!(text(&fine("inspect a.lfold", at).stdout).contains("light of aces2065-1"));
}

#[test]
fn light_is_not_clipped_silently() {
    let at = TempDir::new().unwrap();
    let at = at.path();
    write(at, 3.0, Primaries::REC709);
    let said = refused("encode . -o a.lfold", at);
    assert!(said.contains("--hdr") && said.contains("--clip") && said.contains("colour pixels"), "{said}");
    assert!(!at.join("a.lfold").exists());
    fine("encode . -o hdr.lfold --hdr", at);
    fine("diff . hdr.lfold --min-cell-psnr 40", at);
    fine("encode . -o dark.lfold --exposure -2", at);
    fine("diff . dark.lfold --min-cell-psnr 40", at);

    fine("encode . -o a.lfold --clip", at);
    let shown = text(&fine("inspect a.lfold", at).stdout);
    assert!(shown.contains("were clipped to 8 bits by the encoder"), "{shown}");
    fine("decode a.lfold -o decoded", at);
    for side in ["a.lfold", "decoded"] {
        let (code, said) = run(&format!("diff . {side} --min-cell-psnr 40"), at);
        assert_eq!(code, 1, "{said}");
        assert!(
            said.contains("did not fit 8 bits") && said.contains("--min-cell-psnr 40.00 dB does not hold"),
            "{said}"
        );
        let (code, said) = run(&format!("diff . {side} --stream color"), at);
        assert!(code == 1 && !said.contains("inf dB"), "{said}");
        fine(&format!("diff . {side} --min-cell-psnr 40 --allow-clipping"), at);
    }
    // The container records the clipping, so `diff` reports it without the source.
    let (code, said) = run("diff a.lfold decoded", at);
    assert!(code == 1 && said.contains("did not fit 8 bits"), "{said}");
    fine("diff a.lfold decoded --stream depth", at);
}

#[test]
fn missing_frames_are_stood_in_for_and_remembered() {
    let at = TempDir::new().unwrap();
    let at = at.path();
    write(at, 0.9, Primaries::REC709);
    std::fs::remove_file(at.join("probe_00/face_px/color.0001.exr")).unwrap();
    std::fs::remove_file(at.join("probe_00/face_px/depth.0002.exr")).unwrap();
    let said = refused("encode . -o a.lfold", at);
    assert!(said.contains("missing"), "{said}");
    let exact = "--color-codec cells --psnr 200 --max-error 0";
    fine(&format!("encode . -o held.lfold --missing hold {exact}"), at);
    let shown = text(&fine("inspect held.lfold", at).stdout);
    assert!(shown.contains("missing in color 00/px: 1; frame 0 is shown instead"), "{shown}");
    assert!(shown.contains("missing in depth 00/px: 2; frame 1 is shown instead"), "{shown}");
    fine("decode held.lfold -o held", at);
    assert_eq!(read(&at.join("held").join(FIRST)).0, read(&at.join("held").join(FIRST.replace("0000", "0001"))).0);

    // The manifest sets `missing` instead of the option.
    let manifest = at.join("lightfield.json");
    let stated = std::fs::read_to_string(&manifest).unwrap().replace("\"files\"", "\"missing\": \"black\", \"files\"");
    std::fs::write(&manifest, stated).unwrap();
    fine(&format!("encode . -o black.lfold {exact}"), at);
    fine("decode black.lfold -o black", at);
    let (black, _) = read(&at.join("black").join(FIRST.replace("0000", "0001")));
    assert!(black.data().as_flattened().iter().all(|value| *value == f16::ZERO));
    let depth = at.join("black/probe_00/face_px/depth.0002.exr");
    let depth = exr::read_depth(&depth, &ChannelSelect::Auto, &ReadLimits::default()).unwrap();
    assert!(depth.data().iter().all(|metres| *metres == f32::INFINITY));
    let json = text(&fine("inspect black.lfold --json", at).stdout);
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(json["missing_frames"].as_array().unwrap().len(), 2);
    assert_eq!(json["missing_frames"][0]["held"], serde_json::Value::Null);

    let said = refused("encode . -o a.lfold --missing skip", at);
    assert!(said.contains("no gaps") && said.contains("color.0001"), "{said}");
    std::fs::copy(at.join(FIRST), at.join(FIRST.replace("0000", "0001"))).unwrap();
    fine("encode . -o skipped.lfold --missing skip --stream depth", at);
    let json = text(&fine("inspect skipped.lfold --json", at).stdout);
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!((&json["frames"], json.get("missing_frames")), (&2.into(), None));
}

#[test]
fn odd_values_and_large_results_are_told_before_and_after() {
    let at = TempDir::new().unwrap();
    let at = at.path();
    let color = |_: Face, _: u32| Plane::filled(SIDE, SIDE, [f16::from_f32(0.5); 3]);
    let write = |far: f32| {
        let depth =
            |_: Face, _: u32| Plane::from_fn(SIDE, SIDE, |x, y| if x < 8 { far } else { 2.0 + (x + y) as f32 * 0.1 });
        Footage { frames: [0, 0], depth: Some(&depth), color: Some(&color), ..Footage::new(SIDE, SIDE) }.write(at);
    };
    // A depth of 1e30 is read as background.
    write(1e30);
    let said = text(&fine("encode . -o a.lfold", at).stderr);
    assert!(!said.contains("depth.background") && !said.contains("warning"), "{said}");
    write(1e8);
    let said = text(&fine("encode . -o a.lfold", at).stderr);
    assert!(said.contains("depth.background") && said.contains("1.0e8 m away"), "{said}");
    assert!(!text(&fine("encode . -o a.lfold --quiet", at).stderr).contains("depth"));
    // A wrong channel is refused before anything is encoded.
    let said = refused("encode . -o b.lfold --depth-channel W", at);
    assert!(said.contains('W') && !at.join("b.lfold").exists(), "{said}");

    // Columns of equal pixels, which EXR files compress well.
    let columns = |_: Face, _: u32| Plane::from_fn(64, 64, |x, _| [f16::from_f32(x as f32 / 64.0); 3]);
    Footage { frames: [0, 0], color: Some(&columns), ..Footage::new(64, 64) }.write(at);
    let line = "encode . -o a.lfold --color-codec cells --psnr 200";
    let said = text(&fine(&format!("{line} --no-compression"), at).stderr);
    assert!(said.contains("the source files are") && said.contains("try --preset small"), "{said}");
    assert!(!text(&fine(line, at).stderr).contains("the source files are"));
}

#[test]
fn presets_are_options_that_others_override() {
    let at = TempDir::new().unwrap();
    let at = at.path();
    write(at, 0.9, Primaries::REC709);
    let bytes = |line: &str| {
        fine(&format!("encode . -o a.lfold {line}"), at);
        std::fs::read(at.join("a.lfold")).unwrap()
    };
    assert_eq!(bytes("--preset balanced"), bytes("--quality 79 --max-error 100"));
    assert_eq!(bytes("--preset small"), bytes("--quality 65 --max-error 400 --effort exhaustive --lzma2=9"));
    assert_eq!(bytes("--preset small --psnr 44 --zstd"), bytes("--psnr 44 --max-error 400 --effort exhaustive --zstd"));
    assert_eq!(bytes("--preset exact"), bytes("--hdr --psnr 200 --max-error 0"));
    assert_eq!(bytes("--preset exact --transfer srgb"), bytes("--psnr 200 --max-error 0"));
    fine("encode . -o a.lfold --preset exact", at);
    fine("diff . a.lfold --max-error 0 --min-cell-psnr inf", at);
}
