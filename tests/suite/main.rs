//! One test binary for everything that is tested from outside the crate.

mod exr_files;
mod input;
mod inspect;
