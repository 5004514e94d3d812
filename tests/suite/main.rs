//! One test binary for everything that is tested from outside the crate.

mod cli;
mod exr_files;
mod house;
mod input;
