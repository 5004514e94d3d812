//! Selection of streams, frames and units.

use crate::decode::decoder::Decoder;
use crate::decode::face::{AllUnits, UnitFilter};
use crate::error::{Error, Result};
use crate::image::Face;
use crate::image::sequence::FrameRange;
use crate::memory::Budget;
use crate::streams::{StreamInfo, StreamKind};

/// Selection of streams and frames. An empty list or `None` selects all.
#[derive(Debug, Clone, Default)]
pub struct Selection {
    pub probes: Vec<String>,
    pub faces: Vec<Face>,
    pub kinds: Vec<StreamKind>,
    pub frames: Option<FrameRange>,
}

#[derive(Debug, Clone, Copy)]
pub struct StreamFrames<'a> {
    pub stream: &'a StreamInfo,
    pub frames: FrameRange,
}

impl Selection {
    pub fn choose<'a>(&self, decoder: &'a Decoder) -> Result<Vec<StreamFrames<'a>>> {
        let name = |stream: &StreamInfo| decoder.probe(stream).name.as_str();
        let has = |test: &dyn Fn(&StreamInfo) -> bool| decoder.streams().iter().any(test);
        let missing =
            |what: String| Err(Error::Usage(format!("{}: there is no {what}", decoder.reader().path().display())));
        if let Some(probe) = self.probes.iter().find(|probe| !has(&|stream| name(stream) == probe.as_str())) {
            return missing(format!("probe '{probe}'"));
        }
        if let Some(face) = self.faces.iter().find(|face| !has(&|stream| stream.face == **face)) {
            return missing(format!("face {}", face.name()));
        }
        if let Some(kind) = self.kinds.iter().find(|kind| !has(&|stream| stream.kind == **kind)) {
            return missing(format!("{} stream", kind.name()));
        }
        if let Some(asked) = self.frames {
            let first = decoder.streams().iter().map(|stream| stream.frames.first).min().unwrap_or(0);
            let last = decoder.streams().iter().map(|stream| stream.frames.last).max().unwrap_or(0);
            if asked.first < first || asked.last > last {
                return missing(format!(
                    "frame {}: its frames are {first}-{last}",
                    if asked.first < first { asked.first } else { asked.last }
                ));
            }
        }
        let wanted = |stream: &&StreamInfo| {
            (self.probes.is_empty() || self.probes.iter().any(|probe| probe == name(stream)))
                && (self.faces.is_empty() || self.faces.contains(&stream.face))
                && (self.kinds.is_empty() || self.kinds.contains(&stream.kind))
        };
        let frames = |stream: &'a StreamInfo| {
            let frames = self.frames.map_or(Some(stream.frames), |frames| stream.frames.intersect(frames));
            frames.map(|frames| StreamFrames { stream, frames })
        };
        let chosen: Vec<_> = decoder.streams().iter().filter(wanted).filter_map(frames).collect();
        if chosen.is_empty() {
            return missing("stream that matches the options".to_owned());
        }
        Ok(chosen)
    }
}

#[derive(Clone, Copy)]
pub struct Request<'a> {
    pub streams: &'a [StreamFrames<'a>],
    pub filter: &'a dyn UnitFilter,
    /// Memory budget of the CPU decoders.
    pub memory: Budget,
}

impl<'a> Request<'a> {
    pub fn all(streams: &'a [StreamFrames<'a>]) -> Request<'a> {
        Request { streams, filter: &AllUnits, memory: Budget::UNLIMITED }
    }
}
