//! How far a decoded image is from its source (GDC figure 1c): the error of each pixel, and for colour the PSNR of each cell.

use super::keyframes::{CellMark, draw_cells};
use super::palette::{self, Rgb};
use super::raster::{HALF_ROOM, ROOM, Scale, hatch, render};
use super::sheet::{Bar, Entry, Panel, Sheet, Swatch};
use super::{Subject, counted, percent};
use crate::error::Result;
use crate::image::plane::Plane;
use crate::video::codec::{CodecHeader, ColorFormat};
use crate::video::difference::PixelError;
use crate::video::error_map::ErrorMap;
use crate::video::side::Coding;

/// The sheet of a frame's errors against the source that the user named.
pub(super) fn sheet(subject: &Subject<'_>, map: &ErrorMap, source: &str, frame: u32) -> Result<Sheet> {
    let size = subject.size();
    let scale = Scale::of(size, if map.cells.is_empty() { ROOM } else { HALF_ROOM });
    let (largest, background, outside) = map.largest();
    let bound = bound(subject);
    let top = bound.map_or(largest, |bound| if largest <= bound { bound } else { largest }).max(1);
    let unit = match map.domain.coding {
        Coding::Depth(_) => "16-bit log codes",
        Coding::Color(ColorFormat::Half { .. }, _) => "64ths of a PU21 step, the largest of R, G and B",
        Coding::Color(..) => "8-bit codes, the largest of R, G and B",
        Coding::Material => "8-bit codes, the largest of the three weights",
    };
    let mut key = Vec::new();
    if background + outside > 0 {
        let words = format!(
            "{}: background on one side only, or a depth outside of the range",
            counted(background + outside, "pixel")
        );
        key.push(Entry { swatch: Swatch::Hatched(palette::MISMATCH), words });
    }
    let mark = bound.filter(|&bound| bound > 0 && bound <= top);
    let errors = Panel {
        caption: "Error of each pixel".to_owned(),
        image: draw_errors(size, scale, map, top),
        key,
        bar: Some(Bar {
            color: palette::heat,
            ticks: ticks(top),
            label: format!("Error in {unit}:"),
            mark: mark.map(|bound| (f64::from(bound) / f64::from(top), format!("the stream's bound, {bound} codes"))),
        }),
    };
    let mut panels = vec![errors];
    if !map.cells.is_empty() {
        panels.push(cells(subject, scale, map)?);
    }
    let pixels = size.iter().map(|&side| u64::from(side)).product();
    let differing = map.differing_pixels();
    let found = match differing {
        0 => "No pixel differs.".to_owned(),
        count => {
            let verb = if count == 1 { "differs" } else { "differ" };
            format!("{} ({}) {verb}, the largest error is {largest}.", counted(count, "pixel"), percent(count, pixels))
        }
    };
    let facts = vec![subject.fact(scale), format!("Compared with {source}. {found}")];
    let title = format!("{}, frame {frame}, distance from the source", subject.name);
    Ok(Sheet { title, facts, panels })
}

/// The largest error that the stream's encoder promised.
fn bound(subject: &Subject<'_>) -> Option<u32> {
    match &subject.stream.header {
        CodecHeader::Depth(header) => header.error_bound().map(u32::from),
        CodecHeader::Material(header) => Some(u32::from(header.temporal.epsilon)),
        CodecHeader::Color(_) => None,
    }
}

fn draw_errors(size: [u32; 2], scale: Scale, map: &ErrorMap, top: u32) -> Plane<Rgb> {
    let color = |x: u32, y: u32| match map.pixels.get(x, y) {
        PixelError::Steps(steps) => palette::heat(f64::from(steps) / f64::from(top)),
        PixelError::Background | PixelError::Outside => palette::MISMATCH[0],
    };
    let mut drawn = render(size, scale, color);
    let odd = |x: u32, y: u32| !matches!(map.pixels.get(x, y), PixelError::Steps(_));
    hatch(&mut drawn, scale, palette::MISMATCH[1], odd);
    drawn
}

/// At most five whole numbers from 0 to `top`.
fn ticks(top: u32) -> Vec<(f64, String)> {
    let count = top.min(4);
    let value = |at: u32| (u64::from(top) * u64::from(at) / u64::from(count)) as u32;
    (0..=count).map(|at| (f64::from(value(at)) / f64::from(top), value(at).to_string())).collect()
}

fn cells(subject: &Subject<'_>, scale: Scale, map: &ErrorMap) -> Result<Panel> {
    let finite = || map.cells.iter().map(|cell| cell.psnr_db).filter(|db| db.is_finite());
    let asked = match &subject.stream.header {
        CodecHeader::Color(header) => Some(header.min_psnr_db),
        _ => None,
    };
    let least = finite().chain(asked).fold(f64::INFINITY, f64::min).floor();
    let most = finite().chain(asked).fold(f64::NEG_INFINITY, f64::max).ceil().max(least + 1.0);
    // What is worse is lighter, as in the picture beside it.
    let part = |db: f64| 1.0 - (db - least) / (most - least);
    let mark = |cell: &crate::video::error_map::CellPsnr| CellMark {
        rect: cell.rect,
        color: if cell.psnr_db.is_finite() { palette::heat(part(cell.psnr_db)) } else { palette::EXACT },
        words: if cell.psnr_db.is_finite() { format!("{:.1}", cell.psnr_db) } else { String::new() },
        corner: asked.is_some_and(|asked| cell.psnr_db < asked),
    };
    let marks: Vec<CellMark> = map.cells.iter().map(mark).collect();
    let exact = map.cells.len() - finite().count();
    let below = marks.iter().filter(|mark| mark.corner).count() as u64;
    let mut key = Vec::new();
    if exact > 0 {
        let words = format!("{}: nothing differs", counted(exact as u64, "cell"));
        key.push(Entry { swatch: Swatch::Flat(palette::EXACT), words });
    }
    if below > 0 {
        let words = format!("{} below what was asked for", counted(below, "cell"));
        key.push(Entry { swatch: Swatch::Corner(palette::heat(1.0)), words });
    }
    let bar = least.is_finite().then(|| Bar {
        color: |part| palette::heat(1.0 - part),
        ticks: (0..=4).map(|at| f64::from(at) / 4.0).map(|at| (at, trimmed(least + at * (most - least)))).collect(),
        label: "PSNR in dB:".to_owned(),
        mark: asked.map(|asked| ((asked - least) / (most - least), format!("asked for, {} dB", trimmed(asked)))),
    });
    let caption = "PSNR of each cell".to_owned();
    Ok(Panel { caption, image: draw_cells(subject.size(), scale, &marks)?, key, bar })
}

/// At most two decimals, none that are 0.
fn trimmed(value: f64) -> String {
    let text = format!("{value:.2}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_whole_numbers_with_both_ends() {
        let values = |top| ticks(top).into_iter().map(|(_, text)| text).collect::<Vec<_>>().join(" ");
        assert_eq!([1, 3, 100, 65535].map(values), ["0 1", "0 1 2 3", "0 25 50 75 100", "0 16383 32767 49151 65535"]);
        assert_eq!([40.0, 42.25, 0.5, 100.0].map(trimmed), ["40", "42.25", "0.5", "100"]);
    }
}
