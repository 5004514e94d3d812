//! The public API: frames are encoded from memory and decoded to pixels in slices.

use codec::color::Target;
use codec::image::Plane;
use codec::monitor::Silent;
use codec::streams::convert;
use footage::dataset::source::{Source, SourceOptions};
use half::f16;
use lightfold::{ColorFormat, Decoder, EncodeSettings, Encoder, Face, PixelsMut, ProbePose, StreamKind};
use tempfile::TempDir;

use crate::footage::Footage;

const SIZE: [u32; 2] = [24, 24];
const FACES: [Face; 2] = [Face::Px, Face::Ny];

fn depth(face: Face, frame: u32) -> Plane<f32> {
    Plane::from_fn(
        SIZE[0],
        SIZE[1],
        |x, y| if x == frame { f32::INFINITY } else { 1.0 + (y + face as u32) as f32 / 8.0 },
    )
}

fn color(face: Face, frame: u32) -> Plane<[f16; 3]> {
    Plane::from_fn(SIZE[0], SIZE[1], |x, y| [x, y + frame, face as u32].map(|v| f16::from_f32(v as f32 / 32.0)))
}

fn material(_: Face, frame: u32) -> Plane<[f32; 3]> {
    Plane::from_fn(SIZE[0], SIZE[1], |x, y| [if x == y + frame { 0.5 } else { 0.0 }, 0.25, 1.5])
}

fn alpha(_: Face, frame: u32) -> Plane<f32> {
    Plane::from_fn(
        SIZE[0],
        SIZE[1],
        |x, y| if x + y > 30 { 1.0 } else { f16::from_f32((x + frame) as f32 / 64.0).to_f32() },
    )
}

/// Encodes streams of all kinds from memory, with the name and frame rate of a source.
fn from_memory(name: &str, fps: f64, settings: &EncodeSettings) -> Vec<u8> {
    let mut encoder = Encoder::new(name, fps).with_settings(settings.clone());
    let pose = ProbePose { position: [0.0, 1.0, 2.0], ..ProbePose::default() };
    let probe = encoder.add_probe("00", pose).unwrap();
    // Faces and kinds are added in another order than that of the file.
    for face in FACES.into_iter().rev() {
        let streams = (
            encoder.add_material(probe, face, SIZE).unwrap(),
            encoder.add_depth(probe, face, SIZE).unwrap(),
            encoder.add_color(probe, face, SIZE).unwrap(),
            encoder.add_alpha(probe, face, SIZE).unwrap(),
        );
        for frame in 0..6 {
            encoder.push_material(streams.0, material(face, frame).data()).unwrap();
            encoder.push_depth(streams.1, depth(face, frame).data()).unwrap();
            encoder.push_color(streams.2, color(face, frame).data()).unwrap();
            encoder.push_alpha(streams.3, alpha(face, frame).data()).unwrap();
        }
    }
    encoder.finish(Vec::new()).unwrap().0
}

#[test]
fn frames_from_memory_come_to_the_bytes_of_files() {
    let folder = TempDir::new().unwrap();
    let mut footage = Footage::new(SIZE[0], SIZE[1]);
    footage.faces = &FACES;
    footage.depth = Some(&depth);
    footage.color = Some(&color);
    footage.material = Some(&material);
    footage.alpha = Some(&alpha);
    footage.write(folder.path());
    let source = Source::open(folder.path(), &SourceOptions::default()).unwrap();
    let settings = EncodeSettings::default();
    let (files, _) = footage::encode::encode(&source, &settings, Vec::new(), &Silent).unwrap();
    assert_eq!(from_memory(source.name(), source.fps(), &settings), files);
}

#[test]
fn pixels_are_written_into_slices_whole_and_by_unit() {
    let file = from_memory("film", 24.0, &EncodeSettings::default());
    let decoder = Decoder::from_memory(file).unwrap();
    assert_eq!(decoder.streams().len(), 8);
    for stream in decoder.streams() {
        let pixels = (SIZE[0] * SIZE[1]) as usize;
        let mut face = decoder.face(stream);
        let mut depths = [vec![0.0f32; pixels], vec![0.0; pixels]];
        let mut lights = [vec![[f16::ZERO; 3]; pixels], vec![[f16::ONE; 3]; pixels]];
        let mut codes = vec![0u16; pixels];
        for frame in [3, 0, 5] {
            let by_unit = |images: &mut dyn FnMut(u32, [u32; 4])| {
                (0..stream.unit_count()).for_each(|unit| images(unit, stream.entry.unit_rect(unit)));
            };
            match stream.kind {
                StreamKind::Depth => {
                    let [whole, parts] = &mut depths;
                    face.decode_into(frame, PixelsMut::DepthMetres(whole)).unwrap();
                    face.decode_into(frame, PixelsMut::DepthCodes(&mut codes)).unwrap();
                    by_unit(&mut |unit, [left, top, width, height]| {
                        let mut tile = vec![0.0; (width * height) as usize];
                        decoder.unit(stream, unit).decode_into(frame, PixelsMut::DepthMetres(&mut tile)).unwrap();
                        for (y, row) in tile.chunks(width as usize).enumerate() {
                            let start = ((top + y as u32) * SIZE[0] + left) as usize;
                            parts[start..start + row.len()].copy_from_slice(row);
                        }
                    });
                    assert_eq!(whole, parts);
                    let source = depth(stream.face, frame);
                    let ratio = stream.depth_range().unwrap().step_ratio();
                    for (at, (&z, &expected)) in whole.iter().zip(source.data()).enumerate() {
                        assert_eq!(z.is_infinite(), expected.is_infinite());
                        assert_eq!(codes[at] == 65535, z.is_infinite());
                        let bound = f64::from(stream.error_bound_codes().unwrap()) + 1.0;
                        assert!(
                            z == expected || f64::from((z / expected - 1.0).abs()) <= bound * ratio,
                            "{z} {expected}"
                        );
                    }
                }
                StreamKind::Color => {
                    let mut codes = vec![[0u8; 3]; pixels];
                    face.decode_into(frame, PixelsMut::ColorHalf(&mut lights[0])).unwrap();
                    face.decode_into(frame, PixelsMut::Color8(&mut codes)).unwrap();
                    let table = codec::image::DecodeTable::new(&codec::image::ToneMap::default());
                    let light = convert::color_light(&Plane::new(SIZE[0], SIZE[1], codes).unwrap(), &table);
                    assert_eq!(light.data(), lights[0]);
                    let mut single = vec![[0.0; 3]; pixels];
                    face.decode_into(frame, PixelsMut::ColorFloat(&mut single)).unwrap();
                    assert_eq!(single, lights[0].iter().map(|light| light.map(f16::to_f32)).collect::<Vec<_>>());
                }
                StreamKind::Material => {
                    let mut values = vec![[0.0; 3]; pixels];
                    face.decode_into(frame, PixelsMut::Material(&mut values)).unwrap();
                    let source = material(stream.face, frame);
                    let close = |a: &[f32; 3], b: &[f32; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() <= 0.005);
                    assert!(values.iter().zip(source.data()).all(|(a, b)| close(a, b)));
                }
                StreamKind::Alpha => {
                    let (mut values, mut bytes) = (vec![0.0f32; pixels], vec![0u8; pixels]);
                    face.decode_into(frame, PixelsMut::Alpha(&mut values)).unwrap();
                    face.decode_into(frame, PixelsMut::Alpha8(&mut bytes)).unwrap();
                    let source = alpha(stream.face, frame);
                    assert!(values.iter().zip(source.data()).all(|(a, b)| (a - b).abs() <= 0.5 / 255.0 + 1e-6));
                    assert!(values.iter().zip(&bytes).all(|(a, b)| *a == f32::from(*b) / 255.0));
                }
            }
        }
        let wrong = face.decode_into(0, PixelsMut::DepthCodes(&mut codes[1..])).unwrap_err().to_string();
        assert!(wrong.contains("575 pixels"), "{wrong}");
        if stream.kind != StreamKind::Depth {
            assert!(face.decode_into(0, PixelsMut::DepthCodes(&mut codes)).is_err());
        }
    }
    assert_eq!(footage::inspect::statistics(&decoder).unwrap().streams.len(), 8);
}

#[test]
fn codes_of_srgb_are_encoded_as_they_are() {
    let codes: Vec<[u8; 3]> = (0..=255).map(|code| [code, 255 - code, 7]).collect();
    let mut settings = EncodeSettings::default();
    // A target of 200 dB makes the encode lossless.
    settings.search.target = Target::Psnr(200.0);
    let mut encoder = Encoder::new("film", 24.0).with_settings(settings);
    let probe = encoder.add_probe("00", ProbePose::default()).unwrap();
    let stream = encoder.add_color(probe, Face::View, [16, 16]).unwrap();
    assert!(encoder.push_color8(stream, &codes[1..]).is_err());
    encoder.push_color8(stream, &codes).unwrap();
    let decoder = Decoder::from_memory(encoder.finish(Vec::new()).unwrap().0).unwrap();
    let mut decoded = vec![[0u8; 3]; 256];
    decoder.face(&decoder.streams()[0]).decode_into(0, PixelsMut::Color8(&mut decoded)).unwrap();
    assert_eq!(decoded, codes);
    assert_eq!((decoder.name(), decoder.fps(), decoder.probes().len()), ("film", 24.0, 1));
}

#[test]
fn settings_out_of_range_are_refused() {
    let refused = |change: fn(&mut EncodeSettings)| {
        let mut settings = EncodeSettings::default();
        change(&mut settings);
        let mut encoder = Encoder::new("film", 24.0).with_settings(settings);
        let probe = encoder.add_probe("00", ProbePose::default()).unwrap();
        let stream = encoder.add_depth(probe, Face::View, [8, 8]).unwrap();
        encoder.push_depth(stream, &[1.0; 64]).unwrap();
        encoder.finish(Vec::new()).unwrap_err().to_string()
    };
    assert_eq!(refused(|all| all.search.target = Target::Psnr(f64::NAN)), "`psnr` NaN: 0 to 200 dB was expected");
    assert_eq!(refused(|all| all.search.target = Target::Step(241)), "`color_qp` 241: 0 to 240 was expected");
    let brighter = |all: &mut EncodeSettings| {
        if let ColorFormat::EightBit(tone) = &mut all.color {
            tone.exposure_ev = 8.5;
        }
    };
    assert_eq!(refused(brighter), "`exposure` 8.5: -8 to 8 stops were expected");
}

#[test]
fn frames_that_cannot_be_encoded_are_refused() {
    let mut encoder = Encoder::new("film", 24.0);
    let probe = encoder.add_probe("00", ProbePose::default()).unwrap();
    assert!(encoder.add_probe("00", ProbePose::default()).is_err());
    assert!(encoder.add_probe("a/b", ProbePose::default()).is_err());
    assert!(encoder.add_depth(probe + 1, Face::Px, [4, 4]).is_err());
    assert!(encoder.add_depth(probe, Face::Px, [4, 8]).is_err());
    let depth = encoder.add_depth(probe, Face::Px, [4, 4]).unwrap();
    assert!(encoder.add_depth(probe, Face::Px, [4, 4]).is_err());
    assert!(encoder.add_depth(probe, Face::View, [4, 4]).is_err());
    assert!(encoder.push_depth(depth, &[1.0; 15]).is_err());
    assert!(encoder.push_color(depth, &[[f16::ONE; 3]; 16]).is_err());
    for bad in [f32::NAN, 0.0, -1.0] {
        let mut metres = [1.0; 16];
        metres[6] = bad;
        let error = encoder.push_depth(depth, &metres).unwrap_err().to_string();
        assert!(error.contains("pixel (2, 1)"), "{error}");
    }
    let error = encoder.finish(Vec::new()).unwrap_err().to_string();
    assert!(error.contains("has no frames"), "{error}");
}
