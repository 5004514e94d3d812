//! The command line: every command and its arguments.

use clap::{CommandFactory, Parser, Subcommand};

use crate::cli::encode::{EncodeSequence, Encodes};
use crate::cli::global::GlobalArgs;
use crate::cli::tradeoff::Args as TradeoffArgs;
use crate::cli::{
    bc4w, capture, completions, decode, demo, diff, encode, encode_color, encode_depth, init, inspect, interpolate,
    man, pack, place, quadtree, quilt, render, scan, schema, selftest, simplify, train,
};

/// Codec toolkit for animated light fields: encodes, inspects, decodes and compares probes of colour and depth.
#[derive(Debug, Parser)]
#[command(
    name = "lightfold",
    version,
    propagate_version = true,
    max_term_width = 100,
    after_help = "Exit codes: 0 success; 1 a check failed: diff exceeds a bound, devices disagree, inspect --check suspects\n\
        an error, or no point of tradeoff meets its limits; 2 bad input or usage; 130 interrupted.\n\n\
        Examples:\n  lightfold demo -o out/demo\n  lightfold encode lightfield.json -o film.lfold\n  \
        lightfold inspect film.lfold\n  lightfold decode film.lfold -o frames\n  \
        lightfold diff lightfield.json film.lfold --max-error 100 --min-cell-psnr 40"
)]
pub struct Cli {
    #[command(subcommand)]
    pub command: Command,
    #[command(flatten)]
    pub global: GlobalArgs,
}

#[derive(Debug, Subcommand)]
pub enum Command {
    /// Capture, encode, decode and compare a built-in scene
    Demo(demo::Args),
    /// Place cameras in a scene by greedy search for coverage
    Place(place::Args),
    /// Capture a scene as a dataset: colour, depth, normals, materials
    Capture(capture::Args),
    /// Propose a manifest for a folder of image sequences
    Init(init::Args),
    /// Encode a dataset into one container
    Encode(encode::Args),
    /// Find the depth ranges of a dataset, for encodes in shards
    Scan(scan::Args),
    /// Encode one colour sequence
    EncodeColor(EncodeSequence<encode_color::Args>),
    /// Encode one depth sequence
    EncodeDepth(EncodeSequence<encode_depth::Args>),
    /// Build quadtrees of one depth sequence, to pack at any error bound
    Quadtree(EncodeSequence<quadtree::Args>),
    /// Encode one depth sequence as BC4w blocks, 32 bytes for 8x8 pixels, and measure their PSNR
    Bc4w(bc4w::Args),
    /// Join containers, recompress them, or pack quadtrees at an error bound
    Pack(pack::Args),
    /// Train entropy tables of colour on containers
    #[command(after_help = train::COLOR_HELP)]
    TrainColor(train::Args),
    /// Train entropy tables of predictive depth on containers
    #[command(after_help = train::DEPTH_HELP)]
    TrainDepth(train::Args),
    /// Show sizes and contents of a container or a scene, verify a container, check the conventions of a dataset
    Inspect(inspect::Args),
    /// Decode a container into image files, or measure decoding time
    Decode(decode::Args),
    /// Render light fields and simplified scenes, and compare pictures with references
    Render(Box<render::Args>),
    /// Simplify a still scene to textured quads under budgets, as binary glTF
    Simplify(simplify::Args),
    /// Interpolate many views side by side, for light-field displays
    Interpolate(Box<interpolate::Args>),
    /// Join rendered views to a quilt, the picture that light-field displays read
    Quilt(quilt::Args),
    /// Compare two containers, datasets or image sequences
    Diff(diff::Args),
    /// Measure bytes, time and quality of settings on your own footage
    Tradeoff(TradeoffArgs),
    /// Test graphics devices against the CPU, and hard cases against their error bounds
    Selftest(selftest::Args),
    /// Print the JSON Schema of a file, for editors and validators
    Schema(schema::Args),
    /// Print a completion script for a shell
    Completions(completions::Args),
    /// Write the man pages
    #[command(hide = true)]
    Man(man::Args),
}

impl Command {
    /// A command that writes a container of footage.
    pub fn as_encoder(&self) -> Option<&dyn Encodes> {
        match self {
            Command::Encode(args) => Some(args),
            Command::EncodeColor(args) => Some(args),
            Command::EncodeDepth(args) => Some(args),
            _ => None,
        }
    }
}

/// The whole command line, for man pages and completions.
pub fn command() -> clap::Command {
    Cli::command()
}
