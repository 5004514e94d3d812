//! Constructed results for tests of reports.

pub(crate) mod sample;
