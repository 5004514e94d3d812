//! Where a container is written, how, and with how much memory.

use std::path::{Path, PathBuf};

use clap::Args;

use crate::encode::EncodeSettings;
use crate::error::{Error, Result};
use crate::memory::Budget;

/// Where a container is written, and how.
#[derive(Debug, Clone, Args)]
pub struct OutputArgs {
    /// The container to write, - for standard output
    #[arg(long = "output", short = 'o', value_name = "OUT.lfold")]
    pub path: PathBuf,
    /// Chunks.
    #[command(flatten)]
    pub store: StoreArgs,
}

/// How chunks are stored and the command reports.
#[derive(Debug, Clone, Args)]
pub struct StoreArgs {
    /// Compress chunks with LZMA2, level 0 (fast) to 9 (small) [default level: 6]
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

/// Memory limit.
#[derive(Debug, Clone, Copy, Args)]
pub struct MemoryArgs {
    /// Memory limit for images, chunks and tables, such as 512M, 2G or 1.5GiB. The result does not depend on it; work
    /// that needs more is refused [default: built-in limits]
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
pub fn parse_memory(text: &str) -> std::result::Result<Budget, String> {
    text.parse::<Budget>().map_err(|error: Error| error.to_string())
}

/// Whether to resume.
#[derive(Debug, Clone, Copy, Args)]
pub struct ResumeArgs {
    /// Resume a stopped encode of this output behind its last complete chunk, with the same options; start anew if there is
    /// none
    #[arg(long)]
    pub resume: bool,
}

impl StoreArgs {
    /// Puts the options where the encoder reads them.
    pub fn apply(&self, settings: &mut EncodeSettings) {
        settings.lzma2 = self.lzma2;
        settings.memory = self.memory.get();
    }
}

impl OutputArgs {
    /// The output of an encode that may be resumed.
    pub fn target(&self, resume: ResumeArgs) -> Target<'_> {
        let unfinished = if resume.resume { Unfinished::Resume } else { Unfinished::Keep };
        Target { path: &self.path, unfinished, json: self.store.json }
    }

    /// Refuses a report and a container on standard output.
    pub fn check(&self) -> Result<()> {
        if self.store.json && self.path == Path::new("-") {
            return Err(both_to_stdout());
        }
        Ok(())
    }
}

/// The error of `--json` together with `-o -`.
pub fn both_to_stdout() -> Error {
    Error::Usage("--json and -o - would both write to standard output; name a file".into())
}

/// What happens to an encode that stops early.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unfinished {
    /// Its chunks are discarded.
    Discard,
    /// Complete chunks are kept. The encode starts anew.
    Keep,
    /// Complete chunks are kept. The encode resumes behind those of an earlier one.
    Resume,
}

/// Where an encode goes, and how it is reported.
#[derive(Debug, Clone, Copy)]
pub struct Target<'a> {
    /// The container, - for standard output.
    pub path: &'a Path,
    /// What happens if it stops early.
    pub unfinished: Unfinished,
    /// Whether the report is JSON.
    pub json: bool,
}
