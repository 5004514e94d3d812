//! `inspect --plot`: writes coding maps and error maps of streams.

use std::fmt::Write;
use std::path::Path;

use serde::Serialize;

use super::args::{Args, Report};
use crate::progress::Progress;
use crate::report::coding_map::{self, Request, What};
use crate::{GlobalArgs, refuse};
use codec::decode::StreamInfo;
use codec::error::Result;
use codec::image::sequence::FrameRange;
use footage::compare::{self, Coverage, Pairing};
use footage::files::OutputFolder;

/// Maximum number of images that are listed; more are only counted.
const MAX_LINES: usize = 24;

#[derive(Debug, Serialize)]
pub struct PlotOut<'a> {
    path: String,
    stream: String,
    kind: &'static str,
    probe: &'a str,
    face: &'static str,
    frame: u32,
    what: &'static str,
}

pub fn check(args: &Args) -> Result<()> {
    if args.source.is_none() && !args.reading.is_usual() {
        return refuse("options for reading files need --source");
    }
    if args.source.is_some() && args.input == Path::new("-") {
        return refuse("--source reads the container twice: use a file instead of standard input");
    }
    Ok(())
}

pub fn write<'a>(folder: &Path, report: &Report<'a>, global: &GlobalArgs) -> Result<Vec<PlotOut<'a>>> {
    let (args, decoder) = (report.args, report.decoder);
    let selection = args.selection.with(args.frame.map(|frame| FrameRange { first: frame, last: frame }));
    let streams: Vec<&StreamInfo> = selection.choose(decoder)?.into_iter().map(|part| part.stream).collect();
    let input = args.input.to_string_lossy();
    let options = args.reading.options(args.selection.with(None))?;
    let open = |source: &String| compare::open_both([&input, source], &options);
    let sides = args.source.as_ref().map(open).transpose()?;
    let pairing = sides.as_ref().map(|sides| Pairing::new(sides, Coverage::Common)).transpose()?;
    let source = sides.as_ref().zip(pairing.as_ref());
    let request = Request { decoder, streams: &streams, frame: args.frame, source };
    let out = OutputFolder::create(folder)?;
    let progress = Progress::start(global, "drawing", coding_map::steps(&request))?;
    let plots = coding_map::plot(&request, out.work_path(), &progress).map_err(|error| out.present(error))?;
    drop(progress);
    let plots = plots.into_iter().map(|plot| PlotOut {
        path: folder.join(&plot.file).display().to_string(),
        stream: format!("{} {}/{}", plot.stream.kind.name(), report.probe_name(plot.stream), plot.stream.face.name()),
        kind: plot.stream.kind.name(),
        probe: &decoder.probe(plot.stream).name,
        face: plot.stream.face.name(),
        frame: plot.frame,
        what: plot.what.name(),
    });
    let plots = plots.collect();
    out.commit()?;
    Ok(plots)
}

pub fn text(args: &Args, folder: &Path, plots: &[PlotOut<'_>]) -> String {
    let mut out = match plots.len() {
        0..=MAX_LINES => {
            let paths: String = plots.iter().map(|plot| format!("{}\n", plot.path)).collect();
            format!("Pictures\n{paths}")
        }
        many => format!("{many} pictures in {}\n", folder.display()),
    };
    let errors = plots.iter().filter(|plot| plot.what == What::Error.name()).count();
    match &args.source {
        None => out.push_str("Error maps need --source, the encoded footage.\n"),
        Some(source) if 2 * errors < plots.len() => {
            let _ =
                writeln!(out, "{} have no error map: {source} lacks their stream or frame.", plots.len() - 2 * errors);
        }
        Some(_) => {}
    }
    out
}
