//! A region's samples, and their transforms of all sizes.

use pulp::{Arch, NullaryFnOnce};

use crate::color::transform::basis::{BASIS_BITS, basis, length_index};
use crate::color::transform::blocks::{Block, LEAST};
use crate::color::transform::domain::{CHANNELS, ChromaSlopes, Keyed, forward, forward_fine};
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
    /// Spatial coefficients by level of the block size: channel, frame, block row by row, row by row.
    spatial: Vec<Vec<f32>>,
    /// Variance of the samples of each channel.
    pub variances: [f32; CHANNELS],
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
        offset_set: usize,
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
        let is_fine = S::DOMAIN.pixel_fraction(offset_set) > 0;
        let channels = keys.iter().map(|&keys| match is_fine {
            true => forward_fine(keys, slopes, &S::DOMAIN),
            false => forward(keys, slopes, &S::DOMAIN).map(|value| value as f32),
        });
        let mut samples = vec![0.0; CHANNELS * keys.len()];
        for (at, values) in channels.enumerate() {
            for (channel, value) in values.into_iter().enumerate() {
                samples[channel * keys.len() + at] = value;
            }
        }
        let vectors = Arch::new();
        let transform = |level| vectors.dispatch(SpatialTransform { samples: &samples, side, size: LEAST << level });
        let spatial = (0..=root.shape.level).map(transform).collect();
        let variance = |samples: &[f32]| {
            let count = samples.len() as f32;
            let mean = samples.iter().sum::<f32>() / count;
            samples.iter().map(|value| (value - mean) * (value - mean)).sum::<f32>() / count
        };
        let variances = std::array::from_fn(|channel| variance(&samples[channel * keys.len()..][..keys.len()]));
        RegionSource { root, keys, spatial, variances }
    }

    /// Coefficients of a channel of a block by temporal frequency, each times the factor of its spatial frequency.
    pub fn coefficients(&self, channel: usize, block: Block, bases: &TimeBases, factors: &[f32], out: &mut Vec<f32>) {
        let (root, side, frames) = (self.root.shape, block.shape.side(), block.shape.frames);
        let first = (channel * root.frames + block.place.frame) * root.pixels();
        // A row of blocks above this one, and blocks to its left.
        let before = block.place.y * root.side() + block.place.x * side;
        out.clear();
        out.resize(frames * block.shape.pixels(), 0.0);
        Arch::new().dispatch(TimeTransform {
            spatial: &self.spatial[block.shape.level][first + before..],
            between: root.pixels(),
            basis: bases.of(frames),
            factors,
            side,
            out,
        });
    }
}

/// Transforms a block in time. Sums have the same order with all kinds of vectors.
struct TimeTransform<'a> {
    /// From the block's first coefficient on.
    spatial: &'a [f32],
    /// Coefficients from one frame to the next.
    between: usize,
    basis: &'a [f32],
    /// By the sum of the vertical and the horizontal frequency.
    factors: &'a [f32],
    side: usize,
    out: &'a mut [f32],
}

// All of it is inlined, so that it is compiled for each kind of vectors.
impl NullaryFnOnce for TimeTransform<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let TimeTransform { spatial, between, basis, factors, side, out } = self;
        let frames = basis.len().isqrt();
        let pixels = out.len() / frames;
        for (weights, out) in basis.chunks_exact(frames).zip(out.chunks_exact_mut(pixels)) {
            for (weight, frame) in weights.iter().zip(spatial.chunks(between)) {
                out.iter_mut().zip(frame).for_each(|(out, value)| *out += weight * value);
            }
            for (row, factors) in out.chunks_exact_mut(side).zip(factors.windows(side)) {
                row.iter_mut().zip(factors).for_each(|(out, factor)| *out *= factor);
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

    /// The basis of a length, one function a row.
    pub fn of(&self, frames: usize) -> &[f32] {
        &self.0[frames]
    }
}

/// Transforms all blocks of `size` pixels square of images of `side` pixels square.
struct SpatialTransform<'a> {
    samples: &'a [f32],
    side: usize,
    size: usize,
}

impl NullaryFnOnce for SpatialTransform<'_> {
    type Output = Vec<f32>;

    #[inline(always)]
    fn call(self) -> Vec<f32> {
        match self.size {
            4 => transform::<4>(self.samples, self.side),
            8 => transform::<8>(self.samples, self.side),
            16 => transform::<16>(self.samples, self.side),
            _ => transform::<32>(self.samples, self.side),
        }
    }
}

#[inline(always)]
fn transform<const SIZE: usize>(samples: &[f32], side: usize) -> Vec<f32> {
    let size = SIZE;
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
            // Of each row of `half`, a part goes to each block.
            for (at, half) in half.as_chunks::<SIZE>().0.iter().enumerate() {
                let (row, block) = (at / (side / size), at % (side / size));
                let mut sums = [0.0; SIZE];
                for (value, column) in half.iter().zip(columns.as_chunks::<SIZE>().0) {
                    sums.iter_mut().zip(column).for_each(|(sum, weight)| *sum += value * weight);
                }
                out[(block * size + row) * size..][..size].copy_from_slice(&sums);
            }
        }
    }
    out
}
