//! One test binary for everything that is tested from outside the crate.

mod anatomy;
mod blocks;
mod cli;
mod commands;
mod corrupt;
mod devices;
mod diff;
mod docs;
mod exr_files;
mod footage;
mod hard_cases;
mod house;
mod input;
mod inspect;
mod interrupted;
mod quadtree;
mod quality;
mod resume;
mod roundtrip;
mod samples;
mod tradeoff;
mod vectors;
mod vectors_of_blocks;
mod vectors_of_nodes;
mod view;
mod visibility;
