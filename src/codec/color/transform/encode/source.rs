//! Samples of a region, and their transforms of all block sizes.

use pulp::{Arch, NullaryFnOnce};

use crate::color::transform::basis::{BASIS_BITS, basis, length_index};
use crate::color::transform::blocks::{Block, MIN_SIDE};
use crate::color::transform::domain::{CHANNELS, ChromaSlopes, Keyed, forward, forward_fine};
use crate::color::transform::palette::Color;

/// Samples of a cell: by frame, row by row, three per pixel.
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
    /// Spatial coefficients by size class of the blocks; ordered by channel, frame, block row by row, and coefficient row by
    /// row.
    spatial: Vec<Vec<f32>>,
    /// Variance of the samples of each channel.
    pub variances: [f32; CHANNELS],
}

/// Returns an orthonormal cosine basis, one function per row.
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
        let mut samples = vec![0.0; CHANNELS * keys.len()];
        let (luma, chroma) = samples.split_at_mut(keys.len());
        let (green, orange) = chroma.split_at_mut(keys.len());
        for (((&keys, luma), green), orange) in keys.iter().zip(luma).zip(green).zip(orange) {
            [*luma, *green, *orange] = match is_fine {
                true => forward_fine(keys, slopes, &S::DOMAIN),
                false => forward(keys, slopes, &S::DOMAIN).map(|value| value as f32),
            };
        }
        let vectors = Arch::new();
        let transform = |level| vectors.dispatch(SpatialTransform { samples: &samples, side, size: MIN_SIDE << level });
        let spatial = (0..=root.shape.level).map(transform).collect();
        let variances = std::array::from_fn(|channel| variance(&samples[channel * keys.len()..][..keys.len()]));
        RegionSource { root, keys, spatial, variances }
    }

    /// Computes the coefficients of a channel of a block by temporal frequency, each times the factor of its spatial
    /// frequency.
    pub fn coefficients(&self, channel: usize, block: Block, bases: &TimeBases, factors: &[f32], out: &mut Vec<f32>) {
        let (root, side, frames) = (self.root.shape, block.shape.side(), block.shape.frames);
        let first = (channel * root.frames + block.place.frame) * root.pixels();
        // Coefficients of the rows of blocks above this one, and of the blocks to its left.
        let before = block.place.y * root.side() + block.place.x * side;
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

/// Transform of a block in time. The order of summation is the same for all vector instruction sets.
struct TimeTransform<'a> {
    /// Spatial coefficients, from the block's first one on.
    spatial: &'a [f32],
    /// Number of coefficients from one frame to the next.
    between: usize,
    basis: &'a [f32],
    /// Factors by the sum of the vertical and the horizontal frequency.
    factors: &'a [f32],
    side: usize,
    /// Output for the coefficients of all frames of the block.
    out: &'a mut [f32],
}

// Everything is inlined, so that it is compiled for each vector instruction set.
impl NullaryFnOnce for TimeTransform<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        match self.side {
            4 => transform_in_time::<4>(self),
            8 => transform_in_time::<8>(self),
            16 => transform_in_time::<16>(self),
            _ => transform_in_time::<32>(self),
        }
    }
}

#[inline(always)]
fn transform_in_time<const SIDE: usize>(of: TimeTransform<'_>) {
    let TimeTransform { spatial, between, basis, factors, out, .. } = of;
    let frames = basis.len().isqrt();
    for (weights, out) in basis.chunks_exact(frames).zip(out.chunks_exact_mut(SIDE * SIDE)) {
        for (y, out) in out.as_chunks_mut::<SIDE>().0.iter_mut().enumerate() {
            let mut sums = [0.0; SIDE];
            for (weight, frame) in weights.iter().zip(spatial.chunks(between)) {
                let row = &frame[SIDE * y..][..SIDE];
                sums.iter_mut().zip(row).for_each(|(sum, value)| *sum += weight * value);
            }
            let factors = &factors[y..][..SIDE];
            for ((out, sum), factor) in out.iter_mut().zip(sums).zip(factors) {
                *out = sum * factor;
            }
        }
    }
}

fn variance(samples: &[f32]) -> f32 {
    let mean = mean_of(samples, |sample| sample);
    mean_of(samples, |sample| (sample - mean) * (sample - mean))
}

/// Mean of a function of samples. The order of summation is the same for all vector instruction sets.
#[inline(always)]
fn mean_of(samples: &[f32], value: impl Fn(f32) -> f32) -> f32 {
    let (chunks, rest) = samples.as_chunks::<16>();
    let mut sums = [0.0; 16];
    for chunk in chunks {
        sums.iter_mut().zip(chunk).for_each(|(sum, &sample)| *sum += value(sample));
    }
    let rest = rest.iter().map(|&sample| value(sample)).sum::<f32>();
    (sums.iter().sum::<f32>() + rest) / samples.len() as f32
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

    /// Returns the basis of a length, one function per row.
    pub fn of(&self, frames: usize) -> &[f32] {
        &self.0[frames]
    }
}

/// Transform of all blocks of `size` pixels square in images of `side` pixels square.
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
    let rows = orthonormal(SIZE);
    let mut columns = [[0.0; SIZE]; SIZE];
    for (k, n) in (0..SIZE).flat_map(|k| (0..SIZE).map(move |n| (k, n))) {
        columns[n][k] = rows[k * SIZE + n];
    }
    let mut out = Vec::with_capacity(samples.len());
    for band in samples.chunks_exact(side * SIZE) {
        for (left, row) in
            (0..side).step_by(SIZE).flat_map(|left| rows.as_chunks::<SIZE>().0.iter().map(move |row| (left, row)))
        {
            let mut half = [0.0; SIZE];
            for (weight, row) in row.iter().zip(band.chunks_exact(side)) {
                half.iter_mut().zip(&row[left..][..SIZE]).for_each(|(half, value)| *half += weight * value);
            }
            let mut sums = [0.0; SIZE];
            for (value, column) in half.iter().zip(&columns) {
                sums.iter_mut().zip(column).for_each(|(sum, weight)| *sum += value * weight);
            }
            out.extend_from_slice(&sums);
        }
    }
    out
}
