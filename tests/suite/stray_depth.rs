//! A few stray pixels that reduce the depth precision of all others: `encode` names them, and --near, --far and --invalid-depth
//! exclude them. Error bounds in percent and metres.

use std::path::Path;

use codec::image::{DepthPlane, Face, Plane};
use serde_json::Value;
use tempfile::TempDir;

use crate::commands::{fine, lightfold, refused};
use crate::footage::Footage;

const SIDE: u32 = 64;

/// Returns depths of 2 m to 20 m, with other depths in some pixels of frame 1.
fn surfaces(frame: u32, strays: &[(u32, u32, f32)]) -> DepthPlane {
    Plane::from_fn(SIDE, SIDE, |x, y| {
        let stray = strays.iter().find(|stray| frame == 1 && (stray.0, stray.1) == (x, y));
        stray.map_or(2.0 + ((x + SIDE * y) as f32 + 0.37 * frame as f32) * 18.0 / 4096.0, |stray| stray.2)
    })
}

fn write(folder: &Path, strays: &[(u32, u32, f32)]) {
    let depth = |_: Face, frame: u32| surfaces(frame, strays);
    Footage { frames: [0, 2], depth: Some(&depth), ..Footage::new(SIDE, SIDE) }.write(folder);
}

/// Runs `encode`; returns its JSON report and its standard error.
fn encode(line: &str, at: &Path) -> (Value, String) {
    let out = fine(&format!("encode {line} --json"), at);
    (serde_json::from_slice(&out.stdout).unwrap(), String::from_utf8(out.stderr).unwrap())
}

fn inspect(container: &str, at: &Path) -> Value {
    serde_json::from_slice(&fine(&format!("inspect {container} --json"), at).stdout).unwrap()
}

fn text_of(line: &str, at: &Path) -> String {
    let out = fine(line, at);
    String::from_utf8([out.stdout, out.stderr].concat()).unwrap()
}

#[test]
fn strays_are_named_with_the_options_that_leave_them_out() {
    for (depth, option) in [(1e-40, "--near 2"), (1e-6, "--near 2"), (0.01, "--near 2"), (9e9, "--far 19.")] {
        let folder = TempDir::new().unwrap();
        let at = folder.path();
        write(at, &[(13, 40, depth)]);
        let (report, said) = encode(". -o a.lfold", at);
        let strays = &report["depth"][0]["strays"];
        assert_eq!((&strays["pixels"], &strays["of_pixels"]), (&1.into(), &12_288.into()), "{report}");
        let first = &strays["first"][0];
        assert_eq!(
            (&first["frame"], &first["x"], &first["y"], &first["face"]),
            (&1.into(), &13.into(), &40.into(), &"px".into())
        );
        assert_eq!(first["depth_m"].as_f64().map(|metres| metres as f32), Some(depth));
        assert!(first["file"].as_str().unwrap().ends_with("depth.0001.exr"));
        let percent = |report: &Value| report["max_error_percent"].as_f64().unwrap();
        assert!(percent(&strays["without"]) < 0.75 * percent(&report["depth"][0]));
        let words = [
            "warning: probe 00: 1 depth pixel of 12288",
            "depth.0001.exr, frame 1, px, pixel (13, 40)",
            option,
            "--invalid-depth",
        ];
        assert!(words.iter().all(|word| said.contains(word)), "{said}");

        // The proposed option excludes the pixel, and the report states it.
        let range = if depth < 1.0 { "--near 2" } else { "--far 20" };
        for (rule, becomes) in [("near", "2"), ("far", "inf")] {
            let line = format!(". -o b.lfold {range} --invalid-depth {rule}");
            let (report, said) = encode(&line, at);
            assert_eq!((&report["outside_pixels"], &report["depth"][0]["strays"]), (&1.into(), &Value::Null));
            assert!(
                percent(&report["depth"][0]) < 0.4 && said.contains("1 depth pixel outside near and far"),
                "{said}"
            );
            let diff = lightfold(&["diff", ".", "b.lfold", "--max-error", "100", "--json"], at);
            assert_eq!(diff.status.code(), Some(1));
            let diff: Value = serde_json::from_slice(&diff.stdout).unwrap();
            assert_eq!(diff["depth"]["outside_pixels"], 1, "{becomes}");
            fine(&format!("diff . b.lfold --max-error 100 --invalid-depth {rule}"), at);
        }
        let said = refused(&format!("encode . -o c.lfold {range}"), at);
        assert!(said.contains("pixel (13, 40)") && said.contains("--invalid-depth"), "{said}");
        assert!(!at.join("c.lfold").exists());
    }
}

#[test]
fn checking_footage_names_strays_as_encoding_does() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    let check = |more: &[&str]| {
        let out = lightfold(&[&["inspect", "--check", "."], more].concat(), at);
        assert!(out.status.code().is_some_and(|code| code < 2), "{out:?}");
        String::from_utf8(out.stdout).unwrap()
    };
    for (depth, option) in [(1e-40, "--near 2"), (1e-6, "--near 2"), (9e9, "--far 19.")] {
        write(at, &[(13, 40, depth)]);
        let said = check(&["--frame", "1"]);
        let words = [
            "warning: probe 00: 1 depth pixel of 4096",
            "depth.0001.exr, frame 1, px, pixel (13, 40)",
            option,
            "--invalid-depth",
        ];
        assert!(words.iter().all(|word| said.contains(word)), "{said}");
        let report: Value = serde_json::from_str(&check(&["--frame", "1", "--json"])).unwrap();
        let first = &report["depth_strays"][0]["strays"]["first"][0];
        assert_eq!((&first["x"], &first["y"]), (&13.into(), &40.into()), "{report}");
        assert_eq!(first["depth_m"].as_f64().map(|metres| metres as f32), Some(depth));
        // Without --frame, another frame is checked, which has no strays.
        assert!(!check(&[]).contains("warning"));
    }
    let report: Value = serde_json::from_str(&check(&["--json"])).unwrap();
    assert!(report["depth_strays"].is_null());
}

#[test]
fn usual_depth_has_no_strays() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    write(at, &[]);
    let (report, said) = encode(". -o a.lfold", at);
    assert!(report["depth"][0]["strays"].is_null() && !said.contains("warning"), "{said}");
    // A depth of 1e30 m is background and not a stray surface.
    write(at, &[(1, 1, 1e30)]);
    let (report, _) = encode(". -o a.lfold", at);
    assert!(report["depth"][0]["strays"].is_null());
    // A single distance is coded exactly.
    let depth = |_: Face, _: u32| Plane::filled(SIDE, SIDE, 3.5);
    Footage { frames: [0, 0], depth: Some(&depth), ..Footage::new(SIDE, SIDE) }.write(at);
    let (report, _) = encode(". -o a.lfold", at);
    assert_eq!(report["depth"][0]["max_error_percent"], 0.0);
    fine("diff . a.lfold --exact", at);
}

#[test]
fn bounds_hold_in_every_pixel_as_they_are_stated() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    let denormal: &[(u32, u32, f32)] = &[(0, 0, 1e-42), (1, 0, 3e-44)];
    for (strays, options) in [
        (&[][..], ""),
        (&[(7, 7, 1e-6)], ""),
        (denormal, ""),
        (&[], "--max-error 0.4%"),
        (&[(7, 7, 1e-6)], "--max-error 2.1%"),
        (&[], "--max-error 0.4% --depth-codec quadtree"),
        (&[], "--max-error 30 --update-threshold 20"),
        (&[], "--depth-codec aabb --update-threshold 55"),
    ] {
        write(at, strays);
        let (report, _) = encode(&format!(". -o a.lfold {options}"), at);
        let of_probe = &report["depth"][0];
        let stream = &inspect("a.lfold", at)["streams"][0];
        for key in ["max_error_percent", "max_error_m", "error_bound_codes", "near_m", "far_m"] {
            assert_eq!(of_probe[key], stream[key], "{key} with {options}");
        }
        let percent = of_probe["max_error_percent"].as_f64().unwrap();
        if let Some(asked) = options.strip_prefix("--max-error ").and_then(|rest| rest.split_once('%')) {
            let asked: f64 = asked.0.parse().unwrap();
            assert!(percent <= asked && percent > 0.98 * asked, "{percent}% of {asked}%");
        }
        let decoder = lightfold::Decoder::open(at.join("a.lfold")).unwrap();
        let mut face = decoder.face(&decoder.streams()[0]);
        let range = decoder.streams()[0].depth_range().unwrap();
        for frame in 0..3 {
            let codec::decode::Picture::Depth(codes) = face.decode(frame).unwrap() else {
                panic!("depth was expected")
            };
            for (code, z) in codes.data().iter().zip(surfaces(frame, strays).data()) {
                let error = (f64::from(range.metres(*code)) - f64::from(*z)).abs();
                assert!(error <= percent / 100.0 * f64::from(*z) * (1.0 + 1e-9), "{z} with {options}: {error}");
            }
        }
        let metres = &of_probe["max_error_m"];
        let near = of_probe["near_m"].as_f64().unwrap();
        assert_eq!(metres["at_1_m"].is_null(), near > 1.0);
        assert!((metres["at_10_m"].as_f64().unwrap() - percent / 10.0).abs() < 1e-9 && metres["at_100_m"].is_null());
        for text in [text_of(&format!("encode . -o a.lfold {options}"), at), text_of("inspect a.lfold", at)] {
            assert!(text.contains("depth of 00: ") && text.contains("% of the distance"), "{text}");
            assert!(text.contains(" at 10 m") && text.contains("no surface at"), "{text}");
        }
    }
    // A codec without an error bound, and a bound that no code meets.
    let text = text_of("encode . -o a.lfold --depth-codec bc4w", at);
    assert!(text.contains("no bound on the error"), "{text}");
    write(at, &[(7, 7, 1e-40)]);
    let said = refused("encode . -o b.lfold --max-error 0.01%", at);
    assert!(said.contains("probe 00") && said.contains("--max-error 0.01%") && said.contains("--near"), "{said}");
    for wrong in ["0.4", "-1%", "101%", "65535", "much"] {
        refused(&format!("encode . -o b.lfold --max-error={wrong}"), at);
    }
    write(at, &[]);
    let bytes = |options: &str| {
        fine(&format!("encode . -o b.lfold {options}"), at);
        std::fs::read(at.join("b.lfold")).unwrap()
    };
    assert_eq!(bytes("--max-error 0.4%"), bytes("--max-error-relative 0.004"));
}

#[test]
fn scans_and_shards_name_the_same_strays() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    write(at, &[(13, 40, 1e-6), (2, 3, 1e-6)]);
    let strays = |line: &str| encode(line, at).0["depth"][0]["strays"].clone();
    let whole = strays(". -o a.lfold");
    assert_eq!(whole["pixels"], 2);
    assert_eq!((&whole["first"][0]["x"], &whole["first"][0]["y"]), (&2.into(), &3.into()));
    fine("scan . -o scan.json", at);
    assert_eq!(strays(". -o b.lfold --scan scan.json"), whole);
    assert_eq!(std::fs::read(at.join("a.lfold")).unwrap(), std::fs::read(at.join("b.lfold")).unwrap());
    fine("scan . -o scan-1.json --threads 1", at);
    assert_eq!(std::fs::read(at.join("scan.json")).unwrap(), std::fs::read(at.join("scan-1.json")).unwrap());
    assert_eq!(strays(". -o c.lfold --scan scan.json --shard 1/1"), whole);
    assert_eq!(strays(". -o d.lfold --shard 1/1 --threads 1"), whole);
}

#[test]
fn only_the_probe_with_strays_is_named() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    for (probe, strays) in [("a", &[][..]), ("b", &[(9, 9, 1e-6)][..])] {
        for frame in 0..2 {
            let folder = at.join(probe);
            std::fs::create_dir_all(&folder).unwrap();
            let path = folder.join(format!("depth.{frame:04}.exr"));
            footage::image_files::exr::write_depth(&path, &surfaces(frame, strays)).unwrap();
        }
    }
    let manifest = r#"{ "lightfield": 1, "name": "two", "fps": 24, "frames": [0, 1], "projection": "cubemap",
        "size": [64, 64], "faces_present": ["px"], "depth": { "kind": "distance", "unit": "m" },
        "files": { "depth": "{probe}/depth.%04d.exr" },
        "probes": [{ "name": "a", "position": [0, 0, 0] }, { "name": "b", "position": [1, 0, 0] }] }"#;
    std::fs::write(at.join("lightfield.json"), manifest).unwrap();
    let (report, said) = encode(". -o a.lfold", at);
    assert_eq!(report["depth"].as_array().unwrap().len(), 2);
    assert!(report["depth"][0]["strays"].is_null() && report["depth"][1]["strays"]["pixels"] == 1, "{report}");
    assert!(said.contains("warning: probe b") && !said.contains("probe a"), "{said}");
}
