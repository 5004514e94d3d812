//! `lightfold simplify`: its output files, reports and errors.

use std::fs;
use std::path::Path;

use serde_json::Value;
use tempfile::TempDir;

use crate::commands::{fine, lightfold, refused};

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
    assert!(report["selection"]["limited_by"].as_array().unwrap().iter().all(Value::is_string));
    let bytes_of = |name: &str| report["counters"][name].as_u64().unwrap();
    assert!(bytes_of("geometry_bytes_meshopt") > 0 && bytes_of("geometry_bytes_meshopt") < bytes_of("geometry_bytes"));

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
    // Triangles are sorted back to front, as seen from the mean camera position. Tiles have an extent in depth, so only the first
    // and the last triangle are compared.
    let middle = [0.15f32, 1.6, 0.15];
    let positions: Vec<[f32; 3]> = reader.read_positions().unwrap().collect();
    let distance = |corner: &u32| -> f32 {
        let at = positions[*corner as usize];
        (0..3).map(|axis| (at[axis] - middle[axis]).powi(2)).sum::<f32>().sqrt()
    };
    let ends = [&indices[..3], &indices[indices.len() - 3..]].map(|corners| corners.iter().map(distance).sum::<f32>());
    assert!(ends[0] > 2.0 * ends[1], "{ends:?}");
    // Every triangle is counter-clockwise as seen from the mean camera position.
    for corners in indices.chunks_exact(3) {
        let [a, b, c] = [0, 1, 2].map(|at| positions[corners[at] as usize].map(f64::from));
        let from = |p: [f64; 3]| std::array::from_fn::<f64, 3, _>(|axis| p[axis] - f64::from(middle[axis]));
        let (a, b, c) = (from(a), from(b), from(c));
        let cross = [b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0]];
        let volume: f64 = (0..3).map(|axis| a[axis] * cross[axis]).sum();
        assert!(volume < 0.0, "{a:?} {b:?} {c:?}");
    }
}

/// Viewers fit their clip planes to the bounding box, and show the view of a camera.
#[test]
fn the_sky_is_near_and_a_camera_is_in_the_region() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    let probes = "--position=-0.2,1.5,-0.2 --position=0.2,1.5,0.2 --position=0,1.8,0";
    fine(&format!("capture courtyard {probes} --size 32 --frames 0 -o yard"), at);
    fine("simplify yard -o quads.glb --triangles 2000 --effort fast", at);
    let (document, _, _) = gltf::import(at.join("quads.glb")).unwrap();
    let bounds = document.meshes().next().unwrap().primitives().next().unwrap().bounding_box();
    let middle = [0.0, 1.65, 0.0];
    let half = |corner: [f32; 3]| (0..3).map(|axis| (corner[axis] - middle[axis]).abs()).fold(0.0, f32::max);
    // Surfaces are up to 10 m away.
    assert!([bounds.min, bounds.max].map(half).iter().all(|half| (20.0..41.0).contains(half)), "{bounds:?}");
    let nodes: Vec<_> = document.nodes().filter(|node| node.camera().is_some()).collect();
    let [node] = &nodes[..] else { panic!("one camera") };
    assert!(document.default_scene().unwrap().nodes().any(|other| other.index() == node.index()));
    let (translation, ..) = node.transform().decomposed();
    assert!(translation.iter().zip(middle).all(|(found, expected)| (found - expected).abs() < 1e-3));
    let camera = node.camera().unwrap();
    let gltf::camera::Projection::Perspective(lens) = camera.projection() else { panic!("a perspective") };
    assert!((lens.yfov().to_degrees() - 60.0).abs() < 1e-3 && lens.aspect_ratio().is_none());
    assert!(
        lens.znear() > 0.01 && lens.znear() < 0.3 && lens.zfar().is_some_and(|far| far > 70.0),
        "{:?}",
        lens.zfar()
    );
    // The sky is seen from the region.
    fine("render quads.glb --eye 0.1,1.6,0.1 --look-at 0.2,2.6,0.1 --up 0,0,1 --size 32 -o sky.png", at);
    let sky = image::open(at.join("sky.png")).unwrap().into_rgba8();
    assert!(sky.pixels().all(|pixel| pixel[3] == 255));
    assert!(sky.pixels().filter(|pixel| pixel[2] > pixel[0]).count() > 500);
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
        ("--triangles 4", "triangles: the minimum is 12"),
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
    let said = refused("simplify room -o nodir/out.glb", folder.path());
    assert!(said.contains("nodir/out.glb: there is no folder nodir"), "{said}");
    let mut manifest: Value =
        serde_json::from_slice(&fs::read(folder.path().join("room/lightfield.json")).unwrap()).unwrap();
    manifest["files"].as_object_mut().unwrap().remove("color");
    fs::write(folder.path().join("room/depth.json"), manifest.to_string()).unwrap();
    let said = refused("simplify room/depth.json -o out.glb", folder.path());
    assert!(said.contains("depth.json: the reference has no colour images"), "{said}");
}

#[test]
fn reports_limiting_budgets() {
    let folder = room();
    let limits = |options: &str| {
        let line = format!("simplify room -o quads.glb --effort fast --atlas 256 {options}");
        let text = String::from_utf8(fine(&line, folder.path()).stderr).unwrap();
        let words = text.split("of the lower bound, ").nth(1).unwrap().lines().next().unwrap().to_owned();
        (words, fine(&format!("{line} --json"), folder.path()).stdout)
    };
    let wide = "--area 40 --peak-overdraw 60";
    let (words, json) = limits(&format!("{wide} --triangles 200"));
    assert_eq!(words, "limited by triangles");
    let report: Value = serde_json::from_slice(&json).unwrap();
    assert_eq!(report["selection"]["limited_by"], serde_json::json!(["triangles"]));
    assert_eq!(limits(&format!("{wide} --triangles 10000000")).0, "not limited by any budget");
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

/// A camera path of two poses, the second for two frames.
const PATH: &str = r#"{"cameras": [
    {"eye": [0.1, 1.55, 0.1], "look_at": [2, 1.4, 0.3], "fov_y_deg": 70, "frame": 0},
    {"eye": [0.2, 1.6, 0.1], "look_at": [2, 1.3, 0.9], "fov_y_deg": 70, "frame": 2}]}"#;

/// Simplifies the dataset of [`room`]; returns the folder of both, and the report.
fn simplified(options: &str) -> (TempDir, Value) {
    let folder = room();
    let line = format!("simplify room -o quads.glb --triangles 3000 --effort fast --json{options}");
    let report = serde_json::from_slice(&fine(&line, folder.path()).stdout).unwrap();
    (folder, report)
}

fn report(line: &str, folder: &Path) -> Value {
    serde_json::from_slice(&fine(line, folder).stdout).unwrap()
}

#[test]
fn a_scene_is_rendered_as_simplify_measured_it() {
    let (folder, made) = simplified(" --frames 1");
    let at = folder.path();
    let shown = report("render quads.glb --reference room --null --error-map maps --json", at);
    assert_eq!((&shown["device"], &shown["pictures"]), (&Value::from("cpu"), &Value::from(18)));
    let near = |found: &Value, wanted: &Value| {
        let (found, wanted) = (found.as_f64().unwrap(), wanted.as_f64().unwrap());
        assert!((found - wanted).abs() <= 1e-4 * wanted, "{found} {wanted}");
    };
    for key in ["psnr_db", "ssim", "psnr_hvs_m_db"] {
        near(&shown["reference"][key], &made[key]);
    }
    for key in ["overdraw_mean", "peak_overdraw_measured", "fragments_per_pixel_max", "triangles"] {
        near(&shown[key], &made[key]);
    }
    assert_eq!(shown["reference"]["method"], "painter");
    assert_eq!(fs::read_dir(at.join("maps")).unwrap().count(), 18);
    // The scene was made from frame 1, and shows that frame at any time.
    let images = shown["reference"]["images"].as_array().unwrap();
    assert!(images.iter().all(|image| image["frame"] == 1));
    let other = report("render quads.glb --reference room --frames 0-1 --null --json --method z-buffer", at);
    assert_eq!(other["reference"]["images"].as_array().unwrap().len(), 36);
    let psnr_db = other["reference"]["psnr_db"].as_f64().unwrap();
    assert!(psnr_db > 20.0, "{psnr_db}");
}

#[test]
fn a_scene_takes_the_cameras_and_outputs_of_a_container() {
    let (folder, _) = simplified("");
    let at = folder.path();
    fs::write(at.join("path.json"), PATH).unwrap();
    let eye = "--eye 0.1,1.55,0.1 --look-at 2,1.4,0.3 --fov 70 --size 40x30";
    fine("render quads.glb --camera path.json --size 24 -o path/%04d.png --contact-sheet sheet.png", at);
    assert_eq!(fs::read_dir(at.join("path")).unwrap().count(), 3);
    fine(&format!("render quads.glb {eye} -o a.png"), at);
    fine(&format!("render quads.glb {eye} -o a.exr"), at);
    fine(&format!("render quads.glb {eye} --stereo side-by-side -o %V.png"), at);
    let open = |name: &str| image::open(at.join(name)).unwrap().to_rgba8();
    let picture = open("a.png");
    assert_eq!((picture.dimensions(), open("left.png").dimensions()), ((40, 30), (40, 30)));
    assert!(open("left.png") != open("right.png") && at.join("sheet.png").exists());
    assert!(picture.pixels().filter(|pixel| pixel[3] == 255).count() > 1100);
    // The bytes do not depend on the number of threads; more samples give a different image.
    let printed = fine(&format!("render quads.glb {eye} -o - --threads 1"), at).stdout;
    assert!(printed == fs::read(at.join("a.png")).unwrap());
    fine(&format!("render quads.glb {eye} -o smooth.png --samples 3"), at);
    assert!(open("smooth.png") != picture);
    let said = String::from_utf8(fine(&format!("render quads.glb {eye} --null --stats"), at).stdout).unwrap();
    assert!(said.contains("triangles") && said.contains("overdraw: mean") && said.contains("median"), "{said}");
    // Without a camera, that of the file is used.
    let own = fine("render quads.glb --size 40x30 -o own.png", at);
    assert!(String::from_utf8(own.stderr).unwrap().contains("the view of the camera of the scene"));
    assert!(open("own.png").pixels().all(|pixel| pixel[3] == 255));
    // The type of a file without an extension is detected from its first bytes.
    fs::rename(at.join("quads.glb"), at.join("quads")).unwrap();
    assert!(fine(&format!("render quads {eye} -o -"), at).stdout == printed);
}

#[test]
fn what_a_scene_cannot_be_rendered_with_is_refused() {
    let (folder, _) = simplified("");
    let at = folder.path();
    let eye = "--eye 0.1,1.55,0.1 --look-at 2,1.4,0.3 --fov 70 --size 8 --null";
    for (options, words) in [
        ("--steps 1024", "--steps applies to light fields"),
        ("--probe 00", "--probe"),
        ("--exclude-probe 00", "--exclude-probe"),
        ("--views 3", "--views"),
        ("--trace a.jsonl", "--trace"),
        ("--holes blank", "--holes"),
        ("--decode all", "--decode"),
        ("--method march", "use painter or z-buffer"),
        ("--method reproject", "use painter or z-buffer"),
        ("--memory 1k", "smaller"),
    ] {
        let said = refused(&format!("render quads.glb {eye} {options}"), at);
        assert!(said.contains(words), "{options}: {said}");
        assert!(!at.join("a.jsonl").exists());
    }
    let bytes = fs::read(at.join("quads.glb")).unwrap();
    fs::write(at.join("cut.glb"), &bytes[..bytes.len() / 2]).unwrap();
    assert!(refused(&format!("render cut.glb {eye}"), at).contains("cut.glb"));
    fs::write(at.join("other.gltf"), r#"{"asset": {"version": "2.0"}}"#).unwrap();
    assert!(refused(&format!("render other.gltf {eye}"), at).contains("capture"));
    fine("encode room --clip -o room.lfold --frames 0", at);
    let said = refused(&format!("render room.lfold {eye} --method painter"), at);
    assert!(said.contains("simplified scenes"), "{said}");
}

#[test]
#[cfg(target_os = "linux")]
fn a_run_that_stops_keeps_its_tiles_and_resumes_to_the_same_bytes() {
    let folder = room();
    let line = "simplify room -o quads.glb --triangles 1000 --effort fast";
    // Writing the texture fails, and so the run stops before the scene is written.
    let full = lightfold(&format!("{line} --ktx2 /dev/full").split(' ').collect::<Vec<_>>(), folder.path());
    let stopped = String::from_utf8_lossy(&full.stderr);
    assert!(!full.status.success() && stopped.contains("--resume continues"), "{stopped}");
    assert!(!folder.path().join("quads.glb").exists() && folder.path().join(".quads.glb.journal").exists());
    let other = refused(&format!("{line} --area 2 --resume"), folder.path());
    assert!(other.contains("cannot resume") && other.contains("options"), "{other}");
    let resumed = fine(&format!("{line} --resume"), folder.path());
    assert!(String::from_utf8_lossy(&resumed.stderr).contains("resuming with the selected tiles"));
    let names: Vec<_> = fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    assert_eq!(names.len(), 2, "{names:?}");
    let bytes = fs::read(folder.path().join("quads.glb")).unwrap();
    fine(&line.replace("quads", "whole"), folder.path());
    assert!(bytes == fs::read(folder.path().join("whole.glb")).unwrap());
}

#[test]
fn no_file_of_the_input_is_overwritten() {
    let folder = room();
    let at = |name: &str| folder.path().join(name);
    let files = ["room/lightfield.json", "room/probe_00/face_px/depth.0000.exr"];
    let before: Vec<Vec<u8>> = files.iter().map(|name| fs::read(at(name)).unwrap()).collect();
    for input in ["room", "room/lightfield.json"] {
        for file in files {
            let line = format!("simplify {input} -o quads.glb --triangles 400 --atlas 128 --effort fast --ktx2 {file}");
            let said = refused(&line, folder.path());
            assert!(said.contains("would be overwritten"), "{said}");
        }
    }
    assert_eq!(before, files.map(|name| fs::read(at(name)).unwrap()));
}

#[test]
fn an_atlas_that_is_too_small_leaves_nothing_to_resume() {
    let folder = room();
    let said = refused("simplify room -o quads.glb --triangles 400 --atlas 4 --effort fast", folder.path());
    assert!(said.contains("atlas") && !said.contains("--resume"), "{said}");
    let left: Vec<_> = fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    assert_eq!(left, ["room"]);
}
