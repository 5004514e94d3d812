//! `lightfold view --export`: the static site.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use codec::image::{Face, Plane};
use footage::image_files::png;
use half::f16;
use serde_json::{Value, json};
use tempfile::TempDir;

use crate::commands::{fine, lightfold, refused};
use crate::footage::Footage;
use crate::serve::{bytes_below, place, player, write_glb};

fn names(folder: &Path) -> BTreeSet<String> {
    fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
}

fn described(site: &Path) -> Value {
    serde_json::from_slice(&fs::read(site.join("film.json")).unwrap()).unwrap()
}

#[test]
fn a_site_has_the_page_and_the_film_and_replaces_an_earlier_one() {
    let folder = place();
    let (at, site) = (folder.path(), folder.path().join("deep/site"));
    let film = fs::read(at.join("a.lfold")).unwrap();
    let output = fine("view a.lfold --export deep/site --json", at);
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    let expected = json!({"kind": "lfold", "url": "film.lfold", "name": "a.lfold", "bytes": film.len()});
    assert_eq!(described(&site), expected);
    assert_eq!(fs::read(site.join("film.lfold")).unwrap(), film);
    let files = player();
    for (name, path) in &files {
        assert_eq!(fs::read(site.join(name)).unwrap(), fs::read(path).unwrap(), "{name}");
    }
    let bytes = bytes_below(&site);
    assert_eq!(report["site"], json!({"path": "deep/site", "files": files.len() + 2, "bytes": bytes}));
    assert_eq!(names(&at.join("deep")), BTreeSet::from(["site".to_owned()]));
    // Another film replaces the first.
    let before = names(&site);
    write_glb(&at.join("b.glb"), 50_000);
    fine("view b.glb --export deep/site", at);
    assert_eq!(described(&site)["url"], "film.glb");
    assert_eq!(fs::read(site.join("film.glb")).unwrap(), fs::read(at.join("b.glb")).unwrap());
    let mut after = before;
    assert!(after.remove("film.lfold") && after.insert("film.glb".to_owned()));
    assert_eq!(names(&site), after);
    // A film of the site can be exported to the same site.
    fine("view deep/site/film.glb --export deep/site", at);
    assert_eq!(fs::read(site.join("film.glb")).unwrap(), fs::read(at.join("b.glb")).unwrap());
}

/// Creates a folder with `a.lfold`: a cube map in which only +X and -Y are not flat, and which states a view if `view` is not
/// empty.
fn room(view: &str) -> TempDir {
    let folder = TempDir::new().unwrap();
    let is_rich = |face: Face| matches!(face, Face::Px | Face::Ny);
    let noise = |face: Face, x: u32, y: u32| {
        let hash = (x * 31 + y * 17 + face as u32).wrapping_mul(2_654_435_761) >> 16 & 255;
        if is_rich(face) { hash as f32 / 255.0 } else { 0.5 }
    };
    let depth = |face: Face, _: u32| Plane::from_fn(32, 32, |x, y| 2.0 + noise(face, x, y));
    let color = |face: Face, _: u32| Plane::from_fn(32, 32, |x, y| [noise(face, x, y); 3].map(f16::from_f32));
    let footage = Footage {
        faces: &Face::CUBE,
        frames: [0, 0],
        depth: Some(&depth),
        color: Some(&color),
        ..Footage::new(32, 32)
    };
    footage.write(folder.path());
    let path = folder.path().join("lightfield.json");
    let mut manifest: Value = serde_json::from_slice(&fs::read(&path).unwrap()).unwrap();
    if !view.is_empty() {
        manifest["view"] = serde_json::from_str(view).unwrap();
        fs::write(&path, manifest.to_string()).unwrap();
    }
    fine("encode . -o a.lfold", folder.path());
    folder
}

#[test]
fn a_film_opens_where_the_most_is_to_see_and_shows_a_poster() {
    let folder = room("");
    let at = folder.path();
    fine("view a.lfold --export site", at);
    let described = described(&at.join("site"));
    assert_eq!(described["poster"], "poster.jpg");
    let start = |key: &str| {
        described["start"][key].as_array().unwrap().iter().map(|value| value.as_f64().unwrap()).collect::<Vec<_>>()
    };
    let forward: Vec<f64> = start("eye").iter().zip(start("look_at")).map(|(eye, point)| point - eye).collect();
    assert!(forward[0] > 0.999 && forward[1] == 0.0, "{forward:?}");
    let poster = fs::read(at.join("site/poster.jpg")).unwrap();
    assert!(poster.starts_with(&[0xff, 0xd8, 0xff]) && poster.ends_with(&[0xff, 0xd9]));
    // A film without a poster removes that of the earlier site.
    let other = place();
    fs::copy(other.path().join("a.lfold"), at.join("b.lfold")).unwrap();
    fine("view b.lfold --export site", at);
    assert!(!names(&at.join("site")).contains("poster.jpg"));
}

/// Returns the mean difference of codes between pictures of one size.
fn difference(a: &Path, b: &Path) -> f64 {
    let [a, b] = [a, b].map(|path| image::open(path).unwrap().into_rgb8());
    assert_eq!(a.dimensions(), b.dimensions());
    let sum: u64 = a.iter().zip(b.iter()).map(|(a, b)| u64::from(a.abs_diff(*b))).sum();
    sum as f64 / a.len() as f64
}

#[test]
fn a_scene_opens_with_its_camera_and_shows_a_poster() {
    let folder = room("");
    let at = folder.path();
    fine("simplify . -o b.glb --triangles 400 --effort fast --atlas 256", at);
    fine("view b.glb --export site", at);
    fine("cameras b.glb --format lightfold -o camera.json", at);
    fine("render b.glb --size 640x320 -o b.png", at);
    let described = described(&at.join("site"));
    assert_eq!(described["poster"], "poster.jpg");
    let fov_y_deg = described["start"]["fov_y_deg"].as_f64().unwrap();
    assert!((fov_y_deg - 60.0).abs() < 1e-4, "{fov_y_deg}");
    let difference = difference(&at.join("site/poster.jpg"), &at.join("b.png"));
    assert!(difference < 8.0, "{difference}");
    fine("view b.glb --export b.html", at);
    assert!(fs::read_to_string(at.join("b.html")).unwrap().contains("data-file=\"poster.jpg\""));
}

#[test]
fn the_poster_of_a_quilt_is_its_middle_view() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    // Views 0 to 5 of 8x6 pixels have the gray 40 to 240; a column and a row are left over.
    let quilt = Plane::from_fn(25, 13, |x, y| [40 * (1 + (x / 8).min(2) + 3 * (1 - (y / 6).min(1))) as u8; 3]);
    png::write_color8(&at.join("a_qs3x2a0.5.png"), &quilt).unwrap();
    fine("view a_qs3x2a0.5.png --export site", at);
    let described = described(&at.join("site"));
    assert_eq!((&described["poster"], described.get("start")), (&"poster.jpg".into(), None));
    png::write_color8(&at.join("view.png"), &Plane::filled(160, 320, [160; 3])).unwrap();
    let difference = difference(&at.join("site/poster.jpg"), &at.join("view.png"));
    assert!(difference < 2.0, "{difference}");
}

#[test]
fn the_view_of_a_manifest_is_stored_and_comes_back() {
    let view = json!({"eye": [0.5, 1.0, 2.0], "look_at": [0.0, 1.25, -2.0], "fov_y_deg": 40.0});
    let folder = room(&view.to_string());
    let at = folder.path();
    fine("view a.lfold --export site", at);
    assert_eq!(described(&at.join("site"))["start"], view);
    fine("decode a.lfold -o decoded", at);
    let manifest: Value = serde_json::from_slice(&fs::read(at.join("decoded/lightfield.json")).unwrap()).unwrap();
    assert_eq!(manifest["view"], view);
    for wrong in [
        r#"{"eye": [0, 1, 2], "look_at": [0, 1, 2], "fov_y_deg": 40}"#,
        r#"{"eye": [0, 1, 2], "look_at": [0, 1, 3], "fov_y_deg": 0}"#,
    ] {
        let mut changed = manifest.clone();
        changed["view"] = serde_json::from_str(wrong).unwrap();
        fs::write(at.join("decoded/lightfield.json"), changed.to_string()).unwrap();
        let said = refused("encode decoded -o b.lfold", at);
        assert!(said.contains("\"view\": "), "{said}");
    }
}

#[test]
fn one_file_has_the_page_and_the_film() {
    let folder = room("");
    let at = folder.path();
    let output = fine("view a.lfold --export film.html --json", at);
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    let page = fs::read_to_string(at.join("film.html")).unwrap();
    assert_eq!(report["site"], json!({"path": "film.html", "files": 1, "bytes": page.len()}));
    let data = |name: &str| {
        let (_, rest) = page.split_once(&format!("data-file=\"{name}\">")).unwrap_or_else(|| panic!("no {name}"));
        rest.split_once("</script>").unwrap().0.to_owned()
    };
    let film = fs::read(at.join("a.lfold")).unwrap();
    assert_eq!(data("film.lfold").len(), film.len().div_ceil(3) * 4);
    for name in ["film.json", "poster.jpg", "worker.js", "cpu_worker.js", "lightfold.wasm"] {
        assert!(data(name).len() > 100, "{name}");
    }
    assert!(!page.contains("data-file=\"glb.js\""));
    // Another export replaces the file.
    write_glb(&at.join("b.glb"), 50_000);
    fine("view b.glb --export film.html", at);
    assert!(fs::read_to_string(at.join("film.html")).unwrap().contains("data-file=\"film.glb\""));
    // A film that is too large is refused, and the file is left as it is.
    write_glb(&at.join("b.glb"), 50_000_001);
    let said = refused("view b.glb --export film.html", at);
    assert!(said.contains("51 MB") && said.contains("set --export to a folder"), "{said}");
    assert!(at.join("film.html").is_file());
}

#[test]
fn folders_of_something_else_are_left_alone() {
    let folder = place();
    let at = folder.path();
    for (name, files) in [("other", &["film.lfold"][..]), ("described", &["film.json"]), ("hidden", &[".x"])] {
        fs::create_dir(at.join(name)).unwrap();
        for file in files {
            fs::write(at.join(name).join(file), "{\"url\": \"other\"}").unwrap();
        }
        let said = refused(&format!("view a.lfold --export {name}"), at);
        assert!(said.contains("the folder has other files"), "{said}");
        assert_eq!(names(&at.join(name)), files.iter().map(|file| (*file).to_owned()).collect(), "{name}");
    }
    fine("view a.lfold --export mixed", at);
    let before = names(&at.join("mixed"));
    for name in ["film.png", "notes.txt"] {
        fs::write(at.join("mixed").join(name), "mine").unwrap();
        assert!(refused("view a.lfold --export mixed", at).contains(&format!("other files ({name})")));
        fs::remove_file(at.join("mixed").join(name)).unwrap();
    }
    fs::write(at.join("mixed/film.json"), "{\"url\": \"film.lfold\", \"x\": 1}").unwrap();
    assert!(refused("view a.lfold --export mixed", at).contains("other files"));
    assert_eq!(names(&at.join("mixed")), before);
    assert!(refused("view a.lfold --export a.lfold", at).contains("a file, where a folder was expected"));
    assert!(refused("view a.lfold --export .", at).contains("the folder has other files"));
    fs::create_dir(at.join("empty")).unwrap();
    fine("view a.lfold --export empty", at);
    assert!(at.join("empty/index.html").is_file());
}

#[test]
fn a_damaged_film_is_not_exported() {
    let folder = place();
    let at = folder.path();
    let whole = fs::read(at.join("a.lfold")).unwrap();
    fine("view a.lfold --export earlier", at);
    let earlier = names(&at.join("earlier"));
    let mut refused = 0;
    for place in (0..whole.len()).step_by(97) {
        let mut other = whole.clone();
        other[place] ^= 0x10;
        fs::write(at.join("b.lfold"), &other).unwrap();
        let verified = lightfold(&["inspect", "b.lfold", "--verify"], at).status.success();
        for to in ["new", "earlier"] {
            let output = lightfold(&["view", "b.lfold", "--export", to, "--json"], at);
            let said = String::from_utf8(output.stderr).unwrap();
            if verified {
                assert!(output.status.success(), "byte {place}: {said}");
                fs::remove_dir_all(at.join("new")).unwrap();
                break;
            }
            let report: Value = serde_json::from_slice(&output.stdout).unwrap();
            let code = output.status.code();
            // Damage to the first 8 bytes, which identify the file type, may have another exit code.
            assert!(code == Some(1) || place < 8, "byte {place}: {said}");
            assert!(said.contains("b.lfold: "), "byte {place}: {said}");
            assert_eq!(report["error"]["code"].as_i64(), code.map(i64::from), "byte {place}");
            refused += 1;
        }
        assert!(!at.join("new").exists(), "byte {place}");
        assert_eq!(names(&at.join("earlier")), earlier, "byte {place}");
    }
    assert_eq!(fs::read(at.join("earlier/film.lfold")).unwrap(), whole);
    assert!(refused > 10, "{refused}");
    assert!(names(at).iter().all(|name| !name.contains("partial")), "{:?}", names(at));
}
