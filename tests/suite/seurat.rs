//! Seurat manifests: what `inspect` reports for them, and the test files of Seurat's release, if they are available.

use std::fs;
use std::path::{Path, PathBuf};

use codec::image::ReadLimits;
use footage::dataset::seurat::SeuratCapture;
use serde_json::{Value, json};
use tempfile::TempDir;

use crate::commands::{fine, refused};

const IDENTITY: [f64; 16] = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];
/// Projection with a field of view of 90° and an infinite far plane.
const PERSPECTIVE: [f64; 16] = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, -1.0, -0.2, 0.0, 0.0, -1.0, 0.0];

/// Returns a view of `size` with a colour file and a camera at x.
fn view(size: [u32; 2], clip_from_eye: [f64; 16], x: f64, depth_type: &str) -> Value {
    let mut pose = IDENTITY;
    pose[3] = x;
    let channels =
        json!({ "path": "c.exr", "channel_0": "R", "channel_1": "G", "channel_2": "B", "channel_alpha": "A" });
    json!({
        "projective_camera": {
            "image_width": size[0], "image_height": size[1], "depth_type": depth_type,
            "clip_from_eye_matrix": clip_from_eye, "world_from_eye_matrix": pose,
        },
        "depth_image_file": { "color": channels, "depth": { "path": "d.exr", "channel_0": "R" } },
    })
}

fn write(folder: &Path, manifest: &Value) {
    fs::write(folder.join("manifest.json"), manifest.to_string()).unwrap();
}

#[test]
fn inspect_says_what_a_manifest_holds() {
    let folder = TempDir::new().unwrap();
    let mut plane = view([8, 4], IDENTITY, -0.5, "WINDOW_Z");
    plane["exposure"] = json!(1);
    let left = json!({ "views": [view([16, 16], PERSPECTIVE, 1.0, "EYE_Z"), plane] });
    let right = json!({ "views": [view([16, 16], PERSPECTIVE, 2.25, "EYE_Z")] });
    write(folder.path(), &json!({ "headbox_center": [1, 2, 3.5], "view_groups": [left, right] }));
    let output = fine("inspect manifest.json", folder.path());
    insta::assert_snapshot!(String::from_utf8(output.stdout).unwrap(), @r"
    manifest.json: Seurat manifest
    Cameras: -0.500, 0.000, 0.000 to 2.250, 0.000, 0.000, 2.750 x 0.000 x 0.000 m in x, y, z
    Headbox centre: 1.000, 2.000, 3.500

    What         Count
    view groups      2
    views            3
    pixels         544

    Views   Size  Projection    Depth
        1    8x4  orthographic  WINDOW_Z
        2  16x16  perspective   EYE_Z
    ");
    assert_eq!(
        String::from_utf8(output.stderr).unwrap(),
        "view_groups[].views[].exposure is not read\nused: 3 views, 2 files, 4 channels; left out: 1\n"
    );
    let report: Value = serde_json::from_slice(&fine("inspect manifest.json --json", folder.path()).stdout).unwrap();
    let expected = json!({
        "manifest": "manifest.json",
        "view_groups": 2,
        "views": 3,
        "pixels": 544,
        "images": [
            { "width": 8, "height": 4, "projection": "orthographic", "depth_type": "WINDOW_Z", "views": 1 },
            { "width": 16, "height": 16, "projection": "perspective", "depth_type": "EYE_Z", "views": 2 },
        ],
        "headbox_center_m": [1.0, 2.0, 3.5],
        "cameras_box_m": { "min": [-0.5, 0.0, 0.0], "max": [2.25, 0.0, 0.0] },
        "account": {
            "used": [
                { "kind": "view", "names": ["view_groups[0].views[0]", "view_groups[0].views[1]", "view_groups[1].views[0]"] },
                { "kind": "file", "names": ["c.exr", "d.exr"] },
                { "kind": "channel", "names": ["R", "G", "B", "A"] },
            ],
            "left_out": ["view_groups[].views[].exposure is not read"],
        },
    });
    assert_eq!(report, expected);
    write(folder.path(), &json!({ "view_groups": [] }));
    let empty: Value = serde_json::from_slice(&fine("inspect manifest.json --json", folder.path()).stdout).unwrap();
    assert_eq!(
        (&empty["views"], &empty["cameras_box_m"], &empty["headbox_center_m"]),
        (&json!(0), &json!(null), &json!(null))
    );
}

#[test]
fn manifests_that_are_none_are_refused() {
    let folder = TempDir::new().unwrap();
    let mut broken = view([8, 4], PERSPECTIVE, 0.0, "EYE_Z");
    broken["projective_camera"]["image_width"] = json!(1e9);
    write(folder.path(), &json!({ "view_groups": [{ "views": [broken] }] }));
    let said = refused("inspect manifest.json", folder.path());
    for says in ["manifest.json", "view_groups[0].views[0].projective_camera.image_width", "1 to 65536"] {
        assert!(said.contains(says), "{said}");
    }
    fs::write(folder.path().join("manifest.json"), "{}").unwrap();
    assert!(refused("inspect manifest.json", folder.path()).contains("view_groups"));
    write(folder.path(), &json!({ "view_groups": [] }));
    assert!(refused("inspect manifest.json --csv", folder.path()).contains("Seurat manifest"));
    fs::rename(folder.path().join("manifest.json"), folder.path().join("lightfield.json")).unwrap();
    assert!(refused("inspect lightfield.json", folder.path()).contains("a dataset, not a container"));
}

fn data() -> PathBuf {
    PathBuf::from(option_env!("LIGHTFOLD_DATA").unwrap_or("no data")).join("seurat")
}

/// Returns a perspective view of 450x450 pixels with test files of the release.
fn released_view(color: &str, depth: [&str; 2]) -> Value {
    let mut view = view([450, 450], PERSPECTIVE, 0.0, "RAY_DEPTH");
    view["depth_image_file"]["color"]["path"] = json!(color);
    view["depth_image_file"]["depth"] = json!({ "path": depth[0], "channel_0": depth[1] });
    view
}

fn capture(view: &Value) -> SeuratCapture {
    let manifest = json!({ "view_groups": [{ "views": [view] }] });
    SeuratCapture::from_json(manifest.to_string().as_bytes(), &data()).unwrap()
}

#[test]
#[cfg_attr(not(seurat_at_hand), ignore = "no files of Seurat's tests at hand: see LIGHTFOLD_DATA in CONTRIBUTING.md")]
fn the_released_manifest_is_inspected_and_the_invalid_one_refused() {
    let output = fine(&format!("inspect {} --json", data().join("manifest_v3.json").display()), Path::new("."));
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    let images =
        json!([{ "width": 450, "height": 450, "projection": "orthographic", "depth_type": "EYE_Z", "views": 1 }]);
    assert_eq!(report["images"], images);
    assert_eq!(report["headbox_center_m"], json!([1.0, 2.0, 3.0]));
    assert_eq!(report["cameras_box_m"], json!({ "min": [0.0, 0.0, 0.0], "max": [0.0, 0.0, 0.0] }));
    assert!(report["account"]["left_out"].to_string().contains("usually is an alpha"), "{report}");
    let capture = SeuratCapture::open(&data().join("manifest_v3.json")).unwrap();
    // The depth channel is an alpha channel: 1 m, or 0, which is infinitely far.
    let rays = capture.views[0].read(&ReadLimits::default()).unwrap();
    assert_eq!(rays.len(), 450 * 450);
    assert!(rays.iter().all(|ray| ray.distance_m == 1.0 || ray.distance_m == f64::INFINITY));
    let said = refused(&format!("inspect {}", data().join("invalid_manifest.json").display()), Path::new("."));
    assert!(said.contains("invalid_manifest.json: this is not JSON"), "{said}");
}

#[test]
#[cfg_attr(not(seurat_at_hand), ignore = "no files of Seurat's tests at hand: see LIGHTFOLD_DATA in CONTRIBUTING.md")]
fn released_images_are_a_capture_of_one_view() {
    let capture = capture(&released_view("color.exr", ["depth.exr", "R"]));
    let rays = capture.views[0].read(&ReadLimits::default()).unwrap();
    assert_eq!(rays.len(), 450 * 450 - 145_396);
    let farthest = rays.iter().map(|ray| ray.distance_m).filter(|distance| distance.is_finite()).fold(0.0, f64::max);
    assert!((farthest - 129.496).abs() < 1e-3, "{farthest}");
    assert!(rays.iter().all(|ray| ray.origin == glam::DVec3::ZERO && ray.direction.z < 0.0));
}

#[test]
#[cfg_attr(not(seurat_at_hand), ignore = "no files of Seurat's tests at hand: see LIGHTFOLD_DATA in CONTRIBUTING.md")]
fn released_images_with_transparency_and_deep_ones() {
    let mut view = released_view("depth_image_with_transparency.exr", ["depth_image_with_transparency.exr", "Z"]);
    view["projective_camera"]["image_width"] = json!(32);
    view["projective_camera"]["image_height"] = json!(16);
    let rays = capture(&view).views[0].read(&ReadLimits::default()).unwrap();
    assert_eq!(rays.len(), 256);
    assert!(rays.iter().all(|ray| ray.alpha == 0.5 && (ray.distance_m - 0.25).abs() < 1e-15), "{:?}", rays[0]);
    let mut view = released_view("arnold_deep_exr.exr", ["arnold_deep_exr.exr", "Z"]);
    view["projective_camera"]["image_width"] = json!(64);
    view["projective_camera"]["image_height"] = json!(32);
    let error = capture(&view).views[0].read(&ReadLimits::default()).unwrap_err().to_string();
    assert!(error.contains("arnold_deep_exr.exr: view_groups[0].views[0]") && error.contains("deep"), "{error}");
}
