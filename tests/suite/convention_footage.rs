//! `inspect --check` on measured footage: with correct labels, and with wrong manifests beside symbolic links to the files.
#![cfg(unix)]

use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};

use footage::convention::{Report, Verdict};
use footage::dataset::Manifest;
use footage::dataset::manifest::{Background, FileDepth, Probe};
use glam::{DMat3, DQuat, DVec3};
use tempfile::TempDir;

use crate::convention::checked;

fn data() -> PathBuf {
    PathBuf::from(option_env!("LIGHTFOLD_DATA").unwrap_or("no data"))
}

/// Creates a dataset of links to every folder of `set`, with faces renamed by `face`, and with a changed manifest.
fn copy(set: &Path, change: impl FnOnce(&mut Manifest), face: impl Fn(&str) -> String) -> TempDir {
    let folder = TempDir::new().unwrap();
    let mut manifest = Manifest::read(set).unwrap();
    change(&mut manifest);
    std::fs::write(folder.path().join("lightfield.json"), manifest.to_json().unwrap()).unwrap();
    for probe in std::fs::read_dir(set).unwrap().map(|entry| entry.unwrap().path()).filter(|path| path.is_dir()) {
        let to = folder.path().join(probe.file_name().unwrap());
        std::fs::create_dir(&to).unwrap();
        for inner in std::fs::read_dir(&probe).unwrap().map(|entry| entry.unwrap()) {
            let name = inner.file_name().into_string().unwrap();
            let name = name.strip_prefix("face_").map_or(name.clone(), |name| format!("face_{}", face(name)));
            symlink(inner.path().canonicalize().unwrap(), to.join(name)).unwrap();
        }
    }
    folder
}

fn mislabelled(set: &str, change: impl FnOnce(&mut Manifest)) -> Report {
    checked(copy(&data().join(set), change, str::to_owned).path())
}

fn exchanged(set: &str, a: &str, b: &str) -> Report {
    let other = |face: &str| {
        if face == a {
            b
        } else if face == b {
            a
        } else {
            face
        }
        .to_owned()
    };
    checked(copy(&data().join(set), |_| (), other).path())
}

#[track_caller]
fn assert_suspects(report: &Report, what: &str, names: &[&str]) {
    let suspected = report.findings.iter().filter(|finding| finding.verdict == Verdict::Suspect);
    let found: Vec<&str> = suspected.map(|finding| finding.check).collect();
    assert!(names.iter().any(|name| found.contains(name)), "{what}: {report:#?}");
}

fn depth(manifest: &mut Manifest) -> &mut footage::dataset::manifest::DepthInfo {
    manifest.depth.as_mut().unwrap()
}

fn scaled(manifest: &mut Manifest, scale: f64) {
    depth(manifest).unit = None;
    depth(manifest).scale = Some(depth(manifest).scale.unwrap_or(1.0) * scale);
}

#[test]
#[cfg_attr(not(footage_at_hand), ignore = "no footage at hand: see LIGHTFOLD_DATA in CONTRIBUTING.md")]
fn measured_footage_raises_no_doubt() {
    for set in ["sponza", "sponza9", "glass", "object", "equirect", "sponza1k"] {
        let report = checked(&data().join(set));
        assert!(!report.suspects(), "{set}: {report:#?}");
        // A single probe without faces allows few checks, but some.
        let fine = report.findings.iter().filter(|finding| finding.verdict == Verdict::Fine).count();
        assert!(fine >= 4, "{set}: {report:#?}");
    }
}

#[test]
#[cfg_attr(not(footage_at_hand), ignore = "no footage at hand: see LIGHTFOLD_DATA in CONTRIBUTING.md")]
#[cfg_attr(all(footage_at_hand, not(all_tests)), ignore = "long: scripts/test all runs it")]
fn measured_footage_with_a_wrong_manifest_is_suspected() {
    for set in ["sponza", "sponza9", "glass", "object"] {
        let wrong = |change: &dyn Fn(&mut Manifest)| mislabelled(set, change);
        let report = wrong(&|manifest| depth(manifest).kind = FileDepth::Planar);
        assert_suspects(&report, set, &["depth.kind"]);
        for scale in [0.001, 0.1, 0.3048, 1.1, 10.0] {
            let report = wrong(&|manifest| scaled(manifest, scale));
            assert_suspects(&report, &format!("{set} {scale}"), &["depth.scale"]);
        }
        let report = wrong(&|manifest| {
            let position = manifest.probes[0].position;
            manifest.probes[0].position = manifest.probes[1].position;
            manifest.probes[1].position = position;
        });
        assert_suspects(&report, set, &["positions"]);
        for axis in 0..3 {
            let report = wrong(&|manifest| {
                manifest.probes.iter_mut().for_each(|probe| probe.position.as_mut().unwrap()[axis] *= -1.0)
            });
            // A flipped axis is suspected even in `object`, whose probes are symmetric about every axis.
            assert_suspects(&report, &format!("{set} -{axis}"), &["positions"]);
        }
        let report = wrong(&|manifest| manifest.probes[2].position.as_mut().unwrap()[0] += 0.3);
        assert_suspects(&report, set, &["positions"]);
        let report = wrong(&|manifest| (depth(manifest).near, depth(manifest).far) = (Some(1000.0), Some(30_000.0)));
        assert_suspects(&report, set, &["depth.near_far"]);
    }
    let report = mislabelled("sponza1k", |manifest| depth(manifest).kind = FileDepth::Planar);
    assert_suspects(&report, "sponza1k", &["depth.kind.flatness"]);
    let report = mislabelled("equirect", |manifest| depth(manifest).far = Some(5.0));
    assert_suspects(&report, "equirect", &["depth.near_far"]);
}

#[test]
#[cfg_attr(not(footage_at_hand), ignore = "no footage at hand: see LIGHTFOLD_DATA in CONTRIBUTING.md")]
fn measured_footage_with_exchanged_faces_is_suspected() {
    for set in ["sponza", "sponza9", "glass"] {
        for (a, b) in [("py", "ny"), ("px", "nx"), ("px", "pz")] {
            assert_suspects(&exchanged(set, a, b), &format!("{set} {a} {b}"), &["seams.depth"]);
        }
    }
    assert_suspects(&exchanged("sponza1k", "px", "nz"), "sponza1k", &["seams.depth"]);
    // No surface of the dragon reaches an edge of a face, so the positions are suspected instead of the seams.
    for (a, b) in [("py", "ny"), ("px", "nx"), ("px", "pz")] {
        assert_suspects(&exchanged("object", a, b), &format!("object {a} {b}"), &["positions", "probes"]);
    }
}

/// Checks 12 frames of a moving depth camera, each as a probe.
fn kinect(change: impl FnOnce(&mut Manifest)) -> Report {
    let folder = TempDir::new().unwrap();
    let set = data().join("rgbd/kinect");
    let template: Manifest = serde_json::from_str(
        r#"{ "lightfield": 1, "name": "kinect", "fps": 30, "frames": [0, 0], "projection": "perspective",
             "size": [640, 480], "depth": { "kind": "planar", "scale": 0.001, "background": 0 },
             "color": { "space": "srgb" },
             "files": { "depth": "{probe}/depth.%04d.png", "color": "{probe}/color.%04d.png" },
             "probes": [{ "name": "0", "position": [0, 0, 0], "intrinsics": [585, 585, 320, 240] }] }"#,
    )
    .unwrap();
    let mut manifest = Manifest { probes: Vec::new(), ..template.clone() };
    for frame in 150..162 {
        let text = std::fs::read_to_string(set.join(format!("frame-{frame:06}.pose.txt"))).unwrap();
        let pose: Vec<f64> = text.split_whitespace().map(|word| word.parse().unwrap()).collect();
        // The cameras of this dataset look along +Z with +Y down.
        let column = |at: usize| DVec3::new(pose[at], pose[4 + at], pose[8 + at]);
        let turn = DQuat::from_mat3(&DMat3::from_cols(column(0), -column(1), -column(2))).normalize();
        let name = frame.to_string();
        std::fs::create_dir(folder.path().join(&name)).unwrap();
        for kind in ["depth", "color"] {
            let file = set.join(format!("frame-{frame:06}.{kind}.png")).canonicalize().unwrap();
            symlink(file, folder.path().join(&name).join(format!("{kind}.0000.png"))).unwrap();
        }
        let orientation = Some(turn.to_array());
        manifest.probes.push(Probe {
            name,
            position: Some(column(3).to_array()),
            orientation,
            ..template.probes[0].clone()
        });
    }
    change(&mut manifest);
    std::fs::write(folder.path().join("lightfield.json"), manifest.to_json().unwrap()).unwrap();
    checked(folder.path())
}

#[test]
#[cfg_attr(not(footage_at_hand), ignore = "no footage at hand: see LIGHTFOLD_DATA in CONTRIBUTING.md")]
fn a_depth_camera_is_checked() {
    let report = kinect(|_| ());
    assert!(!report.suspects(), "{report:#?}");
    let turned = |turn: fn(DQuat) -> DQuat| {
        kinect(|manifest| {
            for probe in &mut manifest.probes {
                probe.orientation = Some(turn(DQuat::from_array(probe.orientation.unwrap())).to_array());
            }
        })
    };
    assert_suspects(&turned(|_| DQuat::IDENTITY), "not turned", &["orientations", "probes"]);
    assert_suspects(&turned(|turn| turn.conjugate()), "inverse", &["orientations"]);
    assert_suspects(&turned(|turn| turn * DQuat::from_xyzw(1.0, 0.0, 0.0, 0.0)), "+Z", &["orientations"]);
    let report = kinect(|manifest| depth(manifest).kind = FileDepth::Distance);
    assert_suspects(&report, "distance", &["depth.kind", "depth.kind.flatness"]);
    let report = kinect(|manifest| scaled(manifest, 1000.0));
    assert_suspects(&report, "millimetres for metres", &["depth.scale", "depth.near_far"]);
    let report = kinect(|manifest| depth(manifest).background = Background::default());
    assert_suspects(&report, "no reading", &["depth.values"]);
}
