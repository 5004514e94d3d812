//! Property tests of round trips: containers, payloads of every codec, manifests, cameras, patterns and codes.

use codec::color::quality::{EightBit, Quality};
use codec::color::{SearchSettings, Target};
use codec::container::{
    ChunkEntry, ChunkKey, Compression, Index, PackedChunk, PayloadKind, ProbeEntry, Reader, StreamEntry, Writer,
    compression, lzma2,
};
use codec::depth::domain::DomainKind;
use codec::depth::node_encoder::NodeSettings;
use codec::depth::quantise::Quantiser;
use codec::depth::{DepthRange, TemporalSettings};
use codec::image::{FrameRange, Pattern, Projection};
use codec::streams::ColorBlocks;
use evaluate::camera_file::{CameraEntry, CameraFile};
use footage::dataset::Manifest;
use footage::dataset::manifest::{
    Background, DepthInfo, FileDepth, Files, MaterialChannels, MaterialInfo, Probe, Unit,
};
use half::f16;
use proptest::collection::vec;
use proptest::prelude::*;

use crate::samples::{self, Shape, Stream};

/// Strategy for a size and images of a few frames, in which most pixels equal those of the frame before.
fn images<T: Clone + std::fmt::Debug + 'static>(
    pixel: impl Strategy<Value = T> + Clone + 'static,
    multiple: u32,
) -> impl Strategy<Value = ([u32; 2], Vec<Vec<T>>)> {
    (1..=3 * multiple, 1..=2 * multiple).prop_flat_map(move |(width, height)| {
        let count = (width * height) as usize;
        let change = vec((0..count, pixel.clone()), 0..6);
        (vec(pixel.clone(), count), vec(change, 0..6)).prop_map(move |(first, changes)| {
            let mut all = vec![first];
            for change in changes {
                let mut next = all[all.len() - 1].clone();
                change.into_iter().for_each(|(at, value)| next[at] = value);
                all.push(next);
            }
            ([width, height], all)
        })
    })
}

fn codes() -> impl Strategy<Value = u16> + Clone {
    prop_oneof![3 => 20_000u16..20_400, 1 => any::<u16>(), 1 => Just(u16::MAX)]
}

fn temporal() -> impl Strategy<Value = TemporalSettings> {
    let one_of = prop_oneof![Just(0u16), 1u16..200];
    (1u8..4, one_of, 1u16..6, 1u32..5).prop_map(|(window, epsilon, max_aabbs, keyframe_interval)| TemporalSettings {
        window,
        epsilon,
        max_aabbs,
        keyframe_interval,
    })
}

fn shape(size: [u32; 2], unit: [u32; 2], frames: usize) -> Shape {
    Shape { face: 0, size, unit, first_frame: 2, frame_count: frames as u32 }
}

/// Encodes a stream to a container and returns its decoded images as bytes.
fn decoded(stream: Stream, compression: Compression) -> Vec<Vec<u8>> {
    let file = samples::container(0, samples::probe("00", 9), &[stream], compression);
    samples::decode_all(file).unwrap().remove(0)
}

fn decoded_codes(stream: Stream) -> Vec<Vec<u16>> {
    let code = |bytes: &[u8; 2]| u16::from_le_bytes(*bytes);
    decoded(stream, Compression::None).iter().map(|image| image.as_chunks().0.iter().map(code).collect()).collect()
}

/// Returns the maximum error of surfaces in codes; background must be exact.
fn largest_error(shown: &[Vec<u16>], sources: &[Vec<u16>]) -> u16 {
    assert_eq!(shown.len(), sources.len());
    let pairs = shown.iter().flatten().zip(sources.iter().flatten());
    pairs
        .map(|(&shown, &source)| {
            assert_eq!(shown == u16::MAX, source == u16::MAX, "the background is exact");
            shown.abs_diff(source)
        })
        .max()
        .unwrap_or(0)
}

fn name() -> impl Strategy<Value = String> {
    "[A-Za-z0-9_-][A-Za-z0-9._-]{0,9}"
}

fn finite() -> impl Strategy<Value = f64> + Clone {
    prop_oneof![-1e3..1e3, any::<f64>().prop_filter("finite", |value| value.is_finite())]
}

fn index() -> impl Strategy<Value = Index> {
    let probe = (name(), vec(finite(), 11), 0u32..1000, 0u32..1000).prop_map(|(name, n, first, more)| ProbeEntry {
        name,
        position: [n[0], n[1], n[2]],
        orientation: [n[3], n[4], n[5], n[6]],
        frames: [first, first + more],
        intrinsics: [n[7], n[8], n[9], n[10]],
    });
    let stream = (any::<[u8; 4]>(), vec(1u32..40, 4), 0u32..1000, 1u32..20, vec(any::<u8>(), 0..20), 1u32..9);
    let streams = vec(stream, 0..5);
    ("[ -~é]{0,20}", 1e-3..1e6, 0u8..2, probe, streams).prop_map(|(name, fps, projection, probe, streams)| {
        let mut index = Index { name, fps, projection, probes: vec![probe], ..Index::default() };
        for (at, (codec, sizes, first_frame, frame_count, codec_header, step)) in (0..).zip(streams) {
            let stream = StreamEntry {
                kind: at as u8 % 3,
                face: at as u8,
                probe: 0,
                codec,
                width: sizes[0],
                height: sizes[1],
                first_frame,
                frame_count,
                unit_width: sizes[2],
                unit_height: sizes[3],
                codec_header: codec_header.into(),
            };
            for unit in 0..stream.unit_count() {
                for from in (0..frame_count).step_by(step as usize) {
                    let frame_count = step.min(frame_count - from);
                    let key = ChunkKey { stream: at, unit, first_frame: first_frame + from, frame_count };
                    let (offset, bytes) = (16 + u64::from(from), sizes[0] % 9);
                    let storage = codec::container::Storage::Raw;
                    let (stored_bytes, raw_bytes) = (bytes, bytes);
                    index.chunks.push(ChunkEntry { key, offset, stored_bytes, raw_bytes, crc32: from, storage });
                }
            }
            index.streams.push(stream);
        }
        index
    })
}

fn manifest() -> impl Strategy<Value = Manifest> {
    let depth =
        (any::<bool>(), proptest::option::of(0usize..3), proptest::option::of(-1e30..1e30), 0.01..1.0, 1.0..1e4);
    let depth = depth.prop_map(|(planar, unit, background, near, far)| DepthInfo {
        kind: if planar { FileDepth::Planar } else { FileDepth::Distance },
        channel: None,
        unit: unit.map(|unit| [Unit::M, Unit::Cm, Unit::Mm][unit]),
        scale: None,
        background: background.map_or_else(Background::default, Background::Value),
        near: Some(near),
        far: Some(far),
        size: unit.map(|unit| [1 + unit as u32, 7]),
    });
    let probes = proptest::collection::btree_map(name(), (vec(finite(), 3), 0u32..50, 0u32..50), 1..4);
    let channels = ("[ -~]{1,8}", "[ -~]{1,8}", "[ -~]{1,8}");
    ("[ -~é]{1,20}", 1e-3..1e4, 1u32..65_537, depth, probes, channels).prop_map(
        |(name, fps, side, depth, probes, channels)| {
            let probe = |(name, (position, first, more)): (String, (Vec<f64>, u32, u32))| Probe {
                name,
                position: Some([position[0], position[1], position[2]]),
                frames: Some([first, first + more]),
                size: (more > 9).then_some([more; 2]),
                extra: Some(serde_json::json!({ "kept": [first, null] })),
                ..Probe::default()
            };
            let (reflection, refraction, ior) = channels;
            Manifest {
                schema: None,
                lightfield: 1,
                name,
                fps,
                frames: [0, 99],
                projection: Projection::Cubemap,
                size: [side; 2],
                faces: None,
                faces_present: Some(vec!["px".into(), "nz".into()]),
                face_names: None,
                stereo: None,
                depth: Some(depth),
                color: None,
                material: Some(MaterialInfo { channels: MaterialChannels { reflection, refraction, ior } }),
                alpha: None,
                missing: None,
                view: None,
                files: Files {
                    color: None,
                    depth: Some("{probe}/{face}.%04d.exr".into()),
                    material: None,
                    alpha: None,
                    normal: None,
                },
                probes: probes.into_iter().map(probe).collect(),
                extra: None,
            }
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn indices_come_back(index in index(), by_time: bool, shared in vec(0usize..12, 1..20)) {
        let mut index = index;
        if by_time {
            index.chunks.sort_by_key(|chunk| (chunk.key.first_frame, chunk.key.stream, chunk.key.unit));
        }
        let mut offset = 16;
        for at in 0..index.chunks.len() {
            let back = shared[at % shared.len()];
            if (1..=at).contains(&back) {
                index.chunks[at] = ChunkEntry { key: index.chunks[at].key, ..index.chunks[at - back] };
            } else {
                index.chunks[at].offset = offset;
                offset += u64::from(index.chunks[at].stored_bytes);
            }
        }
        let bytes = index.write().unwrap();
        index.chunks.sort_by_key(|chunk| chunk.key);
        prop_assert_eq!(Index::read(&bytes, offset).unwrap(), index);
    }

    #[test]
    fn chunks_come_back(payloads in vec(vec(any::<u8>(), 0..200), 1..6), level in 0u32..10, which in 0usize..3) {
        let compression = [Compression::None, Compression::Lzma2(level), Compression::Zstd(1 + 2 * level)][which];
        let mut writer = Writer::new(Vec::new(), "chunks", 24.0, 0).unwrap();
        writer.add_probe(samples::probe("00", 9)).unwrap();
        let header = samples::color8_header(&SearchSettings::default());
        let entry = samples::entry(shape([1, 1], [1, 1], payloads.len()), &header);
        let stream = writer.add_stream(entry);
        for (at, payload) in (0..).zip(&payloads) {
            let key = ChunkKey { stream, unit: 0, first_frame: 2 + at, frame_count: 1 };
            writer.push(&PackedChunk::new(key, payload.clone(), (compression, PayloadKind::Mixed)).unwrap()).unwrap();
        }
        let reader = Reader::from_memory(writer.finish().unwrap().0).unwrap();
        let fetch = |chunk| reader.fetch(chunk).unwrap().into_vec();
        prop_assert_eq!(reader.index().chunks.iter().map(fetch).collect::<Vec<_>>(), payloads);
    }

    #[test]
    fn lzma2_comes_back_from_both_decoders(raw in vec(prop_oneof![Just(0u8), any::<u8>()], 0..3000), level in 0u32..10) {
        let stored = compression::lzma2(&raw, level, PayloadKind::Mixed).unwrap();
        prop_assert_eq!(&lzma2::decompress(&stored, raw.len() as u32).unwrap(), &raw);
        prop_assert_eq!(&lzma2::decompress_independent(&stored, raw.len() as u32).unwrap(), &raw);
    }

    #[test]
    fn boxes_keep_their_epsilon((size, images) in images(codes(), 8), settings in temporal(), unit in 1u32..20) {
        let stream = samples::depth(shape(size, [unit, unit], images.len()), [0.5, 8.0], &images, settings);
        prop_assert!(largest_error(&decoded_codes(stream), &images) <= settings.epsilon);
    }

    #[test]
    fn boxes_in_blocks_keep_their_epsilon((size, images) in images(codes(), 8), settings in temporal(), unit in 1u32..5) {
        let stream = samples::depth_in_blocks(shape(size, [4 * unit, 4 * unit], images.len()), &images, settings);
        prop_assert!(largest_error(&decoded_codes(stream), &images) <= settings.epsilon);
    }

    #[test]
    fn nodes_keep_their_bound(
        (size, images) in images(codes(), 12),
        kind in prop_oneof![Just(DomainKind::Log), Just(DomainKind::Linear), Just(DomainKind::Inverse)],
        (bound, epsilon, window, keyframe_interval) in (0u16..300, 0u16..3, 1u8..4, 1u32..5),
        unit in 1u32..40,
    ) {
        let settings = NodeSettings {
            bound, epsilon, window, keyframe_interval, effort: codec::effort::Effort::Fast, ..NodeSettings::default()
        };
        let stream = samples::nodes(shape(size, [unit, unit], images.len()), kind, &images, settings);
        prop_assert!(largest_error(&decoded_codes(stream), &images) <= bound + epsilon);
        let stream = samples::tree(shape(size, [unit, unit], images.len()), kind, &images, settings);
        prop_assert_eq!(decoded_codes(stream), images);
    }

    #[test]
    fn materials_keep_their_epsilon((size, images) in images(any::<[u8; 3]>(), 6), settings in temporal()) {
        let settings = TemporalSettings { epsilon: settings.epsilon % 20, ..settings };
        let near = |stream: Stream| {
            let shown = decoded(stream, Compression::Lzma2(6));
            let pairs = shown.iter().flatten().zip(images.iter().flatten().flatten());
            let worst = pairs.map(|(&shown, &source)| shown.abs_diff(source)).max();
            u16::from(worst.unwrap_or(0)) <= settings.epsilon
        };
        prop_assert!(near(samples::material(shape(size, [5, 4], images.len()), &images, settings)));
        prop_assert!(near(samples::material_in_blocks(shape(size, [8, 4], images.len()), &images, settings)));
    }

    #[test]
    fn colour_keeps_its_quality((size, images) in images(any::<[u8; 3]>(), 4), db in 20.0f64..60.0) {
        let search = SearchSettings { target: Target::Psnr(db), ..SearchSettings::default() };
        let good = |stream: Stream, db: f64| {
            let shown = decoded(stream, Compression::None);
            shown.iter().zip(&images).all(|(shown, source)| {
                let error = EightBit.squared_error(shown, shown, 0, source.as_flattened(), u64::MAX);
                error <= EightBit.max_squared_error(db, shown.len())
            })
        };
        prop_assert!(good(samples::color8(shape(size, size, images.len()), &images, search), db));
        let unit = size.map(|side| side.next_multiple_of(4));
        for (blocks, final_db) in [(ColorBlocks::Bc1, 20.0), (ColorBlocks::Bc7, 25.0)] {
            let stream = samples::color8_in_blocks(shape(size, unit, images.len()), blocks, &images, search, final_db);
            prop_assert!(good(stream, final_db));
        }
    }

    #[test]
    fn half_floats_are_kept_by_keyframes_as_they_are_seen((size, images) in images(any::<[u16; 3]>(), 3)) {
        let finite = |bits: u16| Some(f16::from_bits(bits)).filter(|half| half.is_finite()).unwrap_or(f16::ONE);
        let halves: Vec<Vec<[f16; 3]>> =
            images.iter().map(|image| image.iter().map(|pixel| pixel.map(finite)).collect()).collect();
        let search = SearchSettings { target: Target::Psnr(1000.0), ..SearchSettings::default() };
        let shown = decoded(samples::color_half(shape(size, size, halves.len()), &halves, search), Compression::None);
        let light = |bits: &[u8; 2]| f16::from_le_bytes(*bits);
        for (shown, source) in shown.iter().zip(&halves) {
            let shown: Vec<f16> = shown.as_chunks().0.iter().map(light).collect();
            // Values are compared within the range of PU21: negative values count as 0, and values from 10,000 cd/m² on, which is
            // 100 at this white, count as equal (formats/color.md 5).
            let seen = |value: f16| value.to_f32().clamp(0.0, 100.0);
            let close = |(a, b): (&f16, &f16)| (seen(*a) - seen(*b)).abs() <= 1e-3 * seen(*b) + 1e-4;
            prop_assert!(shown.iter().zip(source.as_flattened()).all(close));
        }
    }

    #[test]
    fn codes_are_the_nearest((near, ratio) in (1e-3f32..1e3, 1.0f32..1e6), at in 0.0f32..1.0) {
        let range = DepthRange::new(near, near * ratio).unwrap();
        let quantiser = Quantiser::new(range);
        let depth_m = near * ratio.powf(at);
        let code = range.code(depth_m);
        prop_assert_eq!(quantiser.code(depth_m), Some(code));
        prop_assert!(code < u16::MAX);
        let back = f64::from(range.metres(code));
        let error = (back / f64::from(depth_m)).ln().abs();
        // The bound is half a step, plus the rounding of single precision.
        prop_assert!(error <= range.step_ratio().ln_1p() / 2.0 + 2e-6, "{} becomes {}", depth_m, back);
    }

    #[test]
    fn manifests_come_back(manifest in manifest()) {
        let text = manifest.to_json().unwrap();
        prop_assert_eq!(Manifest::from_json(text.as_bytes()).unwrap(), manifest);
    }

    #[test]
    fn cameras_come_back(eye in vec(-1e3..1e3, 3), away in vec(1.0..1e3, 3), fov in 1.0..179.0, first in 0u32..99) {
        let entry = CameraEntry {
            eye: [eye[0], eye[1], eye[2]],
            look_at: Some([eye[0] + away[0], eye[1] + away[1], eye[2] + away[2]]),
            orientation: None,
            up: None,
            fov_y_deg: fov,
            aspect: None,
            off_axis: None,
            near_m: Some(0.1),
            far_m: None,
            frames: Some([first, first + 3]),
            frame: None,
        };
        let file = CameraFile { cameras: vec![entry] };
        let text = serde_json::to_string(&file).unwrap();
        prop_assert_eq!(serde_json::from_str::<CameraFile>(&text).unwrap(), file);
        let cameras = CameraFile::parse(text.as_bytes()).unwrap();
        prop_assert_eq!(cameras[0].frames, Some(FrameRange { first, last: first + 3 }));
    }

    #[test]
    fn patterns_and_ranges_come_back(before in "[a-z%]{0,5}", digits in 1usize..20, frame: u32, last: u32) {
        let text = format!("folder/{}%0{digits}d.exr", before.replace('%', "%%"));
        let pattern = Pattern::parse(&text).unwrap();
        let name = pattern.path(frame);
        prop_assert_eq!(name.to_str().unwrap(), format!("folder/{before}{frame:0digits$}.exr"));
        prop_assert_eq!(Pattern::parse(&pattern.to_string()).unwrap().path(frame), name);
        let range = FrameRange { first: frame.min(last), last: frame.max(last) };
        prop_assert_eq!(range.to_string().parse::<FrameRange>().unwrap(), range);
    }
}
