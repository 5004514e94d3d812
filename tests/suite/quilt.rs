//! `lightfold quilt`: tile of each view, file names, and refusals.

use std::path::Path;

use codec::image::{Plane, ReadLimits};
use footage::image_files::{exr, png};
use half::f16;
use serde_json::{Value, json};
use tempfile::TempDir;

use crate::commands::{fine, lightfold, refused};

/// Returns the colour of a pixel of a view, which differs between views.
fn code(view: u32, x: u32, y: u32) -> [u8; 4] {
    [view as u8, x as u8, y as u8, 255 - view as u8]
}

fn write_view(folder: &Path, name: &str, view: u32, [width, height]: [u32; 2]) {
    let path = folder.join(name);
    std::fs::create_dir_all(path.parent().unwrap()).unwrap();
    png::write_rgba8(&path, &Plane::from_fn(width, height, |x, y| code(view, x, y))).unwrap();
}

/// Writes views `first..first + count` of 3x4 pixels to the folder `v`.
fn views(first: u32, count: u32) -> TempDir {
    let folder = TempDir::new().unwrap();
    for view in 0..count {
        write_view(folder.path(), &format!("v/{:04}.png", first + view), view, [3, 4]);
    }
    folder
}

fn picture(path: &Path) -> Plane<[u8; 4]> {
    png::read_rgba8(path, &ReadLimits::default()).unwrap()
}

/// Returns the expected quilt of columns and rows of 3x4 pixels, view 0 at the bottom left.
fn expected(columns: u32, rows: u32, views: u32) -> Plane<[u8; 4]> {
    Plane::from_fn(3 * columns, 4 * rows, |x, y| match (rows - 1 - y / 4) * columns + x / 3 {
        view if view < views => code(view, x % 3, y % 4),
        _ => [0, 0, 0, 255],
    })
}

fn names_in(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap();
    let mut names: Vec<String> = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

fn report(line: &str, folder: &Path) -> Value {
    serde_json::from_slice(&fine(line, folder).stdout).unwrap()
}

#[test]
fn views_go_right_and_then_up() {
    let folder = views(0, 48);
    let mut said = report("quilt v/%04d.png -o q.png --json", folder.path());
    let path = folder.path().join("q_qs8x6a0.75.png");
    assert_eq!(picture(&path), expected(8, 6, 48));
    let object = said.as_object_mut().unwrap();
    assert!(object.remove("seconds").unwrap().as_f64().unwrap() >= 0.0);
    object.remove("peak_memory_bytes");
    let bytes = std::fs::metadata(&path).unwrap().len();
    let all = json!({
        "views": 48, "columns": 8, "rows": 6, "aspect": 0.75, "size": [24, 24], "view_size": [3, 4],
        "path": "q_qs8x6a0.75.png", "bytes": bytes, "device": null, "notes": [],
    });
    assert_eq!(said, all);
    // A folder as input, a file name with the layout, and standard output give the same bytes, on any number of threads.
    let whole = std::fs::read(&path).unwrap();
    for threads in [1, 3] {
        fine(&format!("quilt v --threads {threads} --quilt 8x6 -o r_qs8x6a0.75.png"), folder.path());
        assert_eq!(std::fs::read(folder.path().join("r_qs8x6a0.75.png")).unwrap(), whole);
    }
    let printed = fine("quilt v/%04d.png --memory 128M -o -", folder.path());
    assert_eq!(printed.stdout, whole);
    assert_eq!(names_in(folder.path()), ["q_qs8x6a0.75.png", "r_qs8x6a0.75.png", "v"]);
}

#[test]
fn views_are_counted_from_the_lowest_number() {
    let folder = views(7, 6);
    fine("quilt v -o a.png", folder.path());
    assert_eq!(picture(&folder.path().join("a_qs3x2a0.75.png")), expected(3, 2, 6));
    fine("quilt v/%04d.png --views 7-10 --quilt 2x2 -o b.png", folder.path());
    assert_eq!(picture(&folder.path().join("b_qs2x2a0.75.png")), expected(2, 2, 4));
    // One more view, as from a later run.
    write_view(folder.path(), "v/0013.png", 6, [3, 4]);
    let blank = fine("quilt v --quilt 4x2 -o c.png", folder.path());
    assert_eq!(picture(&folder.path().join("c_qs4x2a0.75.png")), expected(4, 2, 7));
    let said = String::from_utf8(blank.stderr).unwrap();
    assert!(said.contains("1 of 8 tiles is black: there are 7 views"), "{said}");
    assert!(said.contains("c_qs4x2a0.75.png: 7 views of 3x4 pixels in 4x2 tiles, 12x8 pixels, "), "{said}");
}

#[test]
fn devices_say_what_they_expect() {
    let folder = TempDir::new().unwrap();
    for view in 0..48 {
        write_view(folder.path(), &format!("v{view}.png"), view, [420, 560]);
    }
    let said = report("quilt v%d.png -o q.png --json", folder.path());
    assert_eq!(said["device"], "portrait");
    assert_eq!((&said["size"], &said["notes"]), (&json!([3360, 3360]), &json!([])));
    let said = report("quilt v%d.png -o q.png --quilt go --aspect 9/16 --json", folder.path());
    assert_eq!((&said["device"], &said["path"]), (&json!("go"), &json!("q_qs11x6a0.5625.png")));
    let notes = said["notes"].as_array().unwrap();
    assert_eq!(notes[0], "18 of 66 tiles are black: there are 48 views");
    assert!(notes[1].as_str().unwrap().starts_with("go expects 4092x4092 pixels, views of 372x682; "), "{}", notes[1]);
}

#[test]
fn half_floats_stay_as_they_are() {
    let folder = TempDir::new().unwrap();
    let light =
        |view: u32, x: u32, y: u32| [1000.0 * view as f32, x as f32 / 7.0, -0.25 * y as f32, 0.5].map(f16::from_f32);
    for view in 0..3 {
        let plane = Plane::from_fn(5, 2, |x, y| light(view, x, y));
        exr::write_rgba(&folder.path().join(format!("{view}.exr")), &plane).unwrap();
    }
    let opaque = Plane::from_fn(5, 2, |x, y| light(3, x, y)[..3].try_into().unwrap());
    exr::write_color(&folder.path().join("3.exr"), &opaque).unwrap();
    fine("quilt %d.exr --quilt 1x5 -o q.exr", folder.path());
    let picture = exr::read_rgba(&folder.path().join("q_qs1x5a2.5.exr"), &ReadLimits::default()).unwrap();
    let expected = Plane::from_fn(5, 10, |x, y| match 4 - y / 2 {
        3 => [light(3, x, y % 2)[..3].to_vec(), vec![f16::ONE]].concat().try_into().unwrap(),
        4 => [f16::ZERO, f16::ZERO, f16::ZERO, f16::ONE],
        view => light(view, x, y % 2),
    });
    assert_eq!(picture, expected);
    assert!(refused("quilt %d.exr -o q.png", folder.path()).contains("q.png: the views are EXR files"));
    assert!(refused("quilt %d.exr -o -", folder.path()).contains("standard output takes PNG"));
}

#[test]
fn what_is_refused_writes_nothing() {
    let folder = views(0, 8);
    let here = folder.path();
    write_view(here, "holes/0000.png", 0, [3, 4]);
    write_view(here, "holes/0002.png", 2, [3, 4]);
    write_view(here, "sizes/0000.png", 0, [3, 4]);
    write_view(here, "sizes/0001.png", 1, [4, 3]);
    write_view(here, "own/q_qs1x1a0.75.png", 0, [3, 4]);
    std::fs::create_dir(here.join("damaged")).unwrap();
    std::fs::write(here.join("damaged/0.png"), &std::fs::read(here.join("v/0000.png")).unwrap()[..50]).unwrap();
    std::fs::write(here.join("a.txt"), "").unwrap();
    let before = names_in(here);
    for (line, words) in [
        ("quilt none/%04d.png -o q.png", "none"),
        ("quilt holes/%04d.png -o q.png", "0001.png: frame 1 is missing"),
        ("quilt v/%04d.png --views 6-9 -o q.png", "0008.png: frame 8 is missing"),
        ("quilt sizes/%04d.png -o q.png", "0001.png: this view has 4x3 pixels, but sizes/0000.png has 3x4"),
        ("quilt damaged -o q.png", "damaged/0.png: "),
        ("quilt a.txt -o q.png", "a.txt: views ending in .png or .exr were expected"),
        ("quilt v --quilt 7x1 -o q.png", "--quilt 7x1 has 7 tiles, but there are 8 views"),
        ("quilt v --quilt 0x1 -o q.png", "1 to 4096"),
        ("quilt v --quilt tablet -o q.png", "a device (portrait, go, 16,"),
        ("quilt v -o q_qs8x6a0.75.png", "q_qs8x6a0.75.png: the file name states 8x6 tiles, but the quilt has 4x2"),
        ("quilt v -o q_qs4x2a1.png", "states views of aspect ratio 1, but the quilt has 0.75"),
        ("quilt v -o q.exr", "q.exr: the views are PNG files"),
        ("quilt v -o q", "q: the views are PNG files"),
        ("quilt v -o - --json", "--json and -o - would both write"),
        ("quilt own/q_qs1x1a0.75.png -o own/q.png", "an input would be overwritten"),
        ("quilt v --memory 1k -o q.png", "--memory 1000: joining views to a quilt needs"),
    ] {
        let said = refused(line, here);
        assert!(said.contains(words), "{line}: {said}");
        assert_eq!(names_in(here), before, "{line}");
    }
    assert_eq!(names_in(&here.join("own")), ["q_qs1x1a0.75.png"]);
    assert_eq!(lightfold(&["quilt"], here).status.code(), Some(2));
}
