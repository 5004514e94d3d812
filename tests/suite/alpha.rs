//! Alpha in datasets and containers: beside colour in the same EXR or PNG files, or in files of its own.

use std::path::Path;
use std::time::SystemTime;

use codec::image::{Plane, ReadLimits};
use footage::dataset::{InvalidColor, Manifest, Missing, Source, SourceOptions, StreamKind};
use footage::image_files::{exr, png};
use half::f16;
use serde_json::{Value, json};
use tempfile::TempDir;

use crate::commands::{fine, lightfold, refused};
use crate::input::assert_says;

const SIDE: u32 = 40;
const FRAMES: u32 = 3;

/// Returns the alpha of a soft disc that moves right by one pixel per frame.
fn alpha(x: u32, y: u32, frame: u32) -> f32 {
    let square = (x as f32 - 15.0 - frame as f32).powi(2) + (y as f32 - 20.0).powi(2);
    (2.0 - square / 64.0).clamp(0.0, 1.0)
}

/// Returns premultiplied RGB with alpha, as in EXR files.
fn rgba(frame: u32) -> Plane<[f16; 4]> {
    Plane::from_fn(SIDE, SIDE, |x, y| {
        let a = alpha(x, y, frame);
        [0.75 * a, 0.5 * a, x as f32 / 64.0 * a, a].map(f16::from_f32)
    })
}

fn manifest(files: Value) -> Value {
    json!({
        "lightfield": 1, "name": "disc", "fps": 24, "frames": [0, FRAMES - 1], "projection": "perspective",
        "size": [SIDE, SIDE], "files": files, "probes": [{ "name": "a", "position": [0, 0, 0], "fov_y_deg": 50 }],
    })
}

fn write_manifest(folder: &Path, files: Value) {
    std::fs::write(folder.join("lightfield.json"), manifest(files).to_string()).unwrap();
}

/// Writes a dataset of EXR files with channels R, G, B and A.
fn footage(folder: &Path) {
    std::fs::create_dir(folder).unwrap();
    for frame in 0..FRAMES {
        exr::write_rgba(&folder.join(format!("c.{frame:04}.exr")), &rgba(frame)).unwrap();
    }
    write_manifest(folder, json!({ "color": "c.%04d.exr", "alpha": "c.%04d.exr" }));
}

fn report(line: &str, folder: &Path) -> Value {
    serde_json::from_slice(&fine(line, folder).stdout).unwrap()
}

#[test]
fn alpha_of_exr_files_comes_back_beside_colour_without_loss() {
    let folder = TempDir::new().unwrap();
    footage(&folder.path().join("in"));
    fine("encode in -o a.lfold --psnr 60", folder.path());
    let found = report("diff a.lfold in --json", folder.path());
    assert_eq!(found["alpha"]["max_error_codes"], 0);
    fine("decode a.lfold -o out", folder.path());
    let decoded = Manifest::read(&folder.path().join("out")).unwrap();
    assert_eq!(decoded.files.alpha, decoded.files.color);
    let [source, back] =
        ["in", "out"].map(|name| Source::open(&folder.path().join(name), &SourceOptions::default()).unwrap());
    let of =
        |source: &Source, kind: StreamKind| source.groups().iter().find(|group| group.kind == kind).unwrap().clone();
    for frame in 0..FRAMES {
        let read = |source: &Source| {
            let alpha = source.read_alpha(&of(source, StreamKind::Alpha), frame).unwrap().remove(0);
            (source.read_color(&of(source, StreamKind::Color), frame).unwrap().remove(0), alpha)
        };
        let ((color, alpha), (light, shown)) = (read(&source), read(&back));
        // The tolerance is half an 8-bit step, plus the rounding error of a half float.
        assert!(alpha.data().iter().zip(shown.data()).all(|(a, b)| (a - b).abs() <= 0.5 / 255.0 + 0.0003));
        let pairs = color.data().as_flattened().iter().zip(light.data().as_flattened());
        assert!(pairs.clone().all(|(a, b)| (a.to_f32() - b.to_f32()).abs() < 0.02));
    }
    // Encoding the decoded files again gives the same alpha.
    fine("encode out -o b.lfold --stream alpha", folder.path());
    fine("diff a.lfold b.lfold --stream alpha --exact", folder.path());
    let streams = report("inspect a.lfold --streams --json", folder.path())["streams"].clone();
    let kinds: Vec<&str> = streams.as_array().unwrap().iter().map(|stream| stream["kind"].as_str().unwrap()).collect();
    assert_eq!(kinds, ["color", "alpha"]);
}

#[test]
fn png_files_have_colour_that_is_not_multiplied() {
    let folder = TempDir::new().unwrap();
    footage(&folder.path().join("in"));
    fine("encode in -o a.lfold --color-codec cells --psnr 70", folder.path());
    fine("decode a.lfold -o out --format png", folder.path());
    let path = folder.path().join("out/probe_a/color.0001.png");
    let codes = png::read_rgba8(&path, &ReadLimits::default()).unwrap();
    for (x, y) in (0..SIDE).flat_map(|y| (0..SIDE).map(move |x| (x, y))) {
        let [red, green, _, a] = codes.get(x, y);
        assert!((f32::from(a) - 255.0 * alpha(x, y, 1)).abs() <= 0.51 + 0.1, "({x}, {y}): {a}");
        // 0.75 and 0.5 are codes 225 and 188 in sRGB. Pixels of low alpha are skipped, because their premultiplied colour has few
        // codes.
        if a > 128 {
            assert!(red.abs_diff(225) <= 2 && green.abs_diff(188) <= 2, "({x}, {y}): {red} {green} at alpha {a}");
        }
        assert!(a > 0 || (red, green) == (0, 0));
    }
    // Decoding to a pattern of files writes the same pixels.
    fine("decode a.lfold -o c.%d.png", folder.path());
    let one = png::read_rgba8(&folder.path().join("c.1.png"), &ReadLimits::default()).unwrap();
    assert_eq!(one, codes);
    fine("encode out -o b.lfold --psnr 60", folder.path());
    fine("diff a.lfold b.lfold --stream alpha --exact", folder.path());
    fine("diff a.lfold b.lfold --stream color --min-psnr 40", folder.path());
}

#[test]
fn alpha_has_files_of_its_own_where_colour_has_none() {
    let folder = TempDir::new().unwrap();
    footage(&folder.path().join("in"));
    fine("encode in -o a.lfold", folder.path());
    for (format, name) in [("exr", "alpha.%04d.exr"), ("png", "alpha.%04d.png")] {
        fine(&format!("decode a.lfold -o {format} --stream alpha --format {format}"), folder.path());
        let decoded = Manifest::read(&folder.path().join(format)).unwrap();
        assert!(decoded.files.alpha.unwrap().ends_with(name));
        // Alpha from PNG files is a multiple of 1/255, which is no half float, so only its codes are compared.
        let exact = if format == "exr" { " --exact" } else { " --max-error 0" };
        fine(&format!("diff a.lfold {format} --stream alpha --common{exact}"), folder.path());
    }
    // A 16-bit grey matte, with colour in separate files.
    let matte = folder.path().join("matte");
    std::fs::create_dir(&matte).unwrap();
    for frame in 0..FRAMES {
        let name = |kind: &str, ending: &str| matte.join(format!("{kind}.{frame:04}.{ending}"));
        let gray = Plane::from_fn(SIDE, SIDE, |x, y| (65535.0 * alpha(x, y, frame)).round() as u16);
        png::write_depth16(&name("m", "png"), &gray).unwrap();
        exr::write_color(&name("c", "exr"), &rgba(frame).map(|&[r, g, b, _]| [r, g, b])).unwrap();
    }
    write_manifest(&matte, json!({ "color": "c.%04d.exr", "alpha": "m.%04d.png" }));
    fine("encode matte -o m.lfold", folder.path());
    fine("diff a.lfold m.lfold --exact --allow-clipping", folder.path());
}

#[test]
fn alpha_that_nobody_names_is_noted_and_what_is_none_is_refused() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("in");
    footage(&path);
    write_manifest(&path, json!({ "color": "c.%04d.exr" }));
    let said = fine("encode in -o a.lfold", folder.path());
    assert_says(&String::from_utf8(said.stderr).unwrap(), &["alpha is below 1 in ", "list it as files.alpha"]);
    std::fs::remove_file(path.join("lightfield.json")).unwrap();
    let said = String::from_utf8(fine("init in", folder.path()).stderr).unwrap();
    assert!(!said.contains("the checks stopped early"), "{said}");
    fine("inspect in --check", folder.path());
    let proposed = Manifest::read(&path).unwrap().files;
    assert!(proposed.alpha.is_some() && proposed.alpha == proposed.color);
    for frame in 0..FRAMES {
        exr::write_color(&path.join(format!("d.{frame:04}.exr")), &rgba(frame).map(|&[r, g, b, _]| [r, g, b])).unwrap();
    }
    write_manifest(&path, json!({ "color": "d.%04d.exr", "alpha": "d.%04d.exr" }));
    assert_says(&refused("encode in -o b.lfold", folder.path()), &["the colour layer has no alpha"]);
    let beyond = Plane::filled(SIDE, SIDE, f16::from_f32(1.5));
    exr::write_alpha(&path.join("e.0000.exr"), &beyond).unwrap();
    write_manifest(&path, json!({ "alpha": "e.%04d.exr" }));
    let output = lightfold(&["encode", "in", "-o", "c.lfold", "--frames", "0-0"], folder.path());
    assert_says(&String::from_utf8(output.stderr).unwrap(), &["pixel (0, 0) has an alpha of 1.5: 0 to 1 was expected"]);
    assert_eq!(output.status.code(), Some(2));
}

#[test]
fn missing_files_are_transparent_where_they_are_black() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("in");
    footage(&path);
    std::fs::remove_file(path.join("c.0001.exr")).unwrap();
    fine("encode in -o a.lfold --missing black", folder.path());
    fine("decode a.lfold -o out --frames 1-1", folder.path());
    let back = exr::read_rgba(&folder.path().join("out/probe_a/color.0001.exr"), &ReadLimits::default()).unwrap();
    assert!(back.data().iter().all(|pixel| *pixel == [f16::ZERO; 4]));
}

/// Writes a dataset of white PNG colour, with alpha in separate EXR files.
fn white_with_mattes(folder: &Path, alpha: impl Fn(u32) -> f32) {
    std::fs::create_dir(folder).unwrap();
    for frame in 0..FRAMES {
        let matte = Plane::filled(SIDE, SIDE, f16::from_f32(alpha(frame)));
        png::write_color8(&folder.join(format!("c.{frame:04}.png")), &Plane::filled(SIDE, SIDE, [255; 3])).unwrap();
        exr::write_alpha(&folder.join(format!("m.{frame:04}.exr")), &matte).unwrap();
    }
    write_manifest(folder, json!({ "color": "c.%04d.png", "alpha": "m.%04d.exr" }));
}

#[test]
fn colour_of_png_files_follows_alpha_of_other_files() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("in");
    white_with_mattes(&path, |frame| if frame == 2 { 1.0005 } else { 0.5 });
    std::fs::remove_file(path.join("m.0001.exr")).unwrap();
    let light = |options: &SourceOptions, frame| {
        let source = Source::open(&path, options).unwrap();
        let color = source.groups().iter().find(|group| group.kind == StreamKind::Color).unwrap();
        source.read_color(color, frame).unwrap()[0].get(0, 0).map(f16::to_f32)
    };
    let black = SourceOptions { missing: Some(Missing::Black), ..SourceOptions::default() };
    assert_eq!([0, 1, 2].map(|frame| light(&black, frame)), [[0.5; 3], [0.0; 3], [1.0; 3]]);
    let hold = SourceOptions { missing: Some(Missing::Hold), ..SourceOptions::default() };
    assert_eq!(light(&hold, 1), [0.5; 3]);
    // PNG colour is multiplied by alpha, so an invalid alpha is an error even if only colour is encoded.
    exr::write_alpha(&path.join("m.0001.exr"), &Plane::filled(SIDE, SIDE, f16::from_f32(1.5))).unwrap();
    let output = lightfold(&["encode", "in", "-o", "c.lfold", "--stream", "color"], folder.path());
    let said = String::from_utf8(output.stderr).unwrap();
    assert_says(&said, &["m.0001.exr", "pixel (0, 0) has an alpha of 1.5: 0 to 1 was expected"]);
    assert_eq!(output.status.code(), Some(2));
    let clamped = SourceOptions { invalid_color: InvalidColor::Black, ..SourceOptions::default() };
    assert_eq!(light(&clamped, 1), [1.0; 3]);
    // A frame whose alpha is missing is not treated as opaque.
    std::fs::remove_file(path.join("m.0002.exr")).unwrap();
    let output =
        lightfold(&["encode", "in", "-o", "c.lfold", "--missing", "skip", "--invalid-color", "black"], folder.path());
    let said = String::from_utf8(output.stderr).unwrap();
    assert_says(&said, &["frame 2: the alpha of this frame is missing", "--missing to hold or black"]);
}

#[test]
fn gray_files_are_no_mattes_of_their_own() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("in");
    std::fs::create_dir(&path).unwrap();
    for frame in 0..FRAMES {
        let gray = Plane::from_fn(SIDE, SIDE, |x, _| 1000 + 500 * x as u16);
        png::write_depth16(&path.join(format!("c.{frame:04}.png")), &gray.map(|code| *code)).unwrap();
    }
    fine("init in", folder.path());
    let proposed = Manifest::read(&path).unwrap().files;
    assert!(proposed.alpha.is_none(), "{proposed:?}");
}

#[test]
fn a_shard_follows_from_alpha_that_it_does_not_have() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("in");
    white_with_mattes(&path, |_| 0.5);
    std::fs::remove_file(path.join("c.0001.png")).unwrap();
    let line = "encode in --shard 1/2 --shard-stream color --missing hold --resume -o a.lfold";
    let is_complete = || {
        let said = fine(line, folder.path());
        String::from_utf8(said.stderr).unwrap().contains("this shard is complete")
    };
    assert_eq!([is_complete(), is_complete()], [false, true]);
    let matte = path.join("m.0002.exr");
    exr::write_alpha(&matte, &Plane::filled(SIDE, SIDE, f16::from_f32(0.25))).unwrap();
    assert_eq!([is_complete(), is_complete()], [false, true]);
    // Adds the frame that was missing, with a modification time before that of the shard.
    std::fs::copy(path.join("c.0000.png"), path.join("c.0001.png")).unwrap();
    let file = std::fs::File::options().write(true).open(path.join("c.0001.png")).unwrap();
    file.set_modified(SystemTime::UNIX_EPOCH).unwrap();
    assert_eq!([is_complete(), is_complete()], [false, true]);
}

#[test]
fn an_encode_is_not_resumed_after_its_alpha_has_changed() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("in");
    white_with_mattes(&path, |_| 0.5);
    // Depth is truncated, so that the encode stops after the colour chunks are written.
    let depth = |frame: u32| path.join(format!("d.{frame:04}.exr"));
    for frame in 0..FRAMES {
        exr::write_depth(&depth(frame), &Plane::filled(SIDE, SIDE, 2.0 + frame as f32)).unwrap();
    }
    let whole = std::fs::read(depth(2)).unwrap();
    std::fs::write(depth(2), &whole[..whole.len() / 2]).unwrap();
    write_manifest(&path, json!({ "color": "c.%04d.png", "alpha": "m.%04d.exr", "depth": "d.%04d.exr" }));
    let line = "encode in -o a.lfold --stream color,depth --resume";
    let stopped = lightfold(&line.split(' ').collect::<Vec<_>>(), folder.path());
    let said = String::from_utf8(stopped.stderr).unwrap();
    assert_says(&said, &["d.0002.exr", "safe in "]);
    std::fs::write(depth(2), &whole).unwrap();
    exr::write_alpha(&path.join("m.0000.exr"), &Plane::filled(SIDE, SIDE, f16::from_f32(0.25))).unwrap();
    assert_says(
        &refused(line, folder.path()),
        &["c.0000.png or ", "m.0000.exr (color of probe a", "has changed since"],
    );
}

/// Writes `all.lfold`: faces px and nx of probe `a`, with colour in frames 0 and 1, and alpha of the faces `alpha_of` in the
/// frames `alpha_frames`.
fn faces(folder: &Path, alpha_of: &[&str], alpha_frames: &str) {
    let path = folder.join("in");
    std::fs::create_dir(&path).unwrap();
    for (face, frame) in ["px", "nx"].into_iter().flat_map(|face| [0, 1].map(|frame| (face, frame))) {
        exr::write_rgba(&path.join(format!("{face}.{frame:04}.exr")), &rgba(frame)).unwrap();
    }
    let mut manifest = manifest(json!({ "color": "{face}.%04d.exr", "alpha": "{face}.%04d.exr" }));
    manifest["projection"] = json!("cubemap");
    manifest["faces_present"] = json!(["px", "nx"]);
    manifest["frames"] = json!([0, 1]);
    manifest["probes"] = json!([{ "name": "a", "position": [0, 0, 0] }]);
    std::fs::write(path.join("lightfield.json"), manifest.to_string()).unwrap();
    fine("encode in -o color.lfold --stream color", folder);
    manifest["faces_present"] = json!(alpha_of);
    std::fs::write(path.join("lightfield.json"), manifest.to_string()).unwrap();
    fine(&format!("encode in -o alpha.lfold --stream alpha --frames {alpha_frames}"), folder);
    fine("pack color.lfold alpha.lfold -o all.lfold", folder);
}

#[test]
fn what_a_manifest_cannot_describe_has_none() {
    for (alpha_of, frames) in [(&["px"][..], "0-1"), (&["px", "nx"], "1-1")] {
        let folder = TempDir::new().unwrap();
        faces(folder.path(), alpha_of, frames);
        for format in ["exr", "png"] {
            let said = fine(&format!("decode all.lfold -o {format} --format {format}"), folder.path());
            let said = String::from_utf8(said.stderr).unwrap();
            assert_says(&said, &["some faces have kinds or frames that others do not"]);
            assert!(!folder.path().join(format).join("lightfield.json").exists());
            // Decoding a single kind writes a manifest, and the dataset can be encoded again.
            fine(&format!("decode all.lfold -o {format}2 --format {format} --stream color"), folder.path());
            fine(&format!("encode {format}2 -o again.lfold"), folder.path());
        }
    }
    let folder = TempDir::new().unwrap();
    footage(&folder.path().join("in"));
    fine("encode in -o a.lfold --exposure -1", folder.path());
    let said = String::from_utf8(fine("decode a.lfold -o png --format png", folder.path()).stderr).unwrap();
    assert_says(&said, &["a manifest cannot describe the content of these PNG files"]);
}

#[test]
fn light_that_alpha_cannot_hold_counts_as_clipped() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("in");
    std::fs::create_dir(&path).unwrap();
    // White at alpha 0.5, additive red at alpha 0, a blue value above its alpha, and black. PNG files cannot store the second and
    // the third.
    let pixels = [[0.5, 0.5, 0.5, 0.5], [0.25, 0.0, 0.0, 0.0], [0.5, 0.5, 0.9, 0.5], [0.0; 4]];
    let picture = Plane::from_fn(SIDE, SIDE, |x, _| pixels[x as usize / 10].map(f16::from_f32));
    exr::write_rgba(&path.join("c.0000.exr"), &picture).unwrap();
    let mut manifest = manifest(json!({ "color": "c.%04d.exr", "alpha": "c.%04d.exr" }));
    manifest["frames"] = json!([0, 0]);
    std::fs::write(path.join("lightfield.json"), manifest.to_string()).unwrap();
    fine("encode in -o a.lfold --color-codec cells --psnr 90", folder.path());
    let said = String::from_utf8(fine("decode a.lfold -o out --format png", folder.path()).stderr).unwrap();
    assert_says(&said, &["800 colour pixels exceeded the 8-bit range"]);
}

#[test]
fn pictures_from_a_probe_have_its_alpha() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("in");
    footage(&path);
    for frame in 0..FRAMES {
        let depth = Plane::from_fn(SIDE, SIDE, |x, y| 2.0 + 0.01 * (x + y) as f32);
        exr::write_depth(&path.join(format!("d.{frame:04}.exr")), &depth).unwrap();
    }
    write_manifest(&path, json!({ "color": "c.%04d.exr", "alpha": "c.%04d.exr", "depth": "d.%04d.exr" }));
    fine("encode in -o a.lfold --psnr 60", folder.path());
    let line = "render a.lfold --eye 0,0,0 --look-at 0,0,-1 --fov 50 --size 40 --samples 1 --frames 1 --background transparent";
    fine(&format!("{line} -o a.exr"), folder.path());
    let found = exr::read_rgba(&folder.path().join("a.exr"), &ReadLimits::default()).unwrap();
    for (found, expected) in found.data().iter().zip(rgba(1).data()) {
        let [found, expected] = [found, expected].map(|pixel| pixel.map(f16::to_f32));
        // The renderer drops layers with a share below 1/64.
        let pairs = found.iter().zip(&expected);
        assert!(pairs.clone().all(|(a, b)| (a - b).abs() < 0.03), "{found:?} and {expected:?}");
    }
    // A picture of another frame of the same file has the alpha of that frame.
    fine(&format!("{} -o b.exr", line.replace("--frames 1", "--frames 2")), folder.path());
    let moved = exr::read_rgba(&folder.path().join("b.exr"), &ReadLimits::default()).unwrap();
    let differ = |found: &Plane<[f16; 4]>, frame| {
        let pairs = found.data().iter().zip(rgba(frame).into_data());
        pairs.map(|(a, b)| (a[3].to_f32() - b[3].to_f32()).abs()).fold(0.0, f32::max)
    };
    assert!(differ(&moved, 2) < 0.03 && differ(&moved, 1) > 0.2);
}
