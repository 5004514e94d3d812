//! Arguments of `inspect`.

use std::path::PathBuf;

use crate::options::{AccountArgs, MemoryArgs, SelectionArgs, SideArgs};
use crate::refuse;
use codec::decode::{Decoder, StreamInfo};
use codec::error::Result;
use codec::image::sequence::FrameRange;
use footage::inspect::Inspection;

#[derive(Debug, clap::Args)]
#[command(
    group = clap::ArgGroup::new("looks").args(["plot", "check"]),
    after_help = "Raw: size as 32-bit depth and 24-bit colour. Temporal: size after temporal coding, before \
        compression of chunks.\n\
    Keys: number of keyframes of all cells or tiles. AABBs: number of boxes of all frames. Upd. %: pixels written \
    when all frames are decoded in order.\nUnits: tiles of depth and material, cells of colour. In cells: chunks of \
    the transform codec coded as keyframes because that is smaller. Palettes: blocks coded as palettes, of any \
    size.\nStatic: cells or tiles that never change. Empty: tiles of one value in every frame.\n\n\
    For a scene (glTF, GLB, OBJ, or built in): bounds in metres, triangles, materials and lights at time 0, and animations.\n\n\
    For a Seurat manifest: view groups, views, image sizes, depth types, and the box around the cameras in metres.\n\n\
    --check reads one frame of up to 16 probes. It checks face order and orientation, planar depth or distance, \
    scale, positions, orientations, near, far, background and colour, and reports fine, SUSPECT or cannot tell for \
    each. The exit code is 1 if any check is suspect.\n\n\
    Examples:\n  lightfold inspect film.lfold\n  lightfold inspect film.lfold --stream depth --streams\n  \
    lightfold inspect film.lfold --per-frame --frames 10-19 --csv > frames.csv\n  \
    lightfold inspect film.lfold --verify --json\n  \
    lightfold inspect film.lfold --plot pictures --source lightfield.json --probe 00\n  \
    lightfold inspect scene.glb\n  lightfold inspect manifest.json --json\n  lightfold inspect lightfield.json --check\n  lightfold inspect lightfield.json --check --depth-kind planar --json"
)]
pub struct Args {
    /// Container, - for standard input; scene, as for capture; Seurat manifest; with --check a lightfield.json or its
    /// folder
    #[arg(value_name = "IN")]
    pub input: PathBuf,
    #[command(flatten)]
    pub selection: SelectionArgs,
    /// Print one row per stream [default: if there are many, one per probe and kind]
    #[arg(long)]
    pub streams: bool,
    /// Print one row per frame of every stream; the bytes of a chunk are counted at its first frame
    #[arg(long)]
    pub per_frame: bool,
    /// With --per-frame, only rows of these frames, such as 10-99 or 12
    #[arg(long, value_name = "A-B")]
    pub frames: Option<FrameRange>,
    /// Verify all chunks (CRC-32, decompression by two decoders, structure), and list damaged ones
    #[arg(long)]
    pub verify: bool,
    /// Check a manifest against its files, and report suspected errors
    #[arg(long, conflicts_with_all = ["streams", "per_frame", "frames", "verify", "csv", "source"])]
    pub check: bool,
    /// Report as JSON
    #[arg(long, conflicts_with = "csv")]
    pub json: bool,
    #[command(flatten)]
    pub account: AccountArgs,
    /// Report as CSV: one row per stream, or with --per-frame per frame
    #[arg(long)]
    pub csv: bool,
    /// Write coding maps of each stream into this folder as PNG
    #[arg(long, value_name = "DIR")]
    pub plot: Option<PathBuf>,
    #[command(flatten)]
    pub memory: MemoryArgs,
    /// Frame for --plot [default: the frame with most changes, for depth and material also the first] or --check
    /// [default: the first]
    #[arg(long, value_name = "N", requires = "looks")]
    pub frame: Option<u32>,
    /// Source footage of the container, for error maps of --plot: a lightfield.json or its folder, or an image sequence
    #[arg(long, value_name = "SOURCE", requires = "plot")]
    pub source: Option<String>,
    #[command(flatten)]
    pub reading: SideArgs,
}

impl Args {
    /// Fails if options other than --json are given. `what` names the input and its kind, which is reported only as a
    /// table or as JSON.
    pub fn refuse_all_but_json(&self, what: &str) -> Result<()> {
        let selection = &self.selection;
        let is_selective = !selection.probe.is_empty() || !selection.face.is_empty() || !selection.stream.is_empty();
        let is_per_frame = self.per_frame || self.frames.is_some();
        if is_selective || is_per_frame || self.streams || self.verify || self.csv || self.plot.is_some() {
            return refuse(format!("{what} is reported as a table or with --json only: leave out the other options"));
        }
        Ok(())
    }
}

pub struct Report<'a> {
    pub args: &'a Args,
    pub decoder: &'a Decoder,
    pub inspection: &'a Inspection<'a>,
}

impl Report<'_> {
    pub fn probe_name(&self, stream: &StreamInfo) -> &str {
        &self.decoder.probe(stream).name
    }
}
