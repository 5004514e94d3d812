//! `lightfold simplify`: what it writes, reports and refuses.

use std::fs;

use serde_json::Value;
use tempfile::TempDir;

use crate::commands::{fine, refused};

const PLAN: &str = "capture interior --position=0,1.5,0 --position=0.3,1.5,0.1 --position=0.1,1.7,0.3 --size 48 --samples 2 --frames 0-1 -o room";

pub fn room() -> TempDir {
    let folder = TempDir::new().unwrap();
    fine(PLAN, folder.path());
    folder
}

#[test]
fn a_dataset_becomes_a_blended_mesh_within_its_budgets() {
    let folder = room();
    let line =
        "simplify room -o quads.glb --triangles 4000 --area 2 --peak-overdraw 3.5 --atlas 512 --effort fast --json";
    let report: Value = serde_json::from_slice(&fine(line, folder.path()).stdout).unwrap();
    let number = |name: &str| report[name].as_f64().unwrap_or_else(|| panic!("{name} in {report}"));
    assert!(number("triangles") <= 4000.0 && number("projected_area") <= 2.0 && number("peak_overdraw") <= 3.5);
    assert!(number("peak_overdraw_measured") <= 1.15 * 3.5);
    assert!(number("atlas_width").max(number("atlas_height")) <= 512.0 && number("atlas_occupancy") > 0.5);
    assert!(number("psnr_db") > 25.0 && number("released_psnr_db") > number("psnr_db") + 20.0, "{report}");
    assert!(number("psnr_hvs_m_db") > 15.0 && number("ssim") > 0.8);
    assert_eq!((number("samples"), number("pixels")), (18.0 * 48.0 * 48.0, 18.0 * 48.0 * 48.0));
    for budget in report["budgets"].as_array().unwrap() {
        assert!(budget["used"].as_f64().unwrap() <= budget["limit"].as_f64().unwrap() + 1e-9, "{budget}");
    }
    assert!(report["selection"]["dual"].as_f64().unwrap() <= report["selection"]["primal"].as_f64().unwrap());

    let bytes = fs::read(folder.path().join("quads.glb")).unwrap();
    assert_eq!(report["files"][0]["bytes"], bytes.len());
    let (document, buffers, _) = gltf::import_slice(&bytes).unwrap();
    let primitives: Vec<_> = document.meshes().flat_map(|mesh| mesh.primitives().collect::<Vec<_>>()).collect();
    let [primitive] = &primitives[..] else { panic!("one primitive, in drawing order") };
    let material = primitive.material();
    assert!(material.unlit() && material.double_sided());
    assert_eq!(material.alpha_mode(), gltf::material::AlphaMode::Blend);
    let reader = primitive.reader(|buffer| Some(&buffers[buffer.index()]));
    let indices: Vec<u32> = reader.read_indices().unwrap().into_u32().collect();
    assert_eq!(indices.len() as f64, 3.0 * number("triangles"));
    // From back to front, seen from the middle of the cameras; a tile is as long as its triangles are.
    let middle = [0.15f32, 1.6, 0.15];
    let positions: Vec<[f32; 3]> = reader.read_positions().unwrap().collect();
    let distance = |corner: &u32| -> f32 {
        let at = positions[*corner as usize];
        (0..3).map(|axis| (at[axis] - middle[axis]).powi(2)).sum::<f32>().sqrt()
    };
    let ends = [&indices[..3], &indices[indices.len() - 3..]].map(|corners| corners.iter().map(distance).sum::<f32>());
    assert!(ends[0] > 2.0 * ends[1], "{ends:?}");
    // Every triangle is counter-clockwise for an eye in the middle.
    for corners in indices.chunks_exact(3) {
        let [a, b, c] = [0, 1, 2].map(|at| positions[corners[at] as usize].map(f64::from));
        let from = |p: [f64; 3]| std::array::from_fn::<f64, 3, _>(|axis| p[axis] - f64::from(middle[axis]));
        let (a, b, c) = (from(a), from(b), from(c));
        let cross = [b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0]];
        let volume: f64 = (0..3).map(|axis| a[axis] * cross[axis]).sum();
        assert!(volume < 0.0, "{a:?} {b:?} {c:?}");
    }
}

#[test]
fn the_bytes_do_not_depend_on_the_number_of_threads() {
    let folder = room();
    let write = |name: &str, threads: u32| {
        fine(&format!("simplify room -o {name} --triangles 1000 --effort fast --threads {threads}"), folder.path());
        fs::read(folder.path().join(name)).unwrap()
    };
    assert!(write("one.glb", 1) == write("three.glb", 3));
}

#[test]
fn what_cannot_be_kept_or_simplified_is_refused_and_nothing_is_written() {
    let folder = room();
    let cases = [
        ("--triangles 4", "triangles: the least that would do is 12"),
        ("--area 0.5", "the budget of area"),
        ("--peak-overdraw 0.2", "peak overdraw"),
        ("--atlas 4", "an atlas of 4 texels a side"),
        ("--region=-9,-9,-9,9,9,9", "lies in the viewing region"),
        ("--region=1,2", "six numbers"),
        ("--frames 7", "no image of frame 7"),
    ];
    for (options, words) in cases {
        let said = refused(&format!("simplify room -o out.glb --effort fast {options}"), folder.path());
        assert!(said.contains(words), "{options}: {said}");
        assert!(!folder.path().join("out.glb").exists());
    }
    assert!(refused("simplify nowhere -o out.glb", folder.path()).contains("nowhere"));
}

#[test]
fn charts_and_pictures_are_drawn_into_a_folder() {
    let folder = room();
    let line = "simplify room -o quads.glb --triangles 600 --effort fast --plot figures --json";
    let report: Value = serde_json::from_slice(&fine(line, folder.path()).stdout).unwrap();
    let mut names: Vec<String> = fs::read_dir(folder.path().join("figures"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    let maps = ["error-1.png", "error-2.png", "error-3.png", "error-4.png"];
    let expected = [&["convergence.png", "convergence.svg"][..], &maps, &["overdraw.png", "stages.png", "stages.svg"]];
    assert_eq!(names, expected.concat());
    assert_eq!(report["figures"].as_array().unwrap().len(), names.len());
    let chart = fs::read_to_string(folder.path().join("figures/convergence.svg")).unwrap();
    assert!(chart.contains("bound (dual)") && chart.contains("best selection (primal)"), "{chart}");
}
