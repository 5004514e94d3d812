//! Hard cases of colour cells (CALF 5.1; color.md): every frame must reach its PSNR.

use std::sync::Arc;

use half::f16;

use crate::case::{Bound, Family, Group, HardCase, Measured};
use crate::clip::{Clip, EFFORT, Sequence, noise};
use crate::paths::paths;
use codec::color::quality::{EightBit, MAX_OUTSIDE_RMS, PU_STEPS, Pu21, Quality};
use codec::color::temporal::{BlockStage, CLOSE_AT_BYTES, CellEncoder};
use codec::color::transform::encode::{PricedTables, TransformEncoder};
use codec::color::transform::{Keyed, Tables};
use codec::color::{CellChunk, CellFormat, HalfKey, Sample, SearchSettings, Target};
use codec::decode::Picture;
use codec::error::{Error, Result};
use codec::image::ToneMap;
use codec::metrics::psnr::U8_PEAK;
use codec::metrics::pu21::{PU21_MAX_CD_M2, PU21_MIN_CD_M2, PU21_PEAK, pu21_encode};
use codec::streams::{CodecHeader, ColorBlocks, ColorCoding, ColorFormat, ColorHeader};

/// Luminance of 1.0 in the half-float cases, in cd/m².
const WHITE_CD_M2: f64 = 100.0;
/// Frames per chunk of the transform codec.
const CHUNK_FRAMES: u32 = 7;

/// Sequence of a cell: name, size, number of frames, and the pixel at (frame, x, y).
type Cell<T> = (&'static str, [u32; 2], u32, fn(u32, u32, u32) -> [T; 3]);

const BYTES: [Cell<u8>; 14] = [
    ("black", [12, 12], 20, |_, _, _| [0; 3]),
    ("saturated", [12, 12], 20, |_, _, _| [255; 3]),
    ("black and saturated in turn", [12, 12], 30, |frame, _, _| [[0; 3], [255; 3]][frame as usize % 2]),
    ("pure colours, checkerboard", [12, 12], 20, |frame, x, y| match (frame / 4 + x + y) % 4 {
        0 => [255, 0, 0],
        1 => [0, 255, 0],
        2 => [0, 0, 255],
        _ => [0; 3],
    }),
    ("a still picture", [16, 16], 60, |_, x, y| [(x * 16) as u8, (y * 16) as u8, 128]),
    ("equal keyframes with another picture between", [12, 12], 31, |frame, x, y| {
        if frame % 10 == 5 { [200, (x * 9) as u8, 10] } else { [20, (y * 9) as u8, 100] }
    }),
    ("equal keyframes with noise between", [12, 12], 31, |frame, x, y| {
        if frame % 10 == 0 { [90, 90, 90] } else { [(noise([frame, x, y], 256)) as u8, 90, 90] }
    }),
    ("a fade of one code over 500 frames", [8, 8], 500, |frame, x, y| {
        // Each pixel changes at a different frame.
        [100 + u8::from(frame > 7 * (x + 8 * y)), 50, 200 - u8::from(frame > 499 - 7 * (x + 8 * y))]
    }),
    ("a fade from black to saturated, 500 frames", [8, 8], 500, |frame, _, _| [(frame * 255 / 499) as u8; 3]),
    ("a cut in every frame", [12, 12], 40, |frame, x, y| [0, 1, 2].map(|c| noise([frame * 3 + c, x, y], 256) as u8)),
    ("one pixel, any colour in every frame", [1, 1], 40, |frame, _, _| {
        [0, 1, 2].map(|c| noise([frame, c, 7], 256) as u8)
    }),
    ("one row", [37, 1], 12, |frame, x, _| [(x * 7 + frame) as u8, (x * 3) as u8, 255 - (x + frame) as u8]),
    ("one sample of one pixel flickers", [16, 16], 60, |frame, x, y| {
        [100, if (x, y) == (3, 11) && frame % 2 == 1 { 255 } else { 100 }, 100]
    }),
    ("two clusters in every block, all but black", [16, 16], 16, |frame, x, y| {
        if (x * 5 + y * 3 + frame) % 7 < 3 { [1, 0, 1] } else { [254, 255, 3 * (x % 4) as u8] }
    }),
];

fn half(value: f64) -> f16 {
    f16::from_f64(value)
}

const HALVES: [Cell<f16>; 17] = [
    ("black", [12, 12], 20, |_, _, _| [f16::ZERO; 3]),
    ("65504 everywhere", [12, 12], 20, |_, _, _| [f16::MAX; 3]),
    ("6e-8 to 65504 across", [24, 12], 16, |frame, x, y| {
        let value = 6e-8 * (65_504.0 / 6e-8f64).powf(f64::from(x) / 23.0);
        [value, value / f64::from(1 + y), value / f64::from(1 + frame)].map(half)
    }),
    ("6e-8 to 65504 in time", [8, 8], 60, |frame, x, _| {
        let value = 6e-8 * (65_504.0 / 6e-8f64).powf(f64::from(frame) / 59.0);
        [value, value * 0.5, (value * f64::from(1 + x)).min(65_504.0)].map(half)
    }),
    ("0 and 65504 in turn", [12, 12], 30, |frame, _, _| [[f16::ZERO; 3], [f16::MAX; 3]][frame as usize % 2]),
    ("0 and 65504, checkerboard", [12, 12], 12, |frame, x, y| {
        [[f16::ZERO; 3], [f16::MAX; 3]][(frame + x + y) as usize % 2]
    }),
    ("negative light", [12, 12], 20, |frame, x, y| {
        [-0.5 - f64::from(x), f64::from(y) - 5.5, -65_504.0 * f64::from(frame % 2)].map(half)
    }),
    ("NaN beside light, in space and in time", [12, 12], 30, |frame, x, y| match (x + y + frame) % 5 {
        0 => [f16::NAN; 3],
        1 => [half(1.0), f16::NAN, half(65_504.0)],
        _ => [half(0.2 + 0.01 * f64::from(frame)); 3],
    }),
    ("both infinities", [12, 12], 20, |frame, x, _| match (x + frame) % 4 {
        0 => [f16::INFINITY; 3],
        1 => [f16::NEG_INFINITY; 3],
        _ => [half(3.0); 3],
    }),
    ("denormal halves and both zeros", [12, 12], 20, |frame, x, y| {
        [f16::from_bits((x + 12 * y + frame) as u16), f16::from_bits(0x8000 | (x * frame) as u16), f16::NEG_ZERO]
    }),
    ("one pixel, any bits in every frame", [1, 1], 60, |frame, _, _| {
        [0, 1, 2].map(|c| f16::from_bits(noise([frame, c, 3], 65_536) as u16))
    }),
    ("a lamp of one pixel moves, 200 to 60000", [16, 16], 32, |frame, x, y| {
        let lamp = [200.0, 60_000.0, 121.0 + 1000.0 * f64::from(frame)];
        if [x, y] == [frame % 16, 5 + frame / 16] { lamp.map(half) } else { [half(0.4 + 0.01 * f64::from(y)); 3] }
    }),
    ("light from 90 to 110 flickers in one pixel", [12, 12], 24, |frame, x, y| match (x, y) {
        (5, 7) => [0, 1, 2].map(|c| half(90.0 + f64::from(noise([frame, c, 5], 20)))),
        _ => [half(f64::from(x) / 12.0); 3],
    }),
    ("a lamp at 65504 beside black", [16, 16], 24, |frame, x, y| {
        if (x, y) == (3 + frame / 8, 9) { [f16::MAX; 3] } else { [f16::ZERO; 3] }
    }),
    ("darkness below 0.005 cd/m2 in motion", [12, 12], 24, |frame, x, y| {
        [0, 1, 2].map(|c| half(5e-5 * f64::from(noise([frame, 3 * x + c, y], 1000)) / 1000.0))
    }),
    ("negative light just below black", [12, 12], 24, |frame, x, y| match noise([frame, x, y], 9) {
        0 => [half(-0.0011), half(-1e-6), half(0.3)],
        _ => [half(0.3), half(-1.24), half(2e-5)],
    }),
    ("one negative pixel of each size in light", [12, 12], 24, |frame, x, y| {
        let value = -6e-8 * (65_504.0 / 6e-8f64).powf(f64::from(frame) / 23.0);
        if (x, y) == (7, 2) { [half(value), half(0.5), half(-value)] } else { [half(0.5); 3] }
    }),
];

/// Minimum PSNR that forces lossless coding.
const EXACT_DB: f64 = 200.0;

#[derive(Clone, Copy)]
enum Codec {
    Cells(Option<ColorBlocks>),
    Transform,
}

#[derive(Clone, Copy)]
struct Coding {
    format: ColorFormat,
    codec: Codec,
    min_psnr_db: f64,
}

impl Coding {
    fn header(&self) -> ColorHeader {
        let Coding { format, codec, min_psnr_db } = *self;
        let coding = match codec {
            Codec::Cells(blocks) => ColorCoding::Cells(blocks),
            Codec::Transform => ColorCoding::Transform(Tables::default()),
        };
        ColorHeader { format, coding, min_psnr_db, min_quality: 0.0 }
    }
}

pub(super) fn cases() -> Vec<HardCase> {
    let mut cases = Vec::new();
    let formats = [
        ("CCL8", Codec::Cells(None), 50.0),
        ("CCB1", Codec::Cells(Some(ColorBlocks::Bc1)), 30.0),
        ("CCB7", Codec::Cells(Some(ColorBlocks::Bc7)), 40.0),
        ("CTR8", Codec::Transform, 45.0),
    ];
    for (name, codec, min_psnr_db) in formats {
        let group = Group::new(Family::Color, name, "dB");
        let format = ColorFormat::EightBit(ToneMap::default());
        let coding = Coding { format, codec, min_psnr_db };
        let any_path = paths_of(name);
        for cell in BYTES {
            cases.push(group.case(cell.0, Bound::AtLeast(min_psnr_db), move || bytes(cell, &coding.header())));
            cases.push(any_path.none(cell.0, move || paths(&clip_of_bytes(cell, &coding.header())?.1)));
        }
    }
    let formats = [
        ("CCLH", Codec::Cells(None), 50.0),
        ("CCB6", Codec::Cells(Some(ColorBlocks::Bc6h)), 40.0),
        ("CTRH", Codec::Transform, 45.0),
    ];
    for (name, codec, min_psnr_db) in formats {
        let group = Group::new(Family::Color, name, "dB of PU21");
        let coding = Coding { format: ColorFormat::Half { white_cd_m2: WHITE_CD_M2 }, codec, min_psnr_db };
        let exact = Group::new(Family::Color, format!("{name}, keyframes of samples"), "samples of other bits");
        let any_path = paths_of(name);
        let outside =
            Group::new(Family::Color, format!("{name}, outside the range of PU21"), "of the RMS error allowed");
        let all_exact = Group::new(Family::Color, format!("{name}, exact"), "samples of other bits");
        // Both PU21 codes are rounded to steps.
        let rms = PU21_PEAK * 10f64.powf(-min_psnr_db / 20.0);
        let most = Bound::AtMost(MAX_OUTSIDE_RMS as f64 + 1.0 / PU_STEPS / rms);
        for cell in HALVES {
            cases.push(group.case(cell.0, Bound::AtLeast(min_psnr_db), move || halves(cell, &coding.header())));
            cases.push(outside.case(cell.0, most, move || halves_outside(cell, &coding.header())));
            let exactly = Coding { min_psnr_db: EXACT_DB, ..coding };
            cases.push(all_exact.none(cell.0, move || changed_samples(cell, &exactly.header())));
            cases.push(any_path.none(cell.0, move || paths(&clip_of_halves(cell, &coding.header())?.1)));
            if matches!(codec, Codec::Cells(_)) {
                cases.push(exact.none(cell.0, move || changed_keyframes(cell, &coding.header())));
            }
        }
    }
    cases
}

fn paths_of(codec: &str) -> Group {
    Group::new(Family::Color, format!("{codec}, every legal path"), "pictures that differ")
}

fn decibels(sum: f64, samples: usize, peak: f64) -> f64 {
    if sum == 0.0 { f64::INFINITY } else { 10.0 * (peak * peak * samples as f64 / sum).log10() }
}

/// Encodes a cell. `coded` converts its samples.
fn clip_of<T, S: Sample + Keyed, Q: Quality<S>>(
    source: &Sequence<[T; 3]>,
    header: &ColorHeader,
    format: CellFormat<S>,
    quality: &Q,
    coded: fn(&T) -> S,
) -> Result<Clip> {
    let usual = SearchSettings { effort: EFFORT, ..SearchSettings::default() };
    let search = SearchSettings { target: Target::Psnr(usual.target.min_psnr_db().max(header.min_psnr_db)), ..usual };
    let samples = |frame: &Vec<[T; 3]>| frame.as_flattened().iter().map(coded).collect::<Vec<S>>();
    let chunks = match &header.coding {
        ColorCoding::Transform(tables) => {
            let search = SearchSettings { target: Target::Psnr(header.min_psnr_db), ..search };
            let tables = Arc::new(PricedTables::new(tables.clone()));
            let mut encoder = TransformEncoder::new(format, search, CHUNK_FRAMES, tables);
            source.encode(|frame| match frame {
                Some(frame) => encoder.push(&samples(frame), quality),
                None => encoder.finish(quality),
            })?
        }
        ColorCoding::Cells(_) => {
            let CellFormat { size, blocks } = format;
            let mut encoder = CellEncoder::new(search, CLOSE_AT_BYTES);
            if let Some(blocks) = blocks {
                encoder = encoder.with_blocks(BlockStage { blocks, size, final_psnr_db: header.min_psnr_db });
            }
            let mut chunks = Vec::new();
            for frame in &source.frames {
                chunks.extend(encoder.push(&samples(frame), quality)?);
            }
            chunks.extend(encoder.finish(quality)?);
            chunks
        }
    };
    Ok(Clip::new("cell", CodecHeader::Color(header.clone()), source, chunks))
}

fn clip_of_bytes((_, size, count, pixel): Cell<u8>, header: &ColorHeader) -> Result<(Sequence<[u8; 3]>, Clip)> {
    let source = Sequence::new(size, count, pixel);
    let clip = clip_of(&source, header, header.cell_of_bytes(size), &EightBit, |sample| *sample)?;
    Ok((source, clip))
}

fn bytes(cell: Cell<u8>, header: &ColorHeader) -> Result<Measured> {
    let (source, clip) = clip_of_bytes(cell, header)?;
    let mut worst = Measured::nothing();
    clip.show(|frame, picture| {
        let Picture::Color8(shown) = picture else { return Err(Error::invalid("8-bit colour was expected")) };
        let (shown, source) = (shown.data().as_flattened(), source.frames[frame].as_flattened());
        let squares = shown.iter().zip(source).map(|(a, b)| f64::from(a.abs_diff(*b)).powi(2));
        worst.least(decibels(squares.sum(), source.len(), U8_PEAK), || format!("frame {frame}"));
        Ok(())
    })?;
    Ok(worst.with_clip(clip))
}

fn clip_of_halves((_, size, count, pixel): Cell<f16>, header: &ColorHeader) -> Result<(Sequence<[f16; 3]>, Clip)> {
    let source = Sequence::new(size, count, pixel);
    let key = |value: &f16| HalfKey::from_bits(value.to_bits());
    let clip = clip_of(&source, header, header.cell_of_halves(size), &Pu21::new(WHITE_CD_M2)?, key)?;
    Ok((source, clip))
}

/// Returns the largest error, in PU21, of a sample that is outside the PU21 range in the decoded or the source frame,
/// as color.md 5 defines it.
fn largest_outside(shown: &[f16], source: &[f16]) -> f64 {
    // Independent of the encoder's tables.
    let code = |half: f16| match half {
        half if half.is_nan() => pu21_encode(262_144f64.copysign(half.to_f64()) * WHITE_CD_M2),
        half if half.is_infinite() => pu21_encode(131_072f64.copysign(half.to_f64()) * WHITE_CD_M2),
        half => pu21_encode(half.to_f64() * WHITE_CD_M2),
    };
    let is_outside = |half: f16| !(PU21_MIN_CD_M2..=PU21_MAX_CD_M2).contains(&(half.to_f64() * WHITE_CD_M2));
    let pairs = shown.iter().zip(source).filter(|(shown, source)| is_outside(**shown) || is_outside(**source));
    pairs.fold(0.0, |largest, (shown, source)| (code(*shown) - code(*source)).abs().max(largest))
}

fn halves(cell: Cell<f16>, header: &ColorHeader) -> Result<Measured> {
    let (source, clip) = clip_of_halves(cell, header)?;
    let pu21 = Pu21::new(WHITE_CD_M2)?;
    let mut worst = Measured::nothing();
    clip.show(|frame, picture| {
        let (shown, source) = (halves_of(picture)?, source.frames[frame].as_flattened());
        // color.md 5 defines the bound in steps of PU21.
        let (squares, _) = pu21.between(shown, source);
        worst.least(decibels(squares as f64, source.len(), PU21_PEAK * PU_STEPS), || format!("frame {frame}"));
        Ok(())
    })?;
    Ok(worst.with_clip(clip))
}

/// Returns the largest error of samples outside the range of the metric, in multiples of the RMS error that the minimum
/// PSNR allows.
fn halves_outside(cell: Cell<f16>, header: &ColorHeader) -> Result<Measured> {
    let (source, clip) = clip_of_halves(cell, header)?;
    let rms = PU21_PEAK * 10f64.powf(-header.min_psnr_db / 20.0);
    let mut worst = Measured::count(0);
    clip.show(|frame, picture| {
        let largest = largest_outside(halves_of(picture)?, source.frames[frame].as_flattened());
        worst.greatest(largest / rms, || format!("frame {frame}"));
        Ok(())
    })?;
    Ok(worst.with_clip(clip))
}

/// Counts samples of all frames that are not bit exact.
fn changed_samples(cell: Cell<f16>, header: &ColorHeader) -> Result<Measured> {
    let (source, clip) = clip_of_halves(cell, header)?;
    let mut wrong = Measured::count(0);
    clip.show(|frame, picture| {
        for (shown, source) in halves_of(picture)?.iter().zip(source.frames[frame].as_flattened()) {
            let [shown, source] = [shown, source].map(|half| half.to_bits());
            wrong.count_if(shown != source, || format!("frame {frame}: {source:04x} became {shown:04x}"));
        }
        Ok(())
    })?;
    Ok(wrong.with_clip(clip))
}

fn halves_of(picture: &Picture) -> Result<&[f16]> {
    match picture {
        Picture::ColorHalf(shown) => Ok(shown.data().as_flattened()),
        _ => Err(Error::invalid("half floats were expected")),
    }
}

/// Counts samples that are not bit exact, in frames that are keyframes stored as samples.
fn changed_keyframes(cell: Cell<f16>, header: &ColorHeader) -> Result<Measured> {
    let (source, clip) = clip_of_halves(cell, header)?;
    let (mut exact, mut in_blocks) = (vec![false; source.frames.len()], 0);
    for chunk in &clip.chunks {
        let format = header.cell_of_halves(clip.size);
        let parsed = CellChunk::<HalfKey>::parse(chunk.payload.clone(), format, chunk.frame_count)?;
        for (at, frame) in parsed.keyframes.iter().enumerate() {
            exact[(chunk.first_frame + frame) as usize] = !parsed.in_blocks(at);
            in_blocks += u32::from(parsed.in_blocks(at));
        }
    }
    let mut wrong = Measured::count(0);
    clip.show(|frame, picture| {
        let Picture::ColorHalf(shown) = picture else { return Err(Error::invalid("half floats were expected")) };
        let samples = shown.data().as_flattened().iter().zip(source.frames[frame].as_flattened());
        for (shown, source) in samples.map(|(shown, source)| (shown.to_bits(), source.to_bits())) {
            let differs = exact[frame] && shown != source;
            wrong.count_if(differs, || format!("frame {frame}: {source:04x} became {shown:04x}"));
        }
        Ok(())
    })?;
    let samples = exact.iter().filter(|exact| **exact).count();
    // Fails if a stream without blocks has no keyframe stored as samples: nothing was compared.
    if samples == 0 && header.blocks().is_none() {
        wrong.figure = f64::NAN;
    }
    Ok(wrong.with_note(format!("{samples} keyframes of samples, {in_blocks} in blocks")))
}
