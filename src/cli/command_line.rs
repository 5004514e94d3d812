//! The command line: every command and its arguments.

use clap::{CommandFactory, Parser, Subcommand};

use crate::cli::global::GlobalArgs;
use crate::cli::{
    bc4w, capture, completions, decode, demo, diff, encode, encode_color, encode_depth, inspect, man, pack, place,
    quadtree, render, selftest, tradeoff,
};

/// Codec toolkit for animated light fields: encodes, inspects, decodes and compares probes of colour and depth.
#[derive(Debug, Parser)]
#[command(
    name = "lightfold",
    version,
    propagate_version = true,
    max_term_width = 100,
    after_help = "Exit codes: 0 fine, 1 a bound given to diff is broken, devices disagree, inspect --check suspects\n\
        something, or no point of tradeoff meets what is asked, 2 bad input or usage, 130 interrupted.\n\n\
        Examples:\n  lightfold demo -o out/demo\n  lightfold encode lightfield.json -o film.lfold\n  \
        lightfold inspect film.lfold\n  lightfold decode film.lfold -o frames\n  \
        lightfold diff lightfield.json film.lfold --max-error 1 --min-psnr 50"
)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
    /// Options of every subcommand.
    #[command(flatten)]
    pub global: GlobalArgs,
}

/// The subcommands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Capture, encode, decode and compare a built-in scene
    Demo(demo::Args),
    /// Find where cameras see a scene best, one after the other
    Place(place::Args),
    /// Capture a scene as a dataset: colour, depth, normals, materials
    Capture(capture::Args),
    /// Encode a dataset: all its streams into one container
    Encode(encode::Args),
    /// Encode one colour sequence
    EncodeColor(encode_color::Args),
    /// Encode one depth sequence
    EncodeDepth(encode_depth::Args),
    /// Build the quadtrees of one depth sequence, to be packed at any bound
    Quadtree(quadtree::Args),
    /// Encode one depth sequence as plain BC4w blocks at a fixed 4:1, and measure them
    Bc4w(bc4w::Args),
    /// Join containers into one, compress one further, or pack quadtrees at a bound
    Pack(pack::Args),
    /// Show what a container holds and what it costs, and verify it; check a dataset's conventions; show a scene's size
    Inspect(inspect::Args),
    /// Decode a container into image files, or into nothing to time it
    Decode(decode::Args),
    /// Render pictures of a light field from anywhere, and compare them with the truth
    Render(Box<render::Args>),
    /// Compare two of anything: containers, datasets, sequences
    Diff(diff::Args),
    /// Show what settings cost in bytes, time and quality on footage of your own
    Tradeoff(tradeoff::Args),
    /// Test graphics devices against the CPU, and hard cases against their bounds
    Selftest(selftest::Args),
    /// Print a completion script for a shell
    Completions(completions::Args),
    /// Write the man pages
    #[command(hide = true)]
    Man(man::Args),
}

/// The whole command line, for man pages and completions.
pub fn command() -> clap::Command {
    Cli::command()
}
