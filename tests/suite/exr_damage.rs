//! EXR files whose chunks claim more bytes than their pixels or the file allow: refused with one sentence, before memory is
//! allocated.

use std::io::{Seek, SeekFrom, Write};
use std::path::Path;

use codec::image::{ChannelSelect, ReadLimits};
use exr::meta::MetaData;
use exr::prelude::{Blocks, Compression, FlatSamples, IntegerBounds, Vec2};
use footage::image_files::exr as ours;
use half::f16;
use tempfile::TempDir;

use crate::exr_files::{Part, write_parts};
use crate::input::{assert_says, message};

const AUTO: ChannelSelect = ChannelSelect::Auto;
const COMPRESSIONS: [Compression; 10] = [
    Compression::Uncompressed,
    Compression::RLE,
    Compression::ZIP1,
    Compression::ZIP16,
    Compression::PIZ,
    Compression::PXR24,
    Compression::B44,
    Compression::B44A,
    Compression::DWAA(None),
    Compression::DWAB(None),
];

/// Writes colour and alpha as half floats, and depth as floats: all kinds of channels that DWA distinguishes.
fn write_mixed(path: &Path, compression: Compression, blocks: Blocks, size: [usize; 2]) {
    let count = size[0] * size[1];
    let halves = |step: usize| FlatSamples::F16((0..count).map(|i| f16::from_f32((i / 8 * step % 5) as f32)).collect());
    let depth = FlatSamples::F32((0..count).map(|i| 1.0 + (i / 8 % 3) as f32).collect());
    let channels = vec![("R", halves(1)), ("G", halves(3)), ("B", halves(7)), ("A", halves(0)), ("Z", depth)];
    let part = Part { name: None, position: [0, 0], size, channels };
    write_parts(path, IntegerBounds::from_dimensions((size[0], size[1])), compression, blocks, vec![part]);
}

/// Returns the offset of the first chunk in a file of one part.
fn first_chunk(file: &[u8]) -> usize {
    let mut rest = std::io::Cursor::new(file);
    MetaData::read_from_buffered(&mut rest, true).unwrap();
    let at = rest.position() as usize;
    u64::from_le_bytes(file[at..at + 8].try_into().unwrap()) as usize
}

fn read_all(path: &Path) -> Result<(), String> {
    let limits = ReadLimits { max_image_bytes: 1 << 20 };
    let depth = ours::read_depth(path, &AUTO, &limits);
    let color = ours::read_color(path, &AUTO, &limits);
    let alpha = ours::read_rgba(path, &limits);
    match [depth.err(), color.err(), alpha.err()].into_iter().flatten().next() {
        Some(said) => Err(said.to_string()),
        None => Ok(()),
    }
}

#[test]
fn counters_of_dwa_chunks_are_bounded_by_their_pixels() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("counters.exr");
    for compression in [Compression::DWAA(None), Compression::DWAB(None)] {
        write_mixed(&path, compression, Blocks::ScanLines, [64, 48]);
        read_all(&path).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        // The chunk's line number and size (8 bytes) and its version (8 bytes) precede nine counters.
        let counters = first_chunk(&bytes) + 8 + 8;
        for counter in 0..9 {
            for value in [u64::MAX, i64::MAX as u64, 1 << 50, 1 << 32, 1 << 24] {
                let mut damaged = bytes.clone();
                damaged[counters + 8 * counter..][..8].copy_from_slice(&value.to_le_bytes());
                std::fs::write(&path, &damaged).unwrap();
                let place = format!("the chunk at byte {} claims {value} ", first_chunk(&bytes));
                assert_says(&read_all(&path).unwrap_err(), &["counters.exr", &place]);
            }
            // One flipped bit of a counter.
            for bit in 0..64 {
                let mut damaged = bytes.clone();
                damaged[counters + 8 * counter + bit / 8] ^= 1 << (bit % 8);
                std::fs::write(&path, &damaged).unwrap();
                let _ = read_all(&path);
            }
        }
    }
}

#[test]
fn run_length_sections_beyond_the_pixels_are_refused() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("bomb.exr");
    // A valid chunk of 2048x256 pixels, in a file that claims 8x256.
    let zeros = FlatSamples::F16(vec![f16::ZERO; 2048 * 256]);
    let part = Part { name: None, position: [0, 0], size: [2048, 256], channels: vec![("A", zeros)] };
    let display = IntegerBounds::from_dimensions((2048, 256));
    write_parts(&path, display, Compression::DWAB(None), Blocks::ScanLines, vec![part]);
    let mut bytes = std::fs::read(&path).unwrap();
    for name in ["dataWindow", "displayWindow"] {
        let head = format!("{name}\0box2i\0");
        let at = bytes.windows(head.len()).position(|window| window == head.as_bytes()).unwrap() + head.len() + 4;
        bytes[at + 8..at + 12].copy_from_slice(&7i32.to_le_bytes());
    }
    std::fs::write(&path, &bytes).unwrap();
    let said = message(ours::read_alpha(&path, &AUTO, &AUTO, &ReadLimits::default()));
    assert_says(&said, &["bomb.exr", "claims 1048576 bytes of run-length coded channels, where 4096 at most"]);
}

#[test]
fn sizes_of_chunks_are_bounded_by_the_file() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("size.exr");
    for compression in COMPRESSIONS {
        for (blocks, words) in [(Blocks::ScanLines, 1), (Blocks::Tiles(Vec2(16, 16)), 4)] {
            write_mixed(&path, compression, blocks, [32, 32]);
            read_all(&path).unwrap();
            let mut bytes = std::fs::read(&path).unwrap();
            let at = first_chunk(&bytes) + 4 * words;
            for value in [i32::MAX, -1, i32::MIN, 1 << 24] {
                bytes[at..at + 4].copy_from_slice(&value.to_le_bytes());
                std::fs::write(&path, &bytes).unwrap();
                let said = read_all(&path).unwrap_err();
                assert_says(&said, &["size.exr", &format!("claims {value} bytes"), "left in the file"]);
            }
        }
    }
}

#[test]
fn blocks_of_b44_that_step_below_zero_are_refused() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("b44.exr");
    for compression in [Compression::B44, Compression::B44A] {
        let halves = FlatSamples::F16((0..256).map(|i| f16::from_f32((i * 7 % 31) as f32)).collect());
        let part = Part { name: None, position: [0, 0], size: [16, 16], channels: vec![("Z", halves)] };
        write_parts(&path, IntegerBounds::from_dimensions((16, 16)), compression, Blocks::ScanLines, vec![part]);
        let mut bytes = std::fs::read(&path).unwrap();
        ours::read_depth(&path, &AUTO, &ReadLimits::default()).unwrap();
        // A first sample of 0, a shift of 12, and downward steps.
        let block = first_chunk(&bytes) + 8;
        bytes[block..block + 14].copy_from_slice(&[0, 0, 12 << 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]);
        std::fs::write(&path, &bytes).unwrap();
        let said = message(ours::read_depth(&path, &AUTO, &ReadLimits::default()));
        assert_says(&said, &["b44.exr", "step below zero"]);
    }
}

/// Changes each byte of files in all compressions: file headers, chunk headers and payloads.
#[cfg_attr(not(all_tests), ignore = "long: scripts/test all runs it")]
#[test]
fn every_changed_byte_is_read_or_refused() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("changed.exr");
    let limits = ReadLimits { max_image_bytes: 1 << 20 };
    let mut refused = 0;
    for compression in COMPRESSIONS {
        for blocks in [Blocks::ScanLines, Blocks::Tiles(Vec2(24, 8))] {
            write_mixed(&path, compression, blocks, [24, 16]);
            let bytes = std::fs::read(&path).unwrap();
            // Written in place, because file systems sync a file that is truncated and written again.
            let mut file = std::fs::OpenOptions::new().write(true).open(&path).unwrap();
            let mut put = |at: usize, value: u8| {
                file.seek(SeekFrom::Start(at as u64)).unwrap();
                file.write_all(&[value]).unwrap();
            };
            for (at, &byte) in bytes.iter().enumerate() {
                for value in [byte ^ 0x80, 0xff] {
                    put(at, value);
                    if let Err(said) = ours::read_channels(&path, ["R", "G", "B", "A", "Z"], &limits) {
                        refused += 1;
                        let said = said.to_string();
                        assert_says(&said, &["changed.exr"]);
                        assert!(!said.contains('\n'), "{said}");
                    }
                }
                put(at, byte);
            }
        }
    }
    assert!(refused > 1000, "{refused}");
}

#[test]
fn reading_takes_at_least_its_pixels_and_its_largest_chunk() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("memory.exr");
    let limits = ReadLimits::default();
    for compression in COMPRESSIONS {
        write_mixed(&path, compression, Blocks::ScanLines, [64, 512]);
        let lines = ours::reading_bytes(&path, 6, &limits).unwrap();
        write_mixed(&path, compression, Blocks::Tiles(Vec2(64, 512)), [64, 512]);
        let tile = ours::reading_bytes(&path, 6, &limits).unwrap();
        assert!(lines >= 64 * 512 * 6, "{compression}: {lines}");
        assert!(tile >= lines, "{compression}: {tile} of one tile, {lines} of lines");
    }
}

#[test]
fn names_that_every_channel_repeats_are_bounded() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("names.exr");
    let name = "n".repeat(100_000);
    let channels = vec![("Z", FlatSamples::F32(vec![1.0; 12]))];
    let part = Part { name: Some(&name), position: [0, 0], size: [4, 3], channels };
    write_parts(&path, IntegerBounds::from_dimensions((4, 3)), Compression::ZIP1, Blocks::ScanLines, vec![part]);
    let said = message(ours::read_depth(&path, &AUTO, &ReadLimits::default()));
    assert_says(&said, &["names.exr", "100000 bytes"]);
    assert!(said.len() < 1000, "{}", said.len());
}

#[test]
fn commands_refuse_a_damaged_file_with_one_sentence() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("abort.0000.exr");
    write_mixed(&path, Compression::DWAA(None), Blocks::ScanLines, [16, 16]);
    let mut bytes = std::fs::read(&path).unwrap();
    // The counter of AC coefficients.
    let at = first_chunk(&bytes) + 8 + 8 * 8;
    bytes[at + 6] = 4;
    std::fs::write(&path, &bytes).unwrap();
    for command in ["encode-color", "encode-depth --max-error 0"] {
        let mut lightfold = assert_cmd::Command::cargo_bin("lightfold").unwrap();
        let ran = lightfold
            .current_dir(folder.path())
            .args(command.split(' '))
            .args(["abort.%04d.exr", "-o", "out.lfold"])
            .output()
            .unwrap();
        let said = String::from_utf8_lossy(&ran.stderr).into_owned();
        assert_eq!(ran.status.code(), Some(2), "{command}: {said}");
        assert!(!folder.path().join("out.lfold").exists(), "{command}");
        assert_says(&said, &["abort.0000.exr", "AC coefficients"]);
    }
}
