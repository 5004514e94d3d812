//! Output options: path, compression and memory of a container, and picture streams on standard output.

use std::io::{IsTerminal, Stdout};
use std::path::{Path, PathBuf};

use clap::Args;

use super::value::{Choices, one_of};
use crate::refuse;
use codec::container::Compression;
use codec::error::Result;
use codec::memory::Budget;
use footage::encode::EncodeSettings;
use footage::files::{DiskFile, standard_output};
use footage::image_files::picture_stream::{FrameRate, PictureStream, StreamFormat};

#[derive(Debug, Clone, Args)]
pub struct OutputArgs {
    /// Output container, - for standard output
    #[arg(long = "output", short = 'o', value_name = "OUT.lfold", value_parser = parse_container_path)]
    pub path: PathBuf,
    #[command(flatten)]
    pub store: StoreArgs,
}

#[derive(Debug, Clone, Args)]
pub struct StoreArgs {
    /// Compress chunks with LZMA2, level 0 (fast) to 9 (small); colour of the transform codec is already entropy-coded
    /// and hardly shrinks [default level: 6]
    #[arg(long, value_name = "LEVEL", num_args = 0..=1, require_equals = true, default_missing_value = "6",
        value_parser = clap::value_parser!(u32).range(0..=9))]
    pub lzma2: Option<u32>,
    /// Compress chunks with Zstandard, level 1 (fast) to 19 (small); default of encoders [default level: 9]
    #[arg(long, value_name = "LEVEL", num_args = 0..=1, require_equals = true, default_missing_value = "9",
        value_parser = clap::value_parser!(u32).range(1..=19), conflicts_with = "lzma2")]
    pub zstd: Option<u32>,
    /// Do not compress chunks
    #[arg(long, conflicts_with_all = ["lzma2", "zstd"])]
    pub no_compression: bool,
    /// Report as JSON
    #[arg(long)]
    pub json: bool,
    #[command(flatten)]
    pub memory: MemoryArgs,
}

#[derive(Debug, Clone, Copy, Args)]
pub struct MemoryArgs {
    /// Memory limit of the process, such as 512M, 2G or 1.5GiB. It does not change the result; commands that need more
    /// fail [default: built-in limits]
    #[arg(long, value_name = "SIZE")]
    pub memory: Option<Budget>,
}

impl MemoryArgs {
    /// Memory budget for images, chunks and tables.
    pub fn get(self) -> Budget {
        self.whole().of_process(rayon::current_num_threads())
    }

    /// Memory budget of the whole process.
    pub fn whole(self) -> Budget {
        self.memory.unwrap_or(Budget::UNLIMITED)
    }
}

#[derive(Debug, Clone, Args)]
pub struct EncodeOutputArgs {
    #[command(flatten)]
    pub container: OutputArgs,
    /// Resume an interrupted encode of this output after its last complete chunk with the same options; start over if
    /// there is none
    #[arg(long)]
    pub resume: bool,
}

impl StoreArgs {
    /// Returns the compression that the options select, if any.
    pub fn compression(&self) -> Option<Compression> {
        let of_level = self.lzma2.map(Compression::Lzma2).or(self.zstd.map(Compression::Zstd));
        of_level.or(self.no_compression.then_some(Compression::None))
    }

    pub fn apply(&self, settings: &mut EncodeSettings) {
        settings.compression = self.compression().unwrap_or_default();
        settings.memory = self.memory.get();
    }
}

impl EncodeOutputArgs {
    pub fn target(&self) -> Target<'_> {
        let unfinished = if self.resume { Unfinished::Resume } else { Unfinished::Keep };
        Target { path: &self.container.path, unfinished, json: self.container.store.json }
    }
}

/// Parses the path of a container. Rejects extensions of images, which are probably a mistake.
fn parse_container_path(text: &str) -> std::result::Result<PathBuf, String> {
    const IMAGES: [&str; 4] = ["exr", "png", "jpg", "jpeg"];
    let path = PathBuf::from(text);
    let ending = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    match IMAGES.contains(&ending.as_str()) {
        true => Err("the output is a container, not an image: use a file name ending in .lfold".to_owned()),
        false => Ok(path),
    }
}

/// Fails if binary output would go to a terminal, or to standard output together with a report.
pub fn check_stdout(path: &Path, has_report: bool) -> Result<()> {
    check_report(path, has_report)?;
    match is_terminal(path) {
        true if path == Path::new("-") => refuse("standard output is a terminal: specify a file, or redirect it"),
        true => refuse(format!("{}: this is a terminal; a file was expected", path.display())),
        false => Ok(()),
    }
}

/// True if an output is a terminal, under any of its names: `-`, `/dev/stdout`, `/dev/tty`.
fn is_terminal(path: &Path) -> bool {
    if path == Path::new("-") {
        return std::io::stdout().is_terminal();
    }
    let is_device = std::fs::metadata(path).is_ok_and(|meta| !meta.is_file() && !meta.is_dir() && !is_pipe(&meta));
    is_device && DiskFile::device(path).is_ok_and(|file| file.is_terminal())
}

/// True for a FIFO: opening it would wait for a reader.
fn is_pipe(meta: &std::fs::Metadata) -> bool {
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt;
        meta.file_type().is_fifo()
    }
    #[cfg(not(unix))]
    {
        let _ = meta;
        false
    }
}

/// Fails if both a report and a result would go to standard output.
pub fn check_report(path: &Path, has_report: bool) -> Result<()> {
    match has_report && path == Path::new("-") {
        true => refuse("--json and -o - would both write to standard output: specify an output file"),
        false => Ok(()),
    }
}

/// Handling of an encode that stops early.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unfinished {
    Discard,
    /// Keeps complete chunks. The encode starts anew.
    Keep,
    /// Keeps complete chunks. The encode continues after those of an earlier one.
    Resume,
}

#[derive(Debug, Clone, Copy)]
pub struct Target<'a> {
    /// Path of the container, - for standard output.
    pub path: &'a Path,
    pub unfinished: Unfinished,
    pub json: bool,
}

const STREAM_FORMATS: &Choices<StreamFormat> = &[
    ("png", StreamFormat::Png, "Concatenated PNG files"),
    ("y4m", StreamFormat::Y4m, "YUV4MPEG2, 4:4:4, 8 bits, BT.709 limited range; colour only"),
    ("raw", StreamFormat::Raw, "A line of text, then codes"),
];

#[derive(Debug, Clone, Copy, Args)]
pub struct StreamArgs {
    /// Format of pictures on standard output (-o -). y4m stores the frame rate of the container. png does not: ffmpeg
    /// assumes 25 unless -framerate is given. raw starts with a line of text such as "width=640 height=480
    /// pixel_format=rgb24 fps=24/1", followed by codes row by row: 8-bit red, green and blue, or 16-bit depth
    /// (gray16le). y4m and raw have no alpha; colour is composited over black [default: png]
    #[arg(long, value_name = "FORMAT", value_parser = one_of(STREAM_FORMATS))]
    pub stream_format: Option<StreamFormat>,
}

impl StreamArgs {
    /// Opens the stream on standard output. `None` if the output is something else.
    pub fn open(self, output: Option<&Path>, has_report: bool, fps: f64) -> Result<Option<PictureStream<Stdout>>> {
        if output != Some(Path::new("-")) {
            return match self.stream_format {
                Some(_) => refuse("--stream-format applies to standard output: add -o -"),
                None => Ok(None),
            };
        }
        check_stdout(Path::new("-"), has_report)?;
        let format = self.stream_format.unwrap_or(StreamFormat::Png);
        Ok(Some(PictureStream::new(standard_output()?, format, FrameRate::of(fps))))
    }
}
