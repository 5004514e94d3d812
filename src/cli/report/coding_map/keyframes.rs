//! Pictures of colour cells: how one frame codes them, and the number of keyframes or bytes of each over all frames.

use super::frames::{Shades, key, sentence, tinted};
use super::subject::{Subject, What};
use crate::report::picture::raster::{HALF_SIDE, Scale};
use crate::report::picture::sheet::{Bar, Entry, Panel, Sheet, Swatch};
use crate::report::picture::shown::srgb;
use crate::report::plot::drawing::{Anchor, Stroke, Text};
use crate::report::plot::palette::{self, Rgb};
use crate::report::plot::save::to_pixels;
use crate::report::plot::{Drawing, Ink};
use codec::decode::Picture;
use codec::error::{Result, counted};
use codec::image::plane::Plane;
use codec::streams::CodecHeader;
use footage::inspect::{CellCoding, CodingMap, Survey};

pub(super) struct CellMark {
    pub rect: [u32; 4],
    pub color: Rgb,
    pub words: String,
    pub corner: bool,
}

pub(super) fn draw_cells(size: [u32; 2], scale: Scale, cells: &[CellMark]) -> Result<Plane<Rgb>> {
    const MIN_EM: f64 = 9.0;
    const MAX_EM: f64 = 30.0;
    let [width, height] = scale.drawn(size);
    let mut drawing = Drawing::new(width, height, "");
    for cell in cells {
        let [left, top, width, height] = cell.rect;
        let (from, to) =
            ([scale.place(left), scale.place(top)], [scale.place(left + width), scale.place(top + height)]);
        let ink = Ink::opaque(palette::contrast(cell.color));
        let (wide, high) = (to[0] - from[0], to[1] - from[1]);
        drawing.rectangle(from, to, Ink::opaque(cell.color));
        if wide >= 6.0 && high >= 6.0 {
            drawing.frame(from, to, Stroke::solid(ink.with_alpha(0.35), 1.0));
        }
        if cell.corner {
            let (side, inset) = ((wide.min(high) / 2.0).min(20.0), (wide.min(high) / 10.0).min(4.0));
            let [x, y] = from.map(|at| at + inset);
            drawing.polygon(&[[x, y], [x + side, y], [x, y + side]], ink);
        }
        let fine = Text::new(&cell.words, 100.0).width() / 100.0;
        let em = (wide * 0.7 / fine.max(0.1)).min(high * 0.5).min(MAX_EM);
        if em >= MIN_EM {
            let middle = [(from[0] + to[0]) / 2.0, (from[1] + to[1]) / 2.0];
            drawing.text_beside(middle, Text::new(&cell.words, em).ink(ink).anchor(Anchor::Middle));
        }
    }
    to_pixels(&drawing, 1)
}

/// Draws the cells by number of keyframes, or by bytes for the transform codec, which has no keyframes.
pub(super) fn sheet(
    subject: &Subject<'_>,
    map: &CodingMap,
    picture: &Picture,
    survey: &Survey,
) -> Result<(What, Sheet)> {
    let scale = Scale::of(subject.size(), HALF_SIDE);
    let shades = Shades::plain(light(subject, picture));
    let (is_transform, has_blocks) = match &subject.stream.header {
        CodecHeader::Color(header) => (header.tables().is_some(), header.blocks().is_some()),
        _ => (false, false),
    };
    let frame = Panel {
        caption: if is_transform {
            format!("Frame {}, and the blocks that it writes", map.frame)
        } else {
            format!("Frame {}, and the cells that it writes", map.frame)
        },
        image: tinted(subject, scale, &shades, map),
        key: key(subject, map),
        bar: None,
    };
    let (what, cells) = if is_transform {
        (What::Bytes, Cells { word: "byte", label: "Bytes", count: |cell| cell.bytes, has_blocks })
    } else {
        (What::Keyframes, Cells { word: "keyframe", label: "Keyframes", count: CellCoding::keyframes, has_blocks })
    };
    let facts = vec![subject.fact(scale), cells.fact(survey), sentence(subject, map, None)];
    let title = format!("{}, {}, and frame {}", subject.name, what.name(), map.frame);
    Ok((what, Sheet { title, facts, panels: vec![frame, cells.panel(subject, scale, survey)?] }))
}

/// The quantity shown for each cell.
struct Cells {
    word: &'static str,
    label: &'static str,
    count: fn(&CellCoding) -> u64,
    /// True if keyframes may be coded in blocks.
    has_blocks: bool,
}

impl Cells {
    fn least_and_most(&self, survey: &Survey) -> (u64, u64) {
        let counts = || survey.cells.iter().map(self.count);
        (counts().min().unwrap_or(0), counts().max().unwrap_or(0))
    }

    fn panel(&self, subject: &Subject<'_>, scale: Scale, survey: &Survey) -> Result<Panel> {
        let (least, most) = self.least_and_most(survey);
        let part = |count: u64| (count - least) as f64 / (most - least).max(1) as f64;
        let mark = |cell: &CellCoding| {
            let count = (self.count)(cell);
            let corner = self.has_blocks && cell.samples > 0;
            CellMark { rect: cell.rect, color: palette::heat(part(count)), words: count.to_string(), corner }
        };
        let marks: Vec<CellMark> = survey.cells.iter().map(mark).collect();
        let cornered = marks.iter().filter(|mark| mark.corner).count() as u64;
        let mut key = Vec::new();
        if least == most {
            let words = format!("{} in each cell", counted(least, self.word));
            key.push(Entry { swatch: Swatch::Flat(palette::heat(0.0)), words });
        }
        if cornered > 0 {
            let cells = counted(cornered, "cell");
            let words = format!("{cells}: some keyframes in samples, since blocks would show them too badly");
            key.push(Entry { swatch: Swatch::Corner(palette::heat(1.0)), words });
        }
        let frames = subject.stream.frames;
        Ok(Panel {
            caption: format!("{} of each cell in frames {}-{}", self.label, frames.first, frames.last),
            image: draw_cells(subject.size(), scale, &marks)?,
            key,
            bar: (least < most).then(|| Bar {
                color: palette::heat,
                ticks: ticks(least, most),
                label: format!("{} for each cell:", self.label),
                mark: None,
            }),
        })
    }

    fn fact(&self, survey: &Survey) -> String {
        let (least, most) = self.least_and_most(survey);
        let total: u64 = survey.cells.iter().map(self.count).sum();
        let blocks: u64 = survey.cells.iter().map(|cell| cell.blocks).sum();
        let mean = total as f64 / survey.cells.len().max(1) as f64;
        let ways = if self.has_blocks {
            format!(", {blocks} of them in blocks and {} in samples", total - blocks)
        } else {
            String::new()
        };
        let spread = match least == most {
            true => format!("{least} in each"),
            false => format!("{least} to {most} in each, {mean:.2} in the mean"),
        };
        let cells = counted(survey.cells.len() as u64, "cell");
        format!("{} in {cells}: {spread}{ways}.", counted(total, self.word))
    }
}

/// Returns at most six integer ticks from `least` to `most`.
fn ticks(least: u64, most: u64) -> Vec<(f64, String)> {
    let span = (most - least).max(1);
    let step = span.div_ceil(5).max(1);
    // The last tick is always `most`.
    let values = (0..span / step).map(|at| least + at * step).chain([most]);
    values.map(|value| ((value - least) as f64 / span as f64, value.to_string())).collect()
}

/// Returns the darkness of each pixel on a display, 0 (white) to 1 (black).
fn light(subject: &Subject<'_>, picture: &Picture) -> Plane<Option<f32>> {
    let dark = |pixel: &[u8; 3]| Some(1.0 - palette::lightness(*pixel) as f32 / 255.0);
    match srgb(&subject.stream.header, picture) {
        Some(codes) => codes.map(dark),
        None => Plane::filled(subject.size()[0], subject.size()[1], None),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_whole_numbers_with_both_ends() {
        let values = |least, most| ticks(least, most).into_iter().map(|(_, text)| text).collect::<Vec<_>>().join(" ");
        assert_eq!(values(1, 6), "1 2 3 4 5 6");
        assert_eq!(values(1, 9), "1 3 5 7 9");
        assert_eq!(values(2, 100), "2 22 42 62 100");
        assert!(ticks(0, u64::from(u32::MAX)).iter().all(|(part, _)| (0.0..=1.0).contains(part)));
    }
}
