//! Charts as SVG and PNG.
//!
//! A chart is a [`Picture`]: a list of shapes whose places are known before anything is drawn. [`save()`] draws the same
//! picture on both backends of `plotters`, so that both files show the same, and the same bytes on every run.

pub mod font;
pub mod picture;
pub mod save;

pub use picture::{Ink, Picture};
pub use save::{save, save_png};
