//! `inspect --check`: correctly labelled data raises no suspicion; data with a common labelling error does.

use std::path::{Path, PathBuf};

use codec::image::{DepthPlane, Face, ImageProjection, Plane};
use codec::monitor::Silent;
use footage::convention::{Choice, Finding, MAX_PROBES, Report, Verdict, check};
use footage::dataset::cameras::{CameraSet, PlacedCamera};
use footage::dataset::manifest::{Background, FileDepth};
use footage::dataset::{Manifest, Source, SourceOptions};
use footage::image_files::exr;
use scene::{DemoKind, DemoScene, FootagePlan, Scene};
use tempfile::TempDir;

const SIDE: u32 = 64;

/// The demo scene captured by four probes that are not on a line.
struct Set {
    folder: TempDir,
    manifest: Manifest,
}

impl Set {
    fn new() -> Set {
        let folder = TempDir::new().unwrap();
        let plan = FootagePlan { kind: DemoKind::Courtyard, frames: 1, face_size: SIDE, probes: 1 };
        let mut plan = plan.capture().unwrap();
        let positions = [[0.0, 1.5, 0.0], [-0.3, 1.3, 0.2], [0.25, 1.65, 0.3], [-0.1, 1.7, -0.3]];
        let camera = |(at, position)| PlacedCamera { name: Some(format!("{at:02}")), ..PlacedCamera::at(position) };
        plan.cameras = CameraSet::new(positions.into_iter().enumerate().map(camera).collect());
        let scene = Scene::Procedural(DemoScene::new(DemoKind::Courtyard));
        plan.write(&scene, folder.path(), &Silent).unwrap();
        let set = Set { folder, manifest: plan.manifest().unwrap() };
        set.write(&set.manifest);
        set
    }

    fn path(&self) -> &Path {
        self.folder.path()
    }

    fn write(&self, manifest: &Manifest) {
        std::fs::write(self.path().join("lightfield.json"), manifest.to_json().unwrap()).unwrap();
    }

    fn depth_file(&self, probe: usize, face: Face) -> PathBuf {
        self.path().join(format!("probe_{probe:02}/face_{}/depth.0000.exr", face.name()))
    }

    /// Applies `change` to the depth file of every face of the probes.
    fn rewrite(&self, probes: std::ops::Range<usize>, change: impl Fn(Face, DepthPlane) -> DepthPlane) {
        for probe in probes {
            for face in Face::CUBE {
                let path = self.depth_file(probe, face);
                let plane = exr::read_depth(&path, &Default::default(), &Default::default()).unwrap();
                exr::write_depth(&path, &change(face, plane)).unwrap();
            }
        }
    }

    /// Exchanges the folders of faces `a` and `b`.
    fn exchange(&self, probes: std::ops::Range<usize>, a: Face, b: Face) {
        for probe in probes {
            let folder = |face: &str| self.path().join(format!("probe_{probe:02}/face_{face}"));
            std::fs::rename(folder(a.name()), folder("aside")).unwrap();
            std::fs::rename(folder(b.name()), folder(a.name())).unwrap();
            std::fs::rename(folder("aside"), folder(b.name())).unwrap();
        }
    }

    fn check(&self) -> Report {
        checked(self.path())
    }

    fn check_as(&self, change: impl FnOnce(&mut Manifest)) -> Report {
        let mut manifest = self.manifest.clone();
        change(&mut manifest);
        self.write(&manifest);
        self.check()
    }
}

pub(crate) fn checked(path: &Path) -> Report {
    let source = Source::open(path, &SourceOptions::default()).unwrap();
    check(&source, &Choice { max_probes: MAX_PROBES, ..Choice::default() }, &Silent).unwrap()
}

fn suspected(report: &Report) -> Vec<&Finding> {
    report.findings.iter().filter(|finding| finding.verdict == Verdict::Suspect).collect()
}

fn finding<'a>(report: &'a Report, name: &str) -> &'a Finding {
    report.findings.iter().find(|finding| finding.check == name).unwrap_or_else(|| panic!("no {name}: {report:#?}"))
}

#[track_caller]
fn assert_suspects(report: &Report, name: &str, words: &str) {
    let found = finding(report, name);
    assert_eq!(found.verdict, Verdict::Suspect, "{report:#?}");
    assert!(found.says.contains(words), "\"{}\" does not say \"{words}\"", found.says);
}

#[track_caller]
fn assert_clean(report: &Report) {
    assert!(suspected(report).is_empty(), "{report:#?}");
}

fn planar(_: Face, plane: DepthPlane) -> DepthPlane {
    Plane::from_fn(SIDE, SIDE, |x, y| {
        (f64::from(plane.get(x, y)) / ImageProjection::cube_face(Face::Px, SIDE).ray_length_factor(x, y)) as f32
    })
}

#[test]
fn data_labelled_right_is_fine() {
    let set = Set::new();
    let report = set.check();
    assert_clean(&report);
    for name in ["seams.depth", "depth.kind.flatness", "depth.kind", "depth.scale", "positions"] {
        assert_eq!(finding(&report, name).verdict, Verdict::Fine, "{report:#?}");
    }
    assert_eq!((report.probes, report.all_probes, report.images, report.all_images), (4, 4, 48, 48));
    // Planar depth that is labelled as planar.
    set.rewrite(0..4, planar);
    let report = set.check_as(|manifest| depth(manifest).kind = FileDepth::Planar);
    assert_clean(&report);
    for name in ["depth.kind.flatness", "depth.kind"] {
        assert_eq!(finding(&report, name).verdict, Verdict::Fine, "{report:#?}");
    }
}

fn place(probe: &mut footage::dataset::manifest::Probe) -> &mut [f64; 3] {
    probe.position.as_mut().unwrap()
}

fn depth(manifest: &mut Manifest) -> &mut footage::dataset::manifest::DepthInfo {
    manifest.depth.as_mut().unwrap()
}

#[test]
fn planar_depth_and_distance_are_told_apart() {
    let set = Set::new();
    let report = set.check_as(|manifest| depth(manifest).kind = FileDepth::Planar);
    assert_suspects(&report, "depth.kind", "depth as distance");
    assert_suspects(&report, "depth.kind.flatness", "looks like distance");
    // Seams do not distinguish planar depth from distance.
    assert_eq!(finding(&report, "seams.depth").verdict, Verdict::Fine);
    // A single probe.
    let report = set.check_as(|manifest| {
        depth(manifest).kind = FileDepth::Planar;
        manifest.probes.truncate(1);
    });
    assert_suspects(&report, "depth.kind.flatness", "looks like distance");
    set.rewrite(0..4, planar);
    let report = set.check_as(|_| ());
    assert_suspects(&report, "depth.kind", "depth as planar");
    assert_suspects(&report, "depth.kind.flatness", "looks like planar");
}

#[test]
fn scales_are_found() {
    let set = Set::new();
    for scale in [0.001, 0.01, 0.1, 0.3048, 1.25, 10.0, 100.0, 1000.0] {
        let report = set.check_as(|manifest| {
            depth(manifest).unit = None;
            depth(manifest).scale = Some(scale);
        });
        let found = finding(&report, "depth.scale");
        assert_eq!(found.verdict, Verdict::Suspect, "{scale}: {report:#?}");
    }
    // Two errors at once.
    let report = set.check_as(|manifest| {
        depth(manifest).unit = None;
        depth(manifest).scale = Some(100.0);
        depth(manifest).kind = FileDepth::Planar;
    });
    assert_suspects(&report, "depth.kind.flatness", "distance");
    assert!(suspected(&report).len() >= 2, "{report:#?}");
}

#[test]
fn positions_are_checked() {
    let set = Set::new();
    let moved = |change: fn([f64; 3]) -> [f64; 3]| {
        set.check_as(|manifest| {
            manifest.probes.iter_mut().for_each(|probe| probe.position = probe.position.map(&change))
        })
    };
    assert_suspects(&moved(|[x, y, z]| [-x, y, z]), "positions", "(-x, y, z)");
    assert_suspects(&moved(|[x, y, z]| [x, -y, z]), "positions", "(x, -y, z)");
    assert_suspects(&moved(|[x, y, z]| [x, y, -z]), "positions", "(x, y, -z)");
    assert_suspects(&moved(|[x, y, z]| [x, z, y]), "positions", "(x, z, y)");
    assert_suspects(&moved(|[x, y, z]| [x, -z, y]), "positions", "(x, z, -y)");
    // The origin of the world is arbitrary.
    assert_clean(&moved(|[x, y, z]| [x + 5.0, y - 7.0, z + 1.0]));
    let report = set.check_as(|manifest| {
        let position = manifest.probes[1].position;
        manifest.probes[1].position = manifest.probes[3].position;
        manifest.probes[3].position = position;
    });
    assert_suspects(&report, "positions", "01 and 03 exchanged");
    let report = set.check_as(|manifest| place(&mut manifest.probes[2])[0] -= 0.4);
    assert_suspects(&report, "positions", "probe 02 contradicts");
}

#[test]
fn orientations_are_checked() {
    let set = Set::new();
    // A world that is rotated about its origin: positions and orientations rotate together.
    let turn = glam::DQuat::from_euler(glam::EulerRot::XYZ, 0.4, -0.8, 0.3);
    let turned = |orientation: glam::DQuat| {
        set.check_as(|manifest| {
            for probe in &mut manifest.probes {
                probe.position = probe.position.map(|at| (turn * glam::DVec3::from(at)).to_array());
                probe.orientation = Some(orientation.to_array());
            }
        })
    };
    let report = turned(turn);
    assert_clean(&report);
    assert_eq!(finding(&report, "orientations").verdict, Verdict::Fine, "{report:#?}");
    assert_suspects(&turned(turn.conjugate()), "orientations", "inverse");
    let first = glam::DQuat::from_xyzw(turn.w, turn.x, turn.y, turn.z);
    assert_suspects(&turned(first), "orientations", "w, x, y, z");
}

#[test]
fn faces_in_a_wrong_order_are_named() {
    let set = Set::new();
    set.exchange(0..4, Face::Nx, Face::Nz);
    let report = set.check();
    assert_suspects(&report, "seams.depth", "nx and nz are exchanged");
    // Colour with 64x64 pixels per face is too coarse for a suspicion, but it must not be reported as fine.
    assert_ne!(finding(&report, "seams.color").verdict, Verdict::Fine);
    set.exchange(0..4, Face::Nx, Face::Nz);
    assert_clean(&set.check());
    // One of four probes.
    set.exchange(2..3, Face::Ny, Face::Pz);
    let report = set.check();
    assert_suspects(&report, "seams.depth", "probe 02: ");
    assert_suspects(&report, "seams.depth", "ny and pz are exchanged");
}

#[test]
fn faces_that_are_turned_and_mirrored_are_named() {
    type From = fn(u32, u32) -> (u32, u32);
    let turns: [(&str, From); 4] = [
        ("turned by 90 degrees to the right", |x, y| (y, SIDE - 1 - x)),
        ("turned by 90 degrees to the left", |x, y| (SIDE - 1 - y, x)),
        ("turned by 180 degrees", |x, y| (SIDE - 1 - x, SIDE - 1 - y)),
        ("mirrored top to bottom", |x, y| (x, SIDE - 1 - y)),
    ];
    for (words, from) in turns {
        let set = Set::new();
        set.rewrite(0..4, |face, plane| {
            if face != Face::Nz {
                return plane;
            }
            Plane::from_fn(SIDE, SIDE, |x, y| {
                let (x, y) = from(x, y);
                plane.get(x, y)
            })
        });
        let report = set.check();
        assert_suspects(&report, "seams.depth", &format!("nz is {words}"));
    }
    let set = Set::new();
    // Every face as seen from inside the cube instead of outside, as programs with left-handed cube maps write it.
    set.rewrite(0..4, |_, plane| Plane::from_fn(SIDE, SIDE, |x, y| plane.get(SIDE - 1 - x, y)));
    let report = set.check();
    assert_suspects(&report, "seams.depth", "every face is mirrored left to right");
}

#[test]
fn values_and_near_and_far() {
    let set = Set::new();
    let report = set.check_as(|manifest| (depth(manifest).near, depth(manifest).far) = (Some(500.0), Some(20_000.0)));
    assert_suspects(&report, "depth.near_far", "1000 times as large would fit");
    assert_clean(&set.check_as(|manifest| (depth(manifest).near, depth(manifest).far) = (Some(0.5), Some(20.0))));
    set.rewrite(0..4, |_, plane| plane.map(|value| if value.is_finite() { *value } else { 1e30 }));
    assert_clean(&set.check());
    set.rewrite(0..4, |_, plane| plane.map(|value| if *value < 1e9 { *value } else { 1e9 }));
    assert_suspects(&set.check(), "depth.background", "\"background\" is 1000000000");
    assert_clean(&set.check_as(|manifest| depth(manifest).background = Background::Value(1e9)));
    set.rewrite(0..4, |_, plane| plane.map(|value| if *value < 1e9 { *value } else { 0.0 }));
    let report = set.check_as(|manifest| depth(manifest).background = Background::Value(1e9));
    assert_suspects(&report, "depth.values", "zero");
    assert_clean(&set.check_as(|manifest| depth(manifest).background = Background::Value(0.0)));
}

#[test]
fn copies_of_images_are_found() {
    let set = Set::new();
    std::fs::copy(set.depth_file(1, Face::Ny), set.depth_file(2, Face::Ny)).unwrap();
    assert_suspects(&set.check(), "images", "depth 01/ny and depth 02/ny have the same pixels");
}

#[test]
fn mistakes_come_before_the_checks_that_fail_because_of_them() {
    let set = Set::new();
    let at_one_place = set.check_as(|manifest| {
        let position = manifest.probes[0].position;
        manifest.probes.iter_mut().for_each(|probe| probe.position = position);
    });
    assert!(suspected(&at_one_place)[0].says.contains("stand at one place"), "{at_one_place:#?}");
    assert!(suspected(&at_one_place).len() > 1, "{at_one_place:#?}");
    // One probe twice.
    for face in Face::CUBE {
        std::fs::copy(set.depth_file(1, face), set.depth_file(2, face)).unwrap();
    }
    let report = set.check_as(|_| ());
    assert_eq!(suspected(&report)[0].check, "images", "{report:#?}");
    assert!(suspected(&report).len() > 1, "{report:#?}");
}

#[test]
fn walls_that_are_alike_are_no_copies() {
    let set = Set::new();
    let verdict = |report: &Report, words: &str| {
        let images = finding(report, "images");
        assert!(images.says.contains(words), "{report:#?}");
        images.verdict
    };
    // The centre of a cubic room.
    let wall =
        |x, y, distance: f64| (distance * ImageProjection::cube_face(Face::Px, SIDE).ray_length_factor(x, y)) as f32;
    set.rewrite(0..1, |_, _| Plane::from_fn(SIDE, SIDE, |x, y| wall(x, y, 2.0)));
    let one = |manifest: &mut Manifest| manifest.probes.truncate(1);
    assert_eq!(verdict(&set.check_as(one), "have the same pixels, as similar walls"), Verdict::CannotTell);
    let color = |face: Face| set.depth_file(0, face).with_file_name("color.0000.exr");
    std::fs::copy(color(Face::Pz), color(Face::Nx)).unwrap();
    assert_eq!(verdict(&set.check_as(one), "color 00/nx and color 00/pz have the same"), Verdict::Suspect);
    // An infinite floor: equal images are plausible at equal heights, and suspect if the manifest states different heights.
    set.rewrite(1..3, |face, _| {
        Plane::from_fn(SIDE, SIDE, |x, y| match face {
            Face::Ny => wall(x, y, 1.5),
            _ => f32::INFINITY,
        })
    });
    let two = |height: f64| {
        set.check_as(|manifest| {
            manifest.probes = manifest.probes[1..3].to_vec();
            (place(&mut manifest.probes[0])[1], place(&mut manifest.probes[1])[1]) = (1.5, height);
        })
    };
    assert_eq!(verdict(&two(1.5), "as similar walls"), Verdict::CannotTell);
    assert_eq!(verdict(&two(1.9), "depth 01/ny and depth 02/ny"), Verdict::Suspect);
}

#[test]
fn the_same_sky_from_everywhere_is_no_copy() {
    let set = Set::new();
    let color = |probe: usize| set.depth_file(probe, Face::Py).with_file_name("color.0000.exr");
    let sky = Plane::from_fn(SIDE, SIDE, |x, y| [half::f16::from_f32((x + 2 * y) as f32 * 0.001); 3]);
    for probe in [1, 2] {
        exr::write_color(&color(probe), &sky).unwrap();
    }
    // Faces with surfaces cannot have the same pixels from two positions.
    set.rewrite(1..3, |face, plane| match face {
        Face::Py => Plane::from_fn(SIDE, SIDE, |x, y| 2.5 + (3 * x + y) as f32 * 0.01 + plane.get(x, y).min(1.0)),
        _ => plane,
    });
    let report = set.check();
    assert_suspects(&report, "images", "color 01/py and color 02/py have the same pixels");
    set.rewrite(1..3, |face, plane| if face == Face::Py { plane.map(|_| f32::INFINITY) } else { plane });
    let found = set.check();
    let images = finding(&found, "images");
    assert_eq!(images.verdict, Verdict::Fine, "{found:#?}");
    assert!(images.says.contains("color 01/py and color 02/py have"), "{}", images.says);
    // Without depth it is unknown whether the images show only sky.
    let report = set.check_as(|manifest| {
        manifest.files.depth = None;
        manifest.depth = None;
    });
    assert_eq!(finding(&report, "images").verdict, Verdict::CannotTell, "{report:#?}");
}

#[test]
fn what_cannot_be_told_is_said() {
    let set = Set::new();
    // Only background.
    set.rewrite(0..4, |_, plane| plane.map(|_| f32::INFINITY));
    let report = set.check();
    for name in ["seams.depth", "depth.kind.flatness", "probes", "depth.near_far"] {
        assert_eq!(finding(&report, name).verdict, Verdict::CannotTell, "{report:#?}");
    }
    // A dome around the probe is indistinguishable from a box in planar depth.
    set.rewrite(0..4, |_, plane| plane.map(|_| 4.0));
    let report = set.check_as(|manifest| manifest.probes.truncate(1));
    for name in ["seams.depth", "depth.kind.flatness", "probes"] {
        assert_eq!(finding(&report, name).verdict, Verdict::CannotTell, "{report:#?}");
    }
    let found = suspected(&report);
    // Colour shows details that depth does not have, which is not an error.
    assert!(found.is_empty(), "{found:#?}");
}

/// Distance from four probes in a dome with a radius of 10 m: one probe is at the centre, the others at up to 70% of the radius.
#[test]
fn probes_in_a_dome_raise_no_doubt() {
    let set = Set::new();
    let towards = glam::DVec3::new(0.6, 0.48, -0.64);
    for share in [0.005, 0.02, 0.05, 0.7] {
        let places = [0.0, 1.0, -1.0, 0.5].map(|along| towards * 10.0 * share * along);
        for (probe, place) in places.into_iter().enumerate() {
            set.rewrite(probe..probe + 1, |face, _| {
                Plane::from_fn(SIDE, SIDE, |x, y| {
                    let along = face.direction(x, y, SIDE).normalize().dot(place);
                    (-along + (along * along + 100.0 - place.length_squared()).sqrt()) as f32
                })
            });
        }
        let report = set.check_as(|manifest| {
            for (probe, place) in manifest.probes.iter_mut().zip(places) {
                probe.position = Some(place.to_array());
            }
            (depth(manifest).near, depth(manifest).far) = (None, None);
        });
        assert_clean(&report);
        // Far from the centre, parts of a dome look planar; the reprojection between probes overrules that suspicion.
        let overruled = finding(&report, "depth.kind.flatness").says.contains("but reprojection between probes");
        assert_eq!(overruled, share > 0.5, "{report:#?}");
    }
}

#[test]
fn threads_do_not_matter() {
    let set = Set::new();
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| set.check_as(|manifest| depth(manifest).kind = FileDepth::Planar))
    };
    assert_eq!(with(1), with(3));
}

#[test]
fn a_single_face_has_no_seams() {
    let set = Set::new();
    let report = set.check_as(|manifest| manifest.faces_present = Some(vec!["ny".into()]));
    assert_eq!(finding(&report, "seams.depth").verdict, Verdict::CannotTell);
    assert_clean(&report);
}

#[test]
fn the_command_answers_with_an_exit_code_and_json() {
    let set = Set::new();
    let run = |arguments: &[&str]| {
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_lightfold"));
        command.arg("inspect").args(arguments).current_dir(set.path()).output().unwrap()
    };
    let output = run(&[".", "--check"]);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.starts_with("courtyard: 4 of 4 probes, 48 of 48 images\n"), "{text}");
    assert!(text.contains("depth.kind ") && text.ends_with("No check is suspect.\n"), "{text}");
    assert!(text.lines().all(|line| line.chars().count() <= 100), "{text}");
    // Sentences are wrapped, and each line continues in the column where the sentence began.
    let began = text.lines().find_map(|line| line.find("Why")).unwrap();
    assert!(text.lines().any(|line| line.len() > began && line[..began].trim().is_empty()), "{text}");
    let output = run(&["lightfield.json", "--check", "--depth-kind", "planar", "--json"]);
    assert_eq!(output.status.code(), Some(1), "{output:?}");
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(json["suspect"], true);
    let checks = json["checks"].as_array().unwrap();
    let kind = checks.iter().find(|check| check["check"] == "depth.kind").unwrap();
    assert_eq!(kind["verdict"], "suspect");
    assert!(kind["says"].as_str().unwrap().contains("depth as distance"));
    assert!(kind["figures"]["margin"].as_f64().unwrap() > 3.0, "{kind}");
    // A single probe, selected by name.
    let output = run(&[".", "--check", "--probe", "02", "--json"]);
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((json["probes"].as_u64(), json["images"].as_u64()), (Some(1), Some(12)));
    for (arguments, words) in [
        (&["film.lfold", "--check"][..], "needs a lightfield.json"),
        (&[".", "--check", "--frame", "7"], "in the requested frame"),
        (&[".", "--check", "--probe", "07"], "no probe \"07\""),
        (&[".", "--check", "--face", "px"], "with --probe and --frame only"),
        (&[".", "--check", "--verify"], "cannot be used with"),
        (&[".", "--check", "--memory", "1G"], "--memory does not apply to --check"),
    ] {
        let output = run(arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(said.contains(words), "{arguments:?}: {said}");
    }
}
