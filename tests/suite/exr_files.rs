//! EXR files of renderers, and hostile EXR files.

use std::path::Path;

use codec::image::{ChannelSelect, Plane, ReadLimits};
use exr::prelude::{
    AnyChannel, AnyChannels, Blocks, Compression, Encoding, FlatSamples, Image, ImageAttributes, IntegerBounds, Layer,
    LayerAttributes, LineOrder, Vec2, WritableImage,
};
use footage::image_files::exr as ours;
use half::f16;
use tempfile::TempDir;

use crate::input::{assert_says, message, ramp};

const AUTO: ChannelSelect = ChannelSelect::Auto;

fn limits() -> ReadLimits {
    ReadLimits::default()
}

fn named(name: &str) -> ChannelSelect {
    ChannelSelect::Named(name.into())
}

/// One layer of an EXR file, made of named channels.
pub(crate) struct Part<'a> {
    pub name: Option<&'a str>,
    pub position: [i32; 2],
    pub size: [usize; 2],
    pub channels: Vec<(&'a str, FlatSamples)>,
}

pub(crate) fn write_parts(
    path: &Path,
    display: IntegerBounds,
    compression: Compression,
    blocks: Blocks,
    parts: Vec<Part>,
) {
    let layers: Vec<_> = parts
        .into_iter()
        .map(|part| {
            let list = part.channels.into_iter().map(|(name, samples)| AnyChannel::new(name, samples)).collect();
            let mut attributes = part.name.map_or_else(LayerAttributes::default, LayerAttributes::named);
            attributes.layer_position = Vec2(part.position[0], part.position[1]);
            let encoding = Encoding { compression, blocks, line_order: LineOrder::Increasing };
            Layer::new((part.size[0], part.size[1]), attributes, encoding, AnyChannels::sort(list))
        })
        .collect();
    let image = Image::from_layers(ImageAttributes::new(display), layers);
    image.write().non_parallel().to_file(path).unwrap();
}

fn write_simple(path: &Path, size: [usize; 2], channels: Vec<(&str, FlatSamples)>) {
    let display = IntegerBounds::from_dimensions((size[0], size[1]));
    let part = Part { name: None, position: [0, 0], size, channels };
    write_parts(path, display, Compression::ZIP16, Blocks::ScanLines, vec![part]);
}

fn floats(count: usize, offset: f32) -> FlatSamples {
    FlatSamples::F32((0..count).map(|i| i as f32 + offset).collect())
}

#[test]
fn planes_come_back_exactly_and_twice_the_same() {
    let folder = TempDir::new().unwrap();
    for (width, height) in [(1, 1), (3, 1), (1, 3), (3, 5), (17, 33)] {
        let (a, b) = (folder.path().join("a.exr"), folder.path().join("b.exr"));
        let depth = Plane::from_fn(width, height, |x, y| if x == y { f32::INFINITY } else { (x + 7 * y) as f32 * 0.1 });
        ours::write_depth(&a, &depth).unwrap();
        ours::write_depth(&b, &depth).unwrap();
        assert_eq!(std::fs::read(&a).unwrap(), std::fs::read(&b).unwrap());
        assert_eq!(ours::read_depth(&a, &AUTO, &limits()).unwrap(), depth);
        assert_eq!(ours::read_size(&a, &limits()).unwrap(), (width, height));

        let color = Plane::from_fn(width, height, |x, y| [x as f32, y as f32, 0.3].map(f16::from_f32));
        ours::write_color(&a, &color).unwrap();
        assert_eq!(ours::read_color(&a, &AUTO, &limits()).unwrap(), color);

        let material = Plane::from_fn(width, height, |x, _| [0.25, 0.75, 1.5 + x as f32]);
        let names = ["reflect", "refract", "ior"];
        ours::write_material(&a, &material, names).unwrap();
        assert_eq!(ours::read_material(&a, names, &limits()).unwrap(), material);
        assert_says(&message(ours::read_material(&a, ["reflect", "refract", "n"], &limits())), &["a.exr", "n", "ior"]);
    }
    assert!(ours::write_depth(&folder.path().join("none.exr"), &Plane::filled(0, 3, 0.0)).is_err());
    assert!(!folder.path().join("none.exr").exists());
}

#[test]
fn every_compression_and_both_block_kinds() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("c.exr");
    let display = IntegerBounds::from_dimensions((37, 29));
    let lossless = [
        Compression::Uncompressed,
        Compression::RLE,
        Compression::ZIP1,
        Compression::ZIP16,
        Compression::PIZ,
        Compression::B44,
        Compression::B44A,
    ];
    for compression in lossless {
        for blocks in [Blocks::ScanLines, Blocks::Tiles(Vec2(16, 8))] {
            let part =
                Part { name: None, position: [0, 0], size: [37, 29], channels: vec![("Z", floats(37 * 29, 0.5))] };
            write_parts(&path, display, compression, blocks, vec![part]);
            assert_eq!(ours::read_depth(&path, &AUTO, &limits()).unwrap(), ramp(37, 29), "{compression:?} {blocks:?}");
        }
    }
}

#[test]
fn half_float_and_uint_channels() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("t.exr");
    // 2049 and 2051 are halfway between half floats, and round to the even neighbours 2048 and 2052.
    let channels = vec![
        ("R", FlatSamples::U32(vec![2049, 2051])),
        ("G", FlatSamples::F32(vec![2049.0, 2051.0])),
        ("B", FlatSamples::F16(vec![f16::from_f32(0.5), f16::NEG_INFINITY])),
    ];
    write_simple(&path, [2, 1], channels);
    let color = ours::read_color(&path, &AUTO, &limits()).unwrap();
    assert_eq!(
        color.data(),
        [[2048.0, 2048.0, 0.5], [2052.0, 2052.0, f32::NEG_INFINITY]].map(|p| p.map(f16::from_f32))
    );
    assert_eq!(ours::read_depth(&path, &named("R"), &limits()).unwrap().data(), [2049.0, 2051.0]);
    assert_eq!(ours::read_depth(&path, &named("B"), &limits()).unwrap().data(), [0.5, f32::NEG_INFINITY]);
    assert_says(
        &message(ours::read_depth(&path, &AUTO, &limits())),
        &["t.exr", "`depth_channel`", "depth.channel", "B, G, R"],
    );
    assert_says(&message(ours::read_depth(&path, &named("Q"), &limits())), &["t.exr", "Q", "B, G, R"]);
}

#[test]
fn layers_are_told_apart() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("m.exr");
    let part = |name, channels| Part { name: Some(name), position: [0, 0], size: [3, 2], channels };
    let rgb = |offset| vec![("R", floats(6, offset)), ("G", floats(6, offset)), ("B", floats(6, offset))];
    let parts = vec![
        part("normal", vec![("X", floats(6, 0.0)), ("Y", floats(6, 0.0)), ("Z", floats(6, 0.0))]),
        part("beauty", rgb(10.0)),
        part("albedo", rgb(20.0)),
        part("depth", vec![("Z", floats(6, 0.5))]),
    ];
    let display = IntegerBounds::from_dimensions((3, 2));
    write_parts(&path, display, Compression::ZIP1, Blocks::ScanLines, parts);
    assert_eq!(ours::read_depth(&path, &AUTO, &limits()).unwrap(), ramp(3, 2));
    assert_eq!(ours::read_color(&path, &AUTO, &limits()).unwrap().get(0, 0), [f16::from_f32(10.0); 3]);
    assert_eq!(ours::read_color(&path, &named("albedo"), &limits()).unwrap().get(1, 0), [f16::from_f32(21.0); 3]);
    let mixed = ours::read_color(&path, &named("beauty.R, albedo.G, depth.Z"), &limits()).unwrap();
    assert_eq!(mixed.get(2, 1), [15.0, 25.0, 5.5].map(f16::from_f32));
    assert_says(&message(ours::read_depth(&path, &named("R"), &limits())), &["beauty.R", "albedo.R"]);
}

#[test]
fn depth_in_three_channels_must_be_one_depth() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("v.exr");
    let three = |blue| vec![("VRayZDepth.R", floats(6, 0.5)), ("VRayZDepth.G", floats(6, 0.5)), ("VRayZDepth.B", blue)];
    write_simple(&path, [3, 2], three(floats(6, 0.5)));
    assert_eq!(ours::read_depth(&path, &AUTO, &limits()).unwrap(), ramp(3, 2));
    assert_eq!(ours::read_depth(&path, &named("VRayZDepth"), &limits()).unwrap(), ramp(3, 2));
    write_simple(&path, [3, 2], three(FlatSamples::F32(vec![0.5, 1.5, 2.5, 3.5, 4.25, 5.5])));
    assert_says(&message(ours::read_depth(&path, &AUTO, &limits())), &["v.exr", "pixel (1, 1)", "depth.channel"]);
    assert_eq!(ours::read_depth(&path, &named("VRayZDepth.R"), &limits()).unwrap(), ramp(3, 2));
}

#[test]
fn data_windows_are_pasted_and_cropped() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("w.exr");
    let display = IntegerBounds::new((10, -4), (5, 4));
    for (position, size) in
        [([11, -3], [2, 2]), ([8, -6], [4, 4]), ([13, -2], [4, 5]), ([9, -5], [8, 8]), ([90, 90], [2, 1])]
    {
        for blocks in [Blocks::ScanLines, Blocks::Tiles(Vec2(3, 2))] {
            let count = size[0] * size[1];
            let part = Part {
                name: None,
                position,
                size,
                channels: vec![("Z", floats(count, 1.0)), ("R", floats(count, 1.0))],
            };
            write_parts(&path, display, Compression::ZIP1, blocks, vec![part]);
            let depth = ours::read_depth(&path, &AUTO, &limits()).unwrap();
            let color = ours::read_color(&path, &named("R"), &limits()).unwrap();
            assert_eq!((depth.width(), depth.height()), (5, 4));
            for (y, x) in (0..4).flat_map(|y| (0..5).map(move |x| (y, x))) {
                let at = [x + 10 - position[0], y - 4 - position[1]];
                let inside = at[0] >= 0 && at[1] >= 0 && (at[0] as usize) < size[0] && (at[1] as usize) < size[1];
                let value = (at[1] * size[0] as i32 + at[0]) as f32 + 1.0;
                let (x, y) = (x as u32, y as u32);
                assert_eq!(depth.get(x, y), if inside { value } else { f32::INFINITY });
                assert_eq!(color.get(x, y)[0].to_f32(), if inside { value } else { 0.0 });
            }
        }
    }
}

#[test]
fn hostile_headers_are_refused_without_panic() {
    let folder = TempDir::new().unwrap();
    let (good, bad) = (folder.path().join("good.exr"), folder.path().join("bad.exr"));
    let display = IntegerBounds::from_dimensions((5, 4));
    let part = |name, first| Part {
        name,
        position: [0, 0],
        size: [5, 4],
        channels: vec![(first, floats(20, 0.5)), ("b", floats(20, 0.0))],
    };
    let tight = ReadLimits { max_image_bytes: 1 << 20 };
    let mut refused = 0;
    for (blocks, parts) in [
        (Blocks::ScanLines, vec![part(None, "Z")]),
        (Blocks::Tiles(Vec2(4, 2)), vec![part(None, "Z")]),
        (Blocks::ScanLines, vec![part(Some("depth"), "Z"), part(Some("other"), "Q")]),
    ] {
        let several = parts.len() > 1;
        write_parts(&good, display, Compression::ZIP1, blocks, parts);
        let bytes = std::fs::read(&good).unwrap();
        for at in 0..bytes.len() {
            for value in [0x00, 0x01, 0x7f, 0x80, 0xff, bytes[at] ^ 0x10, bytes[at].wrapping_add(1)] {
                let mut damaged = bytes.clone();
                damaged[at] = value;
                std::fs::write(&bad, &damaged).unwrap();
                match ours::read_depth(&bad, &AUTO, &tight) {
                    Ok(plane) => assert!(plane.data().len() * 4 <= 1 << 20),
                    Err(error) => {
                        refused += 1;
                        assert_says(&error.to_string(), &["bad.exr"]);
                    }
                }
                let _ = ours::read_size(&bad, &tight);
            }
            std::fs::write(&bad, &bytes[..at]).unwrap();
            let cut = ours::read_depth(&bad, &AUTO, &tight);
            // A layer that is not read may be missing.
            assert!(cut.is_err() || several, "cut at {at}");
        }
        // Four bytes at once: extreme values of sizes and counts.
        for at in 0..bytes.len().saturating_sub(4) {
            for value in [i32::MAX, i32::MIN, -1, 0, 0x0100_0000, 0x0000_ffff] {
                let mut damaged = bytes.clone();
                damaged[at..at + 4].copy_from_slice(&value.to_le_bytes());
                std::fs::write(&bad, &damaged).unwrap();
                let _ = ours::read_depth(&bad, &AUTO, &tight);
            }
        }
    }
    assert!(refused > 1000, "{refused}");
}

#[test]
fn damaged_pixels_do_not_panic() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("p.exr");
    let display = IntegerBounds::from_dimensions((12, 9));
    let halves = || FlatSamples::F16((0..108).map(|i| f16::from_f32((i % 37) as f32 * 0.3)).collect());
    let tight = ReadLimits { max_image_bytes: 1 << 20 };
    for compression in [Compression::RLE, Compression::ZIP16, Compression::PIZ, Compression::PXR24, Compression::B44] {
        let channels = vec![("R", halves()), ("G", halves()), ("B", halves())];
        let part = Part { name: None, position: [0, 0], size: [12, 9], channels };
        write_parts(&path, display, compression, Blocks::ScanLines, vec![part]);
        let bytes = std::fs::read(&path).unwrap();
        for at in 0..bytes.len() {
            let mut damaged = bytes.clone();
            damaged[at] = damaged[at].wrapping_mul(31).wrapping_add(97);
            std::fs::write(&path, &damaged).unwrap();
            if let Ok(plane) = ours::read_color(&path, &AUTO, &tight) {
                assert!(plane.data().len() < 1 << 18);
            }
        }
    }
}

#[test]
fn inverted_windows_are_refused() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("inverted.exr");
    ours::write_depth(&path, &ramp(32, 32)).unwrap();
    let bytes = std::fs::read(&path).unwrap();
    for name in ["dataWindow", "displayWindow"] {
        let head = format!("{name}\0box2i\0");
        let at = bytes.windows(head.len()).position(|window| window == head.as_bytes()).unwrap() + head.len() + 4;
        let mut inverted = bytes.clone();
        for (corner, value) in [31i32, 31, 0, 0].into_iter().enumerate() {
            inverted[at + 4 * corner..][..4].copy_from_slice(&value.to_le_bytes());
        }
        std::fs::write(&path, &inverted).unwrap();
        let words = format!("{name} (31, 31)-(0, 0) is inverted");
        assert_says(&message(ours::read_depth(&path, &AUTO, &limits())), &["inverted.exr", &words]);
        assert_says(&message(ours::read_size(&path, &limits())), &[&words]);
    }
}

#[test]
fn claims_beyond_the_file_are_refused() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("big.exr");
    ours::write_depth(&path, &ramp(64, 64)).unwrap();
    let small = ReadLimits { max_image_bytes: 64 * 64 * 4 - 1 };
    assert_says(&message(ours::read_depth(&path, &AUTO, &small)), &["big.exr", "16384 bytes"]);
    // A data window ten million pixels wide in a file of a few kilobytes.
    let mut bytes = std::fs::read(&path).unwrap();
    let name = b"dataWindow\0box2i\0";
    let at = bytes.windows(name.len()).position(|window| window == name).unwrap() + name.len() + 4;
    bytes[at + 8..at + 12].copy_from_slice(&9_999_999i32.to_le_bytes());
    std::fs::write(&path, &bytes).unwrap();
    assert_says(&message(ours::read_depth(&path, &AUTO, &limits())), &["big.exr", "2560000000 bytes"]);
    assert!(ours::read_depth(folder.path(), &AUTO, &limits()).is_err());
    assert_says(&message(ours::read_depth(&folder.path().join("no.exr"), &AUTO, &limits())), &["no.exr"]);
    for (bytes, words) in
        [(&b""[..], "is empty"), (b"v/", "not an OpenEXR file"), (b"PK\x03\x04 and so on", "not an OpenEXR file")]
    {
        let path = folder.path().join("other.exr");
        std::fs::write(&path, bytes).unwrap();
        assert_says(&message(ours::read_color(&path, &AUTO, &limits())), &["other.exr", words]);
        assert_says(&message(ours::read_size(&path, &limits())), &["other.exr", words]);
    }
    std::fs::write(&path, b"").unwrap();
    assert!(ours::read_depth(&path, &AUTO, &limits()).is_err());
}
