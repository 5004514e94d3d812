//! Decoding of the units that cameras see: through the library, and on the command line.

use std::fs;
use std::path::Path;

use codec::decode::{AllUnits, Decoder, OnDamage, Picture, Request, Selection, StreamInfo, UnitFilter, decode_units};
use codec::depth::BACKGROUND_CODE;
use codec::image::{Face, Plane};
use codec::monitor::Silent;
use evaluate::camera_file::CameraFile;
use half::f16;
use render::views::camera_units::CameraUnits;
use serde_json::Value;
use tempfile::TempDir;

use crate::commands::{fine, refused};
use crate::footage::Footage;

/// Writes and encodes a cube map with three kinds of streams around (0, 1, 2). Every image changes in every frame, and no pixel
/// has the value of an omitted unit.
fn container(folder: &Path, options: &str) {
    let shade = |face: Face, frame: u32, x: u32, y: u32| (1 + x + 3 * y + 7 * frame + 11 * face as u32) as f32 / 500.0;
    let depth = |face: Face, frame: u32| Plane::from_fn(32, 32, |x, y| 2.0 + shade(face, frame, x, y));
    let color = |face: Face, frame: u32| {
        Plane::from_fn(32, 32, |x, y| [shade(face, frame, x, y), 0.5, 0.25].map(f16::from_f32))
    };
    let material = |face: Face, frame: u32| Plane::from_fn(32, 32, |x, y| [0.5, shade(face, frame, x, y), 1.5]);
    let footage = Footage {
        faces: &Face::CUBE,
        frames: [0, 3],
        depth: Some(&depth),
        color: Some(&color),
        material: Some(&material),
        ..Footage::new(32, 32)
    };
    footage.write(folder);
    fine(format!("encode . --color-cell 8 -o a.lfold {options}").trim_end(), folder);
}

/// Selects units by a hash of stream, unit and frame.
struct Some3Of7;

impl UnitFilter for Some3Of7 {
    fn wants(&self, stream: &StreamInfo, unit: u32, frame: u32) -> bool {
        let hash = (stream.index * 31 + unit * 17 + frame * 5 + 1).wrapping_mul(2_654_435_761);
        (hash >> 16) % 7 < 3
    }
}

/// Returns the samples of an image as numbers, three per pixel, and those of a pixel of an omitted unit.
fn samples(picture: &Picture) -> (Vec<[u16; 3]>, [u16; 3]) {
    match picture {
        Picture::Depth(codes) => (codes.data().iter().map(|code| [*code; 3]).collect(), [BACKGROUND_CODE; 3]),
        Picture::Color8(codes) | Picture::Material(codes) => {
            (codes.data().iter().map(|pixel| pixel.map(u16::from)).collect(), [0; 3])
        }
        Picture::Alpha(codes) => (codes.data().iter().map(|&code| [code.into(); 3]).collect(), [0; 3]),
        Picture::ColorHalf(light) => (light.data().iter().map(|pixel| pixel.map(f16::to_bits)).collect(), [0; 3]),
    }
}

/// Checks that every image equals the full image in selected units and is blank in the others; returns the number of selected
/// pixels.
fn check(decoder: &Decoder, filter: &dyn UnitFilter) -> u64 {
    let mut wanted_pixels = 0;
    for stream in decoder.streams() {
        let (mut whole, mut part) = (decoder.face(stream), decoder.face(stream));
        for frame in stream.frames.iter() {
            let (all, blank) = samples(&whole.decode(frame).unwrap());
            let (some, _) = samples(&part.decode_filtered(frame, filter).unwrap());
            for unit in 0..stream.entry.unit_count() {
                let wanted = filter.wants(stream, unit, frame);
                let [left, top, width, height] = stream.entry.unit_rect(unit);
                for (x, y) in (left..left + width).flat_map(|x| (top..top + height).map(move |y| (x, y))) {
                    let at = (y * stream.entry.width + x) as usize;
                    assert_ne!(all[at], blank);
                    assert_eq!(some[at], if wanted { all[at] } else { blank }, "{:?} {unit} {frame}", stream.kind);
                }
            }
        }
        wanted_pixels += part.selected_pixels();
    }
    wanted_pixels
}

#[test]
fn units_that_are_not_wanted_are_blank_and_the_others_whole() {
    for options in ["--max-error 0", "--max-error 0 --hdr", "--depth-codec aabb --keyframe-interval 2"] {
        let folder = TempDir::new().unwrap();
        container(folder.path(), options);
        let decoder = Decoder::open(folder.path().join("a.lfold")).unwrap();
        let pixels = check(&decoder, &Some3Of7);
        let chosen = Selection::default().choose(&decoder).unwrap();
        let summary =
            decode_units(&decoder, Request { filter: &Some3Of7, ..Request::all(&chosen) }, OnDamage::Stop, &Silent)
                .unwrap()
                .summary;
        assert_eq!(summary.pixels, pixels);
        assert!(pixels > 0);
        let all = decode_units(&decoder, Request::all(&chosen), OnDamage::Stop, &Silent).unwrap().summary;
        assert_eq!(all.pixels, check(&decoder, &AllUnits));
        assert!(pixels < all.pixels && summary.cost.bytes_read <= all.cost.bytes_read);
    }
}

/// Returns a camera at the centre of the probe.
fn camera(look_at: [f64; 3], more: &str) -> String {
    format!(r#"{{ "eye": [0, 1, 2], "look_at": {look_at:?}, "fov_y_deg": 60 {more} }}"#)
}

fn cameras(entries: &[String]) -> String {
    format!(r#"{{ "cameras": [{}] }}"#, entries.join(", "))
}

#[test]
fn units_are_seen_in_the_frames_of_their_cameras() {
    let folder = TempDir::new().unwrap();
    container(folder.path(), "--max-error 0 --depth-codec quadtree");
    let decoder = Decoder::open(folder.path().join("a.lfold")).unwrap();
    let chosen = Selection::default().choose(&decoder).unwrap();
    let entries = [camera([5.0, 1.0, 2.0], r#", "frames": [1, 2]"#), camera([-5.0, 1.0, 2.0], r#", "frames": [2, 9]"#)];
    let timed = CameraFile::parse(cameras(&entries).as_bytes()).unwrap();
    let seen = CameraUnits::find(&decoder, &chosen, &timed);
    assert!(check(&decoder, &seen) > 0);
    for stream in decoder.streams() {
        let wanted = |frame| (0..stream.entry.unit_count()).any(|unit| seen.wants(stream, unit, frame));
        let expected = match stream.face {
            Face::Px => [false, true, true, false],
            Face::Nx => [false, false, true, true],
            _ => [false; 4],
        };
        assert_eq!([0, 1, 2, 3].map(wanted), expected, "{:?}", stream.face);
    }
    // A field of view of 60 degrees covers 9 of the 16 pixels on each side of the centre, so all 4 tiles and all 16 cells of 8x8
    // pixels of a face are at least partly visible.
    let counts = seen.counts;
    assert_eq!((counts.cameras, counts.units), (2, 6 * (4 + 16 + 4)));
    assert_eq!(counts.visible_units, 2 * (4 + 16 + 4));
    assert_eq!(counts.regular_tests, 2 * counts.units);
    assert!(counts.hierarchical_tests < counts.regular_tests);
}

fn report(folder: &Path, options: &str) -> Value {
    let output = fine(format!("decode a.lfold --null --stats --json {options}").trim_end(), folder);
    serde_json::from_slice(&output.stdout).unwrap()
}

#[test]
fn stats_say_what_a_view_saves() {
    let folder = TempDir::new().unwrap();
    container(folder.path(), "--max-error 0 --depth-codec quadtree");
    let all = report(folder.path(), "");
    assert_eq!(all["bytes_read"], all["bytes_total"]);
    assert_eq!(all["units"], all["visible_units"]);
    assert_eq!((&all["cameras"], &all["visible_fraction"]), (&0.into(), &1.0.into()));
    let eye = "--eye 0,1,2 --look-at 5,1,2";
    let seen = report(folder.path(), &format!("{eye} --fov 60"));
    assert_eq!(seen["cameras"], 1);
    assert_eq!(seen["units"], all["units"]);
    assert_eq!(seen["bytes_total"], all["bytes_total"]);
    let number = |report: &Value, key: &str| report[key].as_f64().unwrap();
    assert!(number(&seen, "bytes_read") < 0.2 * number(&all, "bytes_read"));
    assert_eq!(number(&seen, "pixels") * 6.0, number(&all, "pixels"), "one face of six");
    assert!(number(&seen, "updated_pixels") <= number(&seen, "pixels"));
    assert_eq!(number(&seen, "visible_fraction"), number(&seen, "visible_units") / number(&seen, "units"));
    assert!(seen["frustum_tests"]["hierarchical"].as_u64() < seen["frustum_tests"]["regular"].as_u64());
    // A camera file gives the same result, a single frame has a quarter of the pixels, and a wide image sees more units.
    fs::write(folder.path().join("cam.json"), cameras(&[camera([5.0, 1.0, 2.0], "")])).unwrap();
    let file = report(folder.path(), "--camera cam.json");
    for key in ["visible_units", "bytes_read", "pixels", "frustum_tests"] {
        assert_eq!(file[key], seen[key], "{key}");
    }
    // Without a point to look at, a camera looks along −Z.
    let [stated, unstated] = ["--eye 0,1,2 --look-at 0,1,1", "--eye 0,1,2"].map(|eye| report(folder.path(), eye));
    assert_eq!(
        (&stated["visible_units"], &stated["bytes_read"]),
        (&unstated["visible_units"], &unstated["bytes_read"])
    );
    let one = report(folder.path(), &format!("{eye} --fov 60 --frames 2"));
    assert_eq!(number(&one, "pixels") * 4.0, number(&seen, "pixels"));
    let wide = report(folder.path(), &format!("{eye} --fov 60 --aspect 16/9"));
    assert!(number(&wide, "visible_units") > number(&seen, "visible_units"));
    let text = fine(&format!("decode a.lfold --null --stats {eye} --fov 60"), folder.path()).stdout;
    let text = String::from_utf8(text).unwrap();
    assert!(text.contains("1 camera sees 24 of 144 tiles and cells (16.7%)"), "{text}");
    let plain = String::from_utf8(fine("decode a.lfold --null", folder.path()).stdout).unwrap();
    assert!(!plain.contains("tiles and cells"), "{plain}");
}

#[test]
fn files_hold_what_cameras_see() {
    let folder = TempDir::new().unwrap();
    container(folder.path(), "--max-error 0");
    // Six cameras in two files that together see everything.
    let ahead = [[9, 1, 2], [-9, 1, 2], [0, 9, 2], [0, -9, 2], [0, 1, 9], [0, 1, -9]];
    let entries = ahead
        .map(|look_at| format!(r#"{{ "eye": [0, 1, 2], "look_at": {look_at:?}, "up": [1, 1, 1], "fov_y_deg": 120 }}"#));
    fs::write(folder.path().join("a.json"), cameras(&entries[..2])).unwrap();
    fs::write(folder.path().join("b.json"), cameras(&entries[2..])).unwrap();
    fine("decode a.lfold --camera a.json --camera b.json -o all", folder.path());
    fine("diff a.lfold all --exact", folder.path());
    fine("decode a.lfold --camera a.json --stream depth --face px -o px.%04d.exr", folder.path());
    fine("diff px.%04d.exr probe_00/face_px/depth.%04d.exr --kind depth --max-error 1", folder.path());
    fine("decode a.lfold --eye 0,1,2 --look-at 0,1,-9 --fov 30 -o some", folder.path());
    let said = fine("diff a.lfold some --json", folder.path()).stdout;
    let said: Value = serde_json::from_slice(&said).unwrap();
    assert_eq!(said["equal"], false, "most of it is blank");
    assert!(folder.path().join("some/probe_00/face_px/depth.0000.exr").is_file());
}

#[test]
fn cameras_that_make_no_sense_are_refused() {
    let folder = TempDir::new().unwrap();
    container(folder.path(), "--max-error 0");
    let said = |options: &str| refused(&format!("decode a.lfold --null {options}"), folder.path());
    assert!(said("--eye 0,1,2 --look-at 0,1,2 --fov 60").contains("same point or too far"));
    assert!(said("--eye 0,1,2 --look-at 0,5,2 --fov 60").contains("use another up"));
    assert!(said("--eye 0,1,2 --look-at 0,5,3 --up 0,-4,-1 --fov 60").contains("use another up"));
    assert!(said("--eye 0,1,2 --look-at 0,1,3 --fov 180").contains("between 0 and 180"));
    assert!(said("--eye 0,1,2 --look-at 0,1,3 --fov NaN").contains("between 0 and 180"));
    assert!(said("--eye 0,1 --look-at 0,1,3 --fov 60").contains("three finite numbers"));
    assert!(said("--eye 0,1,2 --look-at 0,1,3 --fov 60 --aspect 0").contains("16/9"));
    assert!(said("--look-at 0,1,2").contains("--eye"));
    assert!(said("--fov 60").contains("--eye"));
    assert!(said("--camera none.json").contains("none.json"));
    fs::write(folder.path().join("cam.json"), cameras(&[camera([0.0, 1.0, 5.0], r#", "fvo": 3"#)])).unwrap();
    let unknown = said("--camera cam.json");
    assert!(unknown.contains("cam.json") && unknown.contains("`fvo`"), "{unknown}");
    fs::write(folder.path().join("long.json"), vec![b' '; (16 << 20) + 1]).unwrap();
    assert!(said("--camera long.json").contains("at most 16777216 bytes"));
    // A file without an end is read up to the limit only.
    #[cfg(unix)]
    assert!(said("--camera /dev/zero").contains("at most 268435456 bytes"));
}
