//! Exposure, tone maps and lookup tables of `render`.

use std::path::Path;

use codec::image::ReadLimits;
use footage::image_files::exr;
use serde_json::Value;
use tempfile::TempDir;

use crate::commands::{fine, refused};
use crate::render::{EYE, encoded};

fn codes(path: &Path) -> Vec<[u8; 3]> {
    image::open(path).unwrap().into_rgb8().pixels().map(|pixel| pixel.0).collect()
}

/// Returns linear RGB of an EXR image.
fn light(path: &Path) -> Vec<[f32; 3]> {
    let plane = exr::read_color(path, &Default::default(), &ReadLimits::default()).unwrap();
    plane.data().iter().map(|light| light.map(half::f16::to_f32)).collect()
}

/// Returns the code of viewer/src/gpu/present.wgsl.
fn of_player(light: f32, exposure_ev: f32, tone_map: &str) -> f32 {
    let x = (light * exposure_ev.exp2()).max(0.0);
    let toned = match tone_map {
        "reinhard" => x / (1.0 + x),
        "filmic" => x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14),
        _ => x,
    };
    let x = toned.clamp(0.0, 1.0);
    255.0 * if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 }
}

fn mean_difference(a: &[[u8; 3]], b: &[[u8; 3]]) -> f64 {
    assert_eq!(a.len(), b.len());
    let each = a.as_flattened().iter().zip(b.as_flattened()).map(|(a, b)| f64::from(a.abs_diff(*b)));
    each.sum::<f64>() / (3 * a.len()) as f64
}

#[test]
fn pictures_look_as_in_the_player() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    encoded("courtyard", at);
    fine(&format!("render a.lfold {EYE} -o light.exr"), at);
    fine(&format!("render a.lfold {EYE} -o usual.png"), at);
    let light = light(&at.join("light.exr"));
    let usual = codes(&at.join("usual.png"));
    for (exposure, tone_map) in [(0.0, "none"), (1.5, "none"), (0.0, "reinhard"), (1.0, "filmic"), (-2.0, "filmic")] {
        let look = format!("--exposure {exposure} --tone-map {tone_map}");
        fine(&format!("render a.lfold {EYE} {look} -o a.png --contact-sheet sheet.png"), at);
        let found = codes(&at.join("a.png"));
        for (found, light) in found.as_flattened().iter().zip(light.as_flattened()) {
            let expected = of_player(*light, exposure, tone_map);
            assert!((f32::from(*found) - expected).abs() < 0.6, "{look}: {light}: {found} {expected}");
        }
        assert_eq!(found == usual, (exposure, tone_map) == (0.0, "none"), "{look}");
        let printed = fine(&format!("render a.lfold {EYE} {look} -o -"), at).stdout;
        assert!(printed == std::fs::read(at.join("a.png")).unwrap(), "{look}");
    }
    // The sheet shows the pictures as they are: the dark one is darker.
    let mean = |codes: &[[u8; 3]]| codes.as_flattened().iter().map(|&code| f64::from(code)).sum::<f64>();
    let dark = codes(&at.join("sheet.png"));
    fine(&format!("render a.lfold {EYE} --exposure 2 --contact-sheet sheet.png"), at);
    assert!(mean(&codes(&at.join("sheet.png"))) > 1.1 * mean(&dark));
}

#[test]
fn an_exposure_replaces_that_of_the_container() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    encoded("courtyard", at);
    fine("encode captured --exposure -1 -o dark.lfold", at);
    fine(&format!("render a.lfold {EYE} -o a.png"), at);
    fine(&format!("render dark.lfold {EYE} -o dark.png"), at);
    fine(&format!("render dark.lfold {EYE} --exposure 0 -o shown.png"), at);
    let [a, dark, shown] = ["a.png", "dark.png", "shown.png"].map(|name| codes(&at.join(name)));
    let [far, near] = [mean_difference(&a, &dark), mean_difference(&a, &shown)];
    assert!(near < 3.0 && far > 20.0, "{near} {far}");
    // Figures are those of the light.
    let report = |look: &str| -> Value {
        let line = format!("render a.lfold --reference captured --reference-probe 04 --frames 0 {look} --json");
        serde_json::from_slice(&fine(&line, at).stdout).unwrap()
    };
    let [plain, bright] = ["", "--exposure 2 --tone-map filmic -o out"].map(report);
    assert_eq!(plain["reference"], bright["reference"]);
    assert!(plain["reference"]["psnr_db"].is_number());
}

#[test]
fn a_lookup_table_replaces_tone_map_and_transfer_function() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    encoded("courtyard", at);
    fine(&format!("render a.lfold {EYE} -o usual.png"), at);
    fine(&format!("render a.lfold {EYE} -o light.exr"), at);
    // The sRGB curve as a table of one dimension, then one of three that inverts red.
    let mut text = "# sRGB\nLUT_1D_SIZE 4096\nLUT_1D_INPUT_RANGE 0 2\nLUT_3D_SIZE 2\n".to_owned();
    for entry in 0..4096 {
        let code = of_player(2.0 * entry as f32 / 4095.0, 0.0, "none") / 255.0;
        text += &format!("{code} {code} {code}\n");
    }
    for corner in 0..8 {
        text += &format!("{} {} {}\n", 1 - (corner & 1), corner >> 1 & 1, corner >> 2);
    }
    std::fs::write(at.join("a.cube"), &text).unwrap();
    fine(&format!("render a.lfold {EYE} --lut a.cube -o a.png"), at);
    let usual: Vec<[u8; 3]> = codes(&at.join("usual.png")).into_iter().map(|[r, g, b]| [255 - r, g, b]).collect();
    assert!(mean_difference(&codes(&at.join("a.png")), &usual) < 0.2);
    // Exposure comes first.
    fine(&format!("render a.lfold {EYE} --exposure 1 -o bright.png"), at);
    fine(&format!("render a.lfold {EYE} --exposure 1 --lut a.cube -o a.png"), at);
    let bright: Vec<[u8; 3]> = codes(&at.join("bright.png")).into_iter().map(|[r, g, b]| [255 - r, g, b]).collect();
    assert!(mean_difference(&codes(&at.join("a.png")), &bright) < 0.2);
    // ACEScct of gray light is the same for all channels; an identity shows its codes.
    let corners: String = (0..8).map(|at| format!("{} {} {}\n", at & 1, at >> 1 & 1, at >> 2)).collect();
    std::fs::write(at.join("same.cube"), format!("LUT_3D_SIZE 2\n{corners}")).unwrap();
    fine(&format!("render a.lfold {EYE} --lut same.cube --lut-input acescct -o log.png"), at);
    let logs = codes(&at.join("log.png"));
    let grays = light(&at.join("light.exr")).into_iter().zip(&logs).filter(|([r, g, b], _)| {
        let (low, high) = (r.min(*g).min(*b), r.max(*g).max(*b));
        low > 0.05 && high < 1.01 * low
    });
    for (light, log) in grays {
        let expected = 255.0 * (light[1].log2() + 9.72) / 17.52;
        assert!(log.iter().all(|code| (f32::from(*code) - expected).abs() < 1.5), "{light:?} {log:?} {expected}");
    }
}

#[test]
fn looks_that_make_no_sense_are_refused() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    encoded("courtyard", at);
    std::fs::write(at.join("bad.cube"), "LUT_3D_SIZE 2\n0 0 0\n0 x 0\n").unwrap();
    for (options, words) in [
        ("--exposure 1 -o a.exr", "linear light"),
        ("--tone-map filmic --null", "add -o or --contact-sheet"),
        ("--exposure 11 -o a.png", "-10 to 10 stops"),
        ("--tone-map aces -o a.png", "none, reinhard, filmic"),
        ("--lut bad.cube -o a.png", "bad.cube: line 3"),
        ("--lut none.cube -o a.png", "none.cube"),
        ("--lut bad.cube --tone-map filmic -o a.png", "--tone-map"),
        ("--lut-input acescct -o a.png", "--lut"),
        ("--lut bad.cube -o bad.cube", "bad.cube"),
    ] {
        let said = refused(&format!("render a.lfold {EYE} {options}"), at);
        assert!(said.contains(words), "{options}: {said}");
        assert!(!at.join("a.png").exists() && !at.join("a.exr").exists(), "{options}");
    }
}
