//! The legend beside a chart: what each series is, and what the short names of points stand for.

use super::drawing::{Drawing, Ink, Spot, Stroke, Text};
use super::font::{self, Weight};
use super::marker::Look;
use super::palette;
use super::style::{MARKER, TICK_EM};

/// From one line to the next, in pixels.
const LINE: f64 = 17.0;
/// Width of swatches with the gap behind them, in pixels.
const SWATCH: f64 = 30.0;
/// The most lines that series or named points have.
const MOST: usize = 28;

/// What a series looks like in the legend.
#[derive(Debug, Clone, PartialEq)]
pub enum Swatch {
    LineAndMarker(Look),
    Marker(Look),
    Line(Stroke),
    /// A filled rectangle.
    Patch(Ink),
}

/// A line of the legend.
#[derive(Debug, Clone, PartialEq)]
pub struct Entry {
    /// What it looks like.
    pub swatch: Swatch,
    /// What it is.
    pub name: String,
}

/// A legend, and a key under it.
#[derive(Debug, Clone, PartialEq)]
pub struct Legend {
    /// What the entries are; may be empty.
    pub title: String,
    /// Series and rules.
    pub entries: Vec<Entry>,
    pub key_title: String,
    /// Short names of points and what they stand for.
    pub key: Vec<(String, String)>,
    /// Largest width in pixels.
    pub room: f64,
}

impl Legend {
    /// Names of the key, the widest of which the texts beside them keep off.
    fn key_indent(&self) -> f64 {
        let widths = self.key.iter().map(|(name, _)| font::width(name, TICK_EM, Weight::Bold));
        widths.fold(0.0, f64::max) + 8.0
    }

    /// Width in pixels; 0 without entries.
    pub fn width(&self) -> f64 {
        let of = |text: &str, em: f64, weight: Weight| font::width(text, em, weight);
        let titles = [&self.title, &self.key_title].map(|title| of(title, TICK_EM, Weight::Bold));
        let entries = self.entries.iter().map(|entry| SWATCH + of(&entry.name, TICK_EM, Weight::Regular));
        let indent = self.key_indent();
        let key = self.key.iter().map(|(_, text)| indent + of(text, TICK_EM, Weight::Regular));
        entries.chain(key).chain(titles).fold(0.0, f64::max).min(self.room)
    }

    /// Height in pixels.
    pub fn height(&self) -> f64 {
        let lines = |count: usize, title: &str| count.min(MOST + 1) + usize::from(!title.is_empty() && count > 0);
        let gap = if self.key.is_empty() || self.entries.is_empty() { 0.0 } else { LINE * 0.6 };
        LINE * (lines(self.entries.len(), &self.title) + lines(self.key.len(), &self.key_title)) as f64 + gap
    }
}

/// Draws a legend, its upper left corner at `at`.
pub fn draw(legend: &Legend, drawing: &mut Drawing, at: Spot) {
    let mut pen = Pen { drawing, at, room: legend.width() };
    if !legend.entries.is_empty() {
        pen.title(&legend.title);
    }
    for entry in legend.entries.iter().take(MOST) {
        pen.swatch(&entry.swatch);
        pen.words(SWATCH, &entry.name);
    }
    pen.rest(legend.entries.len());
    if legend.key.is_empty() {
        return;
    }
    if !legend.entries.is_empty() {
        pen.at[1] += LINE * 0.6;
    }
    pen.title(&legend.key_title);
    let indent = legend.key_indent();
    for (name, text) in legend.key.iter().take(MOST) {
        let short = Text::new(name, TICK_EM).bold().ink(palette::TEXT);
        let middle = pen.middle();
        pen.drawing.text_beside([pen.at[0], middle], short);
        pen.words(indent, text);
    }
    pen.rest(legend.key.len());
}

struct Pen<'a> {
    drawing: &'a mut Drawing,
    at: Spot,
    room: f64,
}

impl Pen<'_> {
    /// The height of the middle of the line to write.
    fn middle(&self) -> f64 {
        self.at[1] + LINE / 2.0
    }

    fn title(&mut self, title: &str) {
        if !title.is_empty() {
            let text = Text::new(title, TICK_EM).bold().ink(palette::TEXT).fit(self.room);
            self.drawing.text_beside([self.at[0], self.middle()], text);
            self.at[1] += LINE;
        }
    }

    fn words(&mut self, indent: f64, words: &str) {
        let text = Text::new(words, TICK_EM).ink(palette::TEXT).fit(self.room - indent);
        self.drawing.text_beside([self.at[0] + indent, self.middle()], text);
        self.at[1] += LINE;
    }

    fn rest(&mut self, count: usize) {
        if count > MOST {
            let text = Text::new(format!("and {} more", count - MOST), TICK_EM).ink(palette::FAINT_TEXT);
            self.drawing.text_beside([self.at[0], self.middle()], text);
            self.at[1] += LINE;
        }
    }

    fn swatch(&mut self, swatch: &Swatch) {
        let (x, y) = (self.at[0], self.middle());
        let (from, to, centre) = ([x, y], [x + SWATCH - 7.0, y], [x + (SWATCH - 7.0) / 2.0, y]);
        match swatch {
            Swatch::LineAndMarker(look) => {
                self.drawing.line(&[from, to], look.stroke(1.8));
                look.mark(self.drawing, centre, MARKER);
            }
            Swatch::Marker(look) => look.mark(self.drawing, centre, MARKER),
            Swatch::Line(stroke) => self.drawing.line(&[from, to], *stroke),
            Swatch::Patch(ink) => {
                self.drawing.rectangle([x, y - 5.0], [x + SWATCH - 7.0, y + 5.0], *ink);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_legend_without_entries_takes_no_room() {
        let none = Legend { title: String::new(), entries: vec![], key_title: String::new(), key: vec![], room: 100.0 };
        assert_eq!((none.width(), none.height()), (0.0, 0.0));
    }

    #[test]
    fn long_names_are_cut_and_many_are_counted() {
        let entry = || Entry { swatch: Swatch::Patch(Ink::BLACK), name: "a rather long name of a series".repeat(3) };
        let entries = (0..MOST + 5).map(|_| entry()).collect();
        let legend = Legend { title: "t".into(), entries, key_title: String::new(), key: vec![], room: 100.0 };
        assert_eq!((legend.width(), legend.height()), (100.0, LINE * (MOST + 2) as f64));
        let mut drawing = Drawing::new(200, 800, "");
        draw(&legend, &mut drawing, [0.0, 0.0]);
        let said = format!("{:?}", drawing.shapes);
        assert!(said.contains("and 5 more") && said.contains('…'), "{said}");
    }
}
