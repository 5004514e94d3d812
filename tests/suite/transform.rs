//! The transform codec through the library: footage is encoded and decoded, and every frame of every cell meets its quality
//! target.

use codec::color::{SearchSettings, Target};
use codec::container::Compression;
use codec::decode::Picture;
use codec::effort::Effort;
use codec::image::{ColorPlane, Face, Plane};
use codec::memory::Budget;
use codec::streams::ColorFormat;
use footage::encode::{ColorCodec, EncodeSettings};
use footage::inspect::{TransformCount, statistics};
use half::f16;
use tempfile::TempDir;

use crate::footage::{Footage, Random, drifting_color};
use crate::roundtrip::{check_color8, check_half, decoder, encoded};

const HALF: ColorFormat = ColorFormat::Half { white_cd_m2: 100.0 };

fn settings(cell: u32, color_chunk: u32, min_psnr_db: f64) -> EncodeSettings {
    let search =
        SearchSettings { target: Target::Psnr(min_psnr_db), effort: Effort::Fast, ..SearchSettings::default() };
    EncodeSettings { cell, color_chunk, search, compression: Compression::None, ..EncodeSettings::default() }
}

fn counts(bytes: &[u8]) -> TransformCount {
    statistics(&decoder(bytes)).unwrap().streams[0].transform
}

#[test]
fn cells_of_any_size_keep_the_promise() {
    for (width, height, cell) in [(1, 1, 64), (3, 5, 64), (33, 65, 64), (100, 3, 40), (37, 29, 16), (251, 250, 251)] {
        let folder = TempDir::new().unwrap();
        let color = |_: Face, frame: u32| drifting_color(width, height, frame);
        let source = Footage { color: Some(&color), frames: [3, 8], ..Footage::new(width, height) }.open(folder.path());
        for db in [30.0, 48.0] {
            let bytes = encoded(&source, &settings(cell, 24, db));
            check_color8(&source, &bytes, db);
            let bytes = encoded(&source, &EncodeSettings { color: HALF, ..settings(cell, 4, db) });
            check_half(&source, &bytes, db);
        }
    }
}

#[test]
fn chunks_of_any_length_keep_the_promise_and_each_decodes_alone() {
    let folder = TempDir::new().unwrap();
    let color = |_: Face, frame: u32| drifting_color(40, 24, frame);
    let source = Footage { color: Some(&color), frames: [0, 99], ..Footage::new(40, 24) }.open(folder.path());
    for length in [1, 2, 3, 5, 7, 24, 25, 96] {
        let bytes = encoded(&source, &settings(24, length, 42.0));
        check_color8(&source, &bytes, 42.0);
        let decoder = decoder(&bytes);
        let stream = &decoder.streams()[0];
        let chunks = decoder.reader().index().unit_chunks(0, 0);
        assert!(chunks.iter().all(|chunk| chunk.key.first_frame % length == 0 && chunk.key.frame_count <= length));
        // Frames decode to the same image in any order, and decoding the current frame again writes no pixels.
        let mut face = decoder.face(stream);
        let shown: Vec<Picture> = stream.frames.iter().map(|frame| face.decode(frame).unwrap()).collect();
        let mut random = Random(u64::from(length));
        for frame in (0..40).map(|_| random.below(100)) {
            assert!(face.decode(frame).unwrap() == shown[frame as usize], "length {length} frame {frame}");
            let before = face.cost().updated_pixels;
            face.decode(frame).unwrap();
            assert_eq!(face.cost().updated_pixels, before);
            assert!(decoder.face(stream).decode(frame).unwrap() == shown[frame as usize]);
        }
    }
}

/// Returns noise on the left, and static flat areas with sharp edges on the right.
fn noise_and_graphics(_: Face, frame: u32) -> ColorPlane {
    let mut random = Random(u64::from(frame));
    Plane::from_fn(64, 32, |x, y| {
        let noise = [random.below(256), random.below(256), random.below(256)].map(|v| v as f32 / 255.0);
        let flat = if (x / 5 + y / 3) % 3 == 0 { [0.9, 0.1, 0.1] } else { [0.1, 0.2, 0.7] };
        if x < 32 { noise } else { flat }.map(f16::from_f32)
    })
}

#[test]
fn noise_is_stored_as_keyframes_and_flat_graphics_as_palettes() {
    let folder = TempDir::new().unwrap();
    let source =
        Footage { color: Some(&noise_and_graphics), frames: [0, 9], ..Footage::new(64, 32) }.open(folder.path());
    for color in [EncodeSettings::default().color, HALF] {
        let settings = EncodeSettings { color, ..settings(32, 5, 80.0) };
        let bytes = encoded(&source, &settings);
        let count = counts(&bytes);
        assert_eq!((count.transform_chunks, count.cells_chunks), (2, 2), "{count:?}");
        assert!(count.palette_blocks > 0, "{count:?}");
        match color {
            ColorFormat::EightBit(_) => drop(check_color8(&source, &bytes, 80.0)),
            ColorFormat::Half { .. } => check_half(&source, &bytes, 80.0),
        }
        // With the cells codec, the same quality target takes more bytes.
        let cells = encoded(&source, &EncodeSettings { color_codec: ColorCodec::Cells, ..settings });
        assert!(bytes.len() < cells.len(), "{} bytes, {} as cells", bytes.len(), cells.len());
    }
}

#[test]
fn the_same_bytes_on_any_number_of_threads_and_in_any_memory() {
    let folder = TempDir::new().unwrap();
    let color = |_: Face, frame: u32| drifting_color(64, 48, frame);
    let source = Footage { color: Some(&color), frames: [0, 19], ..Footage::new(64, 48) }.open(folder.path());
    let settings = settings(16, 8, 42.0);
    let encode = |threads, memory: Option<u64>| {
        let settings = EncodeSettings { memory: memory.map_or(Budget::UNLIMITED, Budget::of), ..settings.clone() };
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| encoded(&source, &settings))
    };
    let alone = encode(1, None);
    assert!(alone == encode(2, None) && alone == encode(7, None) && alone == encode(4, Some(3 << 20)));
}

/// Returns noise that increases with each frame.
fn rising_noise(_: Face, frame: u32) -> ColorPlane {
    let mut random = Random(u64::from(frame) + 1);
    Plane::from_fn(64, 64, |x, y| {
        let smooth = (x + 2 * y) as f32 / 512.0;
        [(); 3].map(|()| f16::from_f32(smooth + (0.02 + 0.01 * frame as f32) * random.below(1000) as f32 / 1000.0))
    })
}

#[test]
fn all_frames_of_a_chunk_come_close_to_the_promise() {
    let folder = TempDir::new().unwrap();
    let source = Footage { color: Some(&rising_noise), frames: [0, 5], ..Footage::new(64, 64) }.open(folder.path());
    let normal = SearchSettings { effort: Effort::Normal, target: Target::Psnr(40.0), ..SearchSettings::default() };
    let bytes = encoded(&source, &EncodeSettings { search: normal, ..settings(64, 6, 40.0) });
    let frames = check_color8(&source, &bytes, 40.0);
    // The first frame has so little noise that it exceeds the target even without any coefficient.
    let mean = frames.iter().sum::<f64>() / frames.len() as f64;
    assert!(mean < 40.6 && frames[2..].iter().all(|psnr| (40.0..40.4).contains(psnr)), "{frames:?}");
}

#[test]
fn a_constant_quantiser_has_one_step_and_promises_nothing() {
    let folder = TempDir::new().unwrap();
    let source = Footage { color: Some(&rising_noise), frames: [0, 5], ..Footage::new(64, 64) }.open(folder.path());
    let at = |step: u8| {
        let search = SearchSettings { target: Target::Step(step), ..SearchSettings::default() };
        let bytes = encoded(&source, &EncodeSettings { search, ..settings(64, 6, 0.0) });
        let frames = check_color8(&source, &bytes, 0.0);
        (bytes.len(), frames.iter().sum::<f64>() / frames.len() as f64)
    };
    let sizes = [0, 40, 80, 120, 240].map(at);
    assert!(sizes.is_sorted_by(|finer, coarser| finer.0 > coarser.0 && finer.1 > coarser.1), "{sizes:?}");
    assert!(sizes[0].1 > 50.0 && sizes[4].1 < 30.0, "{sizes:?}");
}
