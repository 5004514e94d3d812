//! Sizes and text styles shared by charts, heat maps and legends.

use super::drawing::{Anchor, Drawing, Text};
use super::font::{self, Weight};
use super::palette;

/// Font sizes of titles, axis names and ticks in pixels.
pub const TITLE_EM: f64 = 14.0;
pub const NAME_EM: f64 = 12.0;
pub const TICK_EM: f64 = 11.0;
pub const MARKER: f64 = 4.0;
pub const MARGIN: f64 = 12.0;
/// Maximum width of a tick or row label in pixels.
pub const LONGEST_LABEL: f64 = 110.0;

pub fn tick(label: &str) -> Text {
    Text::new(label, TICK_EM).ink(palette::TEXT)
}

/// Returns the text of an axis name, centred on its position and shortened to `room` pixels.
pub fn name(label: &str, room: f64) -> Text {
    Text::new(label, NAME_EM).ink(palette::TEXT).anchor(Anchor::Middle).fit(room)
}

pub fn write_title(drawing: &mut Drawing, title: &str, width: f64) {
    let text = Text::new(title, TITLE_EM).bold().ink(palette::TEXT).fit(width - 2.0 * MARGIN);
    drawing.text([MARGIN, MARGIN + TITLE_EM], text);
}

/// Returns the width in pixels of the widest tick label.
pub fn widest<'a>(labels: impl IntoIterator<Item = &'a String>) -> f64 {
    labels.into_iter().map(|label| font::width(label, TICK_EM, Weight::Regular)).fold(0.0, f64::max)
}
