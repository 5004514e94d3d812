//! Import and export of cameras: files of other programs, conversions between formats, and the probes of a light field as
//! cameras.

use std::path::{Path, PathBuf};

use evaluate::cameras::{self, ReadSettings};
use glam::DVec3;
use serde_json::Value;
use tempfile::TempDir;

use crate::commands::{fine, refused};

fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/cameras").join(name)
}

/// Cameras in files of pycolmap, usd-core and pygltflib have the eyes and directions that these packages report. `make.py` wrote
/// the files and expected.json.
#[test]
fn files_of_other_programs_are_read_as_they_mean_them() {
    let expected: Value = serde_json::from_slice(&std::fs::read(data("expected.json")).unwrap()).unwrap();
    let vector = |value: &Value| DVec3::from_array([0, 1, 2].map(|at| value[at].as_f64().unwrap()));
    let shares = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.5, 0.5]];
    for (name, count, tolerance) in [("colmap", 3, 1e-12), ("shot.usda", 5, 1e-8), ("shot.glb", 4, 1e-6)] {
        let read = cameras::read(&data(name), ReadSettings::with_fps(24.0)).unwrap().cameras;
        assert_eq!(read.len(), count, "{name}");
        let mut place = 0;
        for camera in expected[name].as_array().unwrap() {
            let frame = camera["frame"].as_u64().map(|frame| frame as u32);
            // expected.json has no frames between USD samples: USD interpolates the matrix, whose axes are then not orthonormal.
            while read[place].timed.frames.map(|frames| frames.first) != frame {
                place += 1;
            }
            let found = &read[place].timed.camera;
            let apart = (found.eye() - vector(&camera["eye"])).length();
            assert!(apart <= tolerance, "{name}: eye of {place}: {apart:e}");
            for (at, direction) in shares.iter().zip(camera["directions"].as_array().unwrap()) {
                let apart = (found.direction(*at) - vector(direction)).length();
                assert!(apart <= tolerance, "{name}: {at:?} of {place}: {apart:e}");
            }
            place += 1;
        }
    }
}

const PATH: &str = r#"{"cameras": [
    {"eye": [0.05, 1.5, 0.4], "look_at": [-2, 1.2, 0.8], "fov_y_deg": 60, "aspect": 1.5, "frame": 0},
    {"eye": [0.2, 1.4, 0.1], "look_at": [-2, 1.3, 0.3], "fov_y_deg": 60, "aspect": 1.5, "frame": 2}]}"#;

#[test]
fn a_path_renders_the_same_pictures_from_every_format() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    fine("capture courtyard --position=-0.3,1.5,0 --position=0.3,1.5,0 --frames 0-2 --size 32 -o captured", at);
    fine("encode captured --clip -o a.lfold", at);
    std::fs::write(at.join("path.json"), PATH).unwrap();
    fine("render a.lfold --camera path.json --size 24 -o own/%04d.png", at);
    let bytes = |frame: u32| std::fs::read(at.join(format!("own/{frame:04}.png"))).unwrap();
    assert!(bytes(0) != bytes(1) && bytes(1) != bytes(2), "the pictures show something");
    let picture =
        |name: &str, frame: u32| image::open(at.join(name).join(format!("{frame:04}.png"))).unwrap().to_rgb8();
    for (name, options) in [
        ("again.json", ""),
        ("transforms.json", ""),
        ("model", " --format colmap --size 90x60"),
        ("shot.glb", ""),
        ("shot.usda", " --fps 24"),
    ] {
        fine(&format!("cameras path.json -o {name}{options}"), at);
        fine(&format!("render a.lfold --camera {name} --frames 0-2 --size 24 -o shown_{name}/%04d.png"), at);
        for frame in 0..3 {
            let [own, other] = ["own".to_owned(), format!("shown_{name}")].map(|folder| picture(&folder, frame));
            assert_eq!(own.dimensions(), (36, 24));
            let differ = own.pixels().zip(other.pixels()).filter(|(a, b)| a != b).count();
            // Rays at the edges of surfaces may hit either side.
            assert!(differ <= 8, "{name}, frame {frame}: {differ} pixels differ");
        }
    }
    // The converted files are converted back to cameras.
    fine("cameras shot.usda -o from_usd.json", at);
    fine("cameras model -o from_colmap.json", at);
    let printed = fine("cameras shot.glb --format transforms -o -", at).stdout;
    let transforms: Value = serde_json::from_slice(&printed).unwrap();
    assert_eq!(transforms["frames"][2]["file_path"], "images/view.0002.png");
    assert_eq!(transforms["frames"][2]["frame"], 2);
    assert_eq!((&transforms["w"], &transforms["h"]), (&1620.into(), &1080.into()));
    let report: Value = serde_json::from_slice(&fine("cameras path.json -o b.usda --json", at).stdout).unwrap();
    assert_eq!((&report["cameras"], &report["format"]), (&3.into(), &"usd".into()));
}

#[test]
fn probes_become_cameras_whose_pictures_are_their_images() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    fine("capture courtyard --position=-0.3,1.5,0 --position=0.3,1.5,0 --frames 0-1 --size 32 -o captured", at);
    fine("encode captured --clip -o a.lfold --max-error 0", at);
    for input in ["a.lfold", "captured", "captured/lightfield.json"] {
        fine(&format!("cameras {input} -o transforms.json"), at);
        let text = std::fs::read_to_string(at.join("transforms.json")).unwrap();
        let transforms: Value = serde_json::from_str(&text).unwrap();
        assert_eq!(transforms["frames"].as_array().unwrap().len(), 12);
        assert_eq!(
            (&transforms["w"], &transforms["fl_x"], &transforms["cy"]),
            (&32.into(), &16.0.into(), &16.0.into())
        );
    }
    fine("render a.lfold --camera transforms.json --size 32 --frames 1 -o images/view.%04d.png", at);
    fine("decode a.lfold --stream color --frames 1 --format png -o decoded", at);
    // Image 4 is face pz of the first probe. Faces are stored mirrored; rendered from its own probe alone, a face is nearly
    // unchanged.
    fine("render a.lfold --probe 00 --camera transforms.json --size 32 --frames 1 -o own/view.%04d.png", at);
    for (number, face) in [(1, "nx"), (3, "ny"), (4, "pz"), (5, "nz")] {
        let open = |path: String| image::open(at.join(path)).unwrap().to_rgb8();
        let shown = open(format!("own/view.{number:04}.png"));
        let stored = open(format!("decoded/probe_00/face_{face}/color.0001.png"));
        let error = |mirror: bool| -> f64 {
            let square = |(x, y, pixel): (u32, u32, &image::Rgb<u8>)| {
                let other = stored.get_pixel(if mirror { 31 - x } else { x }, y);
                (0..3).map(|at| (f64::from(pixel[at]) - f64::from(other[at])).powi(2)).sum::<f64>()
            };
            (shown.enumerate_pixels().map(square).sum::<f64>() / (3.0 * 1024.0)).sqrt()
        };
        assert!(error(true) < 3.0 && error(true) < error(false), "{face}: {} {}", error(true), error(false));
    }
}

#[test]
fn what_cannot_be_converted_is_refused_in_a_sentence() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    std::fs::write(at.join("path.json"), PATH).unwrap();
    std::fs::write(at.join("words.json"), "{}").unwrap();
    for (line, words) in [
        ("cameras path.json -o a.txt", "--format"),
        ("cameras path.json -o -", "--format"),
        ("cameras path.json --format colmap -o -", "colmap"),
        ("cameras path.json --format usd -o - --json", "--json"),
        ("cameras path.json -o path.json", "overwritten"),
        ("cameras words.json -o a.usda", "words.json"),
        ("cameras nothing.json -o a.usda", "nothing.json"),
        ("cameras . -o a.usda", "a COLMAP model was expected"),
    ] {
        let said = refused(line, at);
        assert!(said.contains(words), "{line}: {said}");
        assert!(!at.join("a.usda").exists() && !at.join("a.txt").exists());
    }
}
