//! Frozen containers of [`crate::vectors`] for the index and its attributes (container.md 4 to 6).

use codec::color::cells::builder::CellBuilder;
use codec::color::{SearchSettings, Target};
use codec::container::{ChunkKey, Compression, EncodedChunk, PackedChunk, PayloadKind, Storage, Writer};
use codec::depth::TemporalSettings;

use crate::samples::{self, Random, Stream};
use crate::vectors::{closing_cells, shape};
use crate::zstandard;

fn temporal(keyframe_interval: u32) -> TemporalSettings {
    TemporalSettings { window: 1, epsilon: 0, max_aabbs: 8, keyframe_interval }
}

/// Returns a container with three probes and streams of three kinds, with chunks of one and of several lengths, some of them
/// equal. With `by_time`, chunks are in the order of their first frames.
fn of_many_streams(by_time: bool) -> Vec<u8> {
    let size = [17, 9];
    let standing = |seed| vec![samples::moving_codes(size, 1, seed).remove(0); 9];
    let depth =
        |face, images: &[Vec<u16>]| samples::depth(shape(face, size, [8, 8], 2, 9), [0.5, 8.0], images, temporal(4));
    let search = SearchSettings { target: Target::Psnr(42.0), ..SearchSettings::default() };
    let color = |face| samples::color8(shape(face, size, [8, 4], 2, 9), &samples::drifting_bytes(size, 9), search);
    let cells = closing_cells();
    let count = cells.iter().map(CellBuilder::frame_count).sum();
    let streams: Vec<Stream> = vec![
        color(0),
        color(1),
        depth(0, &samples::moving_codes(size, 9, 7)),
        depth(4, &standing(3)),
        samples::material(shape(6, [5, 3], [5, 3], 0, 12), &samples::drifting_bytes([5, 3], 12), temporal(300)),
        color(2),
        samples::cells_by_hand(shape(3, [2, 1], [2, 1], 0, count), &samples::color8_header(&search), cells),
    ];
    let mut writer = Writer::new(Vec::new(), "many", 59.94, 0).unwrap();
    let mut other = samples::probe("other", 300);
    (other.position, other.orientation) = ([9.0, 8.0, 7.0], [0.0, 1.0, 0.0, 0.0]);
    let third = codec::container::ProbeEntry { name: "third".into(), ..other.clone() };
    let probes = [samples::probe("00", 300), other, third].map(|probe| writer.add_probe(probe).unwrap());
    let mut chunks: Vec<(u32, u32, &EncodedChunk)> = Vec::new();
    for (at, stream) in streams.iter().enumerate() {
        let mut entry = stream.entry.clone();
        entry.probe = probes[at / 3];
        let number = writer.add_stream(entry);
        chunks.extend(stream.chunks.iter().map(|(unit, chunk)| (number, *unit, chunk)));
    }
    if by_time {
        chunks.sort_by_key(|(stream, unit, chunk)| (chunk.first_frame, *stream, *unit));
    }
    for (stream, unit, chunk) in chunks {
        let first_frame = streams[stream as usize].entry.first_frame + chunk.first_frame;
        let key = ChunkKey { stream, unit, first_frame, frame_count: chunk.frame_count };
        writer
            .push(&PackedChunk::new(key, chunk.payload.clone(), (Compression::Lzma2(6), PayloadKind::Mixed)).unwrap())
            .unwrap();
    }
    let file = writer.finish().unwrap().0;
    assert!(samples::index_bytes(&file).len() < samples::index_bytes(&samples::stated(&file)).len());
    file
}

pub fn valid() -> Vec<(&'static str, Vec<u8>)> {
    vec![
        ("index-by-unit", of_many_streams(false)),
        ("index-by-time", of_many_streams(true)),
        ("index-by-hand", Parts::new().file()),
        ("zstd", compressed_in_frames()),
        ("zstd-windowed", windowed()),
    ]
    .into_iter()
    .chain(valid_attributes())
    .collect()
}

/// Returns smooth and noisy images of three kinds, whose Zstandard frames have blocks of all kinds.
fn compressed_in_frames() -> Vec<u8> {
    let ramp = |t: u32| (0..256 * 192).map(|at| (at / 256 * 3 + at % 256 / 8 + t * (at / 40_000)) as u16).collect();
    let depth: Vec<Vec<u16>> = (0..3).map(ramp).collect();
    let mut random = Random(3);
    let mut skewed = || [0; 3].map(|_: u8| (random.below(7) * random.below(6)) as u8);
    let color: Vec<Vec<[u8; 3]>> = (0..4).map(|_| (0..64 * 40).map(|_| skewed()).collect()).collect();
    let flat = vec![vec![[5, 6, 7]; 256 * 200]; 4];
    let search = SearchSettings { target: Target::Psnr(50.0), ..SearchSettings::default() };
    let boxes = TemporalSettings { window: 2, ..temporal(64) };
    let streams = [
        samples::depth(shape(0, [256, 192], [256, 192], 0, 3), [1.0, 50.0], &depth, boxes),
        samples::color8(shape(0, [64, 40], [64, 40], 0, 4), &color, search),
        samples::color8(shape(1, [256, 200], [256, 200], 0, 4), &flat, search),
        samples::material(shape(0, [40, 40], [16, 16], 0, 3), &samples::drifting_bytes([40, 40], 3), temporal(64)),
    ];
    let file = samples::container(0, samples::probe("00", 11), &streams, Compression::Zstd(19));
    let (index, _) = samples::take_apart(&file);
    assert!(index.chunks.iter().filter(|chunk| chunk.storage == Storage::Zstd).count() >= 4);
    file
}

/// Returns the payload of [`Parts`] in a Zstandard frame that is not a single segment, with three raw blocks.
fn windowed() -> Vec<u8> {
    let raw = Parts::new().stored;
    let mut frame = vec![0x28, 0xb5, 0x2f, 0xfd, 0x80, 0x07];
    frame.extend_from_slice(&(raw.len() as u32).to_le_bytes());
    for (at, last) in [(0..4, 0), (4..4, 0), (4..raw.len(), 1)] {
        frame.extend_from_slice(&((at.len() as u32) << 3 | last).to_le_bytes()[..3]);
        frame.extend_from_slice(&raw[at]);
    }
    of_frame(&frame, raw.len())
}

/// Returns [`Parts`] with a payload of `raw_bytes` bytes that is stored as a Zstandard frame.
fn of_frame(frame: &[u8], raw_bytes: usize) -> Vec<u8> {
    let mut parts = Parts::new();
    let front = [varint(frame.len() << 3 | 2), varint(raw_bytes)].concat();
    parts.chunks = [&front[..], &crc32fast::hash(frame).to_le_bytes(), &[3]].concat();
    parts.stored = frame.to_vec();
    parts.file()
}

/// Parts of an index: one depth stream of two units with one pixel and two frames each, which have equal payloads.
struct Parts {
    stored: Vec<u8>,
    counts: Vec<u8>,
    /// Order of the chunk table, projection, three reserved bytes.
    order: [u8; 5],
    probe_flags: u8,
    name: Vec<u8>,
    stream: Vec<u8>,
    chunks: Vec<u8>,
    attributes: Vec<u8>,
}

/// Offset in the stream row of the byte with the sign of `near`.
const NEAR_SIGN_AT: usize = 19;

impl Parts {
    fn new() -> Parts {
        let images = vec![vec![77, 77]; 2];
        let stream = samples::depth(shape(0, [2, 1], [1, 1], 0, 2), [1.0, 2.0], &images, temporal(64));
        let stored = stream.chunks[0].1.payload.clone();
        let front = [0xff, 1, b'D', b'A', b'A', b'B', 0, 0, 2, 1, 0, 2, 1, 1, 0];
        let header = &stream.entry.codec_header;
        let row = [&front[..], &[header.len() as u8], header, &[2]].concat();
        assert_eq!(stored.len(), 18);
        let own = [&[0x90, 1][..], &crc32fast::hash(&stored).to_le_bytes()].concat();
        Parts {
            stored,
            counts: vec![1, 1, 2],
            order: [0; 5],
            probe_flags: 2,
            name: b"\x01\x00p".to_vec(),
            stream: row,
            chunks: [&own[..], &[3]].concat(),
            attributes: vec![],
        }
    }

    fn file(self) -> Vec<u8> {
        let empty = Writer::new(Vec::new(), "", 1.0, 0).unwrap().finish().unwrap().0;
        let index = [
            &self.counts[..],
            &self.order,
            &24f64.to_le_bytes(),
            &[0, 0],
            &[self.probe_flags],
            &self.name,
            &[0; 24],
            &[0, 1],
            &self.stream,
            &self.chunks,
            &self.attributes,
        ]
        .concat();
        samples::with_foot([&empty[..16], &self.stored].concat(), &index)
    }
}

/// Returns [`Parts`] with these attribute rows.
fn with_attributes(rows: &[u8]) -> Vec<u8> {
    Parts { attributes: rows.to_vec(), ..Parts::new() }.file()
}

pub fn valid_attributes() -> Vec<(&'static str, Vec<u8>)> {
    let unknown = with_attributes(b"\x03\x00a.b\x02\x00\xff\x05\x00z_9.z\x00");
    // The value is not a valid shard entry, but no pixel depends on it.
    let known = with_attributes(b"\x05\x00shard\x01\x2a");
    // Frame 0 is missing without a replacement; frame 1 is replaced by frame 0.
    let missing =
        with_value("frames.missing", &[missing(b"p", [1, 0], 0, u32::MAX), missing(b"p", [1, 0], 1, 0)].concat());
    let view = with_value("view", &view([0.0, 1.5, 2.0, 0.0, 1.0, -3.0, 50.0]));
    vec![
        ("attributes", unknown),
        ("attributes-of-a-known-name", known),
        ("attributes-missing-frames", missing),
        ("attributes-view", view),
    ]
}

/// Returns [`Parts`] with one attribute.
fn with_value(name: &str, value: &[u8]) -> Vec<u8> {
    with_attributes(&[&[name.len() as u8, 0], name.as_bytes(), &varint(value.len()), value].concat())
}

/// Encodes a number below 2^14 as a varint.
fn varint(number: usize) -> Vec<u8> {
    assert!(number < 0x4000);
    if number < 0x80 { vec![number as u8] } else { vec![number as u8 | 0x80, (number >> 7) as u8] }
}

/// Returns a row of `frames.missing`.
fn missing(probe: &[u8], kind_and_face: [u8; 2], frame: u32, held: u32) -> Vec<u8> {
    [&[probe.len() as u8, 0], probe, &kind_and_face, &frame.to_le_bytes(), &held.to_le_bytes()].concat()
}

/// Returns a row of `probes.poses`.
fn pose(probe: &[u8], frame: u32, x: f64) -> Vec<u8> {
    let numbers = [x, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0].map(f64::to_le_bytes).concat();
    [&[probe.len() as u8, 0], probe, &frame.to_le_bytes(), &numbers].concat()
}

/// Returns the value of `view`: eye and point in metres, and the vertical field of view in degrees.
fn view(numbers: [f64; 7]) -> Vec<u8> {
    numbers.map(f64::to_le_bytes).concat()
}

/// Returns attribute values that break a rule of container.md 6.5.
fn invalid_values() -> Vec<(&'static str, Vec<u8>, &'static str)> {
    let frames = |rows: &[Vec<u8>]| with_value("frames.missing", &rows.concat());
    let poses = |rows: &[Vec<u8>]| with_value("probes.poses", &rows.concat());
    let depth = |frame, held| missing(b"p", [1, 0], frame, held);
    let order = "rows do not ascend";
    let number = "frame 2147483648, frames are numbered below 2147483648";
    vec![
        ("missing-frames-descend", frames(&[depth(1, 0), depth(0, 0)]), order),
        ("missing-frames-kinds-descend", frames(&[depth(0, 0), missing(b"p", [0, 0], 1, 0)]), order),
        ("missing-frames-probes-descend", frames(&[missing(b"q", [0, 0], 0, 0), depth(1, 0)]), order),
        ("missing-frames-repeat", frames(&[depth(1, 0), depth(1, 0)]), order),
        ("missing-frames-repeat-a-frame", frames(&[depth(1, 0), depth(1, u32::MAX)]), order),
        ("missing-frames-number", frames(&[depth(1 << 31, 0)]), number),
        ("missing-frames-held", frames(&[depth(1, 1 << 31)]), number),
        ("missing-frames-kind", frames(&[missing(b"p", [4, 0], 1, 0)]), "a stream of kind 4 and face 0 is unknown"),
        ("missing-frames-face", frames(&[missing(b"p", [1, 7], 1, 0)]), "a stream of kind 1 and face 7 is unknown"),
        ("missing-frames-probe", frames(&[missing(b"p/q", [1, 0], 1, 0)]), "\"p/q\" is not a probe name"),
        ("missing-frames-cut", frames(&[depth(1, 0)[..12].to_vec()]), "more bytes expected"),
        ("poses-descend", poses(&[pose(b"p", 1, 0.0), pose(b"p", 0, 0.0)]), order),
        ("poses-repeat", poses(&[pose(b"p", 1, 0.0), pose(b"p", 1, 0.0)]), order),
        ("poses-number", poses(&[pose(b"p", 1 << 31, 0.0)]), number),
        ("poses-position", poses(&[pose(b"p", 0, f64::NAN)]), "a position is NaN"),
        ("chromaticities-none", with_value("color.chromaticities", &[0; 32]), "do not define a colour space"),
        ("chromaticities-cut", with_value("color.chromaticities", &[0; 31]), "more bytes expected"),
        ("view-cut", with_value("view", &view([0.0; 7])[..55]), "more bytes expected"),
        ("view-of-one-point", with_value("view", &view([1.0, 2.0, 3.0, 1.0, 2.0, 3.0, 50.0])), "two different points"),
        ("view-angle", with_value("view", &view([1.0, 2.0, 3.0, 0.0, 2.0, 3.0, 180.0])), "above 0 and below 180"),
        ("view-infinite", with_value("view", &view([f64::INFINITY, 2.0, 3.0, 0.0, 2.0, 3.0, 50.0])), "an eye is inf"),
        ("clipped-pixels-longer", with_value("color.clipped_pixels", &[0; 9]), "1 bytes after the last field"),
    ]
}

pub fn invalid_attributes() -> Vec<(&'static str, Vec<u8>, &'static str)> {
    vec![
        ("attributes-name-empty", with_attributes(b"\x00\x00\x00\x00"), "\"\" is not an attribute name"),
        ("attributes-name", with_attributes(b"\x01\x00A\x00"), "\"A\" is not an attribute name"),
        ("attributes-order", with_attributes(b"\x01\x00b\x00\x01\x00a\x00"), "a does not ascend by name"),
        ("attributes-twice", with_attributes(b"\x01\x00b\x00\x01\x00b\x00"), "b does not ascend by name"),
        ("attributes-cut", with_attributes(b"\x01\x00a\x02\x00"), "2 more bytes expected, 1 left"),
        ("attributes-longer", with_attributes(b"\x01\x00a\x00\x00"), "2 more bytes expected, 1 left"),
    ]
    .into_iter()
    .chain(invalid_values())
    .collect()
}

/// Returns name, bytes and a part of the message of every invalid vector.
pub fn invalid() -> Vec<(&'static str, Vec<u8>, &'static str)> {
    let edited = |change: &dyn Fn(&mut Parts)| {
        let mut parts = Parts::new();
        change(&mut parts);
        parts.file()
    };
    let counts = |counts: &'static [u8]| edited(&|parts| parts.counts = counts.to_vec());
    let stream = |at: usize, bytes: &'static [u8]| {
        edited(&|parts| {
            parts.stream.splice(at..=at, bytes.iter().copied());
        })
    };
    // `change` makes the chunk table from the first byte of the first row and the rest of that row.
    let chunks = |change: &dyn Fn(u8, &[u8]) -> Vec<u8>| {
        edited(&|parts| parts.chunks = change(parts.chunks[0], &parts.chunks[1..6]))
    };
    // A single-segment frame with one raw block: magic, frame header descriptor, content size, block header, content.
    let zstd = |change: &dyn Fn(&mut Vec<u8>)| {
        let raw = Parts::new().stored;
        let mut frame = [&[0x28, 0xb5, 0x2f, 0xfd, 0x20, 18, 18 << 3 | 1, 0, 0][..], &raw].concat();
        change(&mut frame);
        of_frame(&frame, 18)
    };
    let fit = "do not fit into the rest of the index";
    vec![
        ("index-number-longer", counts(&[0x81, 0, 1, 2]), "not in its shortest form"),
        ("index-number-of-six-bytes", counts(&[0xff, 0xff, 0xff, 0xff, 0xff, 1, 1, 2]), "more than five bytes"),
        ("index-number-of-33-bits", counts(&[0xff, 0xff, 0xff, 0xff, 0x1f, 1, 2]), "more than 32 bits hold"),
        ("index-probe-count", counts(&[0xff, 0xff, 0xff, 0xff, 0xf, 1, 2]), fit),
        ("index-stream-count", counts(&[1, 0xff, 0xff, 0xff, 0xff, 0xf, 2]), fit),
        ("index-chunk-count", counts(&[1, 1, 0xff, 0xff, 0xff, 0xff, 0xf]), fit),
        ("index-order", edited(&|parts| parts.order[0] = 2), "order 2 of the chunk table is unknown"),
        ("index-projection", edited(&|parts| parts.order[1] = 2), "projection 2 is unknown"),
        ("index-reserved", edited(&|parts| parts.order[4] = 1), "a reserved byte is not zero"),
        ("index-probe-flags", edited(&|parts| parts.probe_flags = 10), "flags 10 of a probe"),
        ("index-probe-name", edited(&|parts| parts.name[2] = b'/'), "the probe name \"/\""),
        ("index-stream-probe", stream(6, &[1]), "a stream names probe 1, the file has 1"),
        ("index-stream-probe-beyond", stream(6, &[0x80, 0x80, 4]), "a stream names probe 65536"),
        ("index-stream-face", stream(7, &[7]), "a stream of kind 1 and face 7 is unknown"),
        ("index-stream-no-size", edited(&no_size), "a stream of 0x0 in units of 1x1"),
        ("index-stream-frames-beyond", stream(10, &[0xff, 0xff, 0xff, 0xff, 7]), "from frame 2147483647 on"),
        ("index-header-before-first", stream(14, &[1]), "a codec header of 1 rows before the first"),
        ("index-header-too-long", stream(15, &[127]), "127 more bytes expected"),
        ("index-header-byte", stream(NEAR_SIGN_AT, &[0xff]), "0 < near <= far < inf"),
        ("index-more-units", stream(8, &[3]), "more units than the 2 rows"),
        ("index-no-stream", edited(&no_stream), "2 chunks and no stream"),
        ("index-stream-twice", edited(&twice), "has the kind, probe and face of an earlier one"),
        ("index-step-of-none", chunks(&|own, rest| [&[own | 4, 1, 0], &rest[1..], &[3]].concat()), "a step of 0 units"),
        ("index-step-of-all", chunks(&|own, rest| [&[own | 4, 1, 2], &rest[1..], &[3]].concat()), "a step of 2 units"),
        ("index-unit-twice", chunks(&|own, rest| [&[own], rest, &[7, 1]].concat()), "of which 0 are left"),
        ("index-unit-left-out", edited(&left_out), "the chunk table breaks off at stream 0, unit 0, frame 1"),
        ("index-no-frames", edited(&|parts| frames_of_rows(parts, [0, 2])), "a chunk of 0 frames"),
        ("index-more-frames", edited(&|parts| frames_of_rows(parts, [3, 2])), "a chunk of 3 frames"),
        ("index-shared-before-first", chunks(&|own, rest| [&[3, own], rest].concat()), "0 rows before the first"),
        ("index-shared-too-far", chunks(&|own, rest| [&[own], rest, &[11]].concat()), "1 rows before the first"),
        (
            "index-raw-bytes",
            chunks(&|own, rest| [&[own | 1, 1, 0x80, 0x80, 0x80, 1], &rest[1..], &[3]].concat()),
            "cannot decompress to",
        ),
        ("index-chunk-in-index", chunks(&|own, rest| [&[own + 8], rest, &[3]].concat()), "outside the file's chunks"),
        ("index-gap", edited(&|parts| parts.stored.push(0)), "and the index starts at"),
        ("zstd-magic", zstd(&|frame| frame[0] = 0), "its magic number is wrong"),
        ("zstd-dictionary", zstd(&|frame| frame[4] |= 1), "a dictionary, a checksum or reserved bits"),
        ("zstd-checksum", zstd(&|frame| frame[4] |= 4), "a dictionary, a checksum or reserved bits"),
        ("zstd-reserved", zstd(&|frame| frame[4] |= 8), "a dictionary, a checksum or reserved bits"),
        ("zstd-unused", zstd(&|frame| frame[4] |= 16), "a dictionary, a checksum or reserved bits"),
        ("zstd-size-missing", zstd(&|frame| size_missing(frame)), "lacks its content size"),
        ("zstd-size-longer", zstd(&|frame| frame[5] += 1), "does not decompress to the 18 bytes"),
        ("zstd-window", zstd(&large_window), "a window of 18874368 bytes"),
        ("zstd-block-kind", zstd(&|frame| frame[6] |= 6), "the chunk's Zstandard frame is damaged"),
        ("zstd-shorter", zstd(&shorter), "the chunk's Zstandard frame"),
        ("zstd-cut", zstd(&|frame| frame.truncate(frame.len() - 1)), "the chunk's Zstandard frame is damaged"),
        ("zstd-trailing-byte", zstd(&|frame| frame.push(0)), "1 bytes follow the end of the chunk's Zstandard frame"),
        ("zstd-two-frames", zstd(&two_frames), "9 bytes follow the end of the chunk's Zstandard frame"),
        ("zstd-expansion", edited(&expanding), "cannot decompress to"),
        ("index-cut", edited(&|parts| parts.chunks.truncate(6)), "1 more bytes expected, 0 left"),
    ]
    .into_iter()
    .chain(zstandard::refused().into_iter().map(|(name, frame, size, reason)| (name, of_frame(&frame, size), reason)))
    .chain(invalid_attributes())
    .collect()
}

/// A window descriptor, and no content size.
fn size_missing(frame: &mut [u8]) {
    frame[4] = 0;
    frame[5] = 0;
}

/// A window of 18 MiB. The content size has four bytes, because a size of two bytes cannot be 18.
fn large_window(frame: &mut Vec<u8>) {
    frame.splice(4..6, [0x80, 14 << 3 | 1, 18, 0, 0, 0]);
}

/// The block has one byte less than the frame header states.
fn shorter(frame: &mut Vec<u8>) {
    frame[6] = 17 << 3 | 1;
    frame.pop();
}

/// Appends a second, empty frame.
fn two_frames(frame: &mut Vec<u8>) {
    frame.extend_from_slice(&[0x28, 0xb5, 0x2f, 0xfd, 0x20, 0, 1, 0, 0]);
}

/// 18 stored bytes cannot expand to 589,825.
fn expanding(parts: &mut Parts) {
    parts.chunks.splice(0..2, [0x92, 1, 0x81, 0x80, 0x24]);
}

fn no_size(parts: &mut Parts) {
    parts.stream[0] = 0xff - 8;
    parts.stream.drain(8..10);
}

fn no_stream(parts: &mut Parts) {
    parts.counts[1] = 0;
    parts.stream.clear();
}

/// A second row with all fields of the first, including the face.
fn twice(parts: &mut Parts) {
    parts.counts[1] = 2;
    parts.counts[2] = 4;
    parts.stream.extend_from_slice(&[4, 0]);
    parts.chunks.extend_from_slice(&[3, 3]);
}

/// Unit 0 has one of its two chunks, unit 1 both.
fn left_out(parts: &mut Parts) {
    *parts.stream.last_mut().unwrap() = 1;
    parts.counts[2] = 3;
    parts.chunks.extend_from_slice(&[7, 1]);
}

/// Chunk rows that state their frame counts.
fn frames_of_rows(parts: &mut Parts, [first, second]: [u8; 2]) {
    *parts.stream.last_mut().unwrap() = 0;
    parts.chunks.insert(2, first);
    parts.chunks.push(second);
}
