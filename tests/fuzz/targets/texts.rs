//! Text files: manifests, cameras, entropy and lookup tables, CSV of sweeps, scans, file patterns and frame ranges.

use std::path::Path;

use cli::report::tradeoff::coding::CODING;
use cli::report::tradeoff::store::Store;
use codec::container::Reader;
use codec::decode::{Decoder, StreamFrames};
use codec::entropy::{Model, table_text};
use codec::image::{Face, FrameRange, Pattern, ReadLimits, StreamKind};
use evaluate::camera_file::CameraFile;
use evaluate::cameras::{self, Content, ReadSettings};
use footage::dataset::seurat::{SeuratCapture, SeuratView};
use footage::dataset::{Manifest, Source, SourceOptions};
use footage::encode::ScanFile;
use footage::image_files::lookup_table;
use render::views::camera_units::CameraUnits;
use tempfile::TempDir;

use super::{Judged, Verdict, judge, refused};

thread_local! {
    static SEEN: Decoder = Reader::from_memory(include_bytes!("../../vectors/valid/perspective.lfold").to_vec())
        .and_then(Decoder::new)
        .expect("a valid vector");
    static FOLDER: TempDir = TempDir::new().expect("a temporary folder");
}

/// Parses a manifest, writes it, parses it again, and opens it in a folder without its files.
pub fn run_manifest(bytes: &[u8]) -> Judged {
    let manifest = match Manifest::from_json(bytes) {
        Ok(manifest) => manifest,
        Err(error) => return refused(&error),
    };
    for kind in StreamKind::ALL {
        judge(&manifest.pattern(kind, "00", Face::Px))?;
    }
    let text = manifest.to_json().map_err(|error| format!("a manifest that was taken is not written: {error}"))?;
    match Manifest::from_json(text.as_bytes()) {
        Ok(again) if again == manifest => {}
        Ok(_) => return Err("a manifest comes back as another".into()),
        Err(error) => return Err(format!("a manifest that was written is refused: {error}")),
    }
    FOLDER.with(|folder| {
        let path = folder.path().join("lightfield.json");
        std::fs::write(&path, bytes).expect("the manifest is written");
        judge(&Source::open(&path, &SourceOptions::default())).map(|_| Verdict::Accepted)
    })
}

/// Parses a Seurat manifest, generates rays of its cameras, and reads its views, whose files do not exist.
pub fn run_seurat(bytes: &[u8]) -> Judged {
    let capture = FOLDER.with(|folder| SeuratCapture::from_json(bytes, folder.path()));
    let capture = match capture {
        Ok(capture) => capture,
        Err(error) => return refused(&error),
    };
    if let Some([least, greatest]) = capture.cameras_box()
        && least.cmpgt(greatest).any()
    {
        return Err(format!("the box around the cameras is inverted: {least} {greatest}"));
    }
    for view in &capture.views {
        check_rays(view)?;
        view.perspective();
        // A path of the input may name an existing file of this machine.
        if !view.color.path.exists() && !view.depth.path.exists() {
            judge(&view.read(&ReadLimits { max_image_bytes: 1 << 20 }))?;
        }
    }
    Ok(Verdict::Accepted)
}

fn check_rays(view: &SeuratView) -> Result<(), String> {
    let [width, height] = view.size();
    for pixel in [[0, 0], [width - 1, height / 2], [width / 3, height - 1]] {
        for depth in [0.0, 0.3, 1.0, 1e30, f32::INFINITY, f32::NAN, -1.0] {
            let ray = match view.camera.ray(pixel, depth) {
                Ok(ray) => ray,
                Err(error) => {
                    refused(&error)?;
                    continue;
                }
            };
            let is_good = ray.origin.is_finite() && ray.direction.is_normalized() && ray.distance_m > 0.0;
            if !is_good || (depth == 0.0 && ray.distance_m.is_finite()) || depth.is_nan() || depth < 0.0 {
                return Err(format!("the depth {depth} of pixel {pixel:?} gives {ray:?}"));
            }
        }
    }
    Ok(())
}

/// Parses cameras, and determines what they see of a container.
pub fn run_cameras(bytes: &[u8]) -> Judged {
    let cameras = match CameraFile::parse(bytes) {
        Ok(cameras) => cameras,
        Err(error) => return refused(&error),
    };
    let seen = SEEN.with(|decoder| {
        let all = decoder.streams().iter().map(|stream| StreamFrames { stream, frames: stream.frames });
        let chosen: Vec<_> = all.collect();
        CameraUnits::find(decoder, &chosen, &cameras).counts
    });
    if seen.visible_units > seen.units {
        Err(format!("more is seen than there is: {seen:?}"))
    } else {
        Ok(Verdict::Accepted)
    }
}

/// Parses the cameras of a USD file.
pub fn run_usda(bytes: &[u8]) -> Judged {
    judge(&cameras::parse(&Content { path: Path::new("a.usda"), bytes, settings: ReadSettings::with_fps(24.0) }))
}

/// Parses entropy tables of a model, writes them and parses them again.
pub fn run_tables<M: Model + PartialEq>(bytes: &[u8]) -> Judged {
    let sets = match table_text::read::<M>(bytes) {
        Ok(sets) => sets,
        Err(error) => return refused(&error),
    };
    match table_text::read(table_text::write(&sets).as_bytes()) {
        Ok(again) if again == sets => Ok(Verdict::Accepted),
        _ => Err("entropy tables come back as others".into()),
    }
}

/// Opens the CSV of a sweep, writes it and opens it again.
pub fn run_sweep(bytes: &[u8]) -> Judged {
    FOLDER.with(|folder| {
        let path = folder.path().join(CODING.csv_name());
        std::fs::write(&path, bytes).expect("the CSV is written");
        let store = match Store::open(&CODING, folder.path(), None) {
            Ok(store) => store,
            Err(error) => return refused(&error),
        };
        let text = store.text().map_err(|error| format!("a sweep that was taken is not written: {error}"))?;
        std::fs::write(&path, &text).expect("the CSV is written");
        match Store::open(&CODING, folder.path(), None).and_then(|again| again.text()) {
            Ok(again) if again == text => Ok(Verdict::Accepted),
            Ok(_) => Err("a sweep comes back as another".into()),
            Err(error) => Err(format!("a sweep that was written is refused: {error}")),
        }
    })
}

/// Reads a scan of footage, writes it, reads it again and merges it.
pub fn run_scan(bytes: &[u8]) -> Judged {
    FOLDER.with(|folder| {
        let path = folder.path().join("scan.json");
        std::fs::write(&path, bytes).expect("the scan is written");
        let scan = match ScanFile::read(&path) {
            Ok(scan) => scan,
            Err(error) => return refused(&error),
        };
        scan.missing();
        let text = scan.to_json().map_err(|error| format!("a scan that was taken is not written: {error}"))?;
        std::fs::write(&path, &text).expect("the scan is written");
        match ScanFile::read(&path).and_then(|again| again.to_json()) {
            Ok(again) if again == text => {}
            Ok(_) => return Err("a scan comes back as another".into()),
            Err(error) => return Err(format!("a scan that was written is refused: {error}")),
        }
        let mut joined = scan;
        judge(&ScanFile::read(&path).and_then(|other| joined.merge(other)))
    })
}

/// Parses a file name pattern and a frame range, formats them and parses them again.
pub fn run_patterns(bytes: &[u8]) -> Judged {
    let Ok(text) = std::str::from_utf8(bytes) else { return Ok(Verdict::Refused) };
    let range = text.parse::<FrameRange>();
    if let Ok(range) = &range {
        let shown = range.to_string();
        if shown.parse::<FrameRange>().ok() != Some(*range) {
            return Err(format!("the range {text:?} is shown as {shown:?}"));
        }
        range.count();
    }
    judge(&range)?;
    let pattern = match Pattern::parse(text) {
        Ok(pattern) => pattern,
        Err(error) => return refused(&error),
    };
    for frame in [0, 7, 9999, u32::MAX] {
        pattern.path(frame);
    }
    let shown = pattern.to_string();
    match Pattern::parse(&shown) {
        Ok(again) if again.path(12) == pattern.path(12) => {}
        other => return Err(format!("the pattern {text:?} is shown as {shown:?}, which is {other:?}")),
    }
    let below = pattern.below(Path::new("folder"));
    below.path(3);
    Ok(Verdict::Accepted)
}

/// Parses a lookup table, and applies it to all kinds of numbers.
pub fn run_cube(bytes: &[u8]) -> Judged {
    let table = match lookup_table::parse(&mut &*bytes) {
        Ok(table) => table,
        Err(error) => return refused(&error),
    };
    for rgb in [[0.0, 0.5, 1.0], [-1e30, f32::INFINITY, f32::NAN], [f32::NEG_INFINITY, 1e-40, 222.0]] {
        let found = table.apply(rgb);
        if found.iter().any(|value| value.is_nan()) {
            return Err(format!("{rgb:?} becomes {found:?}"));
        }
    }
    Ok(Verdict::Accepted)
}

/// Texts become trees and rows of words: some hundred bytes per word of a few bytes, and file buffers.
pub fn bound(bytes: &[u8]) -> u64 {
    (2 << 20) + 256 * bytes.len() as u64
}
