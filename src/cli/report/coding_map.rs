//! Pictures of how streams are coded (GDC figure 1): (b) the nodes, boxes or blocks of a frame, tinted by coding mode;
//! the number of keyframes or bytes of each colour cell; and (c) the error of the decoded image. Each picture is a PNG
//! file of at most about 2048 pixels on a side. Its bytes do not depend on the number of threads.

mod errors;
mod frames;
mod keyframes;
mod subject;
mod tints;

use std::path::Path;

use codec::decode::{Decoder, StreamInfo};
use codec::error::{Error, Result};
use codec::image::StreamKind;
use codec::monitor::Monitor;
use codec::ordered::try_map_ordered;
use footage::compare::{Pair, Pairing, Side, error_map};
use footage::image_files::png;
use footage::inspect::{self, Survey, coding_map, survey};

use crate::report::picture::sheet::Sheet;
use subject::Subject;
pub use subject::What;

const MAX_PLOTS: usize = 4096;

#[derive(Debug, Clone, PartialEq)]
pub struct Plot<'a> {
    pub file: String,
    pub stream: &'a StreamInfo,
    pub frame: u32,
    pub what: What,
}

#[derive(Clone, Copy)]
pub struct Request<'a> {
    pub decoder: &'a Decoder,
    pub streams: &'a [&'a StreamInfo],
    /// Frame to draw. `None` selects frames by content. Depth and material: the first frame, which is coded as a whole
    /// picture, and the frame that changes the most pixels outside keyframes. Colour: the frame with the most pixels
    /// coded between keyframes or, if there is none, the frame with the most keyframe pixels after the first frames of
    /// chunks.
    pub frame: Option<u32>,
    /// The container, its source and the pairing of their streams. Needed for error pictures.
    pub source: Option<(&'a [Side; 2], &'a Pairing<'a>)>,
}

pub fn steps(request: &Request<'_>) -> u64 {
    request.streams.iter().map(|stream| inspect::steps(request.decoder, &[stream]) + 1).sum()
}

/// Draws all pictures and writes them into an existing folder. Streams are processed in parallel.
pub fn plot<'a>(request: &Request<'a>, folder: &Path, monitor: &dyn Monitor) -> Result<Vec<Plot<'a>>> {
    let each = if request.source.is_some() { 4 } else { 2 };
    if request.streams.len() * each > MAX_PLOTS {
        return Err(Error::Usage(format!(
            "{} streams may need more than {MAX_PLOTS} pictures: select fewer with `probe`, `face` or `stream`",
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
        (Some(_), StreamKind::Depth | StreamKind::Material | StreamKind::Alpha) => None,
        _ => Some(survey(decoder, stream, monitor)?),
    };
    let mut plots = Vec::new();
    for frame in frames_of(request.frame, stream, surveyed.as_ref()) {
        monitor.check()?;
        let map = coding_map(decoder, stream, frame)?;
        let picture = decoder.face(stream).decode(frame)?;
        let (what, sheet) = match &surveyed {
            Some(survey) if stream.kind == StreamKind::Color => keyframes::sheet(&subject, &map, &picture, survey)?,
            _ => frames::sheet(&subject, &map, &picture),
        };
        let mut save = |what: What, sheet: Sheet| {
            let file = format!("{}_{probe}_{}_{frame:04}_{}.png", stream.kind.name(), stream.face.name(), what.name());
            png::write_color8(&folder.join(&file), &sheet.draw()?)?;
            plots.push(Plot { file, stream, frame, what });
            Ok(())
        };
        save(what, sheet)?;
        if let Some((sides, pairing)) = request.source
            && let Some(pair) = pair_of(pairing, stream, probe).filter(|pair| pair.frames.contains(frame))
        {
            let map = error_map(sides, pair, frame)?;
            save(What::Error, errors::sheet(&subject, &map, &sides[1].path, frame)?)?;
        }
    }
    Ok(plots)
}

fn pair_of<'a>(pairing: &'a Pairing<'_>, stream: &StreamInfo, probe: &str) -> Option<&'a Pair<'a>> {
    let is_it = |pair: &&Pair<'_>| {
        let id = &pair.streams[0].id;
        (id.kind, id.probe.as_str(), id.face) == (stream.kind, probe, stream.face)
    };
    pairing.pairs.iter().find(is_it)
}

fn frames_of(asked: Option<u32>, stream: &StreamInfo, survey: Option<&Survey>) -> Vec<u32> {
    let busiest = survey.and_then(|survey| survey.busiest);
    match (asked, stream.kind) {
        (Some(frame), _) => vec![frame],
        (None, StreamKind::Color) => vec![busiest.unwrap_or(stream.frames.first)],
        (None, _) => [stream.frames.first].into_iter().chain(busiest).collect(),
    }
}
