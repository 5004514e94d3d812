//! Decoder state of a unit: its pixels, and the coding of its blocks (depth.md 15.2).

use crate::depth::predictive::contexts::{self, Tables};
use crate::depth::predictive::levels::Levels;
use crate::depth::predictive::modes::{BACKGROUND, BLOCK, OUTSIDE, PIXELS, PLANES, QUARTERS, SMALL};
use crate::depth::predictive::pixel::{Around, Pixel, Steps};
use crate::depth::predictive::plane::{ChangeSteps, Plane, Side};
use crate::depth::predictive::projection::{Curvature, Projection, UnitArea};
use crate::error::{Error, Result};

/// Maximum number of frames of a chunk.
pub const MAX_FRAMES: u32 = 4096;
/// Maximum width and height of a unit, in pixels.
pub const MAX_SIDE: u32 = 1024;

/// Header fields of predictive coding (depth.md 3, 15.1).
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PredictiveHeader {
    /// E: residuals are in steps of 2E + 1 codes.
    pub bound: u16,
    /// Change of the source, in codes in addition to the bound, up to which a pixel is not updated.
    pub epsilon: u16,
    pub keyframe_interval: u32,
    pub projection: Projection,
    /// Table sets, which payloads select by number.
    pub tables: Tables,
    /// Codes that occur; empty if any may. With levels the bound is 0, and there is no projection.
    pub levels: Levels,
}

#[derive(Debug, Clone, Copy)]
pub struct Block {
    /// Last mode of the block other than [`SAME`](crate::depth::predictive::modes::SAME).
    pub content: usize,
    /// Mode of the block in this frame.
    pub mode: usize,
    /// Plane of the block; valid if `content` is a mode of planes.
    pub plane: Plane,
}

/// Rectangle of the pixels of a block that lie in the unit.
#[derive(Debug, Clone, Copy)]
pub struct Area {
    pub x: usize,
    pub y: usize,
    pub width: usize,
    pub height: usize,
}

impl Area {
    /// Returns left, top, width and height.
    pub fn rect(&self) -> [u32; 4] {
        [self.x, self.y, self.width, self.height].map(|side| side as u32)
    }
}

#[derive(Debug, Clone)]
pub struct Tile {
    pub width: usize,
    pub height: usize,
    /// Pixels per row of `pixels`, which has a border of background: one pixel on the left and right of each row, and a row
    /// above.
    stride: usize,
    pub pixels: Vec<Pixel>,
    pub blocks: Vec<Block>,
    pub columns: usize,
    pub corrections: Vec<i32>,
    pub steps: Steps,
    pub curvature: Curvature,
    /// Levels whose numbers the pixels hold; empty if they hold codes.
    levels: Levels,
    /// True if a frame of the chunk was decoded.
    pub is_later: bool,
}

impl Tile {
    /// Returns the state of a unit of at most 1024x1024 pixels before its first frame: all background.
    pub fn new(header: &PredictiveHeader, area: UnitArea) -> Result<Tile> {
        let [width, height] = area.size().map(|side| side as usize);
        let stride = width + 2;
        let columns = width.div_ceil(BLOCK);
        let blocks = columns * height.div_ceil(BLOCK);
        let mut pixels = Vec::new();
        pixels
            .try_reserve_exact(stride * (height + 1))
            .map_err(|_| Error::invalid("not enough memory for a depth tile"))?;
        pixels.resize(stride * (height + 1), Pixel::BACKGROUND);
        Ok(Tile {
            width,
            height,
            stride,
            pixels,
            blocks: vec![Block { content: BACKGROUND, mode: BACKGROUND, plane: Plane::UNKNOWN }; blocks],
            columns,
            corrections: header.projection.corrections(area),
            steps: Steps::new(header.bound),
            curvature: header.projection.curvature(),
            levels: header.levels.clone(),
            is_later: false,
        })
    }

    /// Resets the state to before the first frame.
    pub fn clear(&mut self) {
        self.pixels.fill(Pixel::BACKGROUND);
        self.blocks.fill(Block { content: BACKGROUND, mode: BACKGROUND, plane: Plane::UNKNOWN });
        self.is_later = false;
    }

    /// Returns 0 before the first frame of the chunk is decoded, otherwise 1.
    pub fn later(&self) -> usize {
        usize::from(self.is_later)
    }

    /// Returns the index of a pixel; `x` and `y` may be -1, and `x` may be the width.
    #[inline(always)]
    pub fn at(&self, x: isize, y: isize) -> usize {
        ((y + 1) as usize) * self.stride + (x + 1) as usize
    }

    pub fn area(&self, block: usize) -> Area {
        let (x, y) = (block % self.columns * BLOCK, block / self.columns * BLOCK);
        self.part(x, y, BLOCK)
    }

    fn part(&self, x: usize, y: usize, side: usize) -> Area {
        Area { x, y, width: side.min(self.width - x), height: side.min(self.height - y) }
    }

    /// Returns the quarters of a block that lie in the unit.
    pub fn quarters(&self, block: Area) -> impl Iterator<Item = Area> + use<> {
        let (width, height) = (self.width, self.height);
        let corners = [[0, 0], [SMALL, 0], [0, SMALL], [SMALL, SMALL]];
        corners
            .into_iter()
            .map(move |[x, y]| (block.x + x, block.y + y))
            .filter(move |&(x, y)| x < width && y < height)
            .map(move |(x, y)| Area { x, y, width: SMALL.min(width - x), height: SMALL.min(height - y) })
    }

    pub fn mode_context(&self, block: usize) -> usize {
        let left = if block.is_multiple_of(self.columns) { OUTSIDE } else { self.blocks[block - 1].mode };
        let above = if block < self.columns { OUTSIDE } else { self.blocks[block - self.columns].mode };
        let past = match self.blocks[block].content {
            _ if !self.is_later => 0,
            PIXELS | QUARTERS => 1,
            _ => 2,
        };
        contexts::mode(left, above, past)
    }

    pub fn small_mode_context(&self, Area { x, y, width, height }: Area) -> usize {
        let (x, y) = (x as isize, y as isize);
        let (right, bottom) = (x + width as isize - 1, y + height as isize - 1);
        let pixel = |x, y| self.pixels[self.at(x, y)];
        contexts::small_mode(
            [pixel(x - 1, y), pixel(x - 1, bottom)],
            [pixel(x, y - 1), pixel(right, y - 1)],
            self.later(),
        )
    }

    /// Returns the plane predicted for a block: from the left (`source` 0), from above (1), or the mean of both (2).
    pub fn plane_from(&self, block: usize, source: usize) -> Plane {
        let Area { x, y, .. } = self.area(block);
        let of = |at: Option<usize>, by, pixel: [usize; 2], by_pixel| match at.map(|at| &self.blocks[at]) {
            Some(Block { content: PLANES.., plane, .. }) => plane.moved(by, self.curvature),
            Some(_) => self.plane_of_pixel(pixel, by_pixel),
            None => Plane::UNKNOWN,
        };
        let left = || {
            let at = (x > 0).then(|| block - 1);
            of(at, [16, 0], [x.wrapping_sub(1), (y + 4).min(self.height - 1)], [9, -1])
        };
        let above = || {
            let at = (y > 0).then(|| block - self.columns);
            of(at, [0, 16], [(x + 4).min(self.width - 1), y.wrapping_sub(1)], [-1, 9])
        };
        match source {
            0 => left(),
            1 => above(),
            _ => left().average(above()),
        }
    }

    /// Returns the plane predicted for a quarter, as [`Self::plane_from`] but from pixels alone.
    pub fn small_plane_from(&self, Area { x, y, .. }: Area, source: usize) -> Plane {
        let left = || match x {
            0 => Plane::UNKNOWN,
            _ => self.plane_of_pixel([x - 1, (y + 2).min(self.height - 1)], [5, -1]),
        };
        let above = || match y {
            0 => Plane::UNKNOWN,
            _ => self.plane_of_pixel([(x + 2).min(self.width - 1), y - 1], [-1, 5]),
        };
        match source {
            0 => left(),
            1 => above(),
            _ => left().average(above()),
        }
    }

    fn plane_of_pixel(&self, [x, y]: [usize; 2], by: [i32; 2]) -> Plane {
        let pixel = &self.pixels[self.at(x as isize, y as isize)];
        if pixel.is_background() { Plane::UNKNOWN } else { Plane::of_pixel(pixel).moved(by, self.curvature) }
    }

    pub fn change_steps(&self, side: Side) -> ChangeSteps {
        ChangeSteps::new(&self.steps, side)
    }

    pub fn fill_plane<const SIDE: usize>(&mut self, area: Area, plane: &Plane) {
        for row in 0..area.height {
            let values = plane.row::<SIDE>(row, self.curvature);
            let start = self.at(area.x as isize, (area.y + row) as isize);
            for (pixel, value) in self.pixels[start..][..area.width].iter_mut().zip(values) {
                *pixel = Pixel::in_plane(value, plane.slope);
            }
        }
    }

    pub fn fill_background(&mut self, area: Area) {
        for row in 0..area.height {
            let start = self.at(area.x as isize, (area.y + row) as isize);
            self.pixels[start..][..area.width].fill(Pixel::BACKGROUND);
        }
    }

    #[inline(always)]
    pub fn around(&self, at: usize, correction: i32) -> Around {
        let above = &self.pixels[at - self.stride - 1..][..3];
        let row = &self.pixels[at - 1..][..2];
        Around {
            left: row[0],
            above: above[1],
            above_left: above[0],
            above_right: above[2],
            before: row[1],
            correction,
        }
    }

    /// Returns three slices for `width` pixels from (x, y) on: the row above, extended by one pixel on both sides; the row
    /// itself, extended by one pixel on the left; and the corrections.
    #[inline(always)]
    pub fn rows(&mut self, x: usize, y: usize, width: usize) -> (&[Pixel], &mut [Pixel], &[i32]) {
        let (before, row) = self.pixels.split_at_mut((y + 1) * self.stride + x);
        let above = &before[y * self.stride + x..][..width + 2];
        (above, &mut row[..width + 1], &self.corrections[y * self.width + x..][..width])
    }

    /// Writes the codes of an area to a picture of the unit.
    pub fn show(&self, area: Area, picture: &mut [u16]) {
        for y in area.y..area.y + area.height {
            let start = self.at(area.x as isize, y as isize);
            let to = y * self.width + area.x;
            let codes = picture[to..][..area.width].iter_mut().zip(&self.corrections[to..][..area.width]);
            for ((code, &correction), pixel) in codes.zip(&self.pixels[start..][..area.width]) {
                *code = pixel.code(correction);
            }
            self.levels.to_codes(&mut picture[to..][..area.width]);
        }
    }
}
