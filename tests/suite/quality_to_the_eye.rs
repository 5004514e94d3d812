//! Quality to the eye of encoded colour, measured by a second implementation of color.md 5.2.

use std::path::Path;

use codec::color::quality::Pu21;
use codec::color::{SearchSettings, Target};
use codec::container::Reader;
use codec::decode::{Decoder, Picture, StreamInfo};
use codec::effort::Effort;
use codec::image::transfer::{EncodeTable, ToneMap};
use codec::image::{ColorPlane, Face, Plane, StreamKind};
use codec::monitor::Silent;
use codec::streams::{ColorFormat, convert};
use footage::dataset::{Source, SourceGroup, SourceOptions};
use footage::encode::EncodeSettings;
use half::f16;
use scene::{DemoKind, FootagePlan};
use serde_json::Value;
use tempfile::TempDir;

use crate::commands::{fine, lightfold};
use crate::footage::{Footage, Random, drifting_color};
use crate::roundtrip::{decoder, encoded};

const HALF: ColorFormat = ColorFormat::Half { white_cd_m2: 100.0 };
const WEIGHTS: [[f64; 4]; 3] = [[0.5, 0.5, 8.0, 1.0], [0.03125, 0.04, 0.09, 0.125], [0.00625, 0.008, 0.018, 0.025]];

/// Returns the quality of pixels of red, green and blue codes.
fn quality([width, height]: [usize; 2], shown: &[[f64; 3]], source: &[[f64; 3]]) -> f64 {
    let (mut sum, mut squares) = (0.0, 0.0);
    for (top, left) in (0..height).step_by(8).flat_map(|top| (0..width).step_by(8).map(move |left| (top, left))) {
        let at = |picture: &[[f64; 3]], x: usize, y: usize| {
            picture[(top + y).min(height - 1) * width + (left + x).min(width - 1)]
        };
        let luma = |[red, green, blue]: [f64; 3]| (red + 2.0 * green + blue) / 4.0;
        let mut error = 0.0;
        for (channel, weights) in WEIGHTS.iter().enumerate() {
            let value = |x: usize, y: usize| {
                let [shown, source] = [shown, source].map(|picture| at(picture, x, y));
                let [red, green, blue] = [0, 1, 2].map(|sample| shown[sample] - source[sample]);
                [luma([red, green, blue]), green - (red + blue) / 2.0, red - blue][channel]
            };
            let energy = |side: usize| -> f64 {
                let starts = || (0..8).step_by(side);
                let sum = |left: usize, top: usize| -> f64 {
                    (top..top + side)
                        .flat_map(|y| (left..left + side).map(move |x| (x, y)))
                        .map(|(x, y)| value(x, y))
                        .sum()
                };
                starts()
                    .flat_map(|top| starts().map(move |left| (left, top)))
                    .map(|(left, top)| sum(left, top).powi(2))
                    .sum::<f64>()
                    / (side * side) as f64
            };
            let [one, two, four, eight] = [1, 2, 4, 8].map(energy);
            error +=
                weights[0] * (one - two) + weights[1] * (two - four) + weights[2] * (four - eight) + weights[3] * eight;
        }
        let lumas: Vec<f64> = (0..64).map(|place| luma(at(source, place % 8, place / 8))).collect();
        let mean = lumas.iter().sum::<f64>() / 64.0;
        let variance = lumas.iter().map(|luma| (luma - mean).powi(2)).sum::<f64>() / 64.0;
        sum += error / 64.0 * 140.0 / (40.0 + variance);
        squares += 1.0;
    }
    100.0 - 7.8 * (sum / squares).max(0.0).sqrt()
}

fn cut<T: Copy>(plane: &Plane<T>, [left, top, width, height]: [u32; 4]) -> Vec<T> {
    (top..top + height).flat_map(|y| (left..left + width).map(move |x| (x, y))).map(|(x, y)| plane.get(x, y)).collect()
}

/// Returns the image of a face and a frame.
type Pictures<'a> = &'a dyn Fn(Face, u32) -> ColorPlane;

/// Encodes images and returns the quality of each frame of each cell.
fn qualities(color: Pictures<'_>, size: [u32; 2], settings: &EncodeSettings) -> Vec<f64> {
    let folder = TempDir::new().unwrap();
    let source = Footage { color: Some(color), frames: [0, 6], ..Footage::new(size[0], size[1]) }.open(folder.path());
    let bytes = encoded(&source, settings);
    let (decoder, metric) = (decoder(&bytes), Pu21::new(100.0).unwrap());
    let stream = &decoder.streams()[0];
    let mut face = decoder.face(stream);
    let mut all = Vec::new();
    for frame in stream.frames.iter() {
        let wanted = source.read_color(&source.groups()[0], frame).unwrap().remove(0);
        let shown = face.decode(frame).unwrap();
        for unit in 0..stream.entry.unit_count() {
            let rect = stream.entry.unit_rect(unit);
            let [shown, source] = match &shown {
                Picture::Color8(shown) => {
                    let (wanted, _) = convert::color_codes(&wanted, &EncodeTable::new(&ToneMap::default()));
                    [cut(shown, rect), cut(&wanted, rect)]
                        .map(|pixels| pixels.into_iter().map(|pixel| pixel.map(f64::from)).collect::<Vec<_>>())
                }
                Picture::ColorHalf(shown) => {
                    let least = settings.search.target.min_quality();
                    let code = |value: f16| f64::from(metric.steps(value)) / 64.0;
                    let [shown, source] = [cut(shown, rect), cut(&wanted, rect)];
                    for (shown, source) in shown.as_flattened().iter().zip(source.as_flattened()) {
                        // 0.005 and 10000 cd/m² are 0.00005 and 100 in linear RGB at this white.
                        let is_outside = |value: &f16| !(0.00005..=100.0).contains(&value.to_f64());
                        let error = (code(*shown) - code(*source)).abs();
                        assert!(
                            !(is_outside(shown) || is_outside(source)) || error <= 0.4 * (100.0 - least),
                            "{source} as {shown}"
                        );
                    }
                    [shown, source].map(|pixels| pixels.into_iter().map(|pixel| pixel.map(code)).collect::<Vec<_>>())
                }
                _ => panic!("colour was expected"),
            };
            all.push(quality([rect[2], rect[3]].map(|side| side as usize), &shown, &source));
        }
    }
    all
}

fn settings(color: ColorFormat, cell: u32, least: f64) -> EncodeSettings {
    let search = SearchSettings { target: Target::Quality(least), effort: Effort::Fast, ..SearchSettings::default() };
    EncodeSettings { cell, color, color_chunk: 4, search, ..EncodeSettings::default() }
}

fn noise(_: Face, frame: u32) -> ColorPlane {
    let mut random = Random(u64::from(frame));
    Plane::from_fn(40, 40, |_, _| [(); 3].map(|()| f16::from_f32(random.below(256) as f32 / 255.0)))
}

/// Returns a dark ramp with a lamp that moves and a corner of negative values.
fn lamp(_: Face, frame: u32) -> ColorPlane {
    Plane::from_fn(40, 40, |x, y| {
        let light = match (x / 3, y / 3) {
            (column, row) if [column, row] == [2 + frame, 5] => 40_000.0,
            (0, 0) => -0.5,
            _ => 0.000_01 * f32::powi(1.2, x as i32) * (1.0 + 0.01 * y as f32),
        };
        [light, 0.9 * light, 0.7 * light].map(f16::from_f32)
    })
}

#[test]
fn each_frame_of_each_cell_keeps_it() {
    let drifting = |_: Face, frame: u32| drifting_color(43, 37, frame);
    let kinds: [(Pictures<'_>, [u32; 2]); 3] = [(&drifting, [43, 37]), (&noise, [40, 40]), (&lamp, [40, 40])];
    for (color, size) in kinds {
        for format in [EncodeSettings::default().color, HALF] {
            let mut means = Vec::new();
            for least in [40.0, 77.0, 92.0, 99.0] {
                let all = qualities(color, size, &settings(format, 16, least));
                let worst = all.iter().copied().fold(f64::INFINITY, f64::min);
                assert!(worst >= least - 1e-3, "{worst} of {least} in {format:?}");
                means.push(all.iter().sum::<f64>() / all.len() as f64);
            }
            assert!(means[2] > means[1] && means[3] > means[2], "{means:?} in {format:?}");
        }
    }
}

#[test]
fn nothing_is_lost_at_100() {
    let all = qualities(&noise, [40, 40], &settings(EncodeSettings::default().color, 16, 100.0));
    assert!(all.iter().all(|&quality| quality == 100.0), "{all:?}");
}

#[test]
fn diff_measures_what_encode_keeps() {
    let folder = TempDir::new().unwrap();
    let color = |_: Face, frame: u32| drifting_color(48, 32, frame);
    Footage { color: Some(&color), ..Footage::new(48, 32) }.write(folder.path());
    let folder = folder.path();
    fine("encode . --clip -o film.lfold --quality 70 --color-cell 16 -q", folder);
    let report: Value =
        serde_json::from_slice(&fine("diff . film.lfold --allow-clipping --json", folder).stdout).unwrap();
    let least = report["color"]["min_quality"].as_f64().unwrap();
    assert!(least >= 70.0, "{least}");
    let at = &report["color"]["min_quality_at"];
    assert!(at["frame"].is_u64() && at["x"].as_u64().unwrap().is_multiple_of(16), "{at}");
    fine("diff . film.lfold --allow-clipping --min-quality 70", folder);
    let output = lightfold(&["diff", ".", "film.lfold", "--allow-clipping", "--min-quality", "99.9"], folder);
    assert_eq!(output.status.code(), Some(1));
    let said = String::from_utf8(output.stdout).unwrap() + &String::from_utf8(output.stderr).unwrap();
    assert!(said.contains("--min-quality 99.90 does not hold"), "{said}");
}

/// Grids of borders of cells, regions and blocks, in pixels, from coarse to fine; the last stands for pixels on no border.
const GRIDS: [u32; 6] = [64, 32, 16, 8, 4, 1];

/// Visible artefacts where the source is smooth or static, in luma codes above the source.
#[derive(Debug)]
struct Seen {
    /// Mean steps between neighbours across the lines of each grid, less those of the last grid.
    borders: [f64; 5],
    /// Maximum over consecutive frames of the mean difference between them.
    flicker: f64,
}

/// Returns the values up to `reach` pixels away, the pixel itself included.
fn around(plane: &Plane<i32>, [x, y]: [u32; 2], reach: u32) -> impl Iterator<Item = i32> + '_ {
    let [columns, rows] = [(x, plane.width()), (y, plane.height())]
        .map(|(at, side)| at.saturating_sub(reach)..(at + reach + 1).min(side));
    rows.flat_map(move |y| columns.clone().map(move |x| plane.get(x, y)))
}

/// Luma of a face in all frames, in quarters of a code: decoded, and of the source.
type Film = [Vec<Plane<i32>>; 2];

/// Encodes the footage of a folder with options and returns the films of all faces.
fn films(folder: &Path, options: &str) -> Vec<Film> {
    fine(&format!("encode . --clip --stream color -o film.lfold -q {options}"), folder);
    let source = Source::open(folder, &SourceOptions::default()).unwrap();
    let decoder = Decoder::new(Reader::open(folder.join("film.lfold")).unwrap()).unwrap();
    let table = EncodeTable::new(&ToneMap::default());
    let luma = |&[red, green, blue]: &[u8; 3]| i32::from(red) + 2 * i32::from(green) + i32::from(blue);
    let film = |stream: &StreamInfo| {
        let is_same = |group: &&SourceGroup| group.kind == StreamKind::Color && group.faces.contains(&stream.face);
        let group = source.groups().iter().find(is_same).unwrap();
        let at = group.faces.iter().position(|face| *face == stream.face).unwrap();
        let mut face = decoder.face(stream);
        let lumas = stream.frames.iter().map(|frame| {
            let Picture::Color8(shown) = face.decode(frame).unwrap() else { panic!("colour of 8 bits") };
            let wanted = &source.read_color(group, frame).unwrap()[at];
            (shown.map(luma), convert::color_codes(wanted, &table).0.map(luma))
        });
        <[_; 2]>::from(lumas.unzip::<_, _, Vec<_>, Vec<_>>())
    };
    decoder.streams().iter().map(film).collect()
}

fn seen(films: &[Film]) -> Seen {
    // Sums of the excess over the source, and their counts.
    let (mut steps, mut changes) = ([[0.0; 2]; GRIDS.len()], vec![[0.0; 2]; films[0][0].len() - 1]);
    for [shown, source] in films {
        let [width, height] = [source[0].width(), source[0].height()];
        let places = || (0..height - 1).flat_map(move |y| (0..width - 1).map(move |x| [x, y]));
        let step = |plane: &Plane<i32>, [ax, ay]: [u32; 2], [bx, by]: [u32; 2]| {
            f64::from((plane.get(ax, ay) - plane.get(bx, by)).abs()) / 4.0
        };
        for (shown, source) in shown.iter().zip(source) {
            let smooth = Plane::from_fn(width, height, |x, y| {
                around(source, [x, y], 4).max().unwrap() - around(source, [x, y], 4).min().unwrap() <= 6 * 4
            });
            for [x, y] in places() {
                for (to, line) in [([x + 1, y], x + 1), ([x, y + 1], y + 1)] {
                    if smooth.get(x, y) && smooth.get(to[0], to[1]) {
                        let grid = GRIDS.iter().position(|&grid| line.is_multiple_of(grid)).unwrap();
                        steps[grid][0] += step(shown, [x, y], to) - step(source, [x, y], to);
                        steps[grid][1] += 1.0;
                    }
                }
            }
        }
        let moved = Plane::from_fn(width, height, |x, y| {
            let values = || source.iter().map(move |frame| frame.get(x, y));
            values().max().unwrap() - values().min().unwrap()
        });
        for [x, y] in places().filter(|&place| around(&moved, place, 2).all(|moved| moved <= 2 * 4)) {
            let change = |two: &[Plane<i32>]| f64::from((two[0].get(x, y) - two[1].get(x, y)).abs()) / 4.0;
            for ((sum, shown), source) in changes.iter_mut().zip(shown.windows(2)).zip(source.windows(2)) {
                sum[0] += change(shown) - change(source);
                sum[1] += 1.0;
            }
        }
    }
    // With fewer samples the means would not be significant.
    assert!(steps.iter().chain(&changes).all(|[_, count]| *count >= 5000.0), "{steps:?} {changes:?}");
    let mean = |[sum, count]: [f64; 2]| sum / count;
    let inside = mean(steps[GRIDS.len() - 1]);
    Seen {
        borders: [0, 1, 2, 3, 4].map(|grid| mean(steps[grid]) - inside),
        flicker: changes.into_iter().map(mean).fold(f64::MIN, f64::max),
    }
}

/// Maximum flicker at the end of a chunk.
const MAX_FLICKER_OF_CHUNKS: f64 = 0.2;

/// Maximum artefacts in a scene.
struct Bounds {
    kind: DemoKind,
    /// Maximum excess at borders of cells, regions, and blocks of 16, 8 and 4 pixels.
    borders: [f64; 5],
    flicker: f64,
}

#[cfg_attr(not(all_tests), ignore = "long: scripts/test all runs it")]
#[test]
fn no_edges_of_blocks_and_no_flicker_are_seen_at_the_default() {
    // The bounds are slightly above the measured values.
    let [interior, courtyard] = [[0.26, 0.28, 0.07, 0.035, 0.01], [0.11, 0.105, 0.015, 0.01, 0.01]];
    for Bounds { kind, borders, flicker } in [
        Bounds { kind: DemoKind::Interior, borders: interior, flicker: 0.006 },
        Bounds { kind: DemoKind::Courtyard, borders: courtyard, flicker: 0.003 },
    ] {
        let folder = TempDir::new().unwrap();
        FootagePlan { kind, frames: 4, face_size: 256, probes: 1 }.write(folder.path(), &Silent).unwrap();
        let at = |options: &str| seen(&films(folder.path(), options));
        let (usual, cut, coarse) = (at(""), at("--color-chunk 2"), at("--quality 40"));
        println!("{kind:?}: {usual:?}, in two chunks {cut:?}, at 40 {coarse:?}");
        for (excess, most) in usual.borders.iter().zip(borders) {
            assert!(*excess <= most, "{kind:?}: {usual:?} of {borders:?}");
        }
        assert!(usual.flicker <= flicker && cut.flicker <= MAX_FLICKER_OF_CHUNKS, "{kind:?}: {usual:?}, {cut:?}");
        // A coarser setting exceeds the bounds.
        assert!(coarse.borders[0] > 1.5 * borders[0] && coarse.borders[1] > 1.5 * borders[1], "{kind:?}: {coarse:?}");
        assert!(coarse.flicker > flicker, "{kind:?}: {coarse:?}");
    }
}
