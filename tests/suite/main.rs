//! One test binary for everything that is tested from outside the crate.

mod diff;
mod exr_files;
mod input;
