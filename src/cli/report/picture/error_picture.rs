//! Error pictures: a picture, its reference and their difference side by side.

use super::raster::{self, HALF_SIDE, Scale};
use super::sheet::{Bar, Panel, Sheet};
use crate::report::plot::palette::{Rgb, heat};
use codec::error::Result;
use codec::image::plane::Plane;

const MAX_CODES: u8 = 64;

/// Draws a picture and its reference, both in display codes, and the largest component difference of each pixel.
pub fn draw(title: &str, [shown, wanted]: [&Plane<Rgb>; 2], difference: &Plane<u8>) -> Result<Plane<Rgb>> {
    let size = [shown.width(), shown.height()];
    let scale = Scale::of(size, HALF_SIDE / 2);
    let panel = |caption: &str, color: &dyn Fn(u32, u32) -> Rgb, bar: Option<Bar>| Panel {
        caption: caption.to_owned(),
        image: raster::render(size, scale, color),
        key: Vec::new(),
        bar,
    };
    let share = |code: u8| f64::from(code.min(MAX_CODES)) / f64::from(MAX_CODES);
    let ticks = [0u8, 16, 32, 48, MAX_CODES]
        .map(|code| (share(code), if code == MAX_CODES { format!("{code} or more") } else { code.to_string() }));
    let bar =
        Bar { color: heat, ticks: ticks.to_vec(), label: "largest difference in display codes".into(), mark: None };
    let worst = difference.data().iter().copied().max().unwrap_or_default();
    let far_off = difference.data().iter().filter(|code| **code >= 16).count();
    let sheet = Sheet {
        title: title.to_owned(),
        facts: vec![format!(
            "The largest difference is {worst} of 255; {:.1}% of the pixels differ by 16 or more.",
            100.0 * far_off as f64 / difference.data().len().max(1) as f64
        )],
        panels: vec![
            panel("rendered", &|x, y| shown.get(x, y), None),
            panel("reference", &|x, y| wanted.get(x, y), None),
            panel("difference", &|x, y| heat(share(difference.get(x, y))), Some(bar)),
        ],
    };
    sheet.draw()
}
