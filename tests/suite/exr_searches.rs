//! EXR files that the `exr` crate takes long to decode: long lists of Huffman codes, and many channels. They are refused before
//! their chunks are decoded. No test measures time.

use std::path::Path;

use codec::image::{ChannelSelect, ReadLimits};
use exr::prelude::{Blocks, Compression, FlatSamples, IntegerBounds, Vec2};
use footage::image_files::exr as ours;
use half::f16;
use tempfile::TempDir;

use crate::exr_files::{Part, write_parts};
use crate::input::assert_says;
use crate::samples::Random;

const PIZ: u8 = 4;
const DWAA: u8 = 8;
/// Rows of a chunk, in both compressions.
const ROWS: u32 = 32;
/// Number of samples in a chunk of 2048x32 pixels; its raw size is above that of the Huffman code.
const SAMPLES: usize = 2048 * 32;

/// Bit writer, most significant bit first.
#[derive(Default)]
struct Bits {
    bytes: Vec<u8>,
    count: usize,
}

impl Bits {
    fn put(&mut self, value: u64, count: usize) {
        for at in (0..count).rev() {
            if self.count.is_multiple_of(8) {
                self.bytes.push(0);
            }
            *self.bytes.last_mut().unwrap() |= ((value >> at & 1) as u8) << (7 - self.count % 8);
            self.count += 1;
        }
    }
}

/// Returns a Huffman code with codes of 1 to 14 bits, and 65,523 codes that begin with 14 zeros. The last of these, which the
/// crate finds after all others, is written `times` times; run codes then repeat it up to `samples` samples.
fn long_list(times: usize, samples: usize) -> Vec<u8> {
    let length = |symbol: u64| match symbol {
        0..=12 => symbol + 1,
        13..=25 => 29,
        65_536 => 14,
        _ => 30,
    };
    let (mut table, mut coded) = (Bits::default(), Bits::default());
    (0..=65_536).for_each(|symbol| table.put(length(symbol), 6));
    (0..times).for_each(|_| coded.put(65_509, 30));
    let mut left = samples.saturating_sub(times) as u64;
    while left > 0 {
        // The run code of 14 bits, then the run length.
        coded.put(1, 14);
        coded.put(left.min(255), 8);
        left -= left.min(255);
    }
    let head = [0, 65_536, table.bytes.len() as u32, coded.count as u32, 0];
    [head.map(u32::to_le_bytes).as_flattened(), &table.bytes, &coded.bytes].concat()
}

/// Returns a PIZ chunk with an empty bitmap.
fn piz(code: &[u8]) -> Vec<u8> {
    [&[1, 0, 0, 0][..], &(code.len() as i32).to_le_bytes(), code].concat()
}

/// Returns a DWA chunk with `coefficients` AC coefficients, and `rules` copies of a channel rule for R.
fn dwa(code: &[u8], coefficients: u64, rules: usize) -> Vec<u8> {
    let rules = b"R\0\x14\x01".repeat(rules);
    let counters = [2, 0, 0, code.len() as u64, 0, 0, 0, 0, coefficients, 0, 0].map(u64::to_le_bytes);
    [counters.as_flattened(), &(rules.len() as u16 + 2).to_le_bytes(), &rules, code].concat()
}

/// Returns a scan-line file with one part of half-float channels.
fn file(compression: u8, [width, height]: [u32; 2], channels: &[String], chunks: &[Vec<u8>]) -> Vec<u8> {
    let window = [0, 0, width - 1, height - 1].map(u32::to_le_bytes).concat();
    let channel = |name: &String| {
        let words = [1u32, 0, 1, 1].map(u32::to_le_bytes).concat();
        [name.as_bytes(), &[0], &words].concat()
    };
    let list: Vec<u8> = channels.iter().flat_map(channel).chain([0]).collect();
    let attributes: [(&str, &str, &[u8]); 8] = [
        ("channels", "chlist", &list),
        ("compression", "compression", &[compression]),
        ("dataWindow", "box2i", &window),
        ("displayWindow", "box2i", &window),
        ("lineOrder", "lineOrder", &[0]),
        ("pixelAspectRatio", "float", &1f32.to_le_bytes()),
        ("screenWindowCenter", "v2f", &[0; 8]),
        ("screenWindowWidth", "float", &1f32.to_le_bytes()),
    ];
    let mut bytes = vec![0x76, 0x2f, 0x31, 0x01, 2, 0, 0, 0];
    for (name, kind, value) in attributes {
        bytes.extend(
            [name.as_bytes(), &[0], kind.as_bytes(), &[0], &(value.len() as u32).to_le_bytes(), value].concat(),
        );
    }
    bytes.push(0);
    let mut place = bytes.len() + 8 * chunks.len();
    for chunk in chunks {
        bytes.extend((place as u64).to_le_bytes());
        place += 8 + chunk.len();
    }
    for (row, chunk) in (0..).step_by(ROWS as usize).zip(chunks) {
        bytes.extend([u32::to_le_bytes(row), (chunk.len() as u32).to_le_bytes()].concat());
        bytes.extend(chunk);
    }
    bytes
}

fn names(count: usize, name: impl Fn(usize) -> String) -> Vec<String> {
    let mut names: Vec<String> = (0..count).map(name).collect();
    names.sort();
    names
}

fn read(path: &Path, bytes: &[u8]) -> Result<(), String> {
    std::fs::write(path, bytes).unwrap();
    let limits = ReadLimits::default();
    let named = |name: &str| ChannelSelect::Named(name.into());
    let first = ours::read_header(path, &limits).map_err(|error| error.to_string());
    first?;
    ours::read_depth(path, &named("R"), &limits).map(|_| ()).map_err(|error| error.to_string())
}

#[test]
fn long_lists_of_codes_are_refused_before_they_are_searched() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("lists.exr");
    let red = names(1, |_| "R".into());
    let of_piz = |times: usize| file(PIZ, [2048, 32], &red, &[piz(&long_list(times, SAMPLES))]);
    read(&path, &of_piz(512)).unwrap();
    let said = read(&path, &of_piz(2048)).unwrap_err();
    assert_says(&said, &["lists.exr", "to 134191104", "save the image with ZIP compression"]);
    // The steps of all chunks of a file are added up.
    let many = file(PIZ, [2048, 32 * 4], &red, &vec![piz(&long_list(512, SAMPLES)); 4]);
    assert_says(&read(&path, &many).unwrap_err(), &["lists.exr", "steps"]);
    let of_dwa = |times: usize| file(DWAA, [2048, 32], &red, &[dwa(&long_list(times, 0), times as u64, 1)]);
    // The channel rule adds three comparisons.
    assert_says(&read(&path, &of_dwa(2048)).unwrap_err(), &["lists.exr", "to 134191107"]);
    let without_end = read(&path, &of_dwa(512)).unwrap_err();
    assert!(!without_end.contains("steps"), "{without_end}");
}

#[test]
fn codes_that_are_not_complete_count_as_their_longest_list() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("open.exr");
    let red = names(1, |_| "R".into());
    // Clears the length of the only 1-bit code.
    let mut code = long_list(4096, SAMPLES);
    code[20] &= 0x03;
    let said = read(&path, &file(PIZ, [2048, 32], &red, &[piz(&code)])).unwrap_err();
    assert_says(&said, &["open.exr", "steps", "allowed"]);
}

#[test]
fn channels_that_dwa_compares_with_each_other_are_counted() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("channels.exr");
    let layers = |count: usize| names(count, |at| format!("{at:04}.R"));
    let chunk = |rules: usize| dwa(&[], 0, rules);
    let wide = |channels: &[String], rules: usize| file(DWAA, [16, 32], channels, &[chunk(rules)]);
    let select = |bytes: &[u8], name: &str| {
        std::fs::write(&path, bytes).unwrap();
        let read = ours::read_depth(&path, &ChannelSelect::Named(name.into()), &ReadLimits::default());
        read.map(|_| ()).map_err(|error| error.to_string())
    };
    // 300 layers, as renderers write them, with the channel rules of OpenEXR.
    let usual = select(&wide(&layers(300), 15), "0000.R").unwrap_err();
    assert!(!usual.contains("steps"), "{usual}");
    let said = select(&wide(&layers(4096), 15), "0000.R").unwrap_err();
    assert_says(&said, &["channels.exr", "steps", "allowed"]);
    let said = select(&wide(&layers(100), 16_000), "0000.R").unwrap_err();
    assert_says(&said, &["channels.exr", "steps", "allowed"]);
}

#[test]
fn channels_are_counted_over_all_parts() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("parts.exr");
    let all = names(2049, |channel| format!("{channel:04}.Depth.R"));
    let write = |counts: [usize; 2]| {
        let part = |(name, count)| {
            let channel = |name| (String::as_str(name), FlatSamples::F16(vec![f16::ZERO]));
            let channels = all.iter().take(count).map(channel).collect();
            Part { name: Some(name), position: [0, 0], size: [1, 1], channels }
        };
        let display = IntegerBounds::from_dimensions((1, 1));
        let parts = [("a", counts[0]), ("b", counts[1])].map(part).into();
        write_parts(&path, display, Compression::ZIP1, Blocks::ScanLines, parts);
    };
    write([2048, 2048]);
    let said = ours::read_depth(&path, &ChannelSelect::Auto, &ReadLimits::default()).unwrap_err().to_string();
    assert_says(&said, &["parts.exr", "no depth channel with a common name"]);
    write([2048, 2049]);
    let said = ours::read_depth(&path, &ChannelSelect::Auto, &ReadLimits::default()).unwrap_err().to_string();
    assert_says(&said, &["parts.exr", "4097 channels, but at most 4096 are supported"]);
}

#[test]
fn rare_values_of_large_tiles_are_read() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("rare.exr");
    let mut random = Random(3);
    let size = [2048, 1024];
    // Thousands of values that occur once have codes in the same list.
    let mut values = vec![f16::ZERO; size[0] * size[1]];
    (0..3000).for_each(|_| {
        let at = random.below((size[0] * size[1]) as u32) as usize;
        values[at] = f16::from_bits(random.below(0x7c00) as u16);
    });
    let channels = vec![("Z", FlatSamples::F16(values.clone()))];
    let part = Part { name: None, position: [0, 0], size, channels };
    let display = IntegerBounds::from_dimensions((size[0], size[1]));
    write_parts(&path, display, Compression::PIZ, Blocks::Tiles(Vec2(size[0], size[1])), vec![part]);
    let plane = ours::read_depth(&path, &ChannelSelect::Auto, &ReadLimits::default()).unwrap();
    assert!(plane.data().iter().zip(&values).all(|(read, value)| *read == value.to_f32()));
}
