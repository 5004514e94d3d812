//! Legend beside a chart: names of the series and explanations of point labels.

use super::drawing::{Drawing, Ink, Spot, Stroke, Text};
use super::font::{self, Weight};
use super::labels::{MARKER, TICK_EM, tick};
use super::marker::Look;
use super::palette;

const LINE: f64 = 17.0;
/// Width in pixels of a swatch and the gap after it.
const SWATCH: f64 = 30.0;
const MAX_ENTRIES: usize = 28;

#[derive(Debug, Clone, PartialEq)]
pub enum Swatch {
    LineAndMarker(Look),
    Marker(Look),
    Line(Stroke),
    Patch(Ink),
}

#[derive(Debug, Clone, PartialEq)]
pub struct Entry {
    pub swatch: Swatch,
    pub name: String,
}

#[derive(Debug, Clone, PartialEq)]
pub struct Legend {
    pub title: String,
    pub entries: Vec<Entry>,
    pub key_title: String,
    pub key: Vec<(String, String)>,
    pub room: f64,
}

impl Legend {
    /// Returns the indent of the key's texts: the width of the widest name and a gap.
    fn key_indent(&self) -> f64 {
        let widths = self.key.iter().map(|(name, _)| font::width(name, TICK_EM, Weight::Bold));
        widths.fold(0.0, f64::max) + 8.0
    }

    pub fn width(&self) -> f64 {
        let titles = [&self.title, &self.key_title].map(|title| font::width(title, TICK_EM, Weight::Bold));
        let entries = self.entries.iter().map(|entry| SWATCH + font::width(&entry.name, TICK_EM, Weight::Regular));
        let indent = self.key_indent();
        let key = self.key.iter().map(|(_, text)| indent + font::width(text, TICK_EM, Weight::Regular));
        entries.chain(key).chain(titles).fold(0.0, f64::max).min(self.room)
    }

    pub fn height(&self) -> f64 {
        let lines =
            |count: usize, title: &str| count.min(MAX_ENTRIES + 1) + usize::from(!title.is_empty() && count > 0);
        let gap = if self.key.is_empty() || self.entries.is_empty() { 0.0 } else { LINE * 0.6 };
        LINE * (lines(self.entries.len(), &self.title) + lines(self.key.len(), &self.key_title)) as f64 + gap
    }

    /// Draws the legend with its upper left corner at `at`.
    pub fn draw(&self, drawing: &mut Drawing, at: Spot) {
        let mut pen = Pen { drawing, at, room: self.width() };
        if !self.entries.is_empty() {
            pen.title(&self.title);
            for entry in self.entries.iter().take(MAX_ENTRIES) {
                pen.swatch(&entry.swatch);
                pen.words(SWATCH, &entry.name);
            }
            pen.rest(self.entries.len());
        }
        if !self.key.is_empty() {
            if !self.entries.is_empty() {
                pen.at[1] += LINE * 0.6;
            }
            pen.title(&self.key_title);
            let indent = self.key_indent();
            for (name, text) in self.key.iter().take(MAX_ENTRIES) {
                pen.write(0.0, tick(name).bold());
                pen.words(indent, text);
            }
            pen.rest(self.key.len());
        }
    }
}

struct Pen<'a> {
    drawing: &'a mut Drawing,
    at: Spot,
    room: f64,
}

impl Pen<'_> {
    fn middle(&self) -> f64 {
        self.at[1] + LINE / 2.0
    }

    /// Draws text in the current line without advancing to the next.
    fn write(&mut self, indent: f64, text: Text) {
        self.drawing.text_beside([self.at[0] + indent, self.middle()], text);
    }

    fn title(&mut self, title: &str) {
        if !title.is_empty() {
            self.write(0.0, tick(title).bold().fit(self.room));
            self.at[1] += LINE;
        }
    }

    fn words(&mut self, indent: f64, words: &str) {
        self.write(indent, tick(words).fit(self.room - indent));
        self.at[1] += LINE;
    }

    fn rest(&mut self, count: usize) {
        if count > MAX_ENTRIES {
            self.write(0.0, tick(&format!("and {} more", count - MAX_ENTRIES)).ink(palette::FAINT_TEXT));
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
        let entries = (0..MAX_ENTRIES + 5).map(|_| entry()).collect();
        let legend = Legend { title: "t".into(), entries, key_title: String::new(), key: vec![], room: 100.0 };
        assert_eq!((legend.width(), legend.height()), (100.0, LINE * (MAX_ENTRIES + 2) as f64));
        let mut drawing = Drawing::new(200, 800, "");
        legend.draw(&mut drawing, [0.0, 0.0]);
        let said = format!("{:?}", drawing.shapes);
        assert!(said.contains("and 5 more") && said.contains('…'), "{said}");
    }
}
