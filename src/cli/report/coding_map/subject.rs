//! The stream that a picture shows, and the texts about it that all pictures share.

use crate::report::picture::raster::Scale;
use codec::decode::StreamInfo;
use codec::image::StreamKind;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum What {
    /// Quadtree nodes.
    Nodes,
    /// Blocks of predictive coding or BC4w.
    Blocks,
    /// Bounding boxes of changed pixels.
    Boxes,
    Keyframes,
    /// Bytes of each cell.
    Bytes,
    Error,
}

impl What {
    pub fn name(self) -> &'static str {
        match self {
            What::Nodes => "nodes",
            What::Blocks => "blocks",
            What::Boxes => "boxes",
            What::Keyframes => "keyframes",
            What::Bytes => "bytes",
            What::Error => "error",
        }
    }
}

pub struct Subject<'a> {
    pub stream: &'a StreamInfo,
    pub file: String,
    pub name: String,
}

impl Subject<'_> {
    pub fn size(&self) -> [u32; 2] {
        [self.stream.entry.width, self.stream.entry.height]
    }

    pub fn pixels(&self) -> u64 {
        self.size().map(u64::from).iter().product()
    }

    /// Line shared by all sheets: file, frame range, codec, image size and drawing scale.
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

    pub fn unit_word(&self) -> &'static str {
        if self.stream.kind == StreamKind::Color { "cell" } else { "tile" }
    }
}

pub fn percent(part: u64, whole: u64) -> String {
    format!("{:.2}%", 100.0 * part as f64 / whole.max(1) as f64)
}
