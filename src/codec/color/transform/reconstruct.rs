//! Reconstructs the samples of one frame of a cell's chunk from its levels (color.md 6.3).

use std::collections::BTreeMap;

use pulp::{Arch, NullaryFnOnce};

use crate::color::transform::basis::{BASIS_BITS, LENGTHS, MAX_LENGTH, basis, length_index};
use crate::color::transform::blocks::{Block, Shape, regions};
use crate::color::transform::contexts::Tables;
use crate::color::transform::domain::{CHANNELS, ChromaSlopes, Keyed, inverse};
use crate::color::transform::levels::Level;
use crate::color::transform::palette::Palette;
use crate::color::transform::payload::{Layout, check_frames};
use crate::color::transform::region::{ChannelLevels, Content, Leaf, Region, Setting};
use crate::error::Result;

/// Distance between rows of coefficients, as in `Position`.
const ROW: usize = 32;
const MAX_PIXELS: usize = ROW * ROW;

/// Weights of planes by frame, for each length; a frame has [`MAX_LENGTH`] weights.
static TIME_BASES: [[i32; MAX_LENGTH * MAX_LENGTH]; LENGTHS.len()] = {
    let mut bases = [[0; MAX_LENGTH * MAX_LENGTH]; LENGTHS.len()];
    let mut at = 0;
    while at < LENGTHS.len() {
        let mut frame = 0;
        while frame < LENGTHS[at] {
            let mut plane = 0;
            while plane < LENGTHS[at] {
                bases[at][frame * MAX_LENGTH + plane] = basis(LENGTHS[at], plane, frame);
                plane += 1;
            }
            frame += 1;
        }
        at += 1;
    }
    bases
};

/// A parsed chunk of a cell, of which any frame can be decoded.
#[derive(Debug)]
pub struct TransformChunk {
    size: [usize; 2],
    slopes: ChromaSlopes,
    /// Fraction bits of the channels of pixels.
    pixel_fraction: u32,
    regions: Vec<Region>,
}

impl TransformChunk {
    pub fn parse<S: Keyed>(payload: &[u8], size: [usize; 2], frames: u32, tables: &Tables) -> Result<Self> {
        check_frames(frames)?;
        let layout = Layout::parse::<S>(payload, size, tables)?;
        let set = &tables.sets()[layout.header.set];
        let read = |(([_, _, width, height], substream), &delta): (([usize; 4], &std::ops::Range<usize>), &i8)| {
            let root = Block::root([width, height], frames as usize);
            let bytes = (&payload[substream.clone()], substream.start);
            Region::read(bytes, root, Setting { header: &layout.header, delta, domain: &S::DOMAIN }, set)
        };
        let mut read_regions = Vec::with_capacity(layout.substreams.len());
        for region in regions(size).zip(&layout.substreams).zip(&layout.deltas).map(read) {
            read_regions.push(region?);
        }
        let pixel_fraction = S::DOMAIN.pixel_fraction(layout.header.offset_set);
        Ok(TransformChunk { size, slopes: layout.header.slopes, pixel_fraction, regions: read_regions })
    }

    pub fn size(&self) -> [usize; 2] {
        self.size
    }

    pub fn regions(&self) -> &[Region] {
        &self.regions
    }

    /// Decodes a frame into `out`, three samples per pixel. Blocks that are equal in frame `shown`, whose samples are in
    /// `out`, are not written. Returns the number of pixels written.
    pub fn show<S: Keyed>(&self, frame: usize, shown: Option<usize>, out: &mut [S]) -> u64 {
        let mut updated = 0;
        let mut planes = Planes::default();
        for (region, leaf, [left, top, columns, rows]) in self.changes(frame, shown) {
            let Block { place, shape } = leaf.block();
            let window = Window { columns, rows, side: shape.side(), stride: 3 * self.size[0] };
            let out = out.get_mut(3 * (top * self.size[0] + left)..).unwrap_or_default();
            match &leaf.content {
                Content::Palette(palette) => window.write_palette(palette, shape, frame - place.frame, out),
                Content::Transform { channels, .. } => {
                    self.decode_channels::<S>(region, channels, (shape, frame - place.frame), &mut planes);
                    let (slopes, fraction) = (self.slopes, self.pixel_fraction);
                    let channels = &planes.channels;
                    planes.vectors.dispatch(PixelWriter { window, channels, slopes, fraction, out });
                }
            }
            updated += (columns * rows) as u64;
        }
        updated
    }

    /// Number of pixels that [`TransformChunk::show`] writes.
    pub fn updated_pixels(&self, frame: usize, shown: Option<usize>) -> u64 {
        self.changed_leaves(frame, shown).map(|(_, [_, _, columns, rows])| (columns * rows) as u64).sum()
    }

    /// Blocks of a frame that differ from those of frame `shown`, with left, top, width and height in the cell.
    pub fn changed_leaves(&self, frame: usize, shown: Option<usize>) -> impl Iterator<Item = (&Leaf, [usize; 4])> {
        self.changes(frame, shown).map(|(_, leaf, rect)| (leaf, rect))
    }

    /// Number of pixels by the set of frames in which their block is equal; bit f of a set is frame f.
    pub fn pixels_of_frames(&self) -> BTreeMap<u128, u64> {
        let mut pixels = BTreeMap::new();
        for (_, leaf, [_, _, columns, rows]) in self.leaves() {
            let Block { place, shape } = leaf.block();
            let mut left = place.frame..place.frame + shape.frames;
            let mut seen = 0u128;
            while let Some(first) = left.next() {
                if seen >> first & 1 == 1 {
                    continue;
                }
                let same = left.clone().filter(|&other| leaf.is_same(first, other));
                let frames = same.fold(1 << first, |frames, frame| frames | 1 << frame);
                seen |= frames;
                *pixels.entry(frames).or_default() += (columns * rows) as u64;
            }
        }
        pixels
    }

    fn changes(&self, frame: usize, shown: Option<usize>) -> impl Iterator<Item = (&Region, &Leaf, [usize; 4])> {
        self.leaves().filter(move |(_, leaf, _)| {
            leaf.block().contains_frame(frame) && !shown.is_some_and(|shown| leaf.is_same(frame, shown))
        })
    }

    /// Blocks with left, top, width and height in the cell of their part inside the cell; blocks may extend beyond its edge.
    fn leaves(&self) -> impl Iterator<Item = (&Region, &Leaf, [usize; 4])> {
        regions(self.size).zip(&self.regions).flat_map(move |([left, top, width, height], region)| {
            region.leaves().filter_map(move |leaf| {
                let Block { place, shape } = leaf.block();
                let [columns, rows] =
                    [width.checked_sub(place.x)?, height.checked_sub(place.y)?].map(|free| free.min(shape.side()));
                let rect = [left + place.x, top + place.y, columns, rows];
                (columns > 0 && rows > 0).then_some((region, leaf, rect))
            })
        })
    }

    fn decode_channels<S: Keyed>(
        &self,
        region: &Region,
        channels: &[ChannelLevels; CHANNELS],
        (shape, frame): (Shape, usize),
        planes: &mut Planes,
    ) {
        let length = length_index(shape.frames).unwrap_or(0);
        let weights = &TIME_BASES[length][frame * MAX_LENGTH..][..shape.frames];
        for (channel, plane) in planes.channels.iter_mut().enumerate() {
            let of = &channels[channel];
            let source = FrameLevels { levels: of.of(region), of, weights };
            let coefficients = &mut planes.coefficients;
            source.coefficients(coefficients);
            let (size_class, extent) = (shape.level, of.extent());
            let fraction_bits = S::DOMAIN.fraction_bits - self.pixel_fraction;
            planes.vectors.dispatch(InverseTransform { size_class, coefficients, extent, fraction_bits, out: plane });
        }
    }
}

/// The part of a block inside its cell, and the number of samples from one row of the cell to the next.
struct Window {
    columns: usize,
    rows: usize,
    side: usize,
    stride: usize,
}

impl Window {
    /// Rows of the block, and the rows of the output.
    #[inline(always)]
    fn rows<'a, T, S>(&self, block: &'a [T], out: &'a mut [S]) -> impl Iterator<Item = (&'a [T], &'a mut [[S; 3]])> {
        let columns = self.columns;
        let rows = block.chunks_exact(self.side).zip(out.chunks_mut(self.stride)).take(self.rows);
        rows.map(move |(row, out)| (&row[..columns], &mut out.as_chunks_mut().0[..columns]))
    }

    fn write_palette<S: Keyed>(&self, palette: &Palette, shape: Shape, frame: usize, out: &mut [S]) {
        let colors: Vec<[S; 3]> = palette.colors.iter().map(|color| color.map(S::from_key)).collect();
        match palette.frame(shape, frame) {
            Some(indices) => {
                for (row, out) in self.rows(indices, out) {
                    for (out, &index) in out.iter_mut().zip(row) {
                        *out = colors[usize::from(index)];
                    }
                }
            }
            None => {
                for out in out.chunks_mut(self.stride).take(self.rows) {
                    out.as_chunks_mut().0[..self.columns].fill(colors[0]);
                }
            }
        }
    }
}

/// Writes the part of a block inside its cell, from its channels.
struct PixelWriter<'a, S> {
    window: Window,
    channels: &'a [[i32; MAX_PIXELS]; CHANNELS],
    slopes: ChromaSlopes,
    /// Fraction bits of the channels.
    fraction: u32,
    out: &'a mut [S],
}

// Everything is inlined, so that it is compiled for each vector instruction set.
impl<S: Keyed> NullaryFnOnce for PixelWriter<'_, S> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let PixelWriter { window, channels: [luma, green, orange], slopes, fraction, out } = self;
        let [least, most] = S::DOMAIN.shown;
        let half = 1 << fraction >> 1;
        let chroma = green.chunks_exact(window.side).zip(orange.chunks_exact(window.side));
        for ((row, out), (green, orange)) in window.rows(luma, out).zip(chroma) {
            for ((out, &luma), (&green, &orange)) in out.iter_mut().zip(row).zip(green.iter().zip(orange)) {
                let keys = inverse([luma, green, orange], slopes, &S::DOMAIN, fraction);
                *out = keys.map(|key| S::from_key((key.wrapping_add(half) >> fraction).clamp(least, most)));
            }
        }
    }
}

impl Leaf {
    /// True if two frames of the chunk are equal in this block.
    fn is_same(&self, frame: usize, other: usize) -> bool {
        let block = self.block();
        if !block.contains_frame(other) {
            return false;
        }
        match &self.content {
            Content::Transform { still, .. } => *still || frame == other,
            Content::Palette(palette) => {
                let [a, b] = [frame, other].map(|frame| palette.frame(block.shape, frame - block.place.frame));
                a == b
            }
        }
    }
}

/// Buffers for the channels of a block.
struct Planes {
    /// The widest vector instruction set of the processor; the same code is compiled for each.
    vectors: Arch,
    coefficients: [i32; MAX_PIXELS],
    channels: [[i32; MAX_PIXELS]; CHANNELS],
}

impl Default for Planes {
    fn default() -> Self {
        Planes { vectors: Arch::new(), coefficients: [0; MAX_PIXELS], channels: [[0; MAX_PIXELS]; CHANNELS] }
    }
}

/// Levels of a channel, for one frame of the block.
struct FrameLevels<'a> {
    levels: &'a [Level],
    of: &'a ChannelLevels,
    /// Weight of each plane in the frame.
    weights: &'a [i32],
}

impl FrameLevels<'_> {
    /// Inverse transform in time: computes the frame's spatial coefficients, times 256, by `Position`.
    fn coefficients(&self, out: &mut [i32; MAX_PIXELS]) {
        let [columns, rows] = self.of.extent();
        for row in out.as_chunks_mut::<ROW>().0.iter_mut().take(rows) {
            row[..columns].fill(0);
        }
        out[0] = self.of.mean << BASIS_BITS;
        for level in self.levels {
            let at = &mut out[usize::from(level.position.0) % MAX_PIXELS];
            *at = at.wrapping_add(level.value.wrapping_mul(self.weights[usize::from(level.plane)]));
        }
    }
}

/// Inverse transform in space: all columns with coefficients, then all rows.
///
/// Functions of even frequency are symmetric, those of odd frequency antisymmetric. The sum of the even and the odd part is
/// the first half of a line, and their difference the second half. Sums wrap, so that their order does not matter.
struct InverseTransform<'a> {
    /// Size class as in [`Shape`].
    size_class: usize,
    /// Coefficients times 256, by `Position`.
    coefficients: &'a [i32; MAX_PIXELS],
    /// Number of columns and rows with coefficients.
    extent: [usize; 2],
    /// Fraction bits that are rounded off.
    fraction_bits: u32,
    out: &'a mut [i32; MAX_PIXELS],
}

// Everything is inlined, so that it is compiled for each vector instruction set.
impl NullaryFnOnce for InverseTransform<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        match self.size_class {
            0 => inverse_transform::<4, 2, 8>(self),
            1 => inverse_transform::<8, 4, 8>(self),
            2 => inverse_transform::<16, 8, 8>(self),
            _ => inverse_transform::<32, 16, 16>(self),
        }
    }
}

#[inline(always)]
fn inverse_transform<const N: usize, const HALF: usize, const LANES: usize>(of: InverseTransform<'_>) {
    let InverseTransform { coefficients, extent: [columns, rows], fraction_bits, out, .. } = of;
    let shift = BASIS_BITS + fraction_bits + N.trailing_zeros();
    let scale = |value: i32| i32::wrapping_add(value, 1 << (BASIS_BITS - 1)) >> BASIS_BITS;
    if [columns, rows] == [1, 1] {
        let mean = scale(coefficients[0]).wrapping_shl(BASIS_BITS);
        out[..N * N].fill(i32::wrapping_add(mean, 1 << (shift - 1)) >> shift);
        return;
    }
    let coefficients = coefficients.as_chunks::<ROW>().0;
    let mut half = [[0; N]; N];
    let used = columns.next_multiple_of(LANES / HALF);
    let value = |row: usize, column: usize| scale(coefficients[row][column]);
    inverse_lines::<N, HALF, LANES>(rows, BASIS_BITS, value, half[..used].as_flattened_mut());
    inverse_lines::<N, HALF, LANES>(columns, shift, |column, row| half[column][row], &mut out[..N * N]);
}

/// Inverse transforms of lines of N samples, from their first `frequencies` frequencies; `value` returns the coefficient of a
/// frequency and a line.
///
/// `HALF` is N / 2. `LANES` is a multiple of `HALF`, so that several short lines are computed together.
#[inline(always)]
fn inverse_lines<const N: usize, const HALF: usize, const LANES: usize>(
    frequencies: usize,
    shift: u32,
    value: impl Fn(usize, usize) -> i32,
    out: &mut [i32],
) {
    for (band, out) in out.chunks_exact_mut(N * LANES / HALF).enumerate() {
        let first = band * LANES / HALF;
        let values =
            |frequency: usize| -> [i32; LANES] { std::array::from_fn(|lane| value(frequency, first + lane / HALF)) };
        let mut even = values(0).map(|value| value.wrapping_shl(BASIS_BITS).wrapping_add(1 << (shift - 1)));
        let mut odd = [0; LANES];
        for frequency in (1..frequencies).step_by(2) {
            add_product(&mut odd, &values(frequency), &Halves::<N, LANES>::FUNCTIONS[frequency]);
            if frequency + 1 < frequencies {
                add_product(&mut even, &values(frequency + 1), &Halves::<N, LANES>::FUNCTIONS[frequency + 1]);
            }
        }
        for (line, out) in out.chunks_exact_mut(N).enumerate() {
            for x in 0..HALF {
                let (even, odd) = (even[line * HALF + x], odd[line * HALF + x]);
                out[x] = i32::wrapping_add(even, odd) >> shift;
                out[N - 1 - x] = i32::wrapping_sub(even, odd) >> shift;
            }
        }
    }
}

/// First half of each function of N points, repeated to fill `LANES`.
struct Halves<const N: usize, const LANES: usize>;

impl<const N: usize, const LANES: usize> Halves<N, LANES> {
    const FUNCTIONS: &[[i32; LANES]; N] = &{
        let mut functions = [[0; LANES]; N];
        let mut k = 0;
        while k < N {
            let mut lane = 0;
            while lane < LANES {
                functions[k][lane] = basis(N, k, lane % (N / 2));
                lane += 1;
            }
            k += 1;
        }
        functions
    };
}

/// Adds products lane by lane.
#[inline(always)]
fn add_product<const LANES: usize>(sums: &mut [i32; LANES], values: &[i32; LANES], weights: &[i32; LANES]) {
    for ((sum, &value), &weight) in sums.iter_mut().zip(values).zip(weights) {
        *sum = i32::wrapping_add(*sum, value.wrapping_mul(weight));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The two passes of color.md 6.3, exactly as specified.
    fn plain(side: usize, coefficients: &[i32; MAX_PIXELS], extent: [usize; 2], fraction_bits: u32) -> Vec<i32> {
        let round = |value: i64, bits: u32| (value + (1 << (bits - 1))) >> bits;
        let shift = BASIS_BITS + fraction_bits + side.trailing_zeros();
        let product = |k: usize, n: usize, value: i64| i64::from(basis(side, k, n)) * value;
        let half = |column: usize, y: usize| {
            let of = |row: usize| product(row, y, round(coefficients[ROW * row + column].into(), BASIS_BITS));
            round((0..extent[1]).map(of).sum(), BASIS_BITS)
        };
        let pixel =
            |(y, x)| round((0..extent[0]).map(|column| product(column, x, half(column, y))).sum(), shift) as i32;
        (0..side).flat_map(|y| (0..side).map(move |x| (y, x))).map(pixel).collect()
    }

    #[test]
    fn lines_in_vectors_are_those_of_the_document() {
        let mut noise = 1u32;
        let mut next = || {
            noise = noise.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            noise >> 8
        };
        for (size_class, round) in (0..4).flat_map(|size_class| (0..50).map(move |round| (size_class, round))) {
            let side = 4 << size_class;
            // Coefficients outside the extent are ignored.
            let mut coefficients = [0; MAX_PIXELS];
            coefficients.fill_with(|| (next() as i32 - (1 << 23)) >> (round % 4));
            let extent = if round == 0 { [1, 1] } else { [(); 2].map(|()| 1 + next() as usize % side) };
            let fraction_bits = [0, 2, 6][round % 3];
            let mut out = [0; MAX_PIXELS];
            let coefficients = &coefficients;
            Arch::new().dispatch(InverseTransform { size_class, coefficients, extent, fraction_bits, out: &mut out });
            assert_eq!(out[..side * side], plain(side, coefficients, extent, fraction_bits), "{side} {extent:?}");
        }
    }
}
