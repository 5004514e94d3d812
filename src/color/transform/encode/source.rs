//! A region's samples, and their transforms of all sizes.

use crate::color::transform::basis::{BASIS_BITS, basis, length_index};
use crate::color::transform::blocks::{Block, LEAST};
use crate::color::transform::domain::{CHANNELS, ChromaSlopes, Keyed, forward};
use crate::color::transform::palette::Color;

/// The samples of a cell: by frame, row by row, three a pixel.
#[derive(Debug)]
pub struct CellSource<'a, S> {
    pub size: [usize; 2],
    pub frames: &'a [Vec<S>],
}

/// A region, padded to the square of its root by repeating the last row and column.
#[derive(Debug)]
pub struct RegionSource {
    pub root: Block,
    /// Keys by frame, row by row.
    pub keys: Vec<Color>,
    /// Spatial coefficients by level of the block size: channel, frame, row by row.
    spatial: Vec<Vec<f32>>,
}

/// An orthonormal basis, one function a row.
pub fn orthonormal(points: usize) -> Vec<f32> {
    let scale = 1.0 / (f32::from(1u16 << BASIS_BITS) * (points as f32).sqrt());
    (0..points * points).map(|at| basis(points, at / points, at % points) as f32 * scale).collect()
}

impl RegionSource {
    pub fn new<S: Keyed>(
        cell: &CellSource<'_, S>,
        [left, top, width, height]: [usize; 4],
        slopes: ChromaSlopes,
    ) -> RegionSource {
        let root = Block::root([width, height], cell.frames.len());
        let side = root.shape.side();
        let mut keys = Vec::with_capacity(cell.frames.len() * side * side);
        for frame in cell.frames {
            for y in (0..side).map(|y| top + y.min(height - 1)) {
                let row = frame[3 * y * cell.size[0]..][..3 * cell.size[0]].as_chunks().0;
                keys.extend((0..side).map(|x| row[left + x.min(width - 1)].map(S::key)));
            }
        }
        let channels = keys.iter().map(|&keys| forward(keys, slopes, &S::DOMAIN));
        let mut samples = vec![0.0; CHANNELS * keys.len()];
        for (at, values) in channels.enumerate() {
            for (channel, value) in values.into_iter().enumerate() {
                samples[channel * keys.len() + at] = value as f32;
            }
        }
        let spatial = (0..=root.shape.level).map(|level| transform(&samples, side, LEAST << level)).collect();
        RegionSource { root, keys, spatial }
    }

    /// Coefficients of a channel of a block in units of `step`, by temporal frequency.
    pub fn coefficients(&self, channel: usize, block: Block, bases: &TimeBases, scale: f32, out: &mut Vec<f32>) {
        let (root, side, frames) = (self.root.shape, block.shape.side(), block.shape.frames);
        let frame_pixels = root.pixels();
        let first = (channel * root.frames + block.place.frame) * frame_pixels;
        let spatial = &self.spatial[block.shape.level][first..];
        let pixels = block.shape.pixels();
        out.clear();
        out.resize(frames * pixels, 0.0);
        let rows = |frame: usize| {
            let corner = frame * frame_pixels + block.place.y * root.side() + block.place.x;
            (0..side).map(move |y| &spatial[corner + y * root.side()..][..side])
        };
        let basis = bases.of(frames);
        for (plane, out) in out.chunks_exact_mut(pixels).enumerate() {
            for frame in 0..frames {
                let weight = basis[plane * frames + frame] * scale;
                for (out, row) in out.chunks_exact_mut(side).zip(rows(frame)) {
                    for (out, value) in out.iter_mut().zip(row) {
                        *out += weight * value;
                    }
                }
            }
        }
    }
}

/// Orthonormal bases in time.
#[derive(Debug)]
pub struct TimeBases(Vec<Vec<f32>>);

impl TimeBases {
    /// Bases of all lengths up to `frames`.
    pub fn up_to(frames: usize) -> TimeBases {
        let of = |length| if length_index(length).is_some() { orthonormal(length) } else { Vec::new() };
        TimeBases((0..=frames).map(of).collect())
    }

    fn of(&self, frames: usize) -> &[f32] {
        &self.0[frames]
    }
}

/// Transforms all blocks of `size` pixels square of images of `side` pixels square.
fn transform(samples: &[f32], side: usize, size: usize) -> Vec<f32> {
    let rows = orthonormal(size);
    let mut columns = vec![0.0; size * size];
    for (k, n) in (0..size).flat_map(|k| (0..size).map(move |n| (k, n))) {
        columns[n * size + k] = rows[k * size + n];
    }
    let mut out = vec![0.0; samples.len()];
    let mut half = vec![0.0; size * side];
    for (image, out) in samples.chunks_exact(side * side).zip(out.chunks_exact_mut(side * side)) {
        for (band, out) in image.chunks_exact(size * side).zip(out.chunks_exact_mut(size * side)) {
            half.fill(0.0);
            for (k, half) in half.chunks_exact_mut(side).enumerate() {
                for (row, weight) in band.chunks_exact(side).zip(&rows[k * size..]) {
                    half.iter_mut().zip(row).for_each(|(half, value)| *half += weight * value);
                }
            }
            for (half, out) in half.chunks_exact(size).zip(out.chunks_exact_mut(size)) {
                for (value, column) in half.iter().zip(columns.chunks_exact(size)) {
                    out.iter_mut().zip(column).for_each(|(out, weight)| *out += value * weight);
                }
            }
        }
    }
    out
}
