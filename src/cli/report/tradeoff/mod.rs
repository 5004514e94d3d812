//! Sweeps: cost in bytes and time and gain in quality of each setting of a command (CALF figures 7 to 9, GDC figures 5,
//! 6 and 8).
//!
//! A [`study::Study`] is a grid of knob values. [`schedule`] measures its points through a [`runner::Bench`], [`store`]
//! keeps them as CSV, [`figures`] and [`page`] draw them, and [`json`] reports them. None of these modules depends on
//! what is measured: a [`kind::SweepKind`] describes it as tables. Each finished run is saved at once, and [`folder`]
//! locks the results.
//!
//! # To add a kind of sweep
//!
//! 1. Write one file like [`rendering`]: a `SweepKind` whose `KNOBS` are options of the command, whose `MEASURES` are rows
//!    with the CSV and JSON name, source, heading and format of each value, whose `PANELS` are drawn along knobs, and whose
//!    `TRADES` plot one measure against another with the Pareto front. Measures of [`kind::Source::Runs`] hold timed runs;
//!    others are derived from them with `median_of`.
//! 2. Implement [`runner::CommandBench`] for it: the command of a point, and which numbers of its JSON report are times and
//!    which are values.
//! 3. Add it to [`plan::KINDS`], and add a function to `lightfold tradeoff` that reads its options and calls `measure_grid`
//!    (`src/cli/tradeoff`).
//!
//! CSV, rounds, page, heat maps and JSON need no further code.

pub mod coding;
pub mod figures;
pub mod findings;
pub mod folder;
pub mod interpolation;
pub mod json;
pub mod kind;
pub mod knob;
pub mod page;
pub mod pareto;
pub mod placement;
pub mod plan;
pub mod rendering;
pub mod runner;
pub mod runs;
pub mod schedule;
pub mod score;
pub mod simplification;
pub mod store;
pub mod study;
pub mod table;

#[cfg(test)]
pub(crate) mod tests;
