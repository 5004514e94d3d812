//! Tests of the decoder alone, through the public API: `cargo test -p lightfold-decoder-tests`.

#![cfg(test)]
#![allow(clippy::disallowed_methods)]

use std::fs;
use std::path::{Path, PathBuf};

use lightfold::{Decoder, PixelsMut, StreamInfo, StreamKind, f16};

/// Returns the frozen containers of a folder of tests/vectors, sorted by path.
fn vectors(folder: &str) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../vectors").join(folder);
    let files = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut files: Vec<_> = files.filter(|path| path.extension().is_some_and(|name| name == "lfold")).collect();
    files.sort();
    files
}

/// Returns the bytes of an image over which a vector's CRC-32 is computed: little-endian codes, samples or half floats.
fn image_bytes(decoder: &Decoder, stream: &StreamInfo, frame: u32) -> Vec<u8> {
    let [width, height] = stream.size().map(|side| side as usize);
    let mut face = decoder.face(stream);
    match stream.kind {
        StreamKind::Depth => {
            let mut codes = vec![0; width * height];
            face.decode_into(frame, PixelsMut::DepthCodes(&mut codes)).unwrap();
            codes.iter().flat_map(|code| code.to_le_bytes()).collect()
        }
        StreamKind::Material => {
            let mut bytes = vec![[0; 3]; width * height];
            face.decode_into(frame, PixelsMut::Material8(&mut bytes)).unwrap();
            bytes.into_flattened()
        }
        StreamKind::Alpha => {
            let mut bytes = vec![0; width * height];
            face.decode_into(frame, PixelsMut::Alpha8(&mut bytes)).unwrap();
            bytes
        }
        StreamKind::Color if stream.is_half_float() == Some(true) => {
            let mut light = vec![[f16::ZERO; 3]; width * height];
            face.decode_into(frame, PixelsMut::ColorHalf(&mut light)).unwrap();
            light.as_flattened().iter().flat_map(|value| value.to_bits().to_le_bytes()).collect()
        }
        StreamKind::Color => {
            let mut bytes = vec![[0; 3]; width * height];
            face.decode_into(frame, PixelsMut::Color8(&mut bytes)).unwrap();
            bytes.into_flattened()
        }
    }
}

#[test]
fn valid_vectors_decode_to_their_crcs() {
    let files = vectors("valid");
    assert!(files.len() > 20, "{} vectors", files.len());
    for path in files {
        let decoder = Decoder::open(&path).unwrap();
        let images = decoder.streams().iter().flat_map(|stream| stream.frames.iter().map(move |frame| (stream, frame)));
        let lines: String = images
            .map(|(stream, frame)| {
                let crc = crc32fast::hash(&image_bytes(&decoder, stream, frame));
                format!("{} {frame} {crc:08x}\n", stream.index)
            })
            .collect();
        assert_eq!(lines, fs::read_to_string(path.with_extension("crc")).unwrap(), "{}", path.display());
    }
}

#[test]
fn invalid_vectors_are_refused() {
    let files = vectors("invalid");
    assert!(files.len() > 100, "{} vectors", files.len());
    for path in files {
        let Ok(decoder) = Decoder::open(&path) else { continue };
        let refused = decoder.streams().iter().any(|stream| {
            let pixels = stream.size().map(|side| side as usize).iter().product();
            let mut face = decoder.face(stream);
            let mut bytes = vec![[0; 3]; pixels];
            let mut codes = vec![0; pixels];
            let mut light = vec![[f16::ZERO; 3]; pixels];
            let mut alpha = vec![0; pixels];
            stream.frames.iter().any(|frame| {
                let target = match stream.kind {
                    StreamKind::Depth => PixelsMut::DepthCodes(&mut codes),
                    StreamKind::Material => PixelsMut::Material8(&mut bytes),
                    StreamKind::Color => PixelsMut::ColorHalf(&mut light),
                    StreamKind::Alpha => PixelsMut::Alpha8(&mut alpha),
                };
                face.decode_into(frame, target).is_err()
            })
        });
        assert!(refused, "{} decodes", path.display());
    }
}
