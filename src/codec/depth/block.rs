//! Square blocks of codes, to which modelling functions are fitted and into which they are decoded (depth.md 7).
//!
//! A block is a quadtree node over a picture. Pixels of the node beyond the right or bottom edge of the picture are not read,
//! written or measured.

/// Maximum level. The side of a block is 4 · 2^level pixels; the largest block covers a tile of 1024×1024 pixels.
pub const MAX_LEVEL: u8 = 8;
/// Maximum width and height of a tile that is coded as a quadtree, in pixels.
pub const MAX_TILE: u32 = 1024;

pub const fn side_of(level: u8) -> usize {
    4 << level
}

fn inside(size: [usize; 2], level: u8, [x, y]: [usize; 2]) -> [usize; 2] {
    [side_of(level).min(size[0] - x), side_of(level).min(size[1] - y)]
}

/// View of the codes of a block in a picture.
#[derive(Debug, Clone, Copy)]
pub struct Block<'a> {
    pixels: &'a [u16],
    stride: usize,
    pub width: usize,
    pub height: usize,
    pub level: u8,
}

/// Mutable view of the codes of a block in a picture.
#[derive(Debug)]
pub struct BlockMut<'a> {
    pixels: &'a mut [u16],
    stride: usize,
    width: usize,
    height: usize,
    pub level: u8,
}

/// Error of decoded codes. There is none (`None`) if background is decoded as a surface or the reverse.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Accuracy {
    /// Maximum difference in codes (GDC, equation 1).
    pub max_error: u16,
    /// Sum of squared differences (GDC, equation 2, before the division by the number of pixels).
    pub squared_error: u64,
}

impl<'a> Block<'a> {
    /// Returns the block of `level` at pixel (`x`, `y`) of a picture of `width` columns. The pixel must lie in the picture.
    pub fn of(picture: &'a [u16], width: usize, level: u8, [x, y]: [usize; 2]) -> Block<'a> {
        let [inside, height] = inside([width, picture.len() / width], level, [x, y]);
        Block { pixels: &picture[y * width + x..], stride: width, width: inside, height, level }
    }

    pub fn pixel_count(&self) -> usize {
        self.width * self.height
    }

    pub fn row(&self, y: usize) -> &'a [u16] {
        &self.pixels[y * self.stride..y * self.stride + self.width]
    }

    pub fn rows(&self) -> impl Iterator<Item = &'a [u16]> + use<'a> {
        let (pixels, stride, width) = (self.pixels, self.stride, self.width);
        (0..self.height).map(move |y| &pixels[y * stride..y * stride + width])
    }
}

impl<'a> BlockMut<'a> {
    pub fn of(picture: &'a mut [u16], width: usize, level: u8, [x, y]: [usize; 2]) -> BlockMut<'a> {
        let [inside, height] = inside([width, picture.len() / width], level, [x, y]);
        BlockMut { pixels: &mut picture[y * width + x..], stride: width, width: inside, height, level }
    }

    pub fn rows_mut(&mut self) -> impl Iterator<Item = &mut [u16]> {
        let width = self.width;
        self.pixels.chunks_mut(self.stride).take(self.height).map(move |row| &mut row[..width])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_end_where_the_picture_ends() {
        let picture: Vec<u16> = (0..70).collect();
        let block = Block::of(&picture, 10, 1, [8, 3]);
        assert_eq!((block.width, block.height, block.pixel_count()), (2, 4, 8));
        assert_eq!(block.rows().collect::<Vec<_>>(), [[38, 39], [48, 49], [58, 59], [68, 69]]);
        assert_eq!(block.row(3), [68, 69]);
        let mut target = vec![0; 70];
        BlockMut::of(&mut target, 10, 1, [8, 3]).rows_mut().for_each(|row| row.fill(7));
        assert_eq!(target.iter().filter(|&&code| code == 7).count(), 8);
        assert_eq!(target[69], 7);
    }
}
