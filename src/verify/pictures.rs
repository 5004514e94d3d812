//! Depth pictures that are hard to model, defined as functions of column and row.

use crate::clip::{self, Sequence};

type Generator = fn(usize, usize) -> f64;

#[derive(Debug, Clone, Copy)]
pub(super) struct HardPicture {
    pub name: &'static str,
    pub size: [usize; 2],
    /// Code at (column, row), clamped to 0 to 65535.
    pixel: Generator,
}

const fn case(name: &'static str, size: [usize; 2], pixel: Generator) -> HardPicture {
    HardPicture { name, size, pixel }
}

const BACKGROUND: f64 = 65535.0;

/// Returns a number below `n` that depends only on the pixel.
fn noise(x: usize, y: usize, n: u32) -> f64 {
    f64::from(clip::noise([0, x as u32, y as u32], n))
}

pub(super) const PICTURES: &[HardPicture] = &[
    case("constant 0", [64, 64], |_, _| 0.0),
    case("constant 1", [64, 64], |_, _| 1.0),
    case("constant 65534", [64, 64], |_, _| 65534.0),
    case("constant background", [64, 64], |_, _| BACKGROUND),
    case("one odd pixel in a corner", [64, 64], |x, y| if (x, y) == (0, 0) { 60_000.0 } else { 7.0 }),
    case("one pixel of background", [64, 64], |x, y| if (x, y) == (9, 14) { BACKGROUND } else { 65534.0 }),
    case("one pixel of surface", [64, 64], |x, y| if (x, y) == (9, 14) { 65534.0 } else { BACKGROUND }),
    case("checkerboard of 0 and 65534", [32, 32], |x, y| if (x + y) % 2 == 0 { 0.0 } else { 65534.0 }),
    case("checkerboard of 0 and background", [32, 32], |x, y| if (x + y) % 2 == 0 { 0.0 } else { BACKGROUND }),
    case("checkerboard of 65534 and background", [32, 32], |x, y| if (x + y) % 2 == 0 { 65534.0 } else { BACKGROUND }),
    case("ramp of 1/64 code a pixel", [256, 64], |x, _| 30_000.0 + (x as f64 / 64.0).floor()),
    case("slanted ramp of 1/64 code a pixel", [128, 128], |x, y| ((x + 2 * y) as f64 / 64.0).round()),
    case("ramp down to 0", [64, 64], |x, y| (300.0 - 9.0 * x as f64 - 5.0 * y as f64).max(0.0)),
    case("ramp up to 65534", [64, 64], |x, y| (65_000.0 + 11.0 * x as f64 + 3.0 * y as f64).min(65534.0)),
    case("step of 65534 along a slanted line", [64, 64], |x, y| if 3 * x > 2 * y + 20 { 65534.0 } else { 0.0 }),
    case("step to the background along a line", [64, 64], |x, y| {
        if 5 * x > 7 * y + 3 { BACKGROUND } else { 40_000.0 + 30.0 * x as f64 + 11.0 * y as f64 }
    }),
    case("a line with one pixel on a side", [8, 8], |x, y| if x + y == 0 { 9000.0 } else { 30_000.0 + 8.0 * x as f64 }),
    case(
        "a line with two pixels on a side",
        [8, 8],
        |x, y| if x + 2 * y < 2 { 9000.0 } else { 30_000.0 + 8.0 * y as f64 },
    ),
    case("two pixels, collinear, of another surface", [16, 16], |x, y| {
        if y == 3 && (5..7).contains(&x) { 100.0 } else { 200.0 * x as f64 }
    }),
    case("a plane at a grazing angle, 512x512", [512, 512], |x, y| 5.0 + 100.0 * x as f64 + 27.9 * y as f64),
    case("a bowl, 256x256", [256, 256], |x, y| {
        let (x, y) = (x as f64 - 128.0, y as f64 - 128.0);
        20_000.0 + 1.1 * (x * x + y * y) + 0.3 * x * y
    }),
    case("a steep bowl", [64, 64], |x, y| {
        let (x, y) = (x as f64 - 32.0, y as f64 - 32.0);
        (16.0 * (x * x + y * y)).min(65534.0)
    }),
    case("noise of all codes", [40, 40], |x, y| noise(x, y, 65536)),
    case("noise of 3 codes", [64, 64], |x, y| 1000.0 + noise(x, y, 3)),
    case("noise of 150 codes on a slope", [64, 64], |x, y| 1000.0 + 40.0 * x as f64 + noise(x, y, 150)),
    case("surfaces next to the background's code", [32, 32], |x, y| 65_535.0 - noise(x, y, 4)),
    case("thin fence before the background", [64, 64], |x, y| {
        if x % 7 == 0 || y % 13 == 0 { 12_000.0 + x as f64 } else { BACKGROUND }
    }),
    case("wider than 512, of which leaves change", [521, 9], |x, y| {
        if (500..530).contains(&x) { 40_000.0 + noise(x, y, 900) } else { 20_000.0 + 5.0 * y as f64 }
    }),
    case("higher than 512, of which leaves change", [7, 1024], |x, y| {
        if y > 700 { 40_000.0 + noise(x, y, 9000) } else { 20_000.0 + 5.0 * y as f64 }
    }),
    case("smaller than a leaf", [3, 2], |x, y| 100.0 * x as f64 + 7.0 * y as f64),
    case("one pixel", [1, 1], |_, _| 12_345.0),
    case("one row", [37, 1], |x, _| 3.0 * x as f64),
    case("one column", [1, 53], |_, y| if y < 20 { BACKGROUND } else { 9.0 * y as f64 }),
    case("not divisible by 4", [45, 30], |x, y| 500.0 * (x / 9) as f64 + y as f64),
    case("not divisible by 8, with an edge", [29, 77], |x, y| if x * 3 > y { 60_000.0 } else { 13.0 * x as f64 }),
    case("collinear pixels of another surface, slanted", [32, 32], |x, y| {
        if x == 2 * y { 50_000.0 } else { 10_000.0 + 12.0 * x as f64 }
    }),
    case("collinear pixels of surface, slanted, before the background", [32, 32], |x, y| {
        if 3 * x == 2 * y { 20_000.0 + 9.0 * x as f64 } else { BACKGROUND }
    }),
    case("a corner pixel of another surface in every node of 8x8", [64, 64], |x, y| {
        if (x % 8, y % 8) == (7, 7) { 300.0 } else { 40_000.0 + 3.0 * y as f64 }
    }),
    case("a bowl whose fourth powers are large, 512x512", [512, 512], |x, y| {
        let (x, y) = (x as f64, y as f64);
        1000.0 + 0.11 * x * x + 0.09 * y * y + 0.04 * x * y
    }),
    case("a saddle with its middle far outside, 200x200", [200, 200], |x, y| {
        let (x, y) = (x as f64 + 900.0, y as f64 - 1500.0);
        33_000.0 + 0.02 * (x * x - y * y) + 0.004 * x * y
    }),
    case("a plane that is all but vertical", [64, 64], |x, _| (1040.0 * x as f64).min(65534.0)),
    case("runs of one code, 65534 to 65535, in stripes", [64, 64], |x, y| 65_534.0 + ((x / 3 + y / 5) % 2) as f64),
];

impl HardPicture {
    pub(super) fn picture(&self) -> Vec<u16> {
        let [width, height] = self.size;
        (0..width * height).map(|at| (self.pixel)(at % width, at / width).clamp(0.0, 65535.0) as u16).collect()
    }

    pub(super) fn still(&self) -> Sequence<u16> {
        Sequence { size: self.size.map(|side| side as u32), frames: vec![self.picture()] }
    }

    /// Three frames: the picture, the picture moved by three columns, and the picture again. Large pictures have one
    /// frame.
    pub(super) fn moving(&self) -> Sequence<u16> {
        if self.size[0] * self.size[1] > 1 << 17 {
            return self.still();
        }
        let (first, width) = (self.picture(), self.size[0]);
        let mut moved = first.clone();
        moved.chunks_mut(width).for_each(|row| row.rotate_left(3.min(width - 1)));
        Sequence { frames: vec![first.clone(), moved, first], ..self.still() }
    }
}
