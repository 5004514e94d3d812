//! Charts as SVG and PNG.
//!
//! A chart is a [`Drawing`]: a list of shapes with fixed coordinates. [`save()`] renders it with both backends of
//! `plotters`, so that both files show the same chart. The bytes of both files are the same on every run.

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

pub use drawing::{Drawing, Figure, Ink};
pub use save::save;
