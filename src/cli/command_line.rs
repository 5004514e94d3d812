//! The command line: every command and its arguments.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use clap::{ArgMatches, CommandFactory, Parser, Subcommand};

use crate::encode::{EncodeSequence, Encodes};
use crate::global::GlobalArgs;
use crate::tradeoff::Args as TradeoffArgs;
use crate::{
    bc4w, cameras, capture, completions, decode, demo, diff, encode, encode_color, encode_depth, init, inspect,
    interpolate, man, pack, place, quadtree, quilt, render, scan, schema, selftest, simplify, train, view,
};
use codec::error::Result;
use footage::files;

/// Codec toolkit for animated light fields: probes of colour and depth.
#[derive(Debug, Parser)]
#[command(
    name = "lightfold",
    version,
    propagate_version = true,
    max_term_width = 100,
    after_help = "Exit codes:\n  \
        0    success\n  \
        1    a check failed: diff exceeds a bound, devices disagree, inspect --check suspects an error, or\n       \
        no point of tradeoff meets its limits\n  \
        2    bad input or usage, or a path on the command line does not exist\n  \
        75   temporary failure: an image does not exist yet, a disk is full, a mount is lost, or another\n       \
        process writes the output\n  \
        130  interrupted\n  \
        141  the reader of standard output closed it\n\n\
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
    /// Encode one depth sequence as BC4w blocks, and measure their PSNR
    Bc4w(bc4w::Args),
    /// Join containers, recompress them, or pack quadtrees at an error bound
    Pack(pack::Args),
    /// Train entropy tables of colour on containers
    #[command(after_help = train::COLOR_HELP)]
    TrainColor(train::Args),
    /// Train entropy tables of predictive depth on containers
    #[command(after_help = train::DEPTH_HELP)]
    TrainDepth(train::Args),
    /// Inspect or verify a container, inspect a scene, or check a dataset
    #[command(alias = "info")]
    Inspect(inspect::Args),
    /// Decode a container into image files, or measure decoding time
    Decode(decode::Args),
    /// Render light fields and simplified scenes, and compare pictures with references
    Render(Box<render::Args>),
    /// Convert camera files between programs, and export the probes of a light field
    Cameras(cameras::Args),
    /// Simplify a still scene to textured quads under budgets, as binary glTF
    Simplify(simplify::Args),
    /// Interpolate many views side by side, for light-field displays
    Interpolate(Box<interpolate::Args>),
    /// Join rendered views into a quilt, the picture format of light-field displays
    Quilt(quilt::Args),
    /// Play a container, a simplified scene or a quilt in the browser
    View(view::Args),
    /// Compare two containers, datasets or image sequences
    Diff(diff::Args),
    /// Measure bytes, time and quality of settings on your own footage
    Tradeoff(TradeoffArgs),
    /// Test graphics devices against the CPU, and hard cases against their error bounds
    Selftest(selftest::Args),
    /// Print the JSON Schema of a file type, for editors and validators
    Schema(schema::Args),
    /// Print a completion script for a shell
    Completions(completions::Args),
    /// Write the man pages
    #[command(hide = true)]
    Man(man::Args),
}

impl Command {
    /// Returns the command as an encoder if it writes a container of footage.
    pub fn as_encoder(&self) -> Option<&dyn Encodes> {
        match self {
            Command::Encode(args) => Some(args),
            Command::EncodeColor(args) => Some(args),
            Command::EncodeDepth(args) => Some(args),
            _ => None,
        }
    }
}

/// Returns the whole command line, for man pages and completions.
pub fn command() -> clap::Command {
    Cli::command()
}

/// Commands that write to standard output only what their options request.
const WRITERS: &[&str] = &[
    "bc4w",
    "capture",
    "decode",
    "encode",
    "encode-color",
    "encode-depth",
    "interpolate",
    "pack",
    "quadtree",
    "quilt",
    "render",
    "simplify",
    "train-color",
    "train-depth",
];
/// Options that print a result on standard output.
const PRINTING: &[&str] = &["json", "list_devices", "null", "stats", "verify"];
const INPUTS: &[&str] = &["held_out", "input", "inputs", "more", "reference"];

/// True if standard output carries the result of a command.
pub fn has_result_on_stdout(matches: &ArgMatches) -> bool {
    let Some((name, matches)) = matches.subcommand() else { return true };
    let prints = |id: &&str| matches.try_get_one::<bool>(id).ok().flatten() == Some(&true);
    let is_dash = |id: &clap::Id| {
        let values = matches.try_get_raw(id.as_str()).ok().flatten();
        !INPUTS.contains(&id.as_str()) && values.is_some_and(|mut values| values.any(|value| value == OsStr::new("-")))
    };
    !WRITERS.contains(&name) || PRINTING.iter().any(prints) || matches.ids().any(is_dash)
}

/// Options that name an output file or folder.
const OUTPUTS: &[&str] =
    &["cameras_out", "contact_sheet", "csv", "error_map", "export", "folder", "output", "path", "plot", "trace"];
/// Options that always name a file.
const FILES: &[&str] = &["cameras_out", "contact_sheet", "csv", "path", "trace"];
/// Commands whose `-o` always names a file.
const FILE_WRITERS: &[&str] = &["bc4w", "init", "place", "quilt", "scan", "simplify", "train-color", "train-depth"];

/// Checks the outputs before any work. Fails if the file system rejects a name, a folder is missing, or standard output
/// is closed.
pub fn check_outputs(matches: &ArgMatches) -> Result<()> {
    let Some((name, matches)) = matches.subcommand() else { return Ok(()) };
    for id in OUTPUTS {
        for path in matches.try_get_many::<PathBuf>(id).ok().flatten().into_iter().flatten() {
            if path == Path::new("-") {
                files::standard_output()?;
            } else if FILES.contains(id) || *id == "output" && FILE_WRITERS.contains(&name) {
                files::check_file(path)?;
            } else {
                files::check_name(path)?;
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;

    #[test]
    fn an_option_stands_below_the_same_heading_in_every_command() {
        // Applies to options shared by commands. A heading continues over all following options, including those of the
        // next group.
        const BELOW_NONE: [&str; 8] = ["effort", "frames", "json", "memory", "missing", "output", "resume", "threads"];
        let root = command();
        let (mut commands, mut known) = (vec![&root], BTreeMap::new());
        while let Some(command) = commands.pop() {
            commands.extend(command.get_subcommands());
            for option in command.get_opts() {
                let (Some(long), Some(help)) = (option.get_long(), option.get_help()) else { continue };
                if long == "face-size" {
                    // For sequences it is part of the layout.
                    continue;
                }
                let (heading, name) = (option.get_help_heading(), command.get_name());
                assert!(heading.is_none() || !BELOW_NONE.contains(&long), "--{long} of {name} is below {heading:?}");
                let (first, of) = known.entry((long, help.to_string())).or_insert((heading, name));
                assert_eq!(*first, heading, "--{long} of {of} and of {name}");
            }
        }
        assert!(known.len() > 200, "{}", known.len());
    }

    #[test]
    fn results_on_standard_output_are_known_from_the_arguments() {
        let of = |line: &str| has_result_on_stdout(&command().get_matches_from(format!("lightfold {line}").split(' ')));
        for line in ["encode a -o b", "decode - -o b", "pack - -o b", "render a -o b.png"] {
            assert!(!of(line), "{line}");
        }
        for line in
            ["encode a -o -", "encode a -o b --json", "decode a --null", "inspect a", "render a -o b.png --trace -"]
        {
            assert!(of(line), "{line}");
        }
        let root = command();
        for name in WRITERS.iter().chain(FILE_WRITERS) {
            assert!(root.find_subcommand(name).is_some(), "{name}");
        }
        for id in OUTPUTS {
            let has = |command: &clap::Command| command.get_arguments().any(|argument| argument.get_id() == id);
            assert!(root.get_subcommands().any(has), "{id}");
        }
    }
}
