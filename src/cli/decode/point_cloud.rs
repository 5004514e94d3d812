//! `decode -o NAME.ply`: decodes frames to point clouds.

use std::io::{BufWriter, Write};
use std::path::Path;
use std::time::Instant;

use serde::Serialize;

use super::args::Args;
use crate::options::check_report;
use crate::output::{self, human_bytes};
use crate::progress::Progress;
use crate::{ExitStatus, GlobalArgs, refuse};
use codec::decode::Decoder;
use codec::error::{Error, Result, counted};
use codec::image::FrameRange;
use codec::image::sequence::Pattern;
use codec::memory::Need;
use evaluate::point_cloud::{POINT_BYTES, write_ply};
use evaluate::reference::Reference;
use footage::files::{DiskFile, OutputFolder, parent_of};

#[derive(Serialize)]
struct Report {
    frames: u64,
    points: u64,
    bytes_out: u64,
    seconds: f64,
}

/// True if the extension of an output is that of a point cloud.
pub fn is_named(output: &Path) -> bool {
    output.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("ply"))
}

pub fn run(args: &Args, input: &Path, output: &Path, global: &GlobalArgs) -> Result<ExitStatus> {
    let others = [
        ("--keep-going", args.keep_going),
        ("--device", args.gpu.index.is_on_device(args.device)),
        ("--stream", !args.selection.stream.is_empty()),
        ("--stream-format", args.stream.stream_format.is_some()),
        ("--camera", !args.cameras.camera.is_empty()),
        ("--eye", args.cameras.eye.is_some()),
    ];
    if let Some((option, _)) = others.iter().find(|(_, is_given)| *is_given) {
        return refuse(format!("{}: {option} does not apply to point clouds: leave it out", output.display()));
    }
    check_report(output, args.json)?;
    let start = Instant::now();
    let decoder = Decoder::open(input)?;
    let chosen = args.selection.with(args.frames.frames).choose(&decoder)?;
    let Some(frames) = chosen.iter().map(|part| part.frames).reduce(FrameRange::hull) else {
        return refuse(format!("{}: has no frames", input.display()));
    };
    let name = output.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let pattern = Pattern::parse(&name).map_err(|error| error.in_file(output))?;
    if !pattern.has_field() && frames.count() != 1 {
        return refuse(format!(
            "{}: one file for {} frames: select one frame with --frames, or use a pattern such as frame.%04d.ply",
            output.display(),
            frames.count()
        ));
    }
    let mut reference = Reference::of_container(decoder).map_err(|error| error.in_file(input))?;
    let is_selected = |list: &[String], name: &String| list.is_empty() || list.contains(name);
    let selection = &args.selection;
    let images: Vec<usize> = (0..reference.images.len())
        .filter(|&at| {
            let image = &reference.images[at];
            is_selected(&selection.probe, &image.probe)
                && (selection.face.is_empty() || selection.face.contains(&image.face))
        })
        .collect();
    let pixels: u64 = images.iter().map(|&at| reference.images[at].size.map(u64::from).iter().product::<u64>()).sum();
    // Growing the list of points may copy it.
    let fixed = pixels.saturating_mul(2 * POINT_BYTES);
    let need = Need { what: "a point cloud", fixed, each: 0, instead: "fewer probes" };
    args.memory.get().at_once(&need, 1)?;
    let in_frame = |reference: &Reference, frame: u32| -> Vec<usize> {
        images.iter().copied().filter(|&at| reference.images[at].frames.contains(frame)).collect()
    };
    let steps = frames.iter().map(|frame| in_frame(&reference, frame).len() as u64).sum();
    let progress = Progress::start(global, "decoding", steps)?;
    let mut report = Report { frames: frames.count(), points: 0, bytes_out: 0, seconds: 0.0 };
    // All files are moved into place together.
    let folder = OutputFolder::create(parent_of(output))?;
    for frame in frames.iter() {
        let path = folder.work_path().join(pattern.path(frame));
        let images = in_frame(&reference, frame);
        let mut write = || -> Result<u64> {
            let mut file = BufWriter::new(DiskFile::create(&path).map_err(|error| Error::io(&path, error))?);
            let points = write_ply(&mut reference, &images, frame, &mut file, &progress)?;
            file.flush().map_err(|error| Error::io(&path, error))?;
            Ok(points)
        };
        let written = write().map_err(|error| output::name_output(error, &path).in_file(input));
        report.points += written.map_err(|error| folder.present(error))?;
        report.bytes_out += std::fs::metadata(&path).map_or(0, |about| about.len());
    }
    folder.commit()?;
    drop(progress);
    report.seconds = start.elapsed().as_secs_f64();
    if args.json {
        output::print_json(&output::with_memory(report))?;
    } else {
        let Report { points, bytes_out, seconds, .. } = report;
        global.note(format_args!(
            "{}: {} of {}, {}, {seconds:.3} s",
            output.display(),
            counted(points, "point"),
            counted(frames.count(), "frame"),
            human_bytes(bytes_out)
        ));
    }
    Ok(ExitStatus::Passed)
}
