//! Charts as SVG and PNG.
//!
//! A chart is a [`Drawing`]: a list of shapes, whose places are known before there is a file. [`save()`] draws it on
//! both backends of `plotters`, so that both files show the same, and have the same bytes on every run.

pub mod axis;
pub mod chart;
pub mod drawing;
pub mod font;
pub mod heat;
pub mod labels;
pub mod legend;
pub mod marker;
pub mod number;
pub mod palette;
pub mod save;
mod style;

pub use drawing::{Drawing, Ink};
pub use save::save;
