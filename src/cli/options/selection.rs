//! Selection of streams and frames.

use clap::Args;

use super::value::{Choices, one_of};
use codec::decode::Selection;
use codec::image::StreamKind;
use codec::image::cube::Face;
use codec::image::sequence::FrameRange;
use footage::dataset::Missing;

pub fn parse_kind(text: &str) -> Result<StreamKind, String> {
    StreamKind::from_name(text).ok_or_else(|| format!("'{text}': color, depth, material or alpha was expected"))
}

pub fn parse_face(text: &str) -> Result<Face, String> {
    Face::from_name(text).ok_or_else(|| format!("'{text}': px, nx, py, ny, pz, nz or view was expected"))
}

#[derive(Debug, Clone, Args)]
pub struct FrameArgs {
    /// Only these frames, such as 10-99 or 12
    #[arg(long, value_name = "A-B")]
    pub frames: Option<FrameRange>,
}

const MISSING: &Choices<Missing> = &[
    ("error", Missing::Error, "Fail, and report the file"),
    ("hold", Missing::Hold, "Repeat the last existing frame"),
    ("skip", Missing::Skip, "Skip them at the start and end of a stream; fail elsewhere"),
    ("black", Missing::Black, "Encode black colour and background depth"),
];

#[derive(Debug, Clone, Copy, Args)]
pub struct MissingArgs {
    /// Handling of frames whose file is missing; the container records them [default: from the manifest, else error]
    #[arg(long, value_name = "WHAT", value_parser = one_of(MISSING))]
    pub missing: Option<Missing>,
}

#[derive(Debug, Clone, Args)]
pub struct SelectionArgs {
    /// Only these probes
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    pub probe: Vec<String>,
    /// Only these faces
    #[arg(long, value_name = "FACE", value_delimiter = ',', value_parser = parse_face)]
    pub face: Vec<Face>,
    /// Only streams of these kinds: color, depth, material, alpha
    #[arg(long, value_name = "KIND", value_delimiter = ',', value_parser = parse_kind)]
    pub stream: Vec<StreamKind>,
}

impl SelectionArgs {
    pub fn with(&self, frames: Option<FrameRange>) -> Selection {
        Selection { probes: self.probe.clone(), faces: self.face.clone(), kinds: self.stream.clone(), frames }
    }
}
