//! Datasets in which a probe has images of another size (formats/manifest.md 2.5.2).

use std::path::Path;

use codec::decode::Decoder;
use codec::image::{ColorPlane, DepthPlane, Plane};
use codec::monitor::Silent;
use footage::dataset::{Manifest, Source, SourceOptions, StreamKind};
use footage::image_files::exr as ours;
use half::f16;
use scene::{DemoKind, FootagePlan};
use serde_json::{Value, json};
use tempfile::TempDir;

use crate::commands::{fine, refused};
use crate::input::{assert_says, message};

/// Side of the faces of most probes.
const SIDE: u32 = 16;
/// Side of the faces of the last probe.
const LARGE: u32 = 48;

/// Writes a dataset of three cubes into the folder `in`, of which the last has larger faces.
fn write_cubes(folder: &Path) -> Manifest {
    let (set, large) = (folder.join("in"), folder.join("large"));
    let plan = FootagePlan { kind: DemoKind::Interior, frames: 1, face_size: SIDE, probes: 3 };
    let mut manifest = plan.write(&set, &Silent).unwrap();
    FootagePlan { face_size: LARGE, ..plan }.write(&large, &Silent).unwrap();
    std::fs::remove_dir_all(set.join("probe_02")).unwrap();
    std::fs::rename(large.join("probe_02"), set.join("probe_02")).unwrap();
    std::fs::remove_dir_all(&large).unwrap();
    manifest.probes[2].size = Some([LARGE; 2]);
    std::fs::write(set.join("lightfield.json"), manifest.to_json().unwrap()).unwrap();
    manifest
}

fn color(width: u32, height: u32) -> ColorPlane {
    Plane::from_fn(width, height, |x, y| [f16::from_f32((x + y) as f32 / (width + height) as f32); 3])
}

fn depth(width: u32, height: u32) -> DepthPlane {
    Plane::from_fn(width, height, |x, y| 2.0 + (3 * x + y) as f32 / (width + height) as f32)
}

/// Writes colour and depth of a frame of a probe.
fn write(folder: &Path, probe: &str, color_size: [u32; 2], depth_size: [u32; 2]) {
    let [color_size, depth_size] = [color_size, depth_size].map(|[width, height]| (width, height));
    ours::write_color(&folder.join(format!("{probe}_c.exr")), &color(color_size.0, color_size.1)).unwrap();
    ours::write_depth(&folder.join(format!("{probe}_d.exr")), &depth(depth_size.0, depth_size.1)).unwrap();
}

/// Returns a manifest of probes `a` and `b` with images of 16x8 pixels; `b` has another size.
fn pair(projection: &str, size_of_b: [u32; 2]) -> Value {
    json!({ "lightfield": 1, "name": "t", "fps": 24, "frames": [0, 0], "projection": projection, "size": [16, 8],
        "files": { "color": "{probe}_c.exr", "depth": "{probe}_d.exr" }, "probes": [
            { "name": "a", "position": [0, 0, 0] }, { "name": "b", "position": [1, 0, 0], "size": size_of_b }] })
}

fn open(folder: &Path, manifest: &Value) -> lightfold::Result<Source> {
    std::fs::write(folder.join("lightfield.json"), manifest.to_string()).unwrap();
    Source::open(folder, &SourceOptions::default())
}

/// Returns the size of the pictures of the probes that a container holds, in the order of its streams.
fn sizes(container: &Path) -> Vec<[u32; 2]> {
    let decoder = Decoder::open(container).unwrap();
    let mut sizes: Vec<_> = decoder.streams().iter().map(|stream| (stream.probe, stream.size())).collect();
    sizes.sort_unstable();
    sizes.dedup();
    sizes.into_iter().map(|(_, size)| size).collect()
}

#[test]
fn cubes_of_two_sizes_go_all_the_way() {
    let folder = TempDir::new().unwrap();
    let path = folder.path();
    let manifest = write_cubes(path);
    fine("encode in -o film.lfold --hdr --quiet", path);
    assert_eq!(sizes(&path.join("film.lfold")), [[SIDE; 2], [SIDE; 2], [LARGE; 2]]);
    fine("inspect film.lfold --verify", path);
    let checks: Value = serde_json::from_slice(&fine("inspect in --check --json", path).stdout).unwrap();
    assert_eq!(checks["images"], 36, "{checks}");
    fine("diff in in", path);
    fine("diff in film.lfold --stream depth --max-error 100", path);
    fine("decode film.lfold -o out --quiet", path);
    let decoded = Manifest::read(&path.join("out")).unwrap();
    assert_eq!(decoded.size, [SIDE; 2]);
    assert_eq!(decoded.probes.iter().map(|probe| probe.size).collect::<Vec<_>>(), [None, None, Some([LARGE; 2])]);
    fine("diff out film.lfold --max-error 0", path);
    fine("render film.lfold --reference in --reference-probe 02 -o pictures --quiet", path);

    // More pixels of the same place give larger textures.
    let atlas = |dataset: &str| {
        let report = fine(&format!("simplify {dataset} -o scene.glb --json"), path).stdout;
        let report: Value = serde_json::from_slice(&report).unwrap();
        report["atlas_width"].as_u64().unwrap() * report["atlas_height"].as_u64().unwrap()
    };
    let of_two_sizes = atlas("in");
    let plan = FootagePlan { kind: DemoKind::Interior, frames: 1, face_size: SIDE, probes: 3 };
    let small = plan.write(&path.join("small"), &Silent).unwrap();
    assert_eq!(small.probes.len(), manifest.probes.len());
    assert!(of_two_sizes > 2 * atlas("small"), "{of_two_sizes}");
    fine("simplify film.lfold -o scene.glb --quiet", path);
}

#[test]
fn init_gives_a_probe_its_own_size() {
    let folder = TempDir::new().unwrap();
    let path = folder.path();
    let before = write_cubes(path);
    std::fs::remove_file(path.join("in/lightfield.json")).unwrap();
    let said = String::from_utf8(fine("init in", path).stderr).unwrap();
    assert_says(&said, &["images of probe 02 are 48x48 pixels, of others 16x16"]);
    let found = Manifest::read(&path.join("in")).unwrap();
    let of = |manifest: &Manifest| {
        manifest.probes.iter().map(|probe| (probe.name.clone(), manifest.size_of(probe))).collect::<Vec<_>>()
    };
    assert_eq!((of(&found), &found.files), (of(&before), &before.files));
    fine("encode in -o film.lfold --hdr --quiet", path);

    // Images of two sizes of one probe, and those of another aspect, are refused.
    let set = path.join("other");
    std::fs::create_dir_all(&set).unwrap();
    write(&set, "north", [16, 8], [16, 8]);
    write(&set, "south", [32, 16], [16, 8]);
    assert_says(&refused("init other", path), &["no probe has files of every kind"]);
    write(&set, "south", [32, 8], [32, 8]);
    assert_says(&refused("init other", path), &["all images of a dataset must have the same size"]);
}

#[test]
fn panoramas_of_two_sizes_become_faces_of_two_sizes() {
    let folder = TempDir::new().unwrap();
    let set = folder.path().join("in");
    std::fs::create_dir_all(&set).unwrap();
    write(&set, "a", [256, 128], [256, 128]);
    write(&set, "b", [512, 256], [512, 256]);
    let mut manifest = pair("equirect", [512, 256]);
    manifest["size"] = json!([256, 128]);
    let source = open(&set, &manifest).unwrap();
    let widths: Vec<u32> = source.groups().iter().map(|group| group.width).collect();
    assert_eq!(widths, [96, 192, 96, 192]);
    for group in source.groups() {
        let width = match group.kind {
            StreamKind::Color => source.read_color(group, 0).unwrap()[0].width(),
            _ => source.read_depth(group, 0).unwrap()[0].width(),
        };
        assert_eq!(width, group.width);
    }
    fine("encode in -o film.lfold --quiet", folder.path());
    assert_eq!(sizes(&folder.path().join("film.lfold")), [[96; 2], [192; 2]]);
    fine("diff in film.lfold --stream depth --max-error 100", folder.path());
    fine("diff film.lfold in --stream depth --max-error 100", folder.path());
}

#[test]
fn depth_of_another_size_is_that_of_probes_without_their_own() {
    let folder = TempDir::new().unwrap();
    write(folder.path(), "a", [16, 8], [8, 4]);
    write(folder.path(), "b", [32, 16], [32, 16]);
    let mut manifest = pair("perspective", [32, 16]);
    manifest["depth"] = json!({ "size": [8, 4] });
    let source = open(folder.path(), &manifest).unwrap();
    let read = |at: usize| source.read_depth(&source.groups()[at], 0).unwrap().remove(0);
    let (a, b) = (read(2), read(3));
    assert_eq!([(a.width(), a.height()), (b.width(), b.height())], [(16, 8), (32, 16)]);
    assert_eq!(b, depth(32, 16));
    assert_eq!((a.get(0, 0), a.get(1, 1), a.get(15, 7)), (2.0, 2.0, depth(8, 4).get(7, 3)));
}

#[test]
fn lenses_are_those_of_the_own_size() {
    let folder = TempDir::new().unwrap();
    write(folder.path(), "a", [16, 8], [16, 8]);
    write(folder.path(), "b", [32, 16], [32, 16]);
    let mut manifest = pair("perspective", [32, 16]);
    for probe in 0..2 {
        manifest["probes"][probe]["fov_y_deg"] = json!(90);
    }
    let source = open(folder.path(), &manifest).unwrap();
    let lenses = source.probes().iter().map(|probe| probe.intrinsics.unwrap().map(|value| value.round()));
    assert_eq!(lenses.collect::<Vec<_>>(), [[4.0, 4.0, 8.0, 4.0], [8.0, 8.0, 16.0, 8.0]]);
}

#[test]
fn sizes_that_files_or_layouts_contradict_are_refused() {
    let folder = TempDir::new().unwrap();
    write(folder.path(), "a", [16, 8], [16, 8]);
    write(folder.path(), "b", [32, 16], [32, 16]);
    assert_says(
        &message(open(folder.path(), &pair("equirect", [32, 32]))),
        &["lightfield.json", "probe \"b\"", "twice as wide as it is high", "32x32"],
    );
    assert_says(&message(open(folder.path(), &pair("perspective", [0, 16]))), &["probe \"b\"", "0x16"]);
    let mut stereo = pair("perspective", [31, 16]);
    stereo["stereo"] = json!("side-by-side");
    for (probe, eye) in ["left", "right"].into_iter().enumerate() {
        stereo["probes"][probe]["eye"] = json!(eye);
    }
    assert_says(&message(open(folder.path(), &stereo)), &["probe \"b\"", "31x16", "halves"]);
    let source = open(folder.path(), &pair("perspective", [64, 32])).unwrap();
    source.read_color(&source.groups()[0], 0).unwrap();
    let said = message(source.read_color(&source.groups()[1], 0));
    assert_says(&said, &["b_c.exr", "the image is 32x16 pixels, expected 64x32"]);
}
