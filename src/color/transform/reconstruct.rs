//! From levels to samples: one frame of a cell's chunk (color.md 6.3).

use crate::color::transform::basis::{BASIS_BITS, basis, length_index, matrix};
use crate::color::transform::blocks::{Block, regions};
use crate::color::transform::domain::{CHANNELS, ChromaSlopes, Keyed, inverse};
use crate::color::transform::levels::Level;
use crate::color::transform::payload::{Layout, check_frames};
use crate::color::transform::region::{ChannelLevels, Content, Leaf, Region};
use crate::color::transform::steps::{Steps, dequantise};
use crate::color::transform::tables::Tables;
use crate::error::Result;

static BASIS_4: [[i32; 4]; 4] = matrix();
static BASIS_8: [[i32; 8]; 8] = matrix();
static BASIS_16: [[i32; 16]; 16] = matrix();
static BASIS_32: [[i32; 32]; 32] = matrix();
const MOST_PIXELS: usize = 32 * 32;

/// A chunk of a cell, as it was read: any of its frames can be shown.
#[derive(Debug)]
pub struct TransformChunk {
    size: [usize; 2],
    steps: Steps,
    slopes: ChromaSlopes,
    regions: Vec<Region>,
}

impl TransformChunk {
    pub fn parse<S: Keyed>(payload: &[u8], size: [usize; 2], frames: u32, tables: &Tables) -> Result<Self> {
        check_frames(frames)?;
        let layout = Layout::parse::<S>(payload, size, tables)?;
        let set = &tables.sets()[layout.header.set];
        let read = |([_, _, width, height], substream): ([usize; 4], &std::ops::Range<usize>)| {
            let root = Block::root([width, height], frames as usize);
            let bytes = (&payload[substream.clone()], substream.start);
            Region::read(bytes, root, &layout.header, set, &S::DOMAIN)
        };
        let regions = regions(size).zip(&layout.substreams).map(read).collect::<Result<_>>()?;
        let steps = Steps::new(layout.header.steps, &S::DOMAIN);
        Ok(TransformChunk { size, steps, slopes: layout.header.slopes, regions })
    }

    pub fn regions(&self) -> &[Region] {
        &self.regions
    }

    /// Writes a frame into `out`, three samples a pixel; blocks that show the same in `shown`, which is in `out`, are
    /// left alone. Answers the number of pixels written.
    pub fn show<S: Keyed>(&self, frame: usize, shown: Option<usize>, out: &mut [S]) -> u64 {
        let mut updated = 0;
        let mut scratch = Scratch::default();
        for ([left, top, width, height], region) in regions(self.size).zip(&self.regions) {
            for leaf in region.leaves.iter().filter(|leaf| leaf.block.contains_frame(frame)) {
                if shown.is_some_and(|shown| leaf.is_same(region, frame, shown)) {
                    continue;
                }
                self.decode_leaf::<S>(region, leaf, frame, &mut scratch);
                let (place, side) = (leaf.block.place, leaf.block.shape.side());
                let [columns, rows] =
                    [width.saturating_sub(place.x), height.saturating_sub(place.y)].map(|n| n.min(side));
                for y in 0..rows {
                    let keys = &scratch.keys[y * side..][..columns];
                    let first = 3 * ((top + place.y + y) * self.size[0] + left + place.x);
                    for (samples, keys) in out[first..][..3 * columns].as_chunks_mut().0.iter_mut().zip(keys) {
                        *samples = keys.map(S::from_key);
                    }
                }
                updated += (columns * rows) as u64;
            }
        }
        updated
    }

    fn decode_leaf<S: Keyed>(&self, region: &Region, leaf: &Leaf, frame: usize, scratch: &mut Scratch) {
        let (shape, frame) = (leaf.block.shape, frame - leaf.block.place.frame);
        let pixels = shape.pixels();
        match &leaf.content {
            Content::Palette(index) => {
                let palette = &region.palettes[*index];
                match palette.frame(shape, frame) {
                    Some(indices) => {
                        for (keys, &index) in scratch.keys.iter_mut().zip(indices) {
                            *keys = palette.colors[usize::from(index)];
                        }
                    }
                    None => scratch.keys[..pixels].fill(palette.colors[0]),
                }
            }
            Content::Transform { channels, .. } => {
                let Scratch { keys, coefficients, planes } = scratch;
                let length = length_index(shape.frames).unwrap_or(0);
                for (channel, plane) in planes.iter_mut().enumerate() {
                    let step = self.steps.step(channel, length);
                    let of = &channels[channel];
                    let source = FrameLevels { levels: &region.levels[of.levels.clone()], of, step, frame };
                    source.coefficients(shape.side(), shape.frames, coefficients);
                    let bits = S::DOMAIN.fraction_bits;
                    match shape.level {
                        0 => inverse_transform(&BASIS_4, coefficients, of.extent, bits, plane),
                        1 => inverse_transform(&BASIS_8, coefficients, of.extent, bits, plane),
                        2 => inverse_transform(&BASIS_16, coefficients, of.extent, bits, plane),
                        _ => inverse_transform(&BASIS_32, coefficients, of.extent, bits, plane),
                    }
                }
                let [luma, green, orange] = planes;
                for (at, keys) in keys[..pixels].iter_mut().enumerate() {
                    *keys = inverse([luma[at], green[at], orange[at]], self.slopes, &S::DOMAIN);
                }
            }
        }
    }
}

impl Leaf {
    /// Whether two frames of the chunk show the same in this block.
    fn is_same(&self, region: &Region, frame: usize, other: usize) -> bool {
        if !self.block.contains_frame(other) {
            return false;
        }
        match &self.content {
            Content::Transform { still, .. } => *still || frame == other,
            Content::Palette(index) => {
                let [a, b] = [frame, other]
                    .map(|frame| region.palettes[*index].frame(self.block.shape, frame - self.block.place.frame));
                a == b
            }
        }
    }
}

/// Room for one block.
struct Scratch {
    keys: [[i32; 3]; MOST_PIXELS],
    coefficients: [i32; MOST_PIXELS],
    planes: [[i32; MOST_PIXELS]; CHANNELS],
}

impl Default for Scratch {
    fn default() -> Self {
        Scratch { keys: [[0; 3]; MOST_PIXELS], coefficients: [0; MOST_PIXELS], planes: [[0; MOST_PIXELS]; CHANNELS] }
    }
}

/// The levels of a channel, for one frame of the block.
struct FrameLevels<'a> {
    levels: &'a [Level],
    of: &'a ChannelLevels,
    step: i32,
    frame: usize,
}

impl FrameLevels<'_> {
    /// The inverse transform in time: the frame's spatial coefficients, in units of 2^-fraction.
    fn coefficients(&self, side: usize, frames: usize, out: &mut [i32; MOST_PIXELS]) {
        let [columns, rows] = self.of.extent;
        for row in out.chunks_exact_mut(side).take(rows) {
            row[..columns].fill(0);
        }
        let mut mean = self.of.predicted;
        for level in self.levels {
            if level.plane == 0 && level.position.0 == 0 {
                mean = mean.wrapping_add(level.value);
                continue;
            }
            let weight = basis(frames, level.plane.into(), self.frame);
            let at = &mut out[level.position.y() * side + level.position.x()];
            *at = at.wrapping_add(dequantise(level.value, self.step).wrapping_mul(weight));
        }
        out[0] = out[0].wrapping_add(dequantise(mean, self.step) << BASIS_BITS);
        for row in out.chunks_exact_mut(side).take(rows) {
            for value in &mut row[..columns] {
                *value = value.wrapping_add(1 << (BASIS_BITS - 1)) >> BASIS_BITS;
            }
        }
    }
}

/// The inverse transform in space: first all columns that have coefficients, then all rows.
fn inverse_transform<const N: usize>(
    basis: &[[i32; N]; N],
    coefficients: &[i32],
    [columns, rows]: [usize; 2],
    fraction_bits: u32,
    out: &mut [i32],
) {
    let mut half = [[1 << (BASIS_BITS - 1); N]; N];
    for (function, coefficients) in basis.iter().zip(coefficients.chunks_exact(N)).take(rows) {
        for (row, &weight) in half.iter_mut().zip(function) {
            for (sum, &coefficient) in row[..columns].iter_mut().zip(coefficients) {
                *sum = i32::wrapping_add(*sum, weight.wrapping_mul(coefficient));
            }
        }
    }
    let shift = BASIS_BITS + fraction_bits + N.trailing_zeros();
    for (half, out) in half.iter().zip(out.chunks_exact_mut(N)) {
        let mut sums = [1 << (shift - 1); N];
        for (&value, function) in half[..columns].iter().zip(basis) {
            let value = value >> BASIS_BITS;
            for (sum, &weight) in sums.iter_mut().zip(function) {
                *sum = i32::wrapping_add(*sum, value.wrapping_mul(weight));
            }
        }
        for (out, sum) in out.iter_mut().zip(sums) {
            *out = sum >> shift;
        }
    }
}
