//! What pictures of a stream say of it.

use crate::decode::StreamInfo;
use crate::image::StreamKind;
use crate::report::picture::raster::Scale;

/// What a picture shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum What {
    /// Nodes of a quadtree, or BC4w blocks.
    Nodes,
    /// Boxes around what changes.
    Boxes,
    /// Cells of colour: what a frame shows, and how many keyframes each has.
    Keyframes,
    /// Distance from the source.
    Error,
}

impl What {
    /// The word for it in names of files and in reports.
    pub fn name(self) -> &'static str {
        match self {
            What::Nodes => "nodes",
            What::Boxes => "boxes",
            What::Keyframes => "keyframes",
            What::Error => "error",
        }
    }
}

/// A stream, and what is known when its pictures are drawn.
pub struct Subject<'a> {
    pub stream: &'a StreamInfo,
    /// The container's file name.
    pub file: String,
    /// Such as `depth 00/px`.
    pub name: String,
}

impl Subject<'_> {
    pub fn size(&self) -> [u32; 2] {
        [self.stream.entry.width, self.stream.entry.height]
    }

    /// The line that all sheets have: file, codec, size.
    pub fn fact(&self, scale: Scale) -> String {
        let ([width, height], frames) = (self.size(), self.stream.frames);
        format!(
            "{}: frames {}-{}, codec {}, {width}x{height} pixels, {}.",
            self.file,
            frames.first,
            frames.last,
            self.stream.header.codec_name(),
            scale.words()
        )
    }

    /// How many units there are of one, `tile` or `cell`.
    pub fn unit_word(&self) -> &'static str {
        if self.stream.kind == StreamKind::Color { "cell" } else { "tile" }
    }
}

pub fn counted(count: u64, what: &str) -> String {
    format!(
        "{count} {what}{}",
        if count == 1 {
            ""
        } else if what.ends_with('x') {
            "es"
        } else {
            "s"
        }
    )
}

pub fn percent(part: u64, whole: u64) -> String {
    format!("{:.2}%", 100.0 * part as f64 / whole.max(1) as f64)
}
