//! What accuracy costs: sweeps of the encoder's and decoder's knobs over a user's own footage, and what each setting
//! comes to in bytes, time and quality (CALF figures 7 and 8, GDC figures 5, 6 and 8).
//!
//! A [`Knob`] is an option of the command line that trades something. A [`Study`] is a grid of knob values for one
//! kind of stream; each of its [`Point`]s is encoded, decoded and compared, which leaves a [`Measured`].

pub mod bench;
pub mod commands;
pub mod figures;
pub mod findings;
pub mod grid_page;
pub mod html;
pub mod json;
pub mod knob;
pub mod page;
pub mod pareto;
pub mod placement;
pub mod plan;
pub mod point;
pub mod recommend;
pub mod rendering;
pub mod runs;
#[cfg(test)]
pub(crate) mod sample;
pub mod schedule;
pub mod score;
pub mod store;
pub mod study;

pub use knob::{KNOBS, Knob};
pub use point::{Measured, Point, Quality, Sizes, Timing};
pub use study::{Axis, Results, Study, Weights};
