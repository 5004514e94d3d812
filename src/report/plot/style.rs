//! Sizes and words that charts, heat maps and legends share.

use super::drawing::{Anchor, Drawing, Text};
use super::font::{self, Weight};
use super::palette;

/// Ems of titles, of axes' names and of ticks, in pixels.
pub const TITLE_EM: f64 = 14.0;
pub const NAME_EM: f64 = 12.0;
pub const TICK_EM: f64 = 11.0;
pub const MARKER: f64 = 4.0;
pub const MARGIN: f64 = 12.0;
/// Longest label of a tick or a row in pixels.
pub const LONGEST_LABEL: f64 = 110.0;

pub fn tick(label: &str) -> Text {
    Text::new(label, TICK_EM).ink(palette::TEXT)
}

/// The name of an axis, its middle at its place, shortened to a width.
pub fn name(label: &str, room: f64) -> Text {
    Text::new(label, NAME_EM).ink(palette::TEXT).anchor(Anchor::Middle).fit(room)
}

pub fn write_title(drawing: &mut Drawing, title: &str, width: f64) {
    let text = Text::new(title, TITLE_EM).bold().ink(palette::TEXT).fit(width - 2.0 * MARGIN);
    drawing.text([MARGIN, MARGIN + TITLE_EM], text);
}

/// Width of the widest of some labels of ticks.
pub fn widest<'a>(labels: impl IntoIterator<Item = &'a String>) -> f64 {
    labels.into_iter().map(|label| font::width(label, TICK_EM, Weight::Regular)).fold(0.0, f64::max)
}
