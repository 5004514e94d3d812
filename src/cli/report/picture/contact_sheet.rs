//! Contact sheet: many reduced pictures on one sheet, each with its name below.

use super::raster::{self, Scale};
use super::sheet::paste;
use crate::report::plot::drawing::Text;
use crate::report::plot::palette::{INK, PAPER, Rgb};
use crate::report::plot::save::to_pixels;
use crate::report::plot::{Drawing, Ink};
use codec::error::Result;
use codec::image::plane::Plane;

const ROOM: u32 = 256;
const MARGIN: u32 = 16;
const GAP: u32 = 12;
const EM: f64 = 13.0;
const LINE: u32 = 20;
/// Colours of the chequerboard behind transparent pixels; `CHECK` is the side of a square in pixels.
const CHECKS: [Rgb; 2] = [[205, 205, 205], [160, 160, 160]];
const CHECK: u32 = 8;

#[derive(Debug, Clone, Default)]
pub struct ContactSheet {
    pictures: Vec<(String, Plane<Rgb>)>,
}

impl ContactSheet {
    /// Adds a picture, reduced to the cell size. A chequerboard shows through its transparent pixels.
    pub fn add(&mut self, name: impl Into<String>, picture: &Plane<[u8; 4]>) {
        let size = [picture.width(), picture.height()];
        let scale = Scale { up: 1, down: size[0].max(size[1]).div_ceil(ROOM).max(1) };
        let over = |x: u32, y: u32| {
            let [r, g, b, alpha] = picture.get(x, y).map(u32::from);
            let check = (x / scale.down / CHECK + y / scale.down / CHECK) % 2;
            let ground = CHECKS[check as usize].map(u32::from);
            let mix = |color: u32, ground: u32| ((color * alpha + ground * (255 - alpha) + 127) / 255) as u8;
            [mix(r, ground[0]), mix(g, ground[1]), mix(b, ground[2])]
        };
        self.pictures.push((name.into(), raster::render(size, scale, over)));
    }

    pub fn is_empty(&self) -> bool {
        self.pictures.is_empty()
    }

    /// Draws the sheet, about as wide as high.
    pub fn draw(&self) -> Result<Plane<Rgb>> {
        let widest =
            |side: fn(&Plane<Rgb>) -> u32| self.pictures.iter().map(|(_, plane)| side(plane)).max().unwrap_or(1);
        let cell = [widest(Plane::width) + GAP, widest(Plane::height) + LINE + GAP];
        let count = self.pictures.len().max(1) as u32;
        let columns =
            (1..=count).find(|columns| columns * cell[0] >= count.div_ceil(*columns) * cell[1]).unwrap_or(count);
        let [width, height] =
            [columns * cell[0] + 2 * MARGIN - GAP, count.div_ceil(columns) * cell[1] + 2 * MARGIN - GAP];
        let mut sheet = Plane::filled(width, height, PAPER);
        for (at, (name, picture)) in (0u32..).zip(&self.pictures) {
            let (left, top) = (MARGIN + at % columns * cell[0], MARGIN + at / columns * cell[1]);
            paste(&mut sheet, picture, [left, top]);
            let mut line = Drawing::new(cell[0] - GAP, LINE, "");
            let room = f64::from(cell[0] - GAP);
            line.text([0.0, f64::from(LINE) - 6.0], Text::new(name, EM).ink(Ink::opaque(INK)).fit(room));
            paste(&mut sheet, &to_pixels(&line, 1)?, [left, top + picture.height()]);
        }
        Ok(sheet)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_picture_has_a_place_of_its_own() {
        let mut sheet = ContactSheet::default();
        for at in 0..5u8 {
            sheet.add(format!("frame {at}"), &Plane::filled(600, 300, [50 * at, 1, 2, 255]));
        }
        sheet.add("a hole", &Plane::filled(600, 300, [255, 0, 0, 0]));
        let drawn = sheet.draw().unwrap();
        let count = |color: Rgb| drawn.data().iter().filter(|pixel| **pixel == color).count();
        for at in 0..5u8 {
            assert_eq!(count([50 * at, 1, 2]), 200 * 100);
        }
        // Antialiased edges of letters may have the same grey.
        assert!((200 * 100..200 * 100 + 100).contains(&(count(CHECKS[0]) + count(CHECKS[1]))));
        assert_eq!(count([255, 0, 0]), 0);
        assert!(drawn.width().abs_diff(drawn.height()) < 300, "{}x{}", drawn.width(), drawn.height());
    }
}
