//! Vectors that break a rule of the container, of depth or of colour cells, and the list of all invalid vectors.

use std::sync::Arc;

use codec::color::SearchSettings;
use codec::color::cells::builder::CellBuilder;
use codec::container::{Compression, Index, PayloadKind, Storage, compression};

use crate::vectors::{keys, one, shape, temporal};
use crate::{
    samples, vectors_of_blocks, vectors_of_indices, vectors_of_limits, vectors_of_nodes, vectors_of_predictive,
    vectors_of_transforms,
};

/// Returns the container from which invalid vectors are made. Chunks: 0 and 1 depth, 2 and 3 8-bit colour, 4 half-float colour, 5
/// material.
pub fn base() -> Vec<u8> {
    let search = SearchSettings::default();
    let depth: Vec<Vec<u16>> = (0..4).map(|t| (0..6).map(|at| at * 100 + t * (at % 2)).collect()).collect();
    let mut cells = vec![CellBuilder::default(), CellBuilder::default()];
    cells[0].push_keyframe::<u8>(&[1, 2, 3, 4, 5, 6]);
    cells[0].push_weight(9, 1);
    cells[0].push_keyframe::<u8>(&[6, 5, 4, 3, 2, 1]);
    cells[0].push_weight(8, 1);
    cells[1].push_keyframe::<u8>(&[7, 7, 7, 8, 8, 8]);
    let mut half = CellBuilder::default();
    half.push_keyframe(&keys(&[0.5, 1.0, -2.0]));
    half.push_weight(0, 1);
    let streams = [
        samples::depth(shape(0, [3, 2], [8, 8], 0, 4), [1.0, 4.0], &depth, temporal(1, 0, 2, 2)),
        samples::cells_by_hand(shape(0, [2, 1], [4, 4], 0, 5), &samples::color8_header(&search), cells),
        samples::cells_by_hand(shape(1, [1, 1], [1, 1], 0, 2), &samples::half_header(&search), vec![half]),
        samples::material(shape(0, [2, 2], [8, 8], 0, 1), &[vec![[1, 2, 3]; 4]], temporal(1, 0, 1, 1)),
    ];
    samples::container(0, samples::probe("00", 4), &streams, Compression::None)
}

/// Returns name, bytes and a part of the message of every invalid vector.
pub fn invalid() -> Vec<(&'static str, Vec<u8>, &'static str)> {
    let good = base();
    let size = good.len();
    let (index, stored) = samples::take_apart(&good);
    assert_eq!(index.chunks.len(), 6);
    let mut all: Vec<(&'static str, Vec<u8>, &'static str)> = Vec::new();
    let byte = |at: usize, value: u8| {
        let mut bytes = good.clone();
        bytes[at] = value;
        bytes
    };
    all.push(("file-empty", vec![], "8 more bytes expected, 0 left"));
    all.push(("file-is-other", b"PK\x03\x04 and something else".to_vec(), "this is not a lightfold container"));
    all.push(("file-cut-in-head", good[..12].to_vec(), "4 more bytes expected, 0 left"));
    all.push(("file-cut-after-head", good[..20].to_vec(), "the container ends after its head"));
    all.push(("file-cut-in-chunks", good[..100].to_vec(), "the container has no foot"));
    all.push(("file-cut-in-foot", good[..size - 1].to_vec(), "the container has no foot"));
    all.push(("file-longer-by-one", [&good[..16], &[0], &good[16..]].concat(), "the foot states a file size of"));
    all.push(("head-magic", byte(1, b'l'), "its signature is wrong"));
    all.push(("head-major-version", byte(8, 2), "the container has format version 2"));
    all.push(("head-reserved", byte(15, 1), "a reserved byte is not zero"));
    all.push(("foot-magic", byte(size - 1, b'X'), "the container has no foot"));
    all.push(("foot-crc", byte(size - 40, good[size - 40] ^ 1), "the foot's CRC-32 does not match"));
    let foot = |change: fn(&mut [u8])| {
        let mut foot = good[size - 40..].to_vec();
        change(&mut foot);
        [&good[..size - 40], &samples::foot_end(foot)].concat()
    };
    all.push(("foot-reserved", foot(|foot| foot[20] = 1), "a reserved byte is not zero"));
    all.push(("foot-file-size", foot(|foot| foot[26] = 1), "the foot states a file size of"));
    all.push(("foot-index-elsewhere", foot(|foot| foot[0] -= 1), "the index does not lie between the chunks"));
    all.push(("foot-index-in-head", foot(|foot| foot[..8].fill(0)), "the index does not lie between the chunks"));
    all.push(("foot-index-wraps", foot(|foot| foot[..16].fill(0xff)), "the index does not lie between the chunks"));
    all.push(("index-crc", byte(size - 50, good[size - 50] ^ 1), "the index's CRC-32 does not match"));

    let patched = |change: &dyn Fn(&mut Vec<u8>)| samples::assemble(&index, &stored, change);
    all.push(("index-name-not-utf8", patched(&|bytes| bytes[18] = 0xff), "the dataset's name is not UTF-8"));
    all.push(("index-name-too-long", patched(&|bytes| bytes[16..18].fill(0xff)), "65535 more bytes expected"));
    all.push(("index-trailing-byte", patched(&|bytes| bytes.push(0)), "2 more bytes expected, 1 left"));
    all.push(("index-cut-in-probes", patched(&|bytes| bytes.truncate(60)), "more bytes expected"));

    let edited = |change: fn(&mut Index)| {
        let mut index = index.clone();
        change(&mut index);
        samples::assemble(&index, &stored, |_| ())
    };
    all.push(("index-fps-zero", edited(|i| i.fps = 0.0), "a frame rate of 0 is not positive"));
    all.push(("index-fps-nan", edited(|i| i.fps = f64::NAN), "the frame rate is NaN"));
    all.push(("probe-name-path", edited(|i| i.probes[0].name = "../up".into()), "the probe name \"../up\""));
    all.push(("probe-name-empty", edited(|i| i.probes[0].name = String::new()), "the probe name \"\""));
    all.push(("probe-name-hidden", edited(|i| i.probes[0].name = ".a".into()), "the probe name \".a\""));
    all.push(("probe-twice", edited(|i| i.probes.push(i.probes[0].clone())), "two probes are named '00'"));
    all.push(("probe-frames", edited(|i| i.probes[0].frames = [3, 2]), "is active from frame 3 to 2"));
    all.push(("probe-frames-beyond", edited(|i| i.probes[0].frames = [0, 1 << 31]), "is active from frame 0 to"));
    all.push(("probe-position", edited(|i| i.probes[0].position[1] = f64::INFINITY), "a probe's position is inf"));
    all.push(("probe-orientation", edited(|i| i.probes[0].orientation[3] = f64::NAN), "orientation is NaN"));
    all.push(("probe-intrinsics", edited(|i| i.probes[0].intrinsics[0] = f64::NAN), "a probe's intrinsics is NaN"));
    all.push(("stream-kind", edited(|i| i.streams[0].kind = 3), "a stream of kind 3 uses codec 'DAAB'"));
    all.push(("stream-kind-unknown", edited(|i| i.streams[0].kind = 4), "a stream of kind 4 and face 0 is unknown"));
    all.push(("stream-face", edited(|i| i.streams[0].face = 7), "a stream of kind 1 and face 7 is unknown"));
    all.push(("stream-probe", edited(|i| i.streams[0].probe = 1), "a stream names probe 1, the file has 1"));
    all.push(("stream-no-width", edited(|i| i.streams[0].width = 0), "each must be 1 to 16384"));
    all.push(("stream-too-high", edited(|i| i.streams[0].height = 16_385), "each must be 1 to 16384"));
    all.push(("stream-no-unit", edited(|i| i.streams[0].unit_width = 0), "each must be 1 to 16384"));
    all.push(("stream-unit-too-wide", edited(|i| i.streams[0].unit_width = u32::MAX), "each must be 1 to 16384"));
    all.push(("stream-no-frames", edited(|i| i.streams[0].frame_count = 0), "a stream of 0 frames"));
    all.push(("stream-frames-beyond", edited(|i| i.streams[0].first_frame = u32::MAX), "from frame 4294967295 on"));
    all.push(("stream-twice", edited(|i| i.streams[3].kind = 1), "stream 3 has the kind, probe and face"));
    all.push(("stream-codec", edited(|i| i.streams[0].codec = *b"DQUA"), "uses codec 'DQUA'"));
    all.push(("stream-codec-of-other-kind", edited(|i| i.streams[0].codec = *b"MAAB"), "uses codec 'MAAB'"));
    all.push((
        "stream-larger-than-justified",
        edited(|i| {
            let stream = &mut i.streams[0];
            [stream.width, stream.height, stream.unit_width, stream.unit_height] = [16_384; 4];
        }),
        "more than a file of",
    ));
    all.push(("dataset-name-control", edited(|i| i.name = "a\u{1b}[2J".into()), "control characters"));
    let coverage = "the chunk table breaks off";
    all.push(("stream-more-units", edited(|i| i.streams[0].unit_width = 2), coverage));
    all.push(("chunk-missing", edited(|i| i.chunks.truncate(5)), coverage));
    all.push((
        "chunk-overlap",
        edited(|i| i.chunks[0].key.frame_count = 3),
        "a chunk of 2 frames of stream 0, unit 0, of which 1 are left",
    ));
    all.push(("chunk-beyond-stream", edited(|i| i.chunks[1].key.frame_count = u32::MAX), "of which 2 are left"));
    all.push(("chunk-in-index", edited(|i| i.chunks[5].stored_bytes += 1), "lies outside the file's chunks"));
    let sizes = "cannot decompress to";
    let bomb: fn(&mut Index) = |i| {
        i.chunks[0].storage = Storage::Lzma2;
        i.chunks[0].raw_bytes = i.chunks[0].stored_bytes * 16_384 + 1;
    };
    all.push(("chunk-expansion", edited(bomb), sizes));
    let large: fn(&mut Index) = |i| {
        i.chunks[0].storage = Storage::Lzma2;
        i.chunks[0].raw_bytes = (1 << 30) + 1;
    };
    all.push(("chunk-too-large", edited(large), sizes));
    all.push(("chunk-crc", byte(20, good[20] ^ 1), "chunk at byte 16: its CRC-32 does not match"));
    let not_lzma2: fn(&mut Index) = |i| i.chunks[0].storage = Storage::Lzma2;
    all.push(("lzma2-damaged", edited(not_lzma2), "the chunk's LZMA2 stream"));

    let mut smooth = compression::lzma2(&[7; 3000], 6, PayloadKind::Mixed).unwrap();
    let lzma2 = |stored: &[u8], raw_bytes: u32| {
        let mut index = index.clone();
        let chunk = &mut index.chunks[0];
        chunk.offset = 16;
        chunk.storage = Storage::Lzma2;
        (chunk.stored_bytes, chunk.raw_bytes, chunk.crc32) = (stored.len() as u32, raw_bytes, crc32fast::hash(stored));
        for (at, other) in index.chunks.iter_mut().enumerate().skip(1) {
            (other.offset, other.stored_bytes, other.raw_bytes) = (16 + at as u64, 1, 1);
        }
        samples::assemble(&index, stored, |_| ())
    };
    all.push(("lzma2-too-long", lzma2(&smooth, 2999), "does not decompress to the 2999 bytes"));
    all.push(("lzma2-too-short", lzma2(&smooth, 3001), "does not decompress to the 3001 bytes"));
    all.push(("lzma2-no-end", lzma2(&smooth[..smooth.len() - 1], 3000), "the chunk's LZMA2 stream is damaged"));
    smooth.push(0);
    all.push(("lzma2-trailing-byte", lzma2(&smooth, 3000), "1 bytes follow the end of the chunk's LZMA2 stream"));

    let header = |stream: usize, at: usize, bytes: &[u8]| {
        let mut index = index.clone();
        Arc::make_mut(&mut index.streams[stream].codec_header)[at..at + bytes.len()].copy_from_slice(bytes);
        samples::assemble(&index, &stored, |_| ())
    };
    let nan = f32::NAN.to_le_bytes();
    all.push(("depth-header-near-beyond-far", header(0, 0, &5f32.to_le_bytes()), "0 < near <= far < inf"));
    all.push(("depth-header-near-zero", header(0, 0, &[0; 4]), "0 < near <= far < inf"));
    all.push(("depth-header-far-nan", header(0, 4, &nan), "0 < near <= far < inf"));
    all.push(("depth-header-background", header(0, 8, &nan), "the background value is not a number"));
    all.push(("depth-header-measure", header(0, 12, &[2]), "depth of kind 2 is unknown"));
    all.push(("depth-header-no-window", header(0, 16, &[0]), "the depth window must be 1 to 255"));
    all.push(("depth-header-window", header(0, 16, &[0, 1]), "a depth window of 256 frames"));
    all.push(("depth-header-no-boxes", header(0, 18, &[0]), "the number of boxes must be 1 to 256"));
    all.push(("depth-header-boxes", header(0, 18, &[1, 1]), "the number of boxes must be 1 to 256"));
    all.push(("depth-header-reserved", header(0, 22, &[1]), "a reserved byte is not zero"));
    all.push(("depth-header-interval", header(0, 24, &[0; 4]), "the keyframe interval must be at least 1"));
    all.push(("material-header-window", header(3, 0, &[0]), "the depth window must be 1 to 255"));
    all.push(("color-header-psnr", header(1, 0, &f64::NAN.to_le_bytes()), "the PSNR is NaN"));
    all.push(("color-header-exposure", header(1, 8, &33f32.to_le_bytes()), "an exposure of 33 stops"));
    all.push(("color-header-transfer", header(1, 12, &[2]), "transfer function 2 is unknown"));
    all.push(("half-header-white", header(2, 8, &[0; 8]), "a white of 0 cd/m"));
    all.push((
        "header-longer",
        edited(|i| Arc::make_mut(&mut i.streams[2].codec_header).push(0)),
        "1 bytes after the last field",
    ));
    all.push((
        "header-shorter",
        edited(|i| Arc::make_mut(&mut i.streams[0].codec_header).truncate(27)),
        "4 more bytes expected, 3 left",
    ));

    // Depth payload 0 has two records: the record table is at byte 4, the keyframe at 20, and the boxes of frame 1 at 36.
    let payload = |chunk: usize, at: usize, bytes: &[u8]| {
        samples::with_payloads(&good, |place, payload| {
            if place == chunk {
                payload[at..at + bytes.len()].copy_from_slice(bytes);
            }
        })
    };
    all.push(("depth-no-records", payload(0, 0, &[0]), "0 records for 2 frames do not fit"));
    all.push(("depth-more-records-than-frames", payload(0, 0, &[3]), "3 records for 2 frames do not fit"));
    all.push(("depth-first-record-late", payload(0, 4, &[1]), "record 0 is for frame 1"));
    all.push(("depth-record-order", payload(0, 12, &[0]), "record 1 is for frame 0"));
    all.push(("depth-record-beyond", payload(0, 12, &[2]), "record 1 is for frame 2"));
    all.push(("depth-record-offset", payload(0, 16, &[37]), "record 1 was announced at offset 37"));
    all.push(("depth-record-kind", payload(0, 36, &[3, 0, 0]), "a record of kind 3"));
    all.push(("depth-record-reserved", payload(0, 37, &[1]), "a reserved byte is not zero"));
    all.push((
        "depth-keyframe-in-boxes",
        payload(0, 20, &[2, 0, 1, 0, 0, 0, 0, 0, 2, 0, 1, 0]),
        "must be a whole picture",
    ));
    all.push(("depth-whole-with-boxes", payload(0, 22, &[1]), "a whole picture announces boxes"));
    all.push(("depth-no-boxes", payload(0, 38, &[0]), "a record of 0 boxes"));
    all.push(("depth-too-many-boxes", payload(0, 38, &[1, 1]), "a record of 257 boxes"));
    all.push(("depth-box-outside", payload(0, 40, &[3]), "is not inside 3x2"));
    all.push(("depth-box-empty", payload(0, 44, &[0]), "is not inside 3x2"));
    all.push(("depth-payload-longer", samples::with_payloads(&good, |_, payload| payload.push(0)), "1 bytes after"));
    all.push((
        "depth-payload-shorter",
        samples::with_payloads(&good, |_, payload| payload.truncate(payload.len() - 1)),
        "expected",
    ));
    all.push((
        "depth-boxes-overlap",
        {
            samples::with_payloads(&good, |place, payload| {
                if place == 0 {
                    payload.truncate(36);
                    payload.extend_from_slice(&[2, 0, 2, 0, 0, 0, 0, 0, 2, 0, 2, 0, 1, 0, 1, 0, 2, 0, 1, 0]);
                    payload.extend_from_slice(&[0; 12]);
                }
            })
        },
        "two boxes of a record overlap",
    ));
    all.push(("color-no-keyframes", payload(2, 0, &[0]), "0 keyframes"));
    all.push(("color-more-keyframes-than-frames", payload(2, 0, &[5]), "5 keyframes"));
    all.push(("color-flags", payload(2, 2, &[2]), "flags 2"));
    all.push(("color-reserved", payload(2, 3, &[1]), "a reserved byte is not zero"));
    all.push(("color-more-weights-than-frames", payload(2, 4, &[5]), "5 weights"));
    all.push(("color-first-keyframe-late", payload(2, 8, &[1]), "keyframe 0 at frame 1"));
    all.push(("color-keyframe-order", payload(2, 12, &[0]), "keyframe 1 at frame 0"));
    all.push(("color-keyframe-beyond", payload(2, 12, &[4]), "keyframe 1 at frame 4"));
    all.push(("color-keyframe-with-weight", payload(2, 16, &[1]), "a weight is not between two keyframes"));
    all.push(("color-weight-not-closed", payload(2, 2, &[0]), "a weight is not between two keyframes"));
    all.push(("color-samples-missing", payload(2, 4, &[3]), "keyframes of 12 bytes expected, 13 there"));
    all.push((
        "color-last-leads-nowhere",
        {
            let mut cell = CellBuilder::default();
            cell.push_keyframe::<u8>(&[1, 2, 3]);
            cell.push_weight(7, 1);
            let header = samples::color8_header(&SearchSettings::default());
            one(samples::cells_by_hand(shape(0, [1, 1], [1, 1], 0, 2), &header, vec![cell]))
        },
        "leads to a next one, and there is none",
    ));
    all.extend(vectors_of_nodes::invalid());
    all.extend(vectors_of_blocks::invalid());
    all.extend(vectors_of_limits::invalid());
    all.extend(vectors_of_transforms::invalid());
    all.extend(vectors_of_predictive::invalid());
    all.extend(vectors_of_indices::invalid());
    all
}
