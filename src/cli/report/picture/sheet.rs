//! Sheet: a title, lines of facts, and images side by side, each with a key and a colour bar below. The content
//! determines the size; nothing is clipped.

use super::raster::{self, HALF_SIDE, Scale, is_hatched};
use crate::report::plot::drawing::{Anchor, Stroke, Text};
use crate::report::plot::font::{self, Weight};
use crate::report::plot::palette::{INK, PAPER, Rgb, SOFT_INK, contrast, hatched, heat};
use crate::report::plot::save::to_pixels;
use crate::report::plot::{Drawing, Ink};
use codec::error::Result;
use codec::image::plane::Plane;

const MARGIN: u32 = 24;
const GAP: u32 = 40;
const MIN_WIDTH: u32 = 620;
const MIN_COLUMN: u32 = 420;
const TITLE_EM: f64 = 21.0;
const CAPTION_EM: f64 = 16.0;
const TEXT_EM: f64 = 14.5;
/// Sheet width in pixels from which text is enlarged, by at most [`MAX_ZOOM`], so that it stays legible when the whole
/// sheet is shown.
const USUAL_WIDTH: f64 = 1100.0;
const MAX_ZOOM: f64 = 1.7;
/// Line height in ems.
const LEADING: f64 = 1.45;
const SWATCH: [f64; 2] = [26.0, 15.0];
const BAR_HEIGHT: f64 = 16.0;
const MAX_BAR: f64 = 640.0;

/// Fill of a swatch in a key.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Swatch {
    Flat(Rgb),
    Hatched(Rgb),
    /// Flat colour with a cut-off corner.
    Corner(Rgb),
    /// Dashed line.
    Dashed(Rgb),
}

#[derive(Debug, Clone, PartialEq)]
pub struct Entry {
    pub swatch: Swatch,
    pub words: String,
}

#[derive(Debug, Clone)]
pub struct Bar {
    /// Colour at each position, 0 to 1.
    pub color: fn(f64) -> Rgb,
    /// Tick positions, 0 to 1 and ascending, with their labels.
    pub ticks: Vec<(f64, String)>,
    pub label: String,
    pub mark: Option<(f64, String)>,
}

/// From the top: caption, image, key, colour bar.
#[derive(Debug, Clone)]
pub struct Panel {
    pub caption: String,
    pub image: Plane<Rgb>,
    pub key: Vec<Entry>,
    pub bar: Option<Bar>,
}

#[derive(Debug, Clone)]
pub struct Sheet {
    pub title: String,
    pub facts: Vec<String>,
    /// At least one panel, from left to right.
    pub panels: Vec<Panel>,
}

impl Sheet {
    pub fn draw(&self) -> Result<Plane<Rgb>> {
        let columns: Vec<u32> = self.panels.iter().map(|panel| panel.image.width().max(MIN_COLUMN)).collect();
        let gaps = GAP * (columns.len() as u32).saturating_sub(1);
        let width = (columns.iter().sum::<u32>() + gaps).max(MIN_WIDTH);
        let zoom = (f64::from(width) / USUAL_WIDTH).clamp(1.0, MAX_ZOOM);
        let head = written(width, zoom, |lines| {
            lines.words(&self.title, TITLE_EM, Weight::Bold);
            lines.space(4.0);
            self.facts.iter().for_each(|fact| lines.words(fact, TEXT_EM, Weight::Regular));
            lines.space(12.0);
        })?;
        let each = || self.panels.iter().zip(&columns);
        let captions = each().map(|(panel, &column)| written(column, zoom, |lines| panel.head(lines)));
        let captions = captions.collect::<Result<Vec<_>>>()?;
        let feet = each().map(|(panel, &column)| written(column, zoom, |lines| panel.foot(lines)));
        let feet = feet.collect::<Result<Vec<_>>>()?;
        let caption = captions.iter().map(Plane::height).max().unwrap_or(0);
        let image = self.panels.iter().map(|panel| panel.image.height()).max().unwrap_or(0);
        let foot = feet.iter().map(Plane::height).max().unwrap_or(0);
        let height = MARGIN + head.height() + caption + image + foot + MARGIN;
        let mut sheet = Plane::filled(width + 2 * MARGIN, height, PAPER);
        paste(&mut sheet, &head, [MARGIN, MARGIN]);
        let (mut left, top) = (MARGIN, MARGIN + head.height());
        for (((panel, column), above), below) in each().zip(&captions).zip(&feet) {
            paste(&mut sheet, above, [left, top]);
            paste(&mut sheet, &panel.image, [left, top + caption]);
            paste(&mut sheet, below, [left, top + caption + panel.image.height()]);
            left += column + GAP;
        }
        Ok(sheet)
    }
}

impl Panel {
    fn head(&self, lines: &mut Lines) {
        lines.words(&self.caption, CAPTION_EM, Weight::Bold);
        lines.space(6.0);
    }

    fn foot(&self, lines: &mut Lines) {
        lines.space(10.0);
        self.key.iter().for_each(|entry| lines.entry(entry));
        if let Some(bar) = &self.bar {
            lines.space(8.0);
            lines.bar(bar);
        }
    }
}

pub fn paste(sheet: &mut Plane<Rgb>, plane: &Plane<Rgb>, [left, top]: [u32; 2]) {
    let columns = left as usize..(left + plane.width()) as usize;
    for y in 0..plane.height() {
        sheet.row_mut(top + y)[columns.clone()].copy_from_slice(plane.row(y));
    }
}

/// Returns the written lines as an image of the given width in pixels.
fn written(width: u32, zoom: f64, write: impl FnOnce(&mut Lines)) -> Result<Plane<Rgb>> {
    let mut lines = Lines { drawing: Drawing::new(width, 1, ""), y: 0.0, zoom, em: TEXT_EM * zoom };
    write(&mut lines);
    lines.drawing.height = (lines.y.ceil() as u32).max(1);
    to_pixels(&lines.drawing, 1)
}

struct Lines {
    drawing: Drawing,
    y: f64,
    /// Factor from the unit of lengths and sizes to pixels.
    zoom: f64,
    /// Em of texts in pixels.
    em: f64,
}

impl Lines {
    fn room(&self) -> f64 {
        f64::from(self.drawing.width)
    }

    fn space(&mut self, pixels: f64) {
        self.y += (pixels * self.zoom).round();
    }

    fn text(&self, words: impl AsRef<str>) -> Text {
        Text::new(words, self.em).ink(Ink::opaque(INK))
    }

    fn words(&mut self, words: &str, em: f64, weight: Weight) {
        let em = em * self.zoom;
        for line in wrap(words, em, weight, self.room()) {
            let text = Text { weight, em, ..self.text(line) };
            self.drawing.text([0.0, self.y + em * LEADING * 0.75], text);
            self.y += (em * LEADING).ceil();
        }
    }

    fn entry(&mut self, entry: &Entry) {
        let [width, height] = SWATCH.map(|side| (side * self.zoom).round());
        let (indent, height_of_line) = (width + 10.0 * self.zoom, (self.em * LEADING).ceil());
        let top = (self.y + (height_of_line - height) / 2.0).round();
        self.swatch(entry.swatch, [0.5, top], [width, top + height]);
        for line in wrap(&entry.words, self.em, Weight::Regular, self.room() - indent) {
            let baseline = self.y + self.em * LEADING * 0.75;
            self.drawing.text([indent, baseline], self.text(line));
            self.y += height_of_line;
        }
    }

    fn swatch(&mut self, swatch: Swatch, from: [f64; 2], to: [f64; 2]) {
        let (Swatch::Flat(ground) | Swatch::Hatched(ground) | Swatch::Corner(ground) | Swatch::Dashed(ground)) = swatch;
        let [left, top] = from;
        self.drawing.rectangle(from, to, Ink::opaque(ground));
        let ink = Ink::opaque(contrast(ground));
        match swatch {
            Swatch::Flat(_) => {}
            Swatch::Dashed(_) => {
                let middle = ((top + to[1]) / 2.0).floor();
                for start in (2..to[0] as u32).step_by(8).map(f64::from) {
                    self.drawing.rectangle([start, middle], [(start + 4.0).min(to[0]), middle + 1.0], ink);
                }
            }
            Swatch::Hatched(_) => {
                let spots = (top as u32..to[1] as u32).flat_map(|y| (0..to[0] as u32).map(move |x| [x, y]));
                for [x, y] in spots.filter(|[x, y]| is_hatched(*x, *y)).map(|at| at.map(f64::from)) {
                    self.drawing.rectangle([x, y], [x + 1.0, y + 1.0], Ink::opaque(hatched(ground)));
                }
            }
            Swatch::Corner(_) => {
                let side = (to[1] - top) * 0.7;
                self.drawing.polygon(&[from, [left + side, top], [left, top + side]], ink);
            }
        }
        self.drawing.frame(from, to, Stroke::solid(Ink::opaque(SOFT_INK), 1.0));
    }

    fn bar(&mut self, bar: &Bar) {
        self.words(&bar.label, TEXT_EM, Weight::Regular);
        self.space(4.0);
        let (zoom, em) = (self.zoom, self.em);
        let half = |text: &str| Text::new(text, em).width() / 2.0;
        // Keeps the labels of the first and last tick centred, like all others.
        let [first, last] =
            [bar.ticks.first(), bar.ticks.last()].map(|tick| tick.map_or(0.0, |(_, text)| half(text)).ceil());
        let (left, right) = (first, (self.room() - last).min(first + MAX_BAR * zoom).floor());
        let x = |part: f64| left + part * (right - left);
        if let Some((part, words)) = &bar.mark {
            let at = x(part.clamp(0.0, 1.0));
            let text = self.text(words).fit(self.room());
            let start = (at - text.width() / 2.0).clamp(0.0, (self.room() - text.width()).max(0.0));
            self.drawing.text([start, self.y + em], text);
            self.y += em + 6.0 * zoom;
            let tip = [[at - 5.0 * zoom, self.y], [at + 5.0 * zoom, self.y], [at, self.y + 7.0 * zoom]];
            self.drawing.polygon(&tip, Ink::opaque(INK));
            self.y += 8.0 * zoom;
        }
        let (top, bottom) = (self.y.ceil(), self.y.ceil() + (BAR_HEIGHT * zoom).round());
        let steps = (right - left) as u32;
        for step in 0..steps {
            let color = (bar.color)(f64::from(step) / f64::from(steps.saturating_sub(1).max(1)));
            let from = left + f64::from(step);
            self.drawing.rectangle([from, top], [from + 1.0, bottom], Ink::opaque(color));
        }
        let line = Stroke::solid(Ink::opaque(SOFT_INK), 1.0);
        self.drawing.frame([left, top], [right, bottom], line);
        let under = bottom + 6.0 * zoom + em;
        // The last label is always drawn; an earlier one only if it does not overlap another.
        let end = bar.ticks.last().map_or(f64::INFINITY, |(part, words)| x(*part) - half(words));
        let mut free_from = f64::NEG_INFINITY;
        for (at_tick, (part, words)) in bar.ticks.iter().enumerate() {
            let (at, half, is_last) = (x(*part), half(words), at_tick + 1 == bar.ticks.len());
            self.drawing.line(&[[at, bottom], [at, bottom + 5.0 * zoom]], line);
            if is_last || (at - half >= free_from && at + half + 8.0 <= end) {
                self.drawing.text([at, under], self.text(words).anchor(Anchor::Middle));
                free_from = at + half + 8.0;
            }
        }
        self.y = under + em * 0.5;
    }
}

/// Breaks `words` into lines of at most `room` pixels. A longer word is shortened in its middle.
fn wrap(words: &str, em: f64, weight: Weight, room: f64) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in words.split_whitespace() {
        if let Some(line) = lines.last_mut() {
            let longer = format!("{line} {word}");
            if font::width(&longer, em, weight) <= room {
                *line = longer;
                continue;
            }
        }
        lines.push(font::fit(word, em, weight, room));
    }
    lines
}

/// Difference in display codes from which error pictures have the last colour.
const MAX_CODES: u8 = 64;

/// Draws a picture and its reference, both in display codes, and the largest component difference of each pixel.
pub fn error_picture(title: &str, [shown, wanted]: [&Plane<Rgb>; 2], difference: &Plane<u8>) -> Result<Plane<Rgb>> {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_wrap_and_none_is_wider_than_its_room() {
        let words = format!("a b c and then a {} with an end", "very".repeat(60));
        let lines = wrap(&words, 14.0, Weight::Regular, 150.0);
        assert!(lines.len() >= 3 && lines.iter().any(|line| line.contains('…')), "{lines:?}");
        assert!(lines.iter().all(|line| font::width(line, 14.0, Weight::Regular) <= 150.0), "{lines:?}");
        assert_eq!(wrap("one line", 14.0, Weight::Regular, 150.0), ["one line"]);
    }

    fn sheet(images: &[[u32; 2]]) -> Sheet {
        let panel = |&[width, height]: &[u32; 2]| Panel {
            caption: "an image".into(),
            image: Plane::filled(width, height, [1, 2, 3]),
            key: vec![
                Entry { swatch: Swatch::Flat([9, 9, 9]), words: "flat".into() },
                Entry { swatch: Swatch::Hatched([0; 3]), words: "lines ".repeat(40) },
            ],
            bar: Some(Bar {
                color: crate::report::plot::palette::heat,
                ticks: vec![(0.0, "0".into()), (1.0, "100".into())],
                label: "error in codes".into(),
                mark: Some((1.0, "the bound, 100 codes".into())),
            }),
        };
        let facts = vec!["one fact".into(), "another fact ".repeat(30)];
        Sheet { title: "title ".repeat(40), facts, panels: images.iter().map(panel).collect() }
    }

    #[test]
    fn images_are_whole_and_nothing_touches_the_margin() {
        for images in [&[[1, 1]][..], &[[7, 5], [7, 5]], &[[1500, 10]], &[[30, 900], [30, 900]]] {
            let drawn = sheet(images).draw().unwrap();
            let pixels = drawn.data().iter().filter(|pixel| **pixel == [1, 2, 3]).count() as u32;
            assert_eq!(pixels, images.iter().map(|[width, height]| width * height).sum::<u32>());
            for y in 0..drawn.height() {
                let row = drawn.row(y);
                let margins = row[..MARGIN as usize - 4].iter().chain(&row[row.len() - MARGIN as usize + 4..]);
                assert!(margins.into_iter().all(|pixel| *pixel == PAPER), "{images:?}, row {y}");
            }
        }
    }
}
