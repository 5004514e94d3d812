use std::fs;
use std::path::Path;

use half::f16;
use serde_json::{Value, json};
use tempfile::TempDir;

use crate::dataset::seurat::{CaptureRay, SeuratCapture};
use crate::image_files::{exr, png};
use codec::image::{Plane, ReadLimits};

/// Projection with a field of view of 90° and an infinite far plane.
const PERSPECTIVE: [f64; 16] = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, -1.0, -0.2, 0.0, 0.0, -1.0, 0.0];
const IDENTITY: [f64; 16] = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];
const DISTANCES: [f32; 6] = [0.0, 1.0, f32::INFINITY, 2.5, 3.0, f32::from_bits(1)];

fn manifest(depth_type: &str, color: &Value, depth: &Value) -> Value {
    let camera = json!({
        "image_width": 3, "image_height": 2, "depth_type": depth_type,
        "clip_from_eye_matrix": PERSPECTIVE, "world_from_eye_matrix": IDENTITY,
    });
    let view = json!({ "projective_camera": camera, "depth_image_file": { "color": color, "depth": depth } });
    json!({ "view_groups": [{ "views": [] }, { "views": [view] }] })
}

fn color(path: &str, [a, b, c, alpha]: [&str; 4]) -> Value {
    json!({ "path": path, "channel_0": a, "channel_1": b, "channel_2": c, "channel_alpha": alpha })
}

fn depth(path: &str, channel: &str) -> Value {
    json!({ "path": path, "channel_0": channel })
}

fn read(folder: &Path, manifest: &Value) -> Result<Vec<CaptureRay>, String> {
    let capture = SeuratCapture::from_json(manifest.to_string().as_bytes(), folder).unwrap();
    capture.views[0].read(&ReadLimits::default()).map_err(|error| error.to_string())
}

/// Asserts that reading `manifest` in `folder` fails with an error that contains all of `says` and the path of the view.
fn assert_refused(folder: &Path, manifest: &Value, says: &[&str]) {
    let error = read(folder, manifest).unwrap_err();
    for says in says.iter().chain(&["view_groups[1].views[0]"]) {
        assert!(error.contains(says), "{says}: {error}");
    }
}

const RGBA: [&str; 4] = ["R", "G", "B", "A"];
const OPAQUE: [&str; 4] = ["R", "G", "B", "CONSTANT_ONE"];

fn write_depth(path: &Path, distances: [f32; 6]) {
    exr::write_depth(path, &Plane::new(3, 2, distances.to_vec()).unwrap()).unwrap();
}

fn write_color(path: &Path, pixels: [[f32; 4]; 6]) {
    let pixels = pixels.map(|pixel| pixel.map(f16::from_f32));
    exr::write_rgba(path, &Plane::new(3, 2, pixels.to_vec()).unwrap()).unwrap();
}

#[test]
fn pixels_are_rays_row_by_row_without_those_of_alpha_0() {
    let folder = TempDir::new().unwrap();
    let mut pixels = [[1.0, 0.5, 0.25, 1.0]; 6];
    pixels[1] = [0.0, f32::INFINITY, -1.0, 0.5];
    pixels[4][3] = 0.0;
    write_color(&folder.path().join("c.exr"), pixels);
    write_depth(&folder.path().join("d.exr"), DISTANCES);
    let manifest = manifest("RAY_DEPTH", &color("c.exr", RGBA), &depth("d.exr", "Z"));
    let rays = read(folder.path(), &manifest).unwrap();
    let pixels: Vec<[u32; 2]> = rays.iter().map(|ray| ray.pixel).collect();
    assert_eq!(pixels, [[0, 0], [1, 0], [2, 0], [0, 1], [2, 1]]);
    let distances: Vec<f64> = rays.iter().map(|ray| ray.distance_m).collect();
    let least = f64::from(f32::from_bits(1));
    assert_eq!(distances[..4], [f64::INFINITY, 1.0, f64::INFINITY, 2.5]);
    assert!((distances[4] / least - 1.0).abs() < 1e-12, "{distances:?}");
    assert_eq!((rays[0].light, rays[0].alpha), ([1.0, 0.5, 0.25], 1.0));
    assert_eq!((rays[1].light, rays[1].alpha), ([0.0, 65504.0, -1.0], 0.5));
    for ray in &rays {
        let [x, y] = [0, 1].map(|axis| (2.0 * f64::from(ray.pixel[axis]) + 1.0) / [3.0, 2.0][axis] - 1.0);
        let expected = glam::DVec3::new(x, -y, -1.0).normalize();
        assert!(ray.direction.distance(expected) < 1e-12, "{ray:?}");
    }
}

#[test]
fn one_file_may_hold_all_and_constants_the_rest() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("all.exr");
    let plane = Plane::new(3, 2, DISTANCES.map(|distance| [0.25, 0.75, distance]).to_vec()).unwrap();
    exr::write_material(&path, &plane, ["left", "up.v", "far"]).unwrap();
    let manifest = |path: &str, far: &str| {
        let color = color(path, ["up.v", "CONSTANT_ONE", "left", "CONSTANT_ONE"]);
        manifest("RAY_DEPTH", &color, &depth(path, far))
    };
    let rays = read(folder.path(), &manifest("all.exr", "far")).unwrap();
    assert_eq!(rays.len(), 6);
    assert!(rays.iter().all(|ray| ray.light == [0.75, 1.0, 0.25] && ray.alpha == 1.0));
    assert_eq!(rays[3].distance_m, 2.5);
    assert_eq!(read(Path::new("elsewhere"), &manifest(path.to_str().unwrap(), "far")).unwrap(), rays);
    let constant = read(folder.path(), &manifest("all.exr", "CONSTANT_ZERO")).unwrap();
    assert!(constant.len() == 6 && constant.iter().all(|ray| ray.distance_m == f64::INFINITY));
    assert_refused(folder.path(), &manifest("all.exr", "Z"), &["all.exr", "no channel Z", "up.v"]);
}

#[test]
fn png_light_is_srgb_and_png_depth_a_share_of_the_largest_code() {
    let folder = TempDir::new().unwrap();
    let codes = Plane::from_fn(3, 2, |x, _| [255, 128, 0, if x == 2 { 0 } else { 51 }]);
    png::write_rgba8(&folder.path().join("c.png"), &codes).unwrap();
    let codes = Plane::from_fn(3, 2, |x, _| [0, 13107, 65535][x as usize]);
    png::write_depth16(&folder.path().join("d.PNG"), &codes).unwrap();
    let manifest = |channel: &str| manifest("WINDOW_Z", &color("c.png", RGBA), &depth("d.PNG", channel));
    let rays = read(folder.path(), &manifest("R")).unwrap();
    assert_eq!(rays.len(), 4);
    // Code 128 of the sRGB curve, from its published table.
    let expected = f16::from_f32(0.215_86).to_f32();
    assert!(rays.iter().all(|ray| ray.light == [1.0, expected, 0.0] && ray.alpha == 0.2), "{rays:?}");
    let planar = |ray: &CaptureRay| -(ray.direction * ray.distance_m).z;
    assert_eq!(rays[0].distance_m, f64::INFINITY);
    // Window depth is 1 - near / planar depth.
    assert!((planar(&rays[1]) - 0.125).abs() < 1e-7, "{}", planar(&rays[1]));
    assert_refused(folder.path(), &manifest("Z"), &["d.PNG", "R, G, B, A", "no Z"]);
}

#[test]
fn what_is_wrong_in_a_file_is_named_with_its_pixel() {
    let folder = TempDir::new().unwrap();
    let [c, d] = ["c.exr", "d.exr"].map(|name| folder.path().join(name));
    let manifest = |depth_type| manifest(depth_type, &color("c.exr", RGBA), &depth("d.exr", "Z"));
    let good = [[0.5, 0.5, 0.5, 1.0]; 6];
    let with = |change: fn(&mut [[f32; 4]; 6])| {
        let mut pixels = good;
        change(&mut pixels);
        pixels
    };
    write_color(&c, good);
    for (value, says) in [(f32::NAN, "not a number"), (-2.0, "EYE_Z is -2")] {
        let mut distances = DISTANCES;
        distances[5] = value;
        write_depth(&d, distances);
        assert_refused(folder.path(), &manifest("EYE_Z"), &["d.exr", "pixel (2, 1)", says]);
        write_color(&c, with(|pixels| pixels[5][3] = 0.0));
        assert_eq!(
            read(folder.path(), &manifest("EYE_Z")).unwrap().len(),
            5,
            "depth without a sample is not looked at"
        );
        write_color(&c, good);
    }
    write_depth(&d, DISTANCES);
    assert_refused(folder.path(), &manifest("WINDOW_Z"), &["d.exr", "pixel (0, 1)", "0 to 1"]);
    write_color(&c, with(|pixels| pixels[3][3] = f32::NAN));
    assert_refused(folder.path(), &manifest("EYE_Z"), &["c.exr", "pixel (0, 1)", "alpha"]);
    write_color(&c, with(|pixels| pixels[3][3] = -0.5));
    assert_refused(folder.path(), &manifest("EYE_Z"), &["c.exr", "pixel (0, 1)", "alpha is -0.5"]);
    write_color(&c, with(|pixels| pixels[3][1] = f32::NAN));
    assert_refused(folder.path(), &manifest("EYE_Z"), &["c.exr", "pixel (0, 1)", "colour is not a number"]);
}

#[test]
fn files_that_do_not_fit_are_refused() {
    let folder = TempDir::new().unwrap();
    exr::write_depth(&folder.path().join("d.exr"), &Plane::filled(2, 3, 1.0)).unwrap();
    fs::write(folder.path().join("text.exr"), "no image").unwrap();
    let constant = color("", ["CONSTANT_ZERO"; 4]);
    let says = |path: &str, says: &[&str]| {
        assert_refused(folder.path(), &manifest("EYE_Z", &constant, &depth(path, "Z")), says);
    };
    says("d.exr", &["d.exr", "2x3 pixels", "3 and 2"]);
    says("text.exr", &["text.exr", "not an OpenEXR file"]);
    says("none.exr", &["none.exr"]);
    assert_refused(
        folder.path(),
        &manifest("EYE_Z", &color("", OPAQUE.map(|_| "CONSTANT_ONE")), &depth("", "CONSTANT_ZERO")),
        &["all channels are constants"],
    );
}
