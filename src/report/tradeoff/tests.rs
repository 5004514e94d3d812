//! Results that were never measured, for tests of reports.

pub(crate) mod sample;
