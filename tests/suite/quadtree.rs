//! Commands of the quadtree codec in sequence: intermediate trees, containers packed from them at any bound, and plain blocks.

use std::path::Path;

use codec::container::Reader;
use codec::decode::{Decoder, Picture};
use codec::image::{Face, Plane};
use codec::streams::CodecHeader;
use serde_json::Value;
use tempfile::TempDir;

use crate::commands::{fine, refused};
use crate::footage::Footage;

const SEQUENCE: &str = "probe_00/face_px/depth.%04d.exr";
/// Not divisible by 8, so that blocks extend beyond the image.
const SIZE: [u32; 2] = [90, 90];

/// Writes a dataset of a floor, a wall behind it, a hole to the background, noise in a corner, and a box that moves.
fn scene(folder: &Path) {
    let depth = |_: Face, frame: u32| {
        Plane::from_fn(SIZE[0], SIZE[1], |x, y| {
            let noise = (x.wrapping_mul(2_654_435_761) ^ y.wrapping_mul(40_503).wrapping_add(frame)) % 97;
            let (x, y) = (x as f32, y as f32);
            let left = 20.0 + 3.0 * frame as f32;
            if (left..left + 17.0).contains(&x) && (30.0..52.0).contains(&y) {
                2.0 + 0.01 * x
            } else if (x - 70.0).hypot(y - 15.0) < 11.0 {
                f32::INFINITY
            } else if x < 16.0 && y < 16.0 {
                4.0 + noise as f32 * 0.05
            } else if y > 40.0 {
                90.0 / (y - 30.0)
            } else {
                9.0 + 0.002 * x
            }
        })
    };
    let size = Footage::new(SIZE[0], SIZE[1]);
    Footage { faces: &[Face::Px], frames: [5, 10], depth: Some(&depth), ..size }.write(folder);
}

/// Returns all depth images of a container as codes.
fn codes(path: &Path) -> Vec<Vec<u16>> {
    let decoder = Decoder::open(path).unwrap();
    let stream = &decoder.streams()[0];
    let mut face = decoder.face(stream);
    let images = stream.frames.iter().map(|frame| match face.decode(frame).unwrap() {
        Picture::Depth(plane) => plane.data().to_vec(),
        other => panic!("{other:?} is no depth"),
    });
    images.collect()
}

fn json(line: &str, folder: &Path) -> Value {
    serde_json::from_slice(&fine(line, folder).stdout).unwrap()
}

#[test]
fn trees_are_lossless_and_packed_at_any_bound_within_it() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    scene(folder);
    fine(&format!("encode-depth {SEQUENCE} --face px --depth-codec aabb -o source.lfold"), folder);
    let source = codes(&folder.join("source.lfold"));
    for options in ["", " --optimize size --min-children 1 --keyframe-interval 4 --lzma2"] {
        let line = format!("quadtree {SEQUENCE} --face px --max-error 300 --effort fast{options}");
        let report = json(&format!("{line} -o tree.lfold --json"), folder);
        assert_eq!((report["frames"].as_u64(), report["raw_bytes"].as_u64()), (Some(6), Some(6 * 4 * 90 * 90)));
        assert!(report["bytes"].as_u64() > Some(0) && report["seconds"].is_number());
        assert_eq!(codes(&folder.join("tree.lfold")), source);
        let mut sizes = Vec::new();
        for bound in [0, 1, 10, 30, 100, 300] {
            for settings in ["", " --depth-window 3 --update-threshold 7 --optimize size"] {
                let pack = |threads: u32, name: &str| {
                    let line =
                        format!("pack tree.lfold --max-error {bound}{settings} --effort fast --threads {threads}");
                    let report = json(&format!("{line} -o {name} --json"), folder);
                    assert_eq!((report["frames"].as_u64(), report["flattened_streams"].as_u64()), (Some(6), Some(1)));
                    std::fs::read(folder.join(name)).unwrap()
                };
                let packed = pack(1, "packed.lfold");
                assert_eq!(pack(3, "again.lfold"), packed, "±{bound} on three threads");
                let tolerance = if settings.is_empty() { bound } else { bound + 7 };
                for (frame, (shown, source)) in codes(&folder.join("packed.lfold")).iter().zip(&source).enumerate() {
                    for (&shown, &source) in shown.iter().zip(source) {
                        let background = (shown == u16::MAX) == (source == u16::MAX);
                        assert!(shown.abs_diff(source) <= tolerance && background, "±{bound}, frame {frame}");
                    }
                }
                fine(&format!("diff . packed.lfold --stream depth --max-error {tolerance}"), folder);
                if settings.is_empty() {
                    sizes.push(packed.len());
                }
            }
        }
        // The search takes the closest function, not the smallest one, so a file may grow from bound 0 to 1.
        assert!(sizes[5] < sizes[3] && sizes[3] < sizes[0], "larger bounds take fewer bytes: {sizes:?}");
    }
}

#[test]
fn bounds_that_cannot_be_kept_are_refused() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    scene(folder);
    fine(&format!("quadtree {SEQUENCE} --max-error 30 --effort fast -o tree.lfold"), folder);
    let said = refused("pack tree.lfold --max-error 31 -o x.lfold", folder);
    assert!(said.contains("built for at most ±30 codes"), "{said}");
    assert!(refused("pack tree.lfold --max-error 10% -o x.lfold", folder).contains("±30 codes"));
    fine("pack tree.lfold --max-error 30 -o packed.lfold", folder);
    assert!(refused("pack packed.lfold --max-error 10 -o x.lfold", folder).contains("lightfold quadtree"));
    for option in ["--optimize size", "--effort fast", "--depth-window 2", "--update-threshold 1", "--min-children 2"] {
        let said = refused(&format!("pack tree.lfold {option} -o x.lfold"), folder);
        assert!(said.contains("--max-error"), "{said}");
    }
    assert!(!folder.join("x.lfold").exists());
    fine("pack tree.lfold -o copied.lfold", folder);
    assert_eq!(std::fs::read(folder.join("copied.lfold")).unwrap(), std::fs::read(folder.join("tree.lfold")).unwrap());
}

#[test]
fn streams_that_are_no_trees_stay_what_they_are() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    scene(folder);
    fine(&format!("quadtree {SEQUENCE} --face px --effort fast -o tree.lfold"), folder);
    fine(&format!("encode-depth {SEQUENCE} --face nx --depth-codec aabb -o boxes.lfold"), folder);
    fine("pack boxes.lfold tree.lfold --max-error 0.1% -o all.lfold", folder);
    let (all, boxes) = (Reader::open(folder.join("all.lfold")).unwrap(), folder.join("boxes.lfold"));
    let boxes = Reader::open(boxes).unwrap();
    assert_eq!(all.index().streams[0], boxes.index().streams[0]);
    let (kept, given) = (all.index().stream_chunks(0), boxes.index().stream_chunks(0));
    assert_eq!(kept.len(), given.len());
    for (kept, given) in kept.iter().zip(given) {
        assert_eq!(all.fetch_stored(kept).unwrap(), boxes.fetch_stored(given).unwrap());
    }
    assert_eq!(CodecHeader::read(&all.index().streams[1]).unwrap().codec_name(), "quadtree");
}

#[test]
fn blocks_take_a_quarter_and_are_measured() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    scene(folder);
    let report = json(&format!("bc4w {SEQUENCE} --face px --effort fast -o blocks.lfold --json"), folder);
    assert_eq!((report["frames"].as_u64(), report["raw_bytes"].as_u64()), (Some(6), Some(6 * 4 * 90 * 90)));
    let blocks = Reader::open(folder.join("blocks.lfold")).unwrap();
    let bytes: u64 = blocks.index().chunks.iter().map(|chunk| u64::from(chunk.raw_bytes)).sum();
    assert_eq!(bytes, 6 * 32 * 12 * 12, "32 bytes for each 8x8 pixels");
    fine("decode blocks.lfold -o decoded", folder);
    fine("diff blocks.lfold decoded --exact", folder);

    let line = format!("bc4w {SEQUENCE} --stats --effort fast --json");
    let mut stats = json(&format!("{line} --threads 1"), folder);
    let mut again = json(&format!("{line} --threads 3 -o both.lfold"), folder);
    assert!(stats["seconds"].take().is_number() && again["seconds"].take().is_number());
    assert!(again.as_object_mut().unwrap().remove("encode").unwrap()["bytes"].is_number());
    for report in [&mut stats, &mut again] {
        report.as_object_mut().unwrap().remove("peak_memory_bytes");
    }
    assert_eq!(stats, again, "on one thread and on three");
    assert_eq!(stats["tiles"], 6 * 12 * 12);
    let difference = json("diff . blocks.lfold --stream depth --json", folder);
    assert_eq!(stats["max_error_codes"], difference["depth"]["max_error_codes"]);
    for model in ["bc4w", "platelet", "biquadratic", "best_of"] {
        for key in ["mean", "min", "p05", "p50", "p95"] {
            let value = &stats["psnr_db"][model][key];
            let is_exact = stats["psnr_db"][model][format!("{key}_is")] == "inf";
            assert!(is_exact || value.as_f64().is_some_and(|db| (0.0..130.0).contains(&db)), "{model} {key}");
        }
        let mean = |model: &str| stats["psnr_db"][model]["mean"].as_f64().unwrap();
        assert!(mean("best_of") >= mean(model));
        let of = &stats["psnr_db"][model];
        let bins = stats["histogram"]["tiles"][model].as_array().unwrap();
        let counted: u64 = bins.iter().map(|count| count.as_u64().unwrap()).sum();
        assert_eq!(counted + of["exact_tiles"].as_u64().unwrap(), 6 * 12 * 12);
    }
    assert!(stats["psnr_db"]["biquadratic"]["unmodelled_tiles"].as_u64() > Some(0));
    let text = String::from_utf8(fine(&format!("bc4w {SEQUENCE} --stats --effort fast"), folder).stdout).unwrap();
    assert!(text.lines().all(|line| line.chars().count() <= 100), "{text}");
    let said = refused(&format!("bc4w {SEQUENCE}"), folder);
    assert!(said.contains("-o") && said.contains("--stats"), "{said}");
    assert!(refused(&format!("bc4w {SEQUENCE} --stats -o -"), folder).contains("standard output"));
}
