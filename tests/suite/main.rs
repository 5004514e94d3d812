//! One test binary for everything that is tested from outside the crate.

mod corrupt;
mod docs;
mod exr_files;
mod footage;
mod input;
mod roundtrip;
mod samples;
mod vectors;
