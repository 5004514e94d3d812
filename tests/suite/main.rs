//! One test binary for everything that is tested from outside the crate.

mod cli;
mod corrupt;
mod docs;
mod diff;
mod exr_files;
mod footage;
mod house;
mod input;
mod roundtrip;
mod samples;
mod vectors;
