//! Options that several subcommands share. Each knob has one name here, in the code and in reports.

mod camera;
mod color;
mod depth;
mod material;
mod number;
mod sequence;
mod side;

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};

use crate::dataset::stream::StreamKind;
use crate::decode::Selection;
use crate::effort::Effort;
use crate::encode::EncodeSettings;
use crate::error::{Error, Result};
use crate::image::cube::Face;
use crate::image::sequence::FrameRange;
use crate::memory::Budget;

pub use camera::{CameraArgs, View, parse_aspect, parse_point};
pub use color::{ColorArgs, InvalidColorArg};
pub use depth::{
    BoundArgs, DepthArgs, DepthReadingArgs, DepthStepArgs, DepthUnitArgs, DomainArgs, ModelArgs, parse_share,
};
pub use material::MaterialArgs;
pub use number::{parse_not_negative, parse_number, parse_positive};
pub use sequence::{ColorSpaceArg, ImageArgs, SequenceArgs};
pub use side::SideArgs;

/// Parses a stream kind.
pub fn parse_kind(text: &str) -> Result<StreamKind, String> {
    StreamKind::from_name(text).ok_or_else(|| format!("'{text}' is none of color, depth, material"))
}

/// Parses a face.
pub fn parse_face(text: &str) -> Result<Face, String> {
    Face::from_name(text).ok_or_else(|| format!("'{text}' is none of px, nx, py, ny, pz, nz, view"))
}

/// Parses `A-B` or `A`.
pub fn parse_frames(text: &str) -> Result<FrameRange, String> {
    text.parse::<FrameRange>().map_err(|error: Error| error.to_string())
}

/// Which frames of the input.
#[derive(Debug, Clone, Args)]
pub struct FrameArgs {
    /// Only these frames, such as 10-99 or 12
    #[arg(long, value_name = "A-B", value_parser = parse_frames)]
    pub frames: Option<FrameRange>,
}

/// Which streams of a container.
#[derive(Debug, Clone, Args)]
pub struct SelectionArgs {
    /// Only these probes
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    pub probe: Vec<String>,
    /// Only these faces
    #[arg(long, value_name = "FACE", value_delimiter = ',', value_parser = parse_face)]
    pub face: Vec<Face>,
    /// Only streams of these kinds: color, depth, material
    #[arg(long, value_name = "KIND", value_delimiter = ',', value_parser = parse_kind)]
    pub stream: Vec<StreamKind>,
}

impl SelectionArgs {
    /// The selection of these streams and of `frames`.
    pub fn with(&self, frames: Option<FrameRange>) -> Selection {
        Selection { probes: self.probe.clone(), faces: self.face.clone(), kinds: self.stream.clone(), frames }
    }
}

/// How hard searches try.
#[derive(Debug, Clone, Copy, Args)]
pub struct EffortArgs {
    /// How hard to search: for the farthest keyframe of colour, and for blocks of all kinds
    #[arg(long, value_enum, default_value_t = EffortArg::Normal)]
    pub effort: EffortArg,
}

impl EffortArgs {
    /// The effort.
    pub fn get(self) -> Effort {
        self.effort.into()
    }

    /// Puts the option where the encoder reads it; after those of depth and colour.
    pub fn apply(self, settings: &mut EncodeSettings) {
        settings.search.effort = self.get();
        settings.depth.effort = self.get();
    }
}

/// `--effort`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum EffortArg {
    /// Quick, at a small loss
    Fast,
    /// What an exhaustive search finds, or nearly so
    Normal,
    /// Everything is tried: the reference, slow
    Exhaustive,
}

impl From<EffortArg> for Effort {
    fn from(effort: EffortArg) -> Effort {
        match effort {
            EffortArg::Fast => Effort::Fast,
            EffortArg::Normal => Effort::Normal,
            EffortArg::Exhaustive => Effort::Exhaustive,
        }
    }
}

/// Where a container is written, how its chunks are stored, and how that is reported.
#[derive(Debug, Clone, Args)]
pub struct OutputArgs {
    /// The container to write, - for standard output
    #[arg(long = "output", short = 'o', value_name = "OUT.lfold")]
    pub path: PathBuf,
    /// Compress chunks with LZMA2 at a level of 0 (fast) to 9 (small), 6 where none is given
    #[arg(long, value_name = "LEVEL", num_args = 0..=1, require_equals = true, default_missing_value = "6",
        value_parser = clap::value_parser!(u32).range(0..=9))]
    pub lzma2: Option<u32>,
    /// Report as JSON
    #[arg(long)]
    pub json: bool,
    /// Memory.
    #[command(flatten)]
    pub memory: MemoryArgs,
}

/// How much memory a command may take.
#[derive(Debug, Clone, Copy, Args)]
pub struct MemoryArgs {
    /// The most that pictures, chunks and tables may take together, such as 512M, 2G or 1.5GiB; the result does not
    /// depend on it, and what cannot be done with it is refused [default: limits of its own]
    #[arg(long, value_name = "SIZE", value_parser = parse_memory)]
    pub memory: Option<Budget>,
}

impl MemoryArgs {
    /// The budget.
    pub fn get(self) -> Budget {
        self.memory.unwrap_or(Budget::UNLIMITED)
    }
}

/// Parses a size.
pub fn parse_memory(text: &str) -> Result<Budget, String> {
    text.parse::<Budget>().map_err(|error: Error| error.to_string())
}

/// Whether an encode goes on with one that was stopped.
#[derive(Debug, Clone, Copy, Args)]
pub struct ResumeArgs {
    /// Go on with an encode into this output that was stopped, behind its last complete chunk; the options must be the
    /// same. Where there is none, begin at the start
    #[arg(long)]
    pub resume: bool,
}

impl OutputArgs {
    /// Refuses a report that would run into the container on standard output.
    pub fn check(&self) -> Result<()> {
        if self.json && self.path == Path::new("-") {
            return Err(Error::Usage("--json and -o - would both write to standard output; name a file".into()));
        }
        Ok(())
    }
}

/// Whether a path names a dataset: a manifest, or a folder that holds one.
pub fn is_dataset(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension == "json")
        || path.join(crate::dataset::manifest::MANIFEST_NAME).is_file()
}
