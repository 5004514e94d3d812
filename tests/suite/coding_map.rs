//! `inspect --plot`: rectangles against the pixels that a decoder writes, pictures of all codecs, and refused requests.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use cli::report::coding_map::{Request, plot};
use codec::decode::{Decoder, Picture, StreamInfo};
use codec::image::{DepthPlane, Face, Plane};
use codec::monitor::Silent;
use footage::compare::{CompareSettings, Coverage, Measured, Pairing, SideOptions, compare, error_map, open_both};
use footage::inspect::{CodingMap, FrameRows, InspectSettings, Writing, coding_map, inspect, steps, survey};
use half::f16;
use serde_json::Value;
use tempfile::TempDir;

use crate::commands::{fine, refused};
use crate::footage::Footage;

fn vectors(folder: &str) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/vectors").join(folder);
    let mut files: Vec<_> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.retain(|path| path.extension().is_some_and(|extension| extension == "lfold"));
    files.sort();
    files
}

/// Returns the index of the patch that contains each pixel. Fails if two patches overlap or one extends beyond the image.
fn owners(stream: &StreamInfo, anatomy: &CodingMap) -> Plane<Option<usize>> {
    let mut owners = Plane::filled(stream.entry.width, stream.entry.height, None);
    for (at, patch) in anatomy.patches.iter().enumerate() {
        let [left, top, width, height] = patch.rect;
        assert!(width > 0 && height > 0 && patch.part < anatomy.parts);
        for y in top..top + height {
            for owner in &mut owners.row_mut(y)[left as usize..(left + width) as usize] {
                assert_eq!(owner.replace(at), None, "frame {}", anatomy.frame);
            }
        }
    }
    owners
}

/// Returns a number for each pixel; two pixels have the same number only if they are equal.
fn values(picture: &Picture) -> Vec<u64> {
    let word = |[a, b, c]: [u64; 3]| a << 32 | b << 16 | c;
    match picture {
        Picture::Depth(plane) => plane.data().iter().map(|&code| u64::from(code)).collect(),
        Picture::Color8(plane) | Picture::Material(plane) => {
            plane.data().iter().map(|pixel| word(pixel.map(u64::from))).collect()
        }
        Picture::Alpha(plane) => plane.data().iter().map(|&code| code.into()).collect(),
        Picture::ColorHalf(plane) => {
            plane.data().iter().map(|pixel| word(pixel.map(|half| u64::from(half.to_bits())))).collect()
        }
    }
}

#[test]
fn rectangles_are_the_pixels_that_a_decoder_writes() {
    let mut seen = BTreeSet::new();
    for path in vectors("valid") {
        let decoder = Decoder::open(&path).unwrap();
        for stream in decoder.streams() {
            let mut face = decoder.face(stream);
            let (mut written, mut before) = (0, None);
            for frame in stream.frames.iter() {
                let named = format!("{} {} frame {frame}", path.display(), stream.header.codec_name());
                let picture = face.decode(frame).unwrap();
                let anatomy = coding_map(&decoder, stream, frame).unwrap();
                let owners = owners(stream, &anatomy);
                let updated = face.cost().updated_pixels - written;
                written += updated;
                assert_eq!(anatomy.updated_pixels(), updated, "{named}");
                assert_eq!(owners.data().iter().flatten().count() as u64, updated, "{named}");
                let now = values(&picture);
                if let Some(before) = before.replace(now.clone()) {
                    let same = now
                        .iter()
                        .zip(&before)
                        .zip(owners.data())
                        .all(|((now, before), owner)| now == before || owner.is_some());
                    assert!(same, "{named}: a pixel outside of all rectangles changed");
                }
                let one_value = anatomy.patches.iter().enumerate().filter(|(_, p)| p.writing == Writing::OneValue);
                for (at, _) in one_value {
                    let of_patch = now.iter().zip(owners.data()).filter(|(_, owner)| **owner == Some(at));
                    assert_eq!(of_patch.map(|(value, _)| *value).collect::<BTreeSet<_>>().len(), 1, "{named}");
                }
                seen.extend(anatomy.patches.iter().map(|patch| (stream.header.codec_name(), patch.writing)));
            }
        }
    }
    // The vectors of each codec use every way of writing that the codec has.
    let counted = |codec: &str| seen.iter().filter(|(name, _)| *name == codec).count();
    let codecs = [
        ("aabb", 2),
        ("aabb-bc5", 3),
        ("aabb-bc1", 1),
        ("quadtree", 4),
        ("quadtree-intermediate", 3),
        ("bc4w", 1),
        ("predictive", 5),
        ("cells-8bit", 2),
        ("cells-half", 2),
        ("cells-bc1", 3),
        ("cells-bc7", 3),
        ("cells-bc6h", 3),
    ];
    for (codec, ways) in codecs {
        assert!(counted(codec) >= ways, "{codec}: {seen:?}");
    }
}

#[test]
fn surveys_agree_with_counts_of_all_frames() {
    let settings = InspectSettings { rows: FrameRows::All, ..InspectSettings::default() };
    for path in vectors("valid") {
        let decoder = Decoder::open(&path).unwrap();
        let streams: Vec<_> = decoder.streams().iter().collect();
        let inspection = inspect(&decoder, &streams, settings, &Silent).unwrap();
        for stats in &inspection.streams {
            let stream = stats.stream;
            let found = survey(&decoder, stream, &Silent).unwrap();
            let keyframes: u64 = found.cells.iter().map(|cell| cell.keyframes()).sum();
            let (blocks, kinds) = (stats.blocks.keyframes, stats.keyframes);
            if !found.cells.is_empty() {
                assert_eq!(keyframes, kinds, "{}", path.display());
                assert_eq!(found.cells.iter().map(|cell| cell.blocks).sum::<u64>(), blocks.blocks);
            }
            // No frame without keyframes may update more pixels than the busiest frame does.
            let rows = inspection.rows.iter().filter(|row| row.stream.index == stream.index);
            let plain = rows.filter(|row| row.cost.keyframe_units == 0).map(|row| row.cost.updated_pixels);
            match found.busiest {
                None => assert_eq!(plain.max().unwrap_or(0), 0, "{}", path.display()),
                Some(frame) => {
                    let most = coding_map(&decoder, stream, frame).unwrap().updated_pixels();
                    assert!(stream.frames.contains(frame) && plain.max().unwrap_or(0) <= most, "{}", path.display());
                }
            }
            assert!(steps(&decoder, &[stream]) >= u64::from(stream.entry.unit_count()));
        }
    }
}

#[cfg_attr(not(all_tests), ignore = "long: scripts/test all runs it")]
#[test]
fn all_vectors_are_drawn_and_no_invalid_one_breaks_anything() {
    let folder = TempDir::new().unwrap();
    let draw = |path: &Path| {
        let decoder = Decoder::open(path)?;
        let streams: Vec<_> = decoder.streams().iter().collect();
        let request = Request { decoder: &decoder, streams: &streams, frame: None, source: None };
        let plots = plot(&request, folder.path(), &Silent)?;
        assert!(plots.iter().all(|plot| folder.path().join(&plot.file).is_file()));
        Ok::<usize, lightfold::Error>(plots.len())
    };
    for path in vectors("valid") {
        let drawn = draw(&path).unwrap();
        assert!(drawn > 0 || path.to_string_lossy().ends_with("empty.lfold"), "{}", path.display());
    }
    let refused = vectors("invalid").iter().filter(|path| draw(path).is_err()).count();
    // Containers that break only a rule about several chunks may be drawn.
    assert!(refused + 3 >= vectors("invalid").len(), "{refused} of {}", vectors("invalid").len());
}

/// Returns depth with a ramp, background at the top, and a square that moves to the right in each of the first three frames.
fn moving(width: u32, height: u32) -> impl Fn(Face, u32) -> DepthPlane {
    move |_, frame| {
        let frame = frame.min(2);
        Plane::from_fn(width, height, |x, y| match (x, y) {
            (_, y) if y < height / 8 => f32::INFINITY,
            (x, y) if (8 * frame..8 * frame + 8).contains(&x) && (16..24).contains(&y) => 1.5,
            _ => 2.0 + 0.01 * (x + y) as f32,
        })
    }
}

fn still_color(width: u32, height: u32) -> impl Fn(Face, u32) -> codec::image::ColorPlane {
    move |_, frame| Plane::from_fn(width, height, |x, y| [f16::from_f32(0.01 * (x * y % 64 + frame) as f32); 3])
}

fn footage(folder: &Path, [width, height]: [u32; 2]) {
    let (depth, color) = (moving(width, height), still_color(width, height));
    let material =
        |_: Face, frame: u32| Plane::from_fn(width, height, |x, _| [if x == frame { 1.0 } else { 0.0 }, 0.0, 1.0]);
    let small = Footage::new(width, height);
    Footage { depth: Some(&depth), color: Some(&color), material: Some(&material), ..small }.write(folder);
}

fn plots(line: &str, folder: &Path) -> Vec<Value> {
    let output = fine(line, folder);
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    report["plots"].as_array().unwrap().clone()
}

fn names(folder: &Path) -> BTreeSet<String> {
    std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
}

#[test]
fn pictures_are_listed_and_the_same_on_any_number_of_threads() {
    let folder = TempDir::new().unwrap();
    footage(folder.path(), [64, 64]);
    fine("encode . -o a.lfold --color-cell 16", folder.path());
    let listed = plots("inspect a.lfold --plot one --source . --json --threads 1", folder.path());
    plots("inspect a.lfold --plot three --source . --json --threads 3", folder.path());
    let expected = [
        "depth_00_px_0000_blocks.png",
        "depth_00_px_0000_error.png",
        "depth_00_px_0001_blocks.png",
        "depth_00_px_0001_error.png",
        "material_00_px_0000_boxes.png",
        "material_00_px_0000_error.png",
    ];
    let written = names(&folder.path().join("one"));
    assert!(expected.iter().all(|name| written.contains(*name)), "{written:?}");
    let color: Vec<_> = written.iter().filter(|name| name.starts_with("color_00_px_")).collect();
    assert!(color.len() == 2 && color[0].ends_with("_bytes.png") && color[1].ends_with("_error.png"), "{color:?}");
    let paths: BTreeSet<String> =
        listed.iter().map(|plot| plot["path"].as_str().unwrap().replace("one/", "")).collect();
    assert_eq!(paths, written);
    assert_eq!(names(&folder.path().join("three")), written);
    for name in &written {
        let read = |at: &str| std::fs::read(folder.path().join(at).join(name)).unwrap();
        assert_eq!(read("one"), read("three"), "{name}");
    }
    let blocks = listed.iter().find(|plot| plot["path"].as_str().unwrap().ends_with("0001_blocks.png")).unwrap();
    assert_eq!((blocks["stream"].as_str(), blocks["what"].as_str()), (Some("depth 00/px"), Some("blocks")));
    assert_eq!((blocks["frame"].as_u64(), blocks["face"].as_str()), (Some(1), Some("px")));
    // A second run adds files to the folder and keeps the other files in it.
    std::fs::write(folder.path().join("one/other.txt"), "mine").unwrap();
    let few = plots("inspect a.lfold --plot one --stream depth --frame 4 --json", folder.path());
    assert_eq!(few.len(), 1);
    assert!(names(&folder.path().join("one")).is_superset(&[String::from("other.txt")].into()));
}

/// Reads a PNG file as 8-bit RGB.
fn read(path: &Path) -> image::RgbImage {
    image::open(path).unwrap().into_rgb8()
}

#[test]
fn what_a_frame_writes_is_tinted_and_the_rest_is_grey() {
    let folder = TempDir::new().unwrap();
    footage(folder.path(), [64, 64]);
    let coloured = |name: &str| {
        let drawn = read(&folder.path().join("p").join(name));
        // The image is between title and key; its 64 pixels are drawn 1,024 wide.
        let (left, top) = (24, drawn.height().saturating_sub(1024) / 3);
        let pixels = (top..top + 900).flat_map(|y| (left..left + 1024).map(move |x| (x, y)));
        pixels.filter(|&(x, y)| drawn.get_pixel(x, y).0.iter().any(|code| *code != drawn.get_pixel(x, y).0[0])).count()
    };
    // The frame with the most changed pixels is drawn, besides the first one. With a window of 2, records repeat changes.
    let codecs = [("predictive", "blocks", 1), ("quadtree", "nodes", 2), ("aabb", "boxes", 2), ("bc4w", "blocks", 2)];
    for (codec, what, busiest) in codecs {
        fine(&format!("encode . -o {codec}.lfold --stream depth --depth-codec {codec}"), folder.path());
        fine(&format!("inspect {codec}.lfold --plot p"), folder.path());
        assert!(coloured(&format!("depth_00_px_0000_{what}.png")) > 800_000, "{codec}");
        if codec != "bc4w" {
            let moved = coloured(&format!("depth_00_px_{busiest:04}_{what}.png"));
            assert!((1000..300_000).contains(&moved), "{codec} {moved}");
        }
        fine(&format!("inspect {codec}.lfold --plot p --frame 5"), folder.path());
        let still = coloured(&format!("depth_00_px_0005_{what}.png"));
        assert_eq!(still == 0, codec != "bc4w", "{codec} {still}");
    }
}

#[test]
fn images_of_any_size_are_drawn_within_bounds() {
    for size in [[1, 1], [7, 5], [1, 300], [2100, 40]] {
        let folder = TempDir::new().unwrap();
        footage(folder.path(), size);
        fine("encode . -o a.lfold", folder.path());
        for plot in plots("inspect a.lfold --plot p --source . --json", folder.path()) {
            let drawn = read(&folder.path().join(plot["path"].as_str().unwrap()));
            assert!((400..2400).contains(&drawn.width()) && drawn.height() < 2900, "{size:?} {:?}", drawn.dimensions());
        }
    }
}

#[test]
fn what_cannot_be_drawn_is_refused_in_a_sentence_and_leaves_nothing() {
    let folder = TempDir::new().unwrap();
    footage(folder.path(), [32, 32]);
    fine("encode . -o a.lfold --stream depth", folder.path());
    fine("encode . -o color.lfold --stream color", folder.path());
    std::fs::write(folder.path().join("file"), "a file").unwrap();
    let damaged = {
        let mut bytes = std::fs::read(folder.path().join("a.lfold")).unwrap();
        bytes[200] ^= 1;
        bytes
    };
    std::fs::write(folder.path().join("bad.lfold"), damaged).unwrap();
    std::fs::create_dir(folder.path().join("empty")).unwrap();
    let before = names(folder.path());
    let cases = [
        ("inspect a.lfold --plot p --frame 6", "its frames are 0-5"),
        ("inspect a.lfold --plot p --stream color", "no color stream"),
        ("inspect a.lfold --plot p --probe 77", "no probe '77'"),
        ("inspect a.lfold --plot file", "a folder was expected"),
        ("inspect bad.lfold --plot p", "bad.lfold"),
        ("inspect bad.lfold --plot p --verify", "damaged"),
        ("inspect a.lfold --frame 2", "--plot"),
        ("inspect a.lfold --source .", "--plot"),
        ("inspect a.lfold --plot p --source nowhere", "no such file"),
        ("inspect a.lfold --plot p --source color.lfold", "no stream and frame in common"),
        ("inspect a.lfold --plot p --depth-scale 2", "--source"),
        ("inspect - --plot p --source .", "reads the container twice"),
        ("inspect a.lfold --plot file/p", "file"),
    ];
    for (line, said) in cases {
        let message = refused(line, folder.path());
        assert!(message.contains(said), "{line}: {message}");
        assert_eq!(names(folder.path()), before, "{line}");
    }
}

#[test]
fn a_source_that_lacks_streams_is_told_of() {
    let folder = TempDir::new().unwrap();
    footage(folder.path(), [32, 32]);
    fine("encode . -o a.lfold", folder.path());
    let said = |line: &str| String::from_utf8(fine(line, folder.path()).stdout).unwrap();
    assert!(said("inspect a.lfold --plot p").contains("Error maps need --source"));
    let some = said("inspect a.lfold --plot p --source probe_00/face_px/depth.%04d.exr --face px");
    assert!(some.contains("depth_00_px_0000_error.png") && some.contains("lacks"), "{some}");
    let all = said("inspect a.lfold --plot p --source .");
    assert!(!all.contains("lacks") && !all.contains("need"), "{all}");
    assert!(!said("inspect a.lfold").contains("Pictures"));
}

#[test]
fn errors_of_pixels_and_cells_are_those_of_a_comparison() {
    let folder = TempDir::new().unwrap();
    let depth = |_: Face, frame: u32| {
        Plane::from_fn(40, 40, |x, y| match (x, (x + y + frame) % 7) {
            (..6, 0) => f32::INFINITY,
            _ => 1.0 + 0.01 * x as f32 + 0.0005 * ((x * y + frame) % 5) as f32,
        })
    };
    let color = |_: Face, frame: u32| {
        let value = |x: u32, y: u32| {
            let wobble = (x + y * frame * frame) % 5;
            f16::from_f32(((x * 7 + y * 13) % 64) as f32 / 80.0 + 0.02 * frame as f32 + 0.005 * wobble as f32)
        };
        Plane::from_fn(40, 40, |x, y| [value(x, y), value(y, x), value(x, x)])
    };
    Footage { depth: Some(&depth), color: Some(&color), ..Footage::new(40, 40) }.write(folder.path());
    for options in ["--max-error 400 --psnr 30 --color-cell 16", "--depth-codec bc4w --hdr --psnr 25 --color-cell 16"] {
        fine(&format!("encode . -o a.lfold {options}"), folder.path());
        let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
        let sides = open_both([&path("a.lfold"), &path("lightfield.json")], &SideOptions::default()).unwrap();
        let pairing = Pairing::new(&sides, Coverage::Whole).unwrap();
        let comparison = compare(&pairing, &CompareSettings::default(), &Silent).unwrap();
        assert_eq!(comparison.streams.len(), 2);
        for (report, pair) in comparison.streams.iter().zip(&pairing.pairs) {
            let maps: Vec<_> = pair.frames.iter().map(|frame| error_map(&sides, pair, frame).unwrap()).collect();
            let largest = maps.iter().map(|map| map.largest().steps).max().unwrap();
            let differing: u64 = maps.iter().map(|map| map.differing_pixels()).sum();
            match &report.measured {
                Measured::Depth(errors) => {
                    assert!(differing > 0 && errors.background_mismatches == 0);
                    assert_eq!((u32::from(errors.max_error_codes), errors.differing_pixels), (largest, differing));
                }
                Measured::Color(errors) => {
                    assert_eq!((errors.max_error, errors.differing_pixels > 0), (largest, differing > 0));
                    let cells = maps.iter().flat_map(|map| &map.cells);
                    let lowest = cells.map(|cell| cell.psnr_db).fold(f64::INFINITY, f64::min);
                    assert_eq!(lowest, errors.lowest_cell.unwrap().value);
                    assert!(lowest.is_finite() && maps.iter().all(|map| map.cells.len() == 9));
                }
                Measured::Bytes(_) => panic!("there is no material"),
            }
        }
    }
}
