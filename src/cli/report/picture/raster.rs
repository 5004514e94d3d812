//! Drawing of images: scaling by integer factors, outlines and hatching.

use crate::report::plot::palette::{Rgb, contrast, hatched, outlined};
use codec::image::plane::Plane;
use footage::inspect::Patch;

/// Maximum side of a drawn image in pixels, if a picture has one image.
pub const MAX_SIDE: u32 = 2048;
pub const HALF_SIDE: u32 = 1024;
const COMFORTABLE: u32 = 1024;
const MAX_UP: u32 = 64;

/// Integer factor by which an image is enlarged or reduced. One of the two fields is 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Scale {
    /// Drawn pixels per image pixel, in each direction.
    pub up: u32,
    /// Image pixels per drawn pixel, in each direction.
    pub down: u32,
}

impl Scale {
    /// Returns the scale of an image of `size` whose longest side is drawn with at most `max_side` pixels.
    pub fn of(size: [u32; 2], max_side: u32) -> Scale {
        let longest = size[0].max(size[1]).max(1);
        if longest > max_side {
            return Scale { up: 1, down: longest.div_ceil(max_side) };
        }
        let wanted = COMFORTABLE.div_ceil(longest).clamp(1, MAX_UP);
        // Enlarges by at least 2: at factor 1 the outlines of leaves would cover too much of the image.
        Scale { up: wanted.max(2).min(max_side / longest).max(1), down: 1 }
    }

    pub fn drawn(self, size: [u32; 2]) -> [u32; 2] {
        size.map(|side| (side * self.up).div_ceil(self.down))
    }

    pub fn place(self, at: u32) -> f64 {
        f64::from(at) * f64::from(self.up) / f64::from(self.down)
    }

    pub fn words(self) -> String {
        match self {
            Scale { up: 1, down: 1 } => "drawn pixel for pixel".to_owned(),
            Scale { up, down: 1 } => format!("each pixel drawn as {up}x{up}"),
            Scale { down, .. } => format!("{down}x{down} pixels drawn as one"),
        }
    }

    fn source(self, x: u32, y: u32) -> (u32, u32) {
        (x * self.down / self.up, y * self.down / self.up)
    }
}

/// Draws an image of `size`. A reduced image shows the mean of the merged pixels.
pub fn render(size: [u32; 2], scale: Scale, color: impl Fn(u32, u32) -> Rgb) -> Plane<Rgb> {
    let [width, height] = scale.drawn(size);
    let small = scale.down == 1;
    let mut row: Vec<Rgb> = Vec::new();
    let mut drawn = Plane::filled(width, height, [0; 3]);
    for y in 0..height {
        let (_, from) = scale.source(0, y);
        if small && y % scale.up == 0 {
            row = (0..size[0]).map(|x| color(x, from)).collect();
        }
        for (x, pixel) in drawn.row_mut(y).iter_mut().enumerate() {
            let x = x as u32;
            *pixel = if small {
                row[(x / scale.up) as usize]
            } else {
                let (left, right) = (x * scale.down, (x * scale.down + scale.down).min(size[0]));
                let rows = from..(from + scale.down).min(size[1]);
                mean(rows.flat_map(|y| (left..right).map(move |x| (x, y))).map(|(x, y)| color(x, y)))
            };
        }
    }
    drawn
}

fn mean(colors: impl Iterator<Item = Rgb>) -> Rgb {
    let (mut sums, mut count) = ([0u32; 3], 0);
    for color in colors {
        count += 1;
        sums.iter_mut().zip(color).for_each(|(sum, code)| *sum += u32::from(code));
    }
    sums.map(|sum| ((sum + count / 2) / count.max(1)) as u8)
}

/// Returns for each pixel the value of the patch that contains it, or `none` outside all patches.
pub fn filled<T: Copy>([width, height]: [u32; 2], patches: &[Patch], none: T, value: impl Fn(&Patch) -> T) -> Plane<T> {
    let mut values = Plane::filled(width, height, none);
    for patch in patches {
        let [left, top, width, height] = patch.rect;
        for y in top..top + height {
            values.row_mut(y)[left as usize..(left + width) as usize].fill(value(patch));
        }
    }
    values
}

fn repaint(drawn: &mut Plane<Rgb>, [x, y]: [u32; 2], with: impl Fn(Rgb) -> Rgb) {
    let pixel = &mut drawn.row_mut(y)[x as usize];
    *pixel = with(*pixel);
}

/// Draws lines of one pixel between adjacent parts, and a frame around the image. Pixels outside all parts have id 0.
pub fn outline(drawn: &mut Plane<Rgb>, scale: Scale, parts: &Plane<u32>) {
    let part = |x: u32, y: u32| {
        let (x, y) = scale.source(x, y);
        parts.get(x, y)
    };
    for y in 0..drawn.height() {
        for x in 0..drawn.width() {
            let own = part(x, y);
            let is_border = x == 0 || y == 0 || x + 1 == drawn.width() || y + 1 == drawn.height();
            let meets = |x: u32, y: u32| part(x, y) != own;
            if (is_border && own != 0) || (x > 0 && meets(x - 1, y)) || (y > 0 && meets(x, y - 1)) {
                repaint(drawn, [x, y], outlined);
            }
        }
    }
}

/// Draws dashed lines of one pixel between adjacent units.
pub fn unit_borders(drawn: &mut Plane<Rgb>, scale: Scale, rects: impl Iterator<Item = [u32; 4]>) {
    let [width, height] = [drawn.width(), drawn.height()];
    let mut dot = |x: u32, y: u32| {
        if (x + y) % 8 < 4 && x < width && y < height {
            repaint(drawn, [x, y], contrast);
        }
    };
    for [left, top, unit_width, unit_height] in rects {
        let [from_x, from_y] = [left, top].map(|at| scale.place(at) as u32);
        let [to_x, to_y] = [left + unit_width, top + unit_height].map(|at| scale.place(at).ceil() as u32);
        if left > 0 {
            (from_y..to_y).for_each(|y| dot(from_x, y));
        }
        if top > 0 {
            (from_x..to_x).for_each(|x| dot(x, from_y));
        }
    }
}

pub fn hatch(drawn: &mut Plane<Rgb>, scale: Scale, chosen: impl Fn(u32, u32) -> bool) {
    for y in 0..drawn.height() {
        for x in 0..drawn.width() {
            let (at_x, at_y) = scale.source(x, y);
            if is_hatched(x, y) && chosen(at_x, at_y) {
                repaint(drawn, [x, y], hatched);
            }
        }
    }
}

pub fn is_hatched(x: u32, y: u32) -> bool {
    (x + y) % 8 < 2
}

#[cfg(test)]
mod tests {
    use super::*;
    use footage::inspect::Writing;

    #[test]
    fn factors_are_whole_and_images_stay_within_their_max_side() {
        let of = |longest, max_side| (Scale::of([longest, 1], max_side).up, Scale::of([longest, 1], max_side).down);
        assert_eq!(
            [1, 7, 16, 100, 256].map(|longest| of(longest, MAX_SIDE)),
            [(64, 1), (64, 1), (64, 1), (11, 1), (4, 1)]
        );
        assert_eq!(
            [1024, 1025, 2048, 2049, 65535].map(|longest| of(longest, MAX_SIDE)),
            [(2, 1), (1, 1), (1, 1), (1, 2), (1, 32)]
        );
        assert_eq!([1, 300, 1024, 1025].map(|longest| of(longest, HALF_SIDE)), [(64, 1), (3, 1), (1, 1), (1, 2)]);
        for longest in 1..5000 {
            for max_side in [HALF_SIDE, MAX_SIDE] {
                let [width, height] = Scale::of([longest, 3], max_side).drawn([longest, 3]);
                let (side, source) = (width.max(height), longest.max(3));
                assert!(side <= max_side && side >= (max_side / 2).min(64 * source) && height > 0, "{longest} {side}");
            }
        }
    }

    #[test]
    fn pixels_are_repeated_or_averaged() {
        let color = |x: u32, y: u32| [(10 * x) as u8, (10 * y) as u8, 0];
        let large = render([3, 2], Scale { up: 3, down: 1 }, color);
        assert_eq!((large.width(), large.height()), (9, 6));
        assert!((0..6).all(|y| (0..9).all(|x| large.get(x, y) == color(x / 3, y / 3))));
        let small = render([3, 2], Scale { up: 1, down: 2 }, color);
        assert_eq!((small.width(), small.height()), (2, 1));
        assert_eq!((small.get(0, 0), small.get(1, 0)), ([5, 5, 0], [20, 5, 0]));
    }

    #[test]
    fn outlines_are_where_parts_meet() {
        let patch = |rect, part| Patch { rect, writing: Writing::Values, part };
        let patches = [patch([0, 0, 2, 2], 0), patch([2, 0, 1, 1], 1), patch([2, 1, 1, 1], 1)];
        let parts = filled([4, 2], &patches, 0, |patch| patch.part + 1);
        assert_eq!(parts.data(), [1, 1, 2, 0, 1, 1, 2, 0]);
        let mut drawn = Plane::filled(16, 8, [200; 3]);
        outline(&mut drawn, Scale { up: 4, down: 1 }, &parts);
        let line = outlined([200; 3]);
        let lines = |y: u32| (0..16).filter(|&x| drawn.get(x, y) == line).collect::<Vec<_>>();
        assert_eq!(lines(4), [0, 8, 12]);
        assert_eq!((lines(0).len(), lines(7).len()), (13, 13));
    }
}
