//! Partition of a cell into regions, and of a region into blocks (color.md 6.4).

/// Side of a region in pixels; regions are coded independently.
pub const REGION: usize = 32;
/// Side of the smallest block, and of the squares that have a mean, in pixels.
pub const MIN_SIDE: usize = 4;
/// Maximum number of frames of a chunk.
pub const MAX_FRAMES: u32 = 96;

/// Shape of a node: 4·2^level pixels square, over `frames` frames. `level` is the size class, z in color.md 6, whereas a
/// level of a transform is a quantised coefficient.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shape {
    pub level: usize,
    pub frames: usize,
}

impl Shape {
    pub fn side(self) -> usize {
        MIN_SIDE << self.level
    }

    pub fn pixels(self) -> usize {
        self.side() * self.side()
    }
}

/// Position of a node: offset in its region in pixels, and first frame in the chunk.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Place {
    pub x: usize,
    pub y: usize,
    pub frame: usize,
}

/// A node of a region's tree.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Block {
    pub place: Place,
    pub shape: Shape,
}

impl Block {
    /// Returns the block that covers a region of this size.
    pub fn root([width, height]: [usize; 2], frames: usize) -> Block {
        let level = (width.max(height).div_ceil(MIN_SIDE).next_power_of_two()).trailing_zeros() as usize;
        Block { place: Place { x: 0, y: 0, frame: 0 }, shape: Shape { level, frames } }
    }

    /// Returns the quarters of a block in coding order: row by row.
    pub fn quarters(self) -> [Block; 4] {
        let Block { place: Place { x, y, frame }, shape } = self;
        let half = shape.side() / 2;
        [[0, 0], [half, 0], [0, half], [half, half]].map(|[right, down]| Block {
            place: Place { x: x + right, y: y + down, frame },
            shape: Shape { level: shape.level.saturating_sub(1), ..shape },
        })
    }

    /// Returns the parts in time: three single frames for three frames, otherwise two halves, the longer one first.
    pub fn parts(self) -> impl Iterator<Item = Block> {
        let Block { place, shape } = self;
        let frames = shape.frames;
        let lengths = if frames == 3 { [1, 1, 1] } else { [frames.div_ceil(2), frames / 2, 0] };
        let mut frame = place.frame;
        lengths.into_iter().filter(|&length| length > 0).map(move |length| {
            let part = Block { place: Place { frame, ..place }, shape: Shape { frames: length, ..shape } };
            frame += length;
            part
        })
    }

    pub fn contains_frame(self, frame: usize) -> bool {
        (self.place.frame..self.place.frame + self.shape.frames).contains(&frame)
    }
}

/// Left, top, width and height of the regions of a cell, row by row.
pub fn regions([width, height]: [usize; 2]) -> impl ExactSizeIterator<Item = [usize; 4]> {
    let [columns, rows] = [width, height].map(|side| side.div_ceil(REGION));
    (0..columns * rows).map(move |at| {
        let (x, y) = (at % columns * REGION, at / columns * REGION);
        [x, y, (width - x).min(REGION), (height - y).min(REGION)]
    })
}

/// Number of pixels of the roots of all regions of a cell.
pub fn padded_pixels(size: [usize; 2]) -> u64 {
    let [columns, rows] = size.map(|side| [side / REGION, side % REGION]);
    // Number and side of the whole regions in a row or column, then those of the last, smaller region.
    let of = |[whole, rest]: [usize; 2]| [(whole, REGION), (usize::from(rest > 0), rest)];
    let pairs = of(columns).into_iter().flat_map(|column| of(rows).map(move |row| (column, row)));
    let pixels = pairs.map(|((columns, width), (rows, height))| match columns * rows {
        0 => 0,
        regions => (regions * Block::root([width, height], 1).shape.pixels()) as u64,
    });
    pixels.sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn regions_cover_a_cell_and_roots_cover_regions() {
        for size in [[1, 1], [64, 64], [250, 251], [33, 5]] {
            let pixels: usize = regions(size).map(|[_, _, width, height]| width * height).sum();
            assert_eq!(pixels, size[0] * size[1]);
            let padded =
                regions(size).map(|[_, _, width, height]| Block::root([width, height], 1).shape.pixels() as u64);
            assert_eq!(padded_pixels(size), padded.sum::<u64>());
            for [_, _, width, height] in regions(size) {
                let side = Block::root([width, height], 1).shape.side();
                assert!(side >= width.max(height) && (side == MIN_SIDE || side / 2 < width.max(height)));
            }
        }
    }

    #[test]
    fn parts_cover_all_frames() {
        for frames in 2..=96 {
            let block = Block { place: Place { x: 0, y: 0, frame: 7 }, shape: Shape { level: 0, frames } };
            let mut next = 7;
            for part in block.parts() {
                assert_eq!(part.place.frame, next);
                next += part.shape.frames;
            }
            assert_eq!(next, 7 + frames);
        }
    }
}
