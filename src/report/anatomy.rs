//! Pictures of what streams are made of, in the spirit of GDC's figure 1: (b) the nodes, boxes or blocks that a frame's
//! record writes, tinted by what they are written with; where in the image a stream of colour spends its keyframes; and (c)
//! how far the decoded image is from its source.
//!
//! Enters: an open container, some of its streams, and the footage that they were made of, where that is at hand. Leaves: a
//! PNG file for each picture, the same bytes whatever the number of threads. An image is enlarged or reduced by a whole
//! factor, so that a file is never much larger than 2048 pixels on a side.

mod errors;
mod frames;
mod keyframes;
pub(super) mod palette;
pub(super) mod raster;
pub(super) mod sheet;

use std::path::Path;

use crate::compare::{Pair, Pairing, Side, error_map};
use crate::dataset::stream::StreamKind;
use crate::decode::{Decoder, StreamInfo};
use crate::error::{Error, Result};
use crate::image::png;
use crate::inspect::{Survey, coding_map, survey, survey_steps};
use crate::monitor::Monitor;
use crate::ordered::try_map_ordered;

pub use sheet::Sheet;

/// More pictures than this are refused.
const MAX_PLOTS: usize = 4096;

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

/// A picture that was written.
#[derive(Debug, Clone, PartialEq)]
pub struct Plot<'a> {
    /// The file's name in the folder.
    pub file: String,
    pub stream: &'a StreamInfo,
    pub frame: u32,
    /// What it shows.
    pub what: What,
}

/// What is to be drawn.
#[derive(Clone, Copy)]
pub struct Request<'a> {
    /// The container.
    pub decoder: &'a Decoder,
    pub streams: &'a [&'a StreamInfo],
    /// The frame. None: of depth and material the first one, which shows whole pictures, and the one that changes most
    /// besides keyframes; of colour the one with most pixels between keyframes, or where none is, with most keyframes after
    /// the first ones.
    pub frame: Option<u32>,
    /// The container and its source, and which of their streams belong together, for pictures of errors.
    pub source: Option<(&'a [Side; 2], &'a Pairing<'a>)>,
}

/// A stream, and what is known when its pictures are drawn.
struct Subject<'a> {
    stream: &'a StreamInfo,
    /// The container's file name.
    file: String,
    /// Such as `depth 00/px`.
    name: String,
}

/// Steps that [`plot`] advances its monitor by.
pub fn steps(request: &Request<'_>) -> u64 {
    let chunks = |stream: &&StreamInfo| survey_steps(request.decoder, stream) + 1;
    request.streams.iter().map(chunks).sum()
}

/// Draws and writes all pictures into a folder that exists, streams in parallel.
///
/// # Errors
/// There would be too many pictures; a chunk is damaged; an image of the source cannot be read; a file cannot be written.
pub fn plot<'a>(request: &Request<'a>, folder: &Path, monitor: &dyn Monitor) -> Result<Vec<Plot<'a>>> {
    let each = if request.source.is_some() { 4 } else { 2 };
    if request.streams.len() * each > MAX_PLOTS {
        return Err(Error::Usage(format!(
            "pictures of {} streams may be more than {MAX_PLOTS}: choose some with `probe`, `face` or `stream`",
            request.streams.len()
        )));
    }
    let plots = try_map_ordered(request.streams.to_vec(), |stream| {
        let plots = plot_stream(request, stream, folder, monitor);
        monitor.advance(1);
        plots
    })?;
    Ok(plots.into_iter().flatten().collect())
}

fn plot_stream<'a>(
    request: &Request<'a>,
    stream: &'a StreamInfo,
    folder: &Path,
    monitor: &dyn Monitor,
) -> Result<Vec<Plot<'a>>> {
    let decoder = request.decoder;
    let probe = &decoder.probe(stream).name;
    let path = decoder.reader().path();
    let file = path.file_name().map_or_else(|| path.display().to_string(), |name| name.to_string_lossy().into_owned());
    let name = format!("{} {probe}/{}", stream.kind.name(), stream.face.name());
    let subject = Subject { stream, file, name };
    let surveyed = match (request.frame, stream.kind) {
        (Some(_), StreamKind::Depth | StreamKind::Material) => None,
        _ => Some(survey(decoder, stream, monitor)?),
    };
    let mut plots = Vec::new();
    for frame in frames_of(request.frame, stream, surveyed.as_ref()) {
        monitor.check()?;
        let anatomy = coding_map(decoder, stream, frame)?;
        let picture = decoder.face(stream).decode(frame)?;
        let (what, sheet) = match &surveyed {
            Some(survey) if stream.kind == StreamKind::Color => {
                (What::Keyframes, keyframes::sheet(&subject, &anatomy, &picture, survey)?)
            }
            _ => frames::sheet(&subject, &anatomy, &picture),
        };
        let mut save = |what: What, sheet: Sheet| {
            let file = format!("{}_{probe}_{}_{frame:04}_{}.png", stream.kind.name(), stream.face.name(), what.name());
            png::write_color8(&folder.join(&file), &sheet.draw()?)?;
            plots.push(Plot { file, stream, frame, what });
            Ok(())
        };
        save(what, sheet)?;
        if let Some((sides, pairing)) = request.source
            && let Some(pair) = pair_of(pairing, stream, probe).filter(|pair| pair.frames().contains(frame))
        {
            let map = error_map(sides, pair, frame)?;
            save(What::Error, errors::sheet(&subject, &map, &sides[1].path, frame)?)?;
        }
    }
    Ok(plots)
}

/// The pair that a stream of the container is the first of.
fn pair_of<'a>(pairing: &'a Pairing<'_>, stream: &StreamInfo, probe: &str) -> Option<&'a Pair<'a>> {
    let is_it = |pair: &&Pair<'_>| {
        let id = &pair.streams()[0].id;
        (id.kind, id.probe.as_str(), id.face) == (stream.kind, probe, stream.face)
    };
    pairing.pairs().iter().find(is_it)
}

/// The frames of a stream that are drawn, ascending.
fn frames_of(asked: Option<u32>, stream: &StreamInfo, survey: Option<&Survey>) -> Vec<u32> {
    let busiest = survey.and_then(|survey| survey.busiest);
    match (asked, stream.kind) {
        (Some(frame), _) => vec![frame],
        (None, StreamKind::Color) => vec![busiest.unwrap_or(stream.frames.first)],
        (None, _) => [stream.frames.first].into_iter().chain(busiest).collect(),
    }
}

impl Subject<'_> {
    fn size(&self) -> [u32; 2] {
        [self.stream.entry.width, self.stream.entry.height]
    }

    /// The line that all sheets have: file, codec, size.
    fn fact(&self, scale: raster::Scale) -> String {
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
    fn unit_word(&self) -> &'static str {
        if self.stream.kind == StreamKind::Color { "cell" } else { "tile" }
    }
}

/// A count with its word.
pub(crate) fn counted(count: u64, what: &str) -> String {
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

fn percent(part: u64, whole: u64) -> String {
    format!("{:.2}%", 100.0 * part as f64 / whole.max(1) as f64)
}
