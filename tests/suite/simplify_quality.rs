//! Simplified scenes may not become worse than tests/baselines/simplify.csv, which has one row per scene: in views from between the
//! cameras, since those of the cameras are best where noise is kept.
//!
//! `cargo test --test suite simplify_quality::write_baselines -- --ignored` regenerates the file after an intended change.

use std::fmt::Write as _;
use std::path::Path;

use codec::effort::Effort;
use codec::monitor::Silent;
use scene::{DemoKind, FootagePlan};
use serde_json::Value;
use simplify::budgets::Budgets;
use simplify::capture::Capture;
use simplify::fidelity::Evaluation;
use simplify::pipeline::{Simplified, simplify};
use simplify::settings::Settings;

const FILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/baselines/simplify.csv");
const HEAD: &str = "set,triangles,texels,psnr_db,ssim";
/// Tolerances in dB, in SSIM, and relative for triangles and texels: logarithms on other processors may select a few different
/// tiles.
const SLACK_DB: f64 = 0.05;
const SLACK_SSIM: f64 = 0.002;
const SLACK: f64 = 1.01;

/// Probes of each scene that are compared, and not simplified.
const HELD_OUT: [&str; 3] = ["01", "03", "05"];

fn settings() -> Settings {
    let budgets = Budgets { triangles: 3000.0, area: 2.5, peak_overdraw: 4.0 };
    Settings { budgets, atlas: 512, effort: Effort::Fast, ..Settings::default() }
}

struct Row {
    set: &'static str,
    triangles: usize,
    texels: u64,
    psnr_db: f64,
    ssim: f64,
}

impl Row {
    fn line(&self) -> String {
        let Row { set, triangles, texels, psnr_db, ssim } = self;
        format!("{set},{triangles},{texels},{psnr_db:.3},{ssim:.4}")
    }
}

/// Opens the probes of a dataset that are named, or those that are not.
fn opened(manifest: &Path, are_named: bool) -> Capture {
    let mut of: Value = serde_json::from_str(&std::fs::read_to_string(manifest).unwrap()).unwrap();
    let probes = of["probes"].as_array_mut().unwrap();
    probes.retain(|probe| HELD_OUT.contains(&probe["name"].as_str().unwrap()) == are_named);
    let path = manifest.with_file_name(format!("{are_named}.json"));
    std::fs::write(&path, of.to_string()).unwrap();
    Capture::open(&path, None).unwrap()
}

fn of_scene(kind: DemoKind) -> Row {
    let folder = tempfile::tempdir().unwrap();
    let plan = FootagePlan { kind, frames: 1, face_size: 32, probes: 7 };
    plan.write(folder.path(), &Silent).unwrap();
    let [mut capture, mut held_out] =
        [false, true].map(|are_named| opened(&folder.path().join("lightfield.json"), are_named));
    let simplified = simplify(&mut capture, &settings(), &Silent).unwrap();
    let Evaluation { fidelity, .. } = simplified.evaluate(&mut held_out, &settings(), &Silent).unwrap();
    let Simplified { scene, atlas, .. } = simplified;
    Row {
        set: kind.name(),
        triangles: scene.mesh.triangles.len(),
        texels: atlas.map(u64::from).iter().product(),
        psnr_db: fidelity.similarity.all.psnr_db(),
        ssim: fidelity.similarity.ssim().unwrap(),
    }
}

fn scenes() -> Vec<Row> {
    [DemoKind::Courtyard, DemoKind::Interior, DemoKind::Mirrors].into_iter().map(of_scene).collect()
}

#[test]
fn simplified_scenes_are_no_worse_and_take_no_more() {
    let text = std::fs::read_to_string(FILE).unwrap();
    assert_eq!(text.lines().next(), Some(HEAD));
    let rows = scenes();
    assert_eq!(text.lines().count(), 1 + rows.len());
    for row in rows {
        println!("{}", row.line());
        let key = format!("{},", row.set);
        let line = text.lines().find(|line| line.starts_with(&key)).unwrap_or_else(|| panic!("{key} has no baseline"));
        let numbers: Vec<f64> = line[key.len()..].split(',').map(|number| number.parse().unwrap()).collect();
        let [triangles, texels, psnr_db, ssim] = numbers[..] else { panic!("{line}") };
        assert!(row.triangles as f64 <= SLACK * triangles, "{key} {} triangles, {triangles} before", row.triangles);
        assert!(row.texels as f64 <= SLACK * texels, "{key} {} texels, {texels} before", row.texels);
        assert!(row.psnr_db >= psnr_db - SLACK_DB, "{key} {} dB are less than {psnr_db}", row.psnr_db);
        assert!(row.ssim >= ssim - SLACK_SSIM, "{key} an SSIM of {} is less than {ssim}", row.ssim);
    }
}

#[test]
#[ignore = "writes tests/baselines"]
fn write_baselines() {
    let mut text = format!("{HEAD}\n");
    for row in scenes() {
        writeln!(text, "{}", row.line()).unwrap();
    }
    std::fs::write(FILE, text).unwrap();
}
