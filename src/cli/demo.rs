//! `lightfold demo`: every step of the toolkit on a scene that is built in.

use std::path::{Path, PathBuf};
use std::time::Instant;

use serde_json::json;

use crate::cli::output::{self, OutputFile, OutputFolder, human_bytes};
use crate::cli::progress::Progress;
use crate::cli::{GlobalArgs, Outcome};
use crate::dataset::source::{Source, SourceOptions};
use crate::error::{Error, Result};
use crate::scene::{DemoKind, FootagePlan};
use crate::video::decode::Decoder;
use crate::video::encode::{self, EncodeSettings, EncodeSummary};
use crate::video::export::{self, DecodeSummary, Destination, FileFormat, Selection};

/// Arguments.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  lightfold demo\n  lightfold demo -o out/demo --frames 48 --size 256 --json\n\n\
    Captures a procedural courtyard into DIR/scene, encodes it to DIR/demo.lfold, decodes that into DIR/decoded, and\n\
    compares the two. The same options give the same bytes on every run.")]
pub struct Args {
    /// Folder to write into
    #[arg(long, short, value_name = "DIR", default_value = "lightfold-demo")]
    pub output: PathBuf,
    /// Number of frames, 24 a second; the scene repeats after 96
    #[arg(long, value_name = "N", default_value_t = 24, value_parser = clap::value_parser!(u32).range(1..=9999))]
    pub frames: u32,
    /// Width and height of each cube face in pixels
    #[arg(long, value_name = "PIXELS", default_value_t = 128, value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub size: u32,
    /// Number of probes
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = clap::value_parser!(u32).range(1..=64))]
    pub probes: u32,
    /// Report as JSON
    #[arg(long)]
    pub json: bool,
}

/// Where the demo's files are.
struct Places {
    scene: PathBuf,
    container: PathBuf,
    decoded: PathBuf,
}

impl Places {
    fn below(folder: &Path) -> Places {
        let at = |name| folder.join(name);
        Places { scene: at("scene"), container: at("demo.lfold"), decoded: at("decoded") }
    }

    /// What a user would type for each step after the capture.
    fn commands(&self) -> [String; 4] {
        let [scene, container, decoded] =
            [&self.scene, &self.container, &self.decoded].map(|path| shell_word(&path.display().to_string()));
        [
            format!("lightfold encode {scene} -o {container}"),
            format!("lightfold inspect {container}"),
            format!("lightfold decode {container} -o {decoded}"),
            format!("lightfold diff {scene} {container}"),
        ]
    }
}

/// Runs the demo.
pub fn run(args: &Args, global: &GlobalArgs) -> Result<Outcome> {
    let places = Places::below(&args.output);
    capture(args, &places.scene, global)?;
    let encoded = encode(&places, global)?;
    let decoder = Decoder::open(&places.container)?;
    let decoded = decode(&decoder, &places.decoded, global)?;
    let _ = (encoded, decoded);
    Ok(Outcome::Fine)
}

fn capture(args: &Args, path: &Path, global: &GlobalArgs) -> Result<()> {
    let plan =
        FootagePlan { kind: DemoKind::Courtyard, frames: args.frames, face_size: args.size, probes: args.probes };
    let progress = Progress::start(global, "capturing", plan.face_count())?;
    let folder = OutputFolder::create(path)?;
    plan.write(folder.work_path(), &progress)?;
    folder.commit()
}

fn encode(places: &Places, global: &GlobalArgs) -> Result<EncodeSummary> {
    let source = Source::open(&places.scene, &SourceOptions::default())?;
    let settings = EncodeSettings::default();
    let images = source.groups().iter().map(|group| group.frames.count()).sum();
    let progress = Progress::start(global, "encoding", images)?;
    let path = &places.container;
    let file = OutputFile::create(path)?;
    let (file, summary) = encode::encode(&source, &settings, file, &progress).map_err(|error| error.in_file(path))?;
    file.commit()?;
    Ok(summary)
}

/// What decoding did, and how long it took without writing files.
struct Decoded {
    summary: DecodeSummary,
    seconds: f64,
}

fn decode(decoder: &Decoder, path: &Path, global: &GlobalArgs) -> Result<Decoded> {
    let chosen = Selection::default().choose(decoder)?;
    let images: u64 = chosen.iter().map(|(_, frames)| frames.count()).sum();
    let progress = Progress::start(global, "decoding", 2 * images)?;
    let start = Instant::now();
    let summary = export::decode_to_nothing(decoder, &chosen, &progress)?;
    let seconds = start.elapsed().as_secs_f64();
    let folder = OutputFolder::create(path)?;
    let destination = Destination::Dataset(folder.work_path().to_path_buf());
    export::decode_to_files(decoder, &chosen, &destination, FileFormat::Exr, &progress)?;
    folder.commit()?;
    Ok(Decoded { summary, seconds })
}

/// A word as a POSIX shell takes it: in quotes where it holds more than plain characters.
fn shell_word(text: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "/._-+,:@%".contains(c);
    if !text.is_empty() && text.chars().all(plain) {
        text.to_owned()
    } else {
        format!("'{}'", text.replace('\'', r"'\''"))
    }
}
