//! Sweeps: cost in bytes and time and gain in quality of each setting of a command (CALF figures 7 to 9, GDC figures 5,
//! 6 and 8).
//!
//! A [`study::Study`] is a grid of knob values. [`schedule`] measures its points through a [`runner::Bench`], [`store`]
//! keeps them as CSV, [`figures`] and [`page`] draw them, [`findings`] tests claims of papers on them, and [`json`] reports
//! them. None of these modules depends on what is measured: a [`kind::SweepKind`] describes it as tables. Each finished run
//! is saved at once, and [`folder`] locks the results.
//!
//! # To add a kind of sweep
//!
//! 1. Write a table like `kinds/rendering.json`: `knobs` are options of the command; `measures` are rows with the CSV and
//!    JSON name, heading and format of each value, and its path in the JSON report of the command or a formula; `panels` are
//!    drawn along knobs, and `trades` plot one measure against another with the Pareto front. Measures with the source `runs`
//!    hold timed runs; others are derived from them, such as `median`. `point` is the command line of a point.
//! 2. Name it in [`kind`], and choose it by its input or its knobs in `lightfold tradeoff` (`src/cli/tradeoff.rs`).
//!
//! CSV, rounds, page, heat maps and JSON need no code, nor do claims that compare the ends of rows.

pub mod coding;
pub mod crops;
pub mod figures;
pub mod findings;
pub mod folder;
pub mod json;
pub mod kind;
pub mod page;
pub mod plan;
pub mod point;
pub mod recommend;
pub mod runner;
pub mod schedule;
pub mod score;
pub mod store;
pub mod study;

#[cfg(test)]
pub(crate) mod tests {
    pub(crate) mod sample;
}
