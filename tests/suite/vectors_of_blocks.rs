//! Frozen containers of [`crate::vectors`] with pieces or keyframes in texture blocks.

use codec::color::cells::builder::CellBuilder;
use codec::color::{HalfKey, SearchSettings, Target};
use codec::container::{Compression, EncodedChunk};
use codec::depth::TemporalSettings;
use codec::streams::{CodecHeader, ColorBlocks};
use half::f16;

use crate::samples::{self, Random, Stream};
use crate::vectors::{one, shape};

fn temporal(window: u8, epsilon: u16, max_aabbs: u16, keyframe_interval: u32) -> TemporalSettings {
    TemporalSettings { window, epsilon, max_aabbs, keyframe_interval }
}

fn search(min_psnr_db: f64) -> SearchSettings {
    SearchSettings { target: Target::Psnr(min_psnr_db), ..SearchSettings::default() }
}

fn random_bytes(random: &mut Random, count: usize) -> Vec<u8> {
    (0..count).map(|_| random.below(256) as u8).collect()
}

/// Returns a container with two keyframes of 64x20 pixels in random blocks, in which `first` sets the first byte from the block
/// number and the random byte; a keyframe of samples; and interpolated frames between them.
fn random_blocks(blocks: ColorBlocks, block_bytes: usize, first: impl Fn(usize, u8) -> u8) -> Vec<u8> {
    let mut random = Random(block_bytes as u64 + 77);
    let mut keyframe = || {
        let mut bytes = random_bytes(&mut random, 16 * 5 * block_bytes);
        for (at, block) in bytes.chunks_exact_mut(block_bytes).enumerate() {
            block[0] = first(at, block[0]);
        }
        bytes
    };
    let mut cell = CellBuilder::default();
    cell.push_keyframe_in_blocks(&keyframe());
    cell.push_weight(100, 2);
    cell.push_keyframe_in_blocks(&keyframe());
    cell.push_weight(3, 1);
    if blocks == ColorBlocks::Bc6h {
        let keys: Vec<HalfKey> = (0..64 * 20 * 3).map(|at| HalfKey::from_bits((at * 97 % 65_536) as u16)).collect();
        cell.push_keyframe_as_samples(&keys);
    } else {
        cell.push_keyframe_as_samples(&(0..64 * 20 * 3).map(|at| (at * 7 % 256) as u8).collect::<Vec<u8>>());
    }
    let header = CodecHeader::Color(samples::color_blocks_header(blocks, 20.0));
    one(samples::cells_by_hand(shape(2, [64, 20], [64, 20], 0, 6), &header, vec![cell]))
}

/// Returns the first byte of a block of each BC7 mode in turn, including the reserved one: the mode is the number of zeros below
/// the lowest 1.
fn bc7_mode(at: usize, noise: u8) -> u8 {
    match at % 9 {
        8 => 0,
        mode => (noise | 1) << mode,
    }
}

/// Returns the first byte of a block of each BC6H mode in turn, including reserved ones: a mode has two bits, or five of which
/// the low two are 10 or 11.
fn bc6h_mode(at: usize, noise: u8) -> u8 {
    match at % 18 {
        mode @ (0 | 1) => (noise & !3) | mode as u8,
        other => {
            let five = (other - 2) as u8;
            (noise & !31) | (five >> 1) << 2 | 2 | (five & 1)
        }
    }
}

/// Returns the valid vectors of texture blocks.
pub fn valid() -> Vec<(&'static str, Vec<u8>)> {
    let size = [45, 30];
    let scene = samples::scene_codes(size, 9);
    let of = |unit| shape(0, size, unit, 3, 9);
    let mut all = Vec::new();
    all.push(("depth-bc5-w2", one(samples::depth_in_blocks(of([24, 16]), &scene, temporal(2, 200, 8, 5)))));
    all.push(("depth-bc5-w3-odd", {
        let stream = |face: u8, size: [u32; 2], unit| {
            let settings = temporal(3, 900, 256, 64);
            samples::depth_in_blocks(shape(face, size, unit, 0, 7), &samples::scene_codes(size, 7), settings)
        };
        let streams = [
            stream(0, [45, 30], [64, 64]),
            stream(1, [1, 1], [4, 4]),
            stream(2, [3, 5], [4, 4]),
            stream(3, [1, 37], [8, 16]),
            stream(4, [33, 17], [32, 20]),
        ];
        samples::container(0, samples::probe("00", 10), &streams, Compression::Lzma2(6))
    }));
    all.push(("depth-bc5-random", {
        // Pieces of random blocks and values in a whole unit and in boxes, written without the encoder.
        let mut random = Random(5);
        let mut payload: Vec<u8> = Vec::new();
        let whole = [vec![0, 0, 0, 0, 0b101], random_bytes(&mut random, 16 * 16 + 4 * 16 * 2 + 16 * 16)].concat();
        let whole = [whole, random_bytes(&mut random, 4 * 16 * 2)].concat();
        let boxes = [8u16, 4, 12, 20, 0, 28, 4, 4];
        let mut update = vec![2, 0, 2, 0];
        boxes.iter().for_each(|value| update.extend_from_slice(&value.to_le_bytes()));
        update.push(0b01);
        update.extend(random_bytes(&mut random, 3 * 4 * 16 + 12 * 4 * 2));
        update.push(0b1);
        update.extend(random_bytes(&mut random, 16));
        for value in [2u32, 0, 20, 1, 20 + whole.len() as u32] {
            payload.extend_from_slice(&value.to_le_bytes());
        }
        payload.extend([whole, update].concat());
        let header = samples::bc5_codec(temporal(1, 0, 8, 64));
        let chunk = EncodedChunk { first_frame: 0, frame_count: 3, payload };
        one(Stream { entry: samples::entry(shape(0, [20, 32], [64, 64], 0, 3), &header), chunks: vec![(0, chunk)] })
    }));
    let materials = samples::patched_materials([41, 22], 8);
    all.push(("material-bc1-w2", {
        one(samples::material_in_blocks(shape(0, [41, 22], [24, 24], 0, 8), &materials, temporal(2, 8, 3, 5)))
    }));
    let drifting = samples::drifting_bytes([17, 9], 20);
    for (name, blocks) in [("color8-bc1-cells", ColorBlocks::Bc1), ("color8-bc7-cells", ColorBlocks::Bc7)] {
        let stream = samples::color8_in_blocks(shape(0, [17, 9], [8, 8], 3, 20), blocks, &drifting, search(40.0), 30.0);
        all.push((name, one(stream)));
    }
    all.push(("half-bc6h-cells", {
        let pixel =
            |at: u32, t: u32| [at as f32 * 0.1, 1.0 + t as f32 * 0.02, (at % 9 * t) as f32 * 0.3].map(f16::from_f32);
        let images: Vec<Vec<[f16; 3]>> = (0..9).map(|t| (0..13 * 7).map(|at| pixel(at, t)).collect()).collect();
        one(samples::color_half_in_blocks(shape(0, [13, 7], [8, 8], 0, 9), &images, search(45.0), 30.0))
    }));
    all.push(("color8-bc1-random", random_blocks(ColorBlocks::Bc1, 8, |_, noise| noise)));
    all.push(("color8-bc7-every-mode", random_blocks(ColorBlocks::Bc7, 16, bc7_mode)));
    all.push(("half-bc6h-every-mode", random_blocks(ColorBlocks::Bc6h, 16, bc6h_mode)));
    all
}

/// Returns the invalid vectors of texture blocks: name, bytes, and a part of the message.
pub fn invalid() -> Vec<(&'static str, Vec<u8>, &'static str)> {
    // Chunk 0 is BC5 depth of 20x4 pixels, a keyframe of two pieces and a box; chunk 1 BC1 colour of 4x4; chunk 2 BC1 material.
    let code = |t: u16, at: u16| 4660 + at / 40 + if at % 20 < 4 { t } else { 0 };
    let depth: Vec<Vec<u16>> = (0..2).map(|t| (0..80).map(|at| code(t, at)).collect()).collect();
    let mut cell = CellBuilder::default();
    cell.push_keyframe_in_blocks(&[7; 8]);
    cell.push_weight(9, 1);
    cell.push_keyframe_as_samples(&[1u8; 48]);
    let color = CodecHeader::Color(samples::color_blocks_header(ColorBlocks::Bc1, 30.0));
    let streams = [
        samples::depth_in_blocks(shape(0, [20, 4], [20, 4], 0, 2), &depth, temporal(1, 0, 4, 8)),
        samples::cells_by_hand(shape(0, [4, 4], [4, 4], 0, 3), &color, vec![cell]),
        samples::material_in_blocks(shape(0, [4, 4], [4, 4], 0, 1), &[vec![[1, 2, 3]; 16]], temporal(1, 0, 1, 1)),
    ];
    let good = samples::container(0, samples::probe("00", 4), &streams, Compression::None);
    assert!(samples::decode_all(good.clone()).is_ok());
    let (index, stored) = samples::take_apart(&good);
    let unit = |stream: usize, width: u32, height: u32| {
        let mut index = index.clone();
        (index.streams[stream].unit_width, index.streams[stream].unit_height) = (width, height);
        samples::assemble(&index, &stored, |_| ())
    };
    let payload = |chunk: usize, at: usize, bytes: &[u8]| {
        samples::with_payloads(&good, |place, payload| {
            if place == chunk {
                payload[at..at + bytes.len()].copy_from_slice(bytes);
            }
        })
    };
    // The record of frame 1 starts with its kind, the number of boxes, and the first box.
    let record = samples::with_payloads(&good, |_, _| ());
    let (_, chunks) = samples::take_apart(&record);
    let second = u32::from_le_bytes(chunks[16..20].try_into().unwrap()) as usize;
    assert_eq!(chunks[second], 2, "a record of boxes");
    let sides = "not multiples of 4 pixels";
    let grid = "cuts blocks of 4x4 pixels";
    vec![
        ("bc5-unit-width", unit(0, 22, 4), sides),
        ("bc5-unit-height", unit(0, 20, 6), sides),
        ("bc1-material-unit", unit(2, 4, 5), sides),
        ("bc1-color-unit", unit(1, 7, 4), sides),
        ("bc5-map-spare-bits", payload(0, 24, &[0x80]), "spare bits of a map of pieces are not zero"),
        ("bc5-map-other-piece", payload(0, 24, &[0]), "expected"),
        ("bc5-box-left", payload(0, second + 4, &[1, 0]), grid),
        ("bc5-box-width", payload(0, second + 8, &[6, 0]), grid),
        ("bc5-box-height", payload(0, second + 10, &[3, 0]), grid),
        ("bc1-keyframe-coding", payload(1, 11, &[0x80]), "keyframes of 96 bytes expected, 56 there"),
        ("bc1-keyframe-beyond", payload(1, 12, &[3]), "keyframe 1 at frame 3"),
        ("bc1-keyframe-first", payload(1, 8, &[1]), "keyframe 0 at frame 1"),
        ("samples-keyframe-coding", payload_of_samples(), "keyframe 0 at frame 2147483648"),
    ]
}

/// Returns a container in a codec without blocks whose keyframe has the bit of a keyframe coding, which is read as part of the
/// frame number.
fn payload_of_samples() -> Vec<u8> {
    let mut cell = CellBuilder::default();
    cell.push_keyframe_as_samples(&[1u8; 3]);
    one(samples::cells_by_hand(shape(0, [1, 1], [1, 1], 0, 1), &samples::color8_header(&search(50.0)), vec![cell]))
}
