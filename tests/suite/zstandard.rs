//! Small Zstandard frames and all their one-bit changes (tests/vectors/zstandard): all decoders of the repository agree on them,
//! and none accepts more than RFC 8878 allows (container.md 6.2).

use std::collections::BTreeSet;
use std::fs;
use std::io::Write;
use std::path::PathBuf;

use codec::container::zstd;
use lightfold::Error;

use crate::samples::Random;
use crate::vectors;

struct Frame {
    name: &'static str,
    raw: Vec<u8>,
    stored: Vec<u8>,
}

fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/vectors/zstandard")
}

/// Returns a frame of libzstd with a window of 2^`window_log` bytes and a block for each part.
fn in_blocks(name: &'static str, (level, window_log): (i32, u32), parts: &[Vec<u8>]) -> Frame {
    let raw = parts.concat();
    let mut encoder = ::zstd::stream::Encoder::new(Vec::new(), level).unwrap();
    encoder.set_pledged_src_size(Some(raw.len() as u64)).unwrap();
    encoder.include_contentsize(true).unwrap();
    encoder.window_log(window_log).unwrap();
    for part in parts {
        encoder.write_all(part).unwrap();
        encoder.flush().unwrap();
    }
    Frame { name, raw, stored: encoder.finish().unwrap() }
}

fn in_one(name: &'static str, level: i32, raw: Vec<u8>) -> Frame {
    let stored = ::zstd::bulk::compress(&raw, level).unwrap();
    Frame { name, raw, stored }
}

/// Returns a frame with a window and raw, RLE and empty blocks.
fn by_hand() -> Frame {
    let mut stored = vec![0x28, 0xb5, 0x2f, 0xfd, 0x80, 0x00, 27, 0, 0, 0];
    for (size, kind, last, bytes) in [(4, 0, 0, &b"abcd"[..]), (0, 0, 0, b""), (20, 1, 0, b"x"), (3, 0, 1, b"end")] {
        stored.extend_from_slice(&u32::to_le_bytes(size << 3 | kind << 1 | last)[..3]);
        stored.extend_from_slice(bytes);
    }
    Frame { name: "raw-and-repeated-bytes", raw: [&b"abcd"[..], &[b'x'; 20], b"end"].concat(), stored }
}

/// Returns bytes drawn from a few values, the first of which is the most frequent.
fn skewed(count: usize, symbols: u32, seed: u64) -> Vec<u8> {
    let mut random = Random(seed);
    (0..count).map(|_| (0..3).map(|_| random.below(symbols)).min().unwrap_or(0) as u8 + b'a').collect()
}

/// Returns rows of twelve bytes, eight of which are equal in all rows.
fn records(count: u32) -> Vec<u8> {
    let row = |at: u32| [&b"depthmap"[..], &(at.wrapping_mul(2_654_435_761)).to_le_bytes()].concat();
    (0..count).flat_map(row).collect()
}

fn frames() -> Vec<Frame> {
    let few: Vec<u8> = skewed(90, 5, 3).into_iter().map(|byte| byte - b'a').collect();
    let words = |seed, count: usize| {
        let mut random = Random(seed);
        let words: [&[u8]; 6] = [b"near ", b"far ", b"plane ", b"light ", b"field ", b"probe "];
        (0..count).flat_map(|_| words[random.below(6) as usize]).copied().collect::<Vec<u8>>()
    };
    let mut random = Random(17);
    let mut noise = |count: usize| (0..count).map(|_| random.below(256) as u8).collect::<Vec<u8>>();
    let far = noise(70);
    vec![
        by_hand(),
        in_one("one-stream", 19, skewed(60, 24, 1)),
        in_one("weights-of-four-bits", 19, few),
        in_one("four-streams", 3, skewed(330, 16, 5)),
        in_one("words", 19, words(2, 24)),
        in_one("one-code-for-all", 3, records(12)),
        in_blocks("blocks-that-repeat-literals", (6, 10), &[1, 2].map(|seed| skewed(260, 8, seed))),
        in_blocks("blocks-that-repeat-sequences", (9, 12), &[1, 2].map(|seed| words(seed, 80))),
        // A match starts 1,034 bytes back, and the content is larger than the window.
        in_blocks("far-match", (19, 11), &[far.clone(), vec![0; 480], vec![7; 484], far, vec![9; 600], vec![9; 600]]),
        in_one("nothing", 3, Vec::new()),
    ]
}

/// Returns the kinds of blocks, literals and tables in a frame.
fn kinds(frame: &Frame) -> BTreeSet<String> {
    let stored = &frame.stored;
    let descriptor = stored[4];
    let single = descriptor >> 5 & 1;
    let size_bytes = match descriptor >> 6 {
        0 => single.into(),
        bits => 1usize << bits,
    };
    let mut at = 6 - usize::from(single) + size_bytes;
    let mut found = BTreeSet::new();
    loop {
        let head = u32::from_le_bytes([stored[at], stored[at + 1], stored[at + 2], 0]);
        let (kind, size) = (head >> 1 & 3, (head >> 3) as usize);
        at += 3;
        found.insert(["raw block", "RLE block", "compressed block"][kind as usize].to_owned());
        let block = &stored[at..at + if kind == 1 { 1 } else { size }];
        at += block.len();
        if kind == 2 {
            kinds_in_block(block, &mut found);
        }
        if head & 1 == 1 {
            return found;
        }
    }
}

fn kinds_in_block(block: &[u8], found: &mut BTreeSet<String>) {
    let (kind, form) = (usize::from(block[0] & 3), usize::from(block[0] >> 2 & 3));
    let literals = ["raw literals", "RLE literals", "Huffman literals", "treeless literals"][kind];
    found.insert(literals.to_owned());
    let size = |bytes: usize, shift: u32, width: u32| {
        let value = block[..bytes].iter().rev().fold(0u64, |value, byte| value << 8 | u64::from(*byte));
        (value >> shift) as usize & ((1 << width) - 1)
    };
    let used = if kind < 2 {
        let (head, shift, width) = [(1, 3, 5), (2, 4, 12), (1, 3, 5), (3, 4, 20)][form];
        head + if kind == 0 { size(head, shift, width) } else { 1 }
    } else {
        found.insert(if form == 0 { "one stream" } else { "four streams" }.to_owned());
        let (head, width) = [(3, 10), (3, 10), (4, 14), (5, 18)][form];
        if kind == 2 {
            found.insert(if block[head] < 128 { "FSE weights" } else { "direct weights" }.to_owned());
        }
        head + size(head, 4 + width, width)
    };
    if block[used] == 0 {
        found.insert("no sequences".to_owned());
        return;
    }
    let modes = block[used + if block[used] < 128 { 1 } else { 2 }];
    for shift in [6, 4, 2] {
        let mode = ["default", "RLE", "FSE", "repeated"][usize::from(modes >> shift & 3)];
        found.insert(format!("{mode} table"));
    }
}

/// Returns the one-bit changes that a decoder accepts, as lines of a byte offset, a bit and the CRC-32 of the decoded bytes.
fn accepted(frame: &Frame, decode: impl Fn(&[u8], u32) -> Option<Vec<u8>>) -> String {
    let mut lines = String::new();
    for at in 0..frame.stored.len() {
        for bit in 0..8 {
            let mut changed = frame.stored.clone();
            changed[at] ^= 1 << bit;
            if let Some(raw) = decode(&changed, frame.raw.len() as u32) {
                assert_eq!(raw.len(), frame.raw.len());
                lines += &format!("{at} {bit} {:08x}\n", crc32fast::hash(&raw));
            }
        }
    }
    lines
}

fn stored_frames() -> Vec<Frame> {
    let read = |Frame { name, .. }: Frame| {
        let path = folder().join(name);
        let stored = fs::read(path.with_extension("zst")).unwrap();
        Frame { name, raw: fs::read(path.with_extension("raw")).unwrap(), stored }
    };
    frames().into_iter().map(read).collect()
}

/// Returns frames that are refused: the name of a vector, the frame, the size of the payload, and the reason. Each is the first
/// change of one byte of a frame that is refused for this reason.
pub fn refused() -> Vec<(&'static str, Vec<u8>, usize, &'static str)> {
    let frames = stored_frames();
    let of_name = |name: &str| frames.iter().find(|frame| frame.name == name).unwrap();
    let mut all = Vec::new();
    for (vector, name, reason) in [
        ("zstd-block-larger-than-window", "blocks-that-repeat-literals", "a block is illegal"),
        ("zstd-literals-cut", "words", "literals end early"),
        ("zstd-huffman-table", "weights-of-four-bits", "a Huffman table is illegal"),
        ("zstd-huffman-table-missing", "blocks-that-repeat-literals", "a Huffman table is missing"),
        ("zstd-huffman-weights-cut", "four-streams", "a Huffman table ends early"),
        ("zstd-stream-length", "one-stream", "a stream of literals has a wrong length"),
        ("zstd-stream-length-of-four", "four-streams", "a stream of literals has a wrong length"),
        ("zstd-stream-without-end", "four-streams", "a bit stream has no end mark"),
        ("zstd-sequences-cut", "words", "sequences end early"),
        ("zstd-sequences-length", "words", "sequences have a wrong length"),
        ("zstd-sequences-modes", "words", "the modes of sequences are illegal"),
        ("zstd-sequences-longer", "one-stream", "bytes follow the sequences"),
        ("zstd-table-missing", "words", "a table of sequences is missing"),
        ("zstd-table-sum", "blocks-that-repeat-sequences", "the probabilities of a table have a wrong sum"),
        ("zstd-table-accuracy", "words", "bits, 9 at most"),
        ("zstd-table-symbol", "one-code-for-all", "the code of a table is illegal"),
        ("zstd-match-before-content", "words", "a match reaches farther back than the window"),
        ("zstd-block-longer", "words", "a block exceeds its maximum size"),
    ] {
        let Frame { raw, stored, .. } = of_name(name);
        let changes = (0..stored.len()).flat_map(|at| (1..=255).map(move |value| (at, value)));
        let mut changed = changes.map(|(at, value)| {
            let mut changed = stored.clone();
            changed[at] ^= value;
            changed
        });
        let why = |stored: &Vec<u8>| zstd::decompress(stored, raw.len() as u32).err().map(|error| error.to_string());
        let found = changed.find(|stored| why(stored).is_some_and(|why| why.contains(reason)));
        all.push((vector, found.unwrap_or_else(|| panic!("{name}: {reason}")), raw.len(), reason));
    }
    // With a window descriptor of 0, the window is 1,024 bytes.
    let Frame { raw, stored, .. } = of_name("far-match");
    let mut narrow = stored.clone();
    narrow[5] = 0;
    all.push(("zstd-match-beyond-window", narrow, raw.len(), "a match reaches farther back than the window"));
    all
}

fn verdicts(frame: &Frame) -> String {
    fs::read_to_string(folder().join(frame.name).with_extension("txt")).unwrap()
}

#[test]
fn frames_have_blocks_and_tables_of_all_kinds() {
    let found: BTreeSet<String> = stored_frames().iter().flat_map(kinds).collect();
    let expected = [
        "raw block",
        "RLE block",
        "compressed block",
        "raw literals",
        "Huffman literals",
        "treeless literals",
        "one stream",
        "four streams",
        "FSE weights",
        "direct weights",
        "no sequences",
        "default table",
        "RLE table",
        "FSE table",
        "repeated table",
    ];
    let missing: Vec<_> = expected.iter().filter(|kind| !found.contains(**kind)).collect();
    assert!(missing.is_empty(), "{missing:?}");
}

#[test]
fn one_bit_changes_decode_as_listed() {
    for frame in stored_frames() {
        assert_eq!(zstd::decompress(&frame.stored, frame.raw.len() as u32).unwrap(), frame.raw, "{}", frame.name);
        let found = accepted(&frame, |stored, raw_bytes| match zstd::decompress(stored, raw_bytes) {
            Ok(raw) => Some(raw),
            Err(Error::Invalid { .. }) => None,
            Err(error) => panic!("another kind of error: {error}"),
        });
        assert_eq!(found, verdicts(&frame), "{}", frame.name);
    }
}

#[test]
fn the_decoder_written_from_the_rfc_agrees_about_one_bit_changes() {
    let expected: String = frames().iter().map(verdicts).collect();
    let paths: Vec<PathBuf> = frames().iter().map(|frame| folder().join(frame.name).with_extension("zst")).collect();
    assert_eq!(vectors::python("zstandard_changes.py", &paths), (expected, String::new()));
}

/// Other libraries accept the frames that this decoder accepts and decode them to the same bytes, for all values of each byte.
#[test]
fn other_libraries_accept_what_is_accepted() {
    let (mut accepted, mut beyond) = (0, [0; 2]);
    for Frame { name, raw, stored } in stored_frames() {
        let raw_bytes = raw.len() as u32;
        let libzstd = |stored: &[u8]| {
            let is_one = ::zstd::zstd_safe::find_frame_compressed_size(stored) == Ok(stored.len());
            let raw = ::zstd::bulk::decompress(stored, raw_bytes as usize).ok()?;
            (is_one && raw.len() == raw_bytes as usize).then_some(raw)
        };
        let changed = |at: usize, value: u8| {
            let mut changed = stored.clone();
            changed[at] ^= value;
            changed
        };
        for stored in (0..stored.len()).flat_map(|at| (1..=255).map(move |value| (at, value))) {
            let stored = changed(stored.0, stored.1);
            let ruzstd = zstd::decompress_independent(&stored, raw_bytes).ok();
            match zstd::decompress(&stored, raw_bytes) {
                Ok(raw) => {
                    accepted += 1;
                    assert_eq!([libzstd(&stored), ruzstd], [Some(raw.clone()), Some(raw)], "{name}: {stored:02x?}");
                }
                Err(_) => {
                    beyond[0] += usize::from(libzstd(&stored).is_some());
                    beyond[1] += usize::from(ruzstd.is_some_and(|raw| raw.len() == raw_bytes as usize));
                }
            }
        }
        for length in 0..stored.len() {
            assert!(zstd::decompress(&stored[..length], raw_bytes).is_err(), "{name}, {length} bytes");
        }
    }
    println!("{accepted} changes are accepted, libzstd accepts {} more, ruzstd {}", beyond[0], beyond[1]);
    assert!(accepted > 100 && beyond[0] > 0);
}

/// Rewrites the frames and their verdicts.
#[test]
#[ignore = "writes tests/vectors/zstandard"]
fn regenerate_frames() {
    fs::create_dir_all(folder()).unwrap();
    for frame in frames() {
        let path = folder().join(frame.name);
        fs::write(path.with_extension("zst"), &frame.stored).unwrap();
        fs::write(path.with_extension("raw"), &frame.raw).unwrap();
        let lines = accepted(&frame, |stored, raw_bytes| zstd::decompress(stored, raw_bytes).ok());
        fs::write(path.with_extension("txt"), lines).unwrap();
        println!("{}: {} bytes, {:?}", frame.name, frame.stored.len(), kinds(&frame));
    }
}
