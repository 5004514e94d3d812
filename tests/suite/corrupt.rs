//! Damaged containers: a damaged file is refused or decodes to exactly the images of the intact file. If the CRC-32s are
//! recomputed after the damage, nothing panics.

use codec::color::{SearchSettings, Target};
use codec::container::{ChunkEntry, ChunkKey, Compression, Index, OpenLimits, Reader, Storage, StreamEntry};
use codec::decode::Decoder;
use codec::depth::TemporalSettings;
use codec::streams::ColorBlocks;
use half::f16;
use rayon::prelude::*;

use crate::samples::{self, Images, Random, Shape};

/// Returns a container of colour, depth and material streams in less than 4,096 bytes, compressed or not.
fn small(compression: Compression) -> Vec<u8> {
    let shape = |face, size: [u32; 2], frame_count| Shape { face, size, unit: [4, 4], first_frame: 3, frame_count };
    let settings = TemporalSettings { window: 2, epsilon: 1, max_aabbs: 4, keyframe_interval: 3 };
    let search = SearchSettings { target: Target::Psnr(38.0), ..SearchSettings::default() };
    let size = [5, 4];
    let halves = halves(-1.0);
    let whole = |shape: Shape| Shape { unit: shape.size, ..shape };
    // Codes that are smooth enough for compression to help.
    let flat: Vec<Vec<u16>> = (0..3).map(|t| (0..96).map(|at| at / 48 + t).collect()).collect();
    let streams = [
        samples::depth(shape(0, size, 5), [0.5, 8.0], &samples::moving_codes(size, 5, 5), settings),
        samples::depth(whole(shape(1, [12, 8], 3)), [0.5, 8.0], &flat, settings),
        samples::color8(shape(0, size, 6), &samples::drifting_bytes(size, 6), search),
        samples::color_half(whole(shape(1, [4, 3], 5)), &halves, search),
        samples::material(whole(shape(0, size, 4)), &samples::drifting_bytes(size, 4), settings),
    ];
    let bytes = samples::container(0, samples::probe("00", 9), &streams, compression);
    let (index, _) = samples::take_apart(&bytes);
    let compressed = index.chunks.iter().any(|chunk| chunk.storage != Storage::Raw);
    assert_eq!(compressed, compression != Compression::None);
    assert!(bytes.len() < 4096, "{} bytes", bytes.len());
    bytes
}

/// Returns images of 4x3 half-float pixels with values from `least` up.
fn halves(least: f32) -> Vec<Vec<[f16; 3]>> {
    let light = |v: u16| f16::from_f32(f32::from(v) / 4.0 + least);
    (0..5).map(|t| (0..12).map(|at| [at + t, at * 2, 7].map(light)).collect()).collect()
}

/// Returns an uncompressed container whose pieces and keyframes are in blocks.
fn in_blocks() -> Vec<u8> {
    let shape = |face, size: [u32; 2], frame_count| Shape { face, size, unit: [8, 4], first_frame: 3, frame_count };
    let settings = TemporalSettings { window: 2, epsilon: 90, max_aabbs: 4, keyframe_interval: 3 };
    let search = SearchSettings { target: Target::Psnr(38.0), ..SearchSettings::default() };
    let size = [9, 6];
    let streams = [
        samples::depth_in_blocks(shape(0, size, 4), &samples::moving_codes(size, 4, 5), settings),
        samples::color8_in_blocks(shape(0, size, 5), ColorBlocks::Bc1, &samples::drifting_bytes(size, 5), search, 20.0),
        samples::color8_in_blocks(shape(1, size, 5), ColorBlocks::Bc7, &samples::drifting_bytes(size, 5), search, 35.0),
        samples::color_half_in_blocks(shape(2, [4, 3], 5), &halves(0.25), search, 20.0),
        samples::material_in_blocks(shape(0, size, 4), &samples::patched_materials(size, 4), settings),
    ];
    let bytes = samples::container(0, samples::probe("00", 9), &streams, Compression::None);
    assert!(bytes.len() < 6000, "{} bytes", bytes.len());
    bytes
}

/// Fails if a damaged file decodes to other pixels than the intact one.
fn check(damaged: Vec<u8>, expected: &Images, what: impl Fn() -> String) {
    if let Ok(images) = samples::decode_all(damaged) {
        assert!(images == *expected, "{}: pixels changed in silence", what());
    }
}

fn all() -> [(Vec<u8>, Images); 3] {
    [small(Compression::None), small(Compression::Lzma2(6)), in_blocks()].map(|file| {
        let images = samples::decode_all(file.clone()).unwrap();
        (file, images)
    })
}

/// Returns the files of [`all`], also with rows that state every field, and one with Zstandard compression.
fn all_and_stated() -> Vec<(Vec<u8>, Images)> {
    let stated = all().map(|(file, images)| (samples::stated(&file), images));
    let zstd = small(Compression::Zstd(19));
    let images = samples::decode_all(zstd.clone()).unwrap();
    all().into_iter().chain(stated).chain([(zstd, images)]).collect()
}

#[test]
fn a_file_cut_at_any_length_is_refused() {
    for (file, _) in all_and_stated() {
        for length in 0..file.len() {
            assert!(samples::decode_all(file[..length].to_vec()).is_err(), "{length} bytes are taken");
        }
    }
}

#[test]
fn any_flipped_bit_is_an_error_or_changes_nothing() {
    for (file, images) in all_and_stated() {
        (0..file.len() * 8).into_par_iter().for_each(|bit| {
            let mut damaged = file.clone();
            damaged[bit / 8] ^= 1 << (bit % 8);
            check(damaged, &images, || format!("bit {} of byte {}", bit % 8, bit / 8));
        });
    }
}

#[test]
fn any_byte_inserted_or_deleted_is_an_error() {
    for (file, _) in all() {
        for at in 0..=file.len() {
            for value in [0, 0xff, file[at.min(file.len() - 1)]] {
                let mut damaged = file.clone();
                damaged.insert(at, value);
                assert!(samples::decode_all(damaged).is_err(), "a byte {value} at {at} is taken");
            }
            if at < file.len() {
                let mut damaged = file.clone();
                damaged.remove(at);
                assert!(samples::decode_all(damaged).is_err(), "byte {at} is not missed");
            }
        }
    }
}

#[test]
fn any_two_bytes_exchanged_are_an_error_or_change_nothing() {
    for (file, images) in all() {
        for distance in [1, 4, 8, 40] {
            for at in 0..file.len() - distance {
                let mut damaged = file.clone();
                damaged.swap(at, at + distance);
                check(damaged, &images, || format!("bytes {at} and {}", at + distance));
            }
        }
    }
}

/// Opens a file and decodes a few frames of each stream of at most 2^20 pixels. Returns false if it does not open.
fn exercise(file: Vec<u8>, random: &mut Random) -> bool {
    let Ok(reader) = Reader::from_memory(file) else { return false };
    let Ok(decoder) = Decoder::new(reader) else { return false };
    for stream in decoder.streams() {
        if u64::from(stream.entry.width) * u64::from(stream.entry.height) > 1 << 20 {
            continue;
        }
        let (first, count) = (stream.frames.first, stream.entry.frame_count);
        let mut frames: Vec<u32> = (0..count.min(6)).chain([count - 1]).collect();
        frames.extend((0..4).map(|_| random.below(count)));
        let mut face = decoder.face(stream);
        for frame in frames {
            // An error is ignored; decoding continues with the next frame.
            let _ = face.decode(first + frame);
        }
    }
    true
}

/// Changes 1 to 3 bytes or fields of a slice, often to extreme values.
fn mutate(bytes: &mut [u8], random: &mut Random) {
    for _ in 0..=random.below(3) {
        if bytes.is_empty() {
            return;
        }
        let at = random.below(bytes.len() as u32) as usize;
        let near = bytes[at];
        match random.below(8) {
            0 => bytes[at] ^= 1 << random.below(8),
            1 => bytes[at] = near.wrapping_add(1),
            2 => bytes[at] = near.wrapping_sub(1),
            3 => bytes[at] = [0, 1, 2, 0x7f, 0x80, 0xfe, 0xff][random.below(7) as usize],
            4 => bytes[at] = random.below(256) as u8,
            5 | 6 => {
                let value = [0, 1, 255, 16_384, 65_535, 0x4000_0000, 0x7fff_ffff, 0x8000_0000, u32::MAX];
                let value = value[random.below(9) as usize].to_le_bytes();
                let end = (at + 4).min(bytes.len());
                bytes[at..end].copy_from_slice(&value[..end - at]);
            }
            _ => {
                let from = random.below(bytes.len() as u32) as usize;
                let count = (1 + random.below(8) as usize).min(bytes.len() - from.max(at));
                bytes.copy_within(from..from + count, at);
            }
        }
    }
}

/// Sets the CRC-32 of every chunk to that of its stored bytes.
fn repair_chunks(index: &mut Index, stored: &[u8]) {
    for chunk in &mut index.chunks {
        let start = chunk.offset as usize - 16;
        chunk.crc32 = crc32fast::hash(&stored[start..start + chunk.stored_bytes as usize]);
    }
}

#[test]
fn payloads_damaged_under_a_right_crc_never_panic() {
    for (file, _) in all() {
        let (index, stored) = samples::take_apart(&file);
        let taken: usize = (0..6000u64)
            .into_par_iter()
            .map(|seed| {
                let mut random = Random(seed);
                let (mut index, mut stored) = (index.clone(), stored.clone());
                let chunk = index.chunks[random.below(index.chunks.len() as u32) as usize];
                let start = chunk.offset as usize - 16;
                mutate(&mut stored[start..start + chunk.stored_bytes as usize], &mut random);
                repair_chunks(&mut index, &stored);
                usize::from(exercise(samples::assemble(&index, &stored, |_| ()), &mut random))
            })
            .sum();
        assert_eq!(taken, 6000, "a container opens whatever its payloads are");
    }
}

#[test]
fn payloads_cut_or_lengthened_under_a_right_crc_never_panic() {
    let file = small(Compression::None);
    for seed in 0..3000 {
        let mut random = Random(seed);
        let victim = random.below(10) as usize;
        let damaged = samples::with_payloads(&file, |at, payload| {
            if at % 10 == victim {
                match random.below(3) {
                    0 => payload.truncate(random.below(payload.len() as u32 + 1) as usize),
                    1 => payload.extend((0..random.below(20)).map(|i| i as u8)),
                    _ => {
                        let at = random.below(payload.len() as u32) as usize;
                        payload.remove(at);
                    }
                }
                mutate(payload, &mut random);
            }
        });
        exercise(damaged, &mut random);
    }
}

#[test]
fn indices_damaged_under_a_right_crc_never_panic() {
    for (file, _) in all_and_stated() {
        let taken: usize = (0..5000u64)
            .into_par_iter()
            .map(|seed| {
                let mut random = Random(seed);
                let damaged = samples::with_index(&file, |bytes| mutate(bytes, &mut random));
                usize::from(exercise(damaged, &mut random))
            })
            .sum();
        assert!(taken > 100, "only {taken} damaged indices were legal: the test sees too little");
    }
}

#[test]
fn every_index_field_survives_extreme_values() {
    for file in [small(Compression::None), samples::stated(&small(Compression::None))] {
        let length = samples::index_bytes(&file).len();
        (0..length - 3).into_par_iter().for_each(|at| {
            for value in [0, 1, 0x4000, 0x7fff_ffff, 0x8000_0000, u32::MAX - 1, u32::MAX] {
                let damaged =
                    samples::with_index(&file, |bytes| bytes[at..at + 4].copy_from_slice(&value.to_le_bytes()));
                exercise(damaged, &mut Random(at as u64));
            }
        });
    }
}

#[test]
fn a_static_stream_of_many_frames_is_decoded_at_once() {
    let long = samples::static_for;
    let last = |reader: Reader, frame: u32| {
        let decoder = Decoder::new(reader).unwrap();
        let picture = decoder.face(&decoder.streams()[0]).decode(frame).unwrap();
        assert_eq!(samples::image_bytes(&picture), [7, 0, 7, 0, 7, 0, 7, 0]);
    };
    last(Reader::from_memory(long(1 << 26)).unwrap(), (1 << 26) - 1);
    // With so many frames, visiting each one takes hours, so only trusted files may have them.
    let refused = Reader::from_memory(long(1 << 31)).unwrap_err().to_string();
    assert!(refused.contains("claim 2147483648 units and 8589934592 pixels"), "{refused}");
    last(Reader::from_source(std::sync::Arc::new(long(1 << 31)), "", OpenLimits::NONE).unwrap(), (1 << 31) - 1);
}

fn refusal(file: Vec<u8>) -> String {
    let opened = Reader::from_memory(file).and_then(Decoder::new);
    opened.map_or_else(|error| error.to_string(), |_| "it opens".into())
}

#[test]
fn streams_that_would_take_more_memory_than_the_file_justifies_are_refused() {
    let sized = |side: u32, streams: u8| {
        samples::static_depth(|index| {
            let (stream, chunk) = (index.streams[0].clone(), index.chunks[0]);
            (index.streams, index.chunks) = Default::default();
            for face in 0..streams {
                let [width, height, unit_width, unit_height] = [side; 4];
                index.streams.push(StreamEntry { face, width, height, unit_width, unit_height, ..stream.clone() });
                let key = ChunkKey { stream: face.into(), ..chunk.key };
                index.chunks.push(ChunkEntry { key, ..chunk });
            }
        })
    };
    // One stream may take 1 GiB: at 4 bytes per pixel, 16,384x16,384 pixels exceed it together with the unit and the payload. All
    // streams together may take four times as much.
    assert_eq!(refusal(sized(16_383, 1)), "it opens");
    assert!(refusal(sized(16_384, 1)).contains("would take 1073746100 bytes"), "{}", refusal(sized(16_384, 1)));
    assert_eq!(refusal(sized(16_383, 4)), "it opens");
    assert!(refusal(sized(16_383, 5)).contains("5 streams would take"), "{}", refusal(sized(16_383, 5)));
    // The limit grows with the size of the file: with an attribute of 1 MiB, the same stream opens.
    let small = Reader::from_source(std::sync::Arc::new(sized(16_384, 1)), "", OpenLimits::NONE).unwrap();
    let mut index = small.index().clone();
    index.attributes.set("padding", vec![0; 1 << 20]);
    let large = samples::assemble(&index, &small.fetch_stored(&index.chunks[0]).unwrap(), |_| ());
    assert_eq!(refusal(large), "it opens");
}

#[test]
fn one_stored_chunk_of_many_units_is_refused_by_the_sum() {
    // A stream of boxes counts 10 bytes per byte of its payloads: 6 units of 16 MiB are below 1 GiB, and 7 are above.
    let shared = samples::shared_chunk;
    assert_eq!(refusal(shared(6)), "it opens");
    assert!(refusal(shared(7)).contains("would take"), "{}", refusal(shared(7)));
    assert!(refusal(shared(256)).contains("payloads of 4294967296 bytes"), "{}", refusal(shared(256)));
}
