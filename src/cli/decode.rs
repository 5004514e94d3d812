//! `lightfold decode IN -o OUT`: decodes a container into image files, a picture stream or point clouds, or measures
//! decoding time.

mod args;
mod point_cloud;

use std::cell::RefCell;
use std::path::Path;
use std::time::Instant;

use serde::Serialize;

use crate::film::is_film;
use crate::output::{self, human_bytes};
use crate::progress::Progress;
use crate::report::statistics::{Spread, median, spread};
use crate::{ExitStatus, GlobalArgs, damage, device, refuse};
use codec::decode::{self, DecodeSummary, Decoded, Decoder, ImageSource, OnCpu, OnDamage, Request};
use codec::error::{Error, Result, counted};
use codec::image::sequence::Pattern;
use codec::memory::Budget;
use footage::dataset::manifest::{MANIFEST_NAME, Manifest};
use footage::export;
use footage::export::{DecodeReport, DecodeTimes, Destination, FileCoding, FileFormat};
use footage::files::{OutputFolder, parent_of};
use gpu::Gpu;
use gpu::device::DeviceChoice;
use gpu::verify::{self, Verification};
use render::views::camera_units::CameraUnitsReport;

pub use args::Args;

/// Maximum size of containers that are read into memory before `--null` starts its clock.
const LOAD_BYTES: u64 = 1 << 30;
/// Containers above this size are read into memory only if at least an eighth of their bytes is needed.
const LOAD_ANY_BYTES: u64 = 64 << 20;

pub fn run(args: &Args, global: &GlobalArgs) -> Result<ExitStatus> {
    let begun = Instant::now();
    if args.gpu.list_devices {
        return device::list(args.json);
    }
    let Some(input) = &args.input else { return refuse("no container to decode was given") };
    if let Some(output) = args.output.as_deref().filter(|output| point_cloud::is_named(output)) {
        return point_cloud::run(args, input, output, global);
    }
    let gpu = open_device(args, global)?;
    let mut decoder = Decoder::open(input)?;
    let selection = args.selection.with(args.frames.frames);
    let memory = args.memory.get();
    let asked = decode::stored_bytes(&decoder, &selection.choose(&decoder)?);
    // Loading leaves enough memory for the decoder.
    let memory_left = match memory.bytes {
        Some(_) => memory.less(decode::min_bytes(&decoder, &selection.choose(&decoder)?)),
        None => memory,
    };
    let limit = load_limit(decoder.reader().file_bytes, asked, memory_left);
    let start = Instant::now();
    // Without output, decoding is timed: the file is read before the clock starts, if it fits.
    let in_memory = args.output.is_none() && decoder.load(limit)?;
    let reading = start.elapsed();
    let chosen = selection.choose(&decoder)?;
    let pipe = args.stream.open(args.output.as_deref(), args.json, decoder.reader().index().fps)?.map(RefCell::new);
    if pipe.is_some() && args.keep_going {
        return refuse("--keep-going skips damaged images, which a picture stream cannot: specify an output folder");
    }
    let view = args.cameras.view(&decoder, &chosen)?;
    let images: u64 = chosen.iter().map(|part| part.frames.count()).sum();
    let passes = args.repeat.map_or(1, |count| u64::from(count) + 1);
    let progress = Progress::start(global, "decoding", images * passes)?;
    let mut runs = Vec::new();
    let request = Request { streams: &chosen, filter: view.filter(), memory };
    let coding = FileCoding { format: args.format, space: args.color_space };
    let write = |source: &dyn ImageSource, output: &Path| match &pipe {
        Some(pipe) => export::decode_to_stream(source, &decoder, request, &mut *pipe.borrow_mut(), &progress),
        None => Export { source, decoder: &decoder, request, coding, progress: &progress }.write(output),
    };
    let on_gpu = |gpu: &Gpu| {
        if let Some(output) = &args.output {
            return Ok((write(gpu, output)?, None));
        }
        let (summary, found) = match args.verify {
            true => verify::verify(gpu, &decoder, request, &progress).map(|(summary, found)| (summary, Some(found)))?,
            false => (verify::decode_to_nothing(gpu, &decoder, request, &progress)?, None),
        };
        Ok((Decoded { summary, ..Decoded::default() }, found))
    };
    let on_damage = if args.keep_going { OnDamage::KeepGoing } else { OnDamage::Stop };
    let on_cpu = || match &args.output {
        Some(output) => Ok((write(&OnCpu(on_damage), output)?, None)),
        None => Ok((decode::decode_units(&decoder, request, on_damage, &progress)?, None)),
    };
    let choice = args.device.filter(|_| !args.verify);
    let mut once = || {
        // With output the time covers the whole command, without output only decoding.
        let start = if args.output.is_some() && runs.is_empty() { begun } else { Instant::now() };
        let done = device::or_on_cpu((gpu.as_ref(), choice), global, on_gpu, on_cpu)?;
        runs.push(start.elapsed().as_secs_f64());
        Ok(done)
    };
    let ((mut decoded, found), name) = once()?;
    if let Some(repeat) = args.repeat {
        for _ in 0..repeat {
            decoded = once()?.0.0;
        }
        // The first run was the warm-up.
        runs.remove(0);
    }
    drop(progress);
    let times = DecodeTimes {
        seconds: median(&runs).unwrap_or_default(),
        reading_seconds: reading.as_secs_f64(),
        container_in_memory: in_memory,
        runs_seconds: args.repeat.map(|_| runs),
        device: name,
    };
    if args.keep_going && !args.json {
        output::note(damage::lines(&decoder, &decoded.damaged).trim_end());
    }
    note_losses(args, &decoded);
    let report = DecodeReport::new(&decoded, &times);
    if args.json {
        let report = if args.keep_going { report.with_damage(&decoder, &decoded) } else { report };
        let document = Document { decoded: report, seen: view.report(), verification: found.as_ref() };
        output::print_json(&output::with_memory(document))?;
    } else {
        let (summary, speed) = (&decoded.summary, report.megapixels_per_second);
        let (line, range) = (speed_text(args, summary, &times, speed), range_text(&times));
        let line = format!("{line}{}{range}{}", view.line(summary), verification_text(found.as_ref()));
        match &args.output {
            None => output::print_text(&format!("{line}\n"))?,
            Some(output) => global.note(format_args!("{}: {line}", output.display())),
        }
    }
    match found {
        Some(found) if found.mismatched_words > 0 => Ok(ExitStatus::Failed),
        _ if !decoded.damaged.is_empty() => Err(verdict(&decoded, images).in_file(input)),
        _ => Ok(ExitStatus::Passed),
    }
}

/// Notes losses that the image files do not show, also with --quiet.
fn note_losses(args: &Args, decoded: &Decoded) {
    let Some(output) = &args.output else { return };
    if decoded.clipped_pixels > 0 {
        output::note(format_args!(
            "{}: {} exceeded the 8-bit range or their alpha, and were clipped; --format exr does not clip",
            output.display(),
            counted(decoded.clipped_pixels, "colour pixel")
        ));
    }
    if let Some(why) = decoded.no_manifest {
        let stays = if output.join(MANIFEST_NAME).exists() { "; an older one is kept, and may not match" } else { "" };
        output::note(format_args!("{}: {MANIFEST_NAME} was not written: {why}{stays}", output.display()));
    }
}

fn verdict(decoded: &Decoded, images: u64) -> Error {
    let (missing, chunks) = (decoded.missing_images(), counted(decoded.damaged.len() as u64, "damaged chunk"));
    Error::invalid(if missing == images {
        format!("none of the {images} images is intact ({chunks}); nothing was written")
    } else {
        format!("{missing} of {images} images could not be decoded ({chunks}); all others are intact")
    })
}

/// Returns the maximum size of a file to read into memory at once, for a file of `file` bytes of which `asked` are
/// needed.
fn load_limit(file: u64, asked: u64, memory: Budget) -> u64 {
    // If only a small part of a large file is needed, it is read during decoding.
    if file > LOAD_ANY_BYTES && asked < file / 8 {
        return 0;
    }
    memory.bytes.map_or(LOAD_BYTES, |bytes| bytes / 4)
}

/// Opens the graphics device for decoding, if one is used. --verify requires a device.
fn open_device(args: &Args, global: &GlobalArgs) -> Result<Option<Gpu>> {
    let is_named = args.device == Some(DeviceChoice::Gpu) || args.gpu.index.gpu_index.is_some();
    if args.memory.memory.is_some() && (args.verify || is_named) {
        return refuse("--memory limits the CPU decoder only, not graphics devices: leave out one of them");
    }
    if args.keep_going && is_named {
        return refuse("--keep-going decodes on the CPU: leave out --device gpu");
    }
    if args.memory.memory.is_some() || args.keep_going {
        return Ok(None);
    }
    let choice = match (args.device, args.verify) {
        (Some(DeviceChoice::Cpu), true) => {
            return refuse("--verify compares a graphics device with the CPU: leave out --device cpu");
        }
        // A software device suffices for the comparison.
        (_, true) => Some(DeviceChoice::Gpu),
        (choice, false) => choice,
    };
    args.gpu.index.open(choice, global)
}

pub struct Export<'a> {
    pub source: &'a dyn ImageSource,
    pub decoder: &'a Decoder,
    pub request: Request<'a>,
    pub coding: FileCoding,
    pub progress: &'a Progress,
}

impl Export<'_> {
    /// Writes a dataset into a folder, or the images of a pattern.
    fn write(&self, output: &Path) -> Result<Decoded> {
        let Some(pattern) = file_pattern(output)? else {
            if output.join(MANIFEST_NAME).exists() {
                check_replaced(output)?;
                output::note(format_args!(
                    "{}: contains a dataset; files of the same names are replaced, others are kept",
                    output.display()
                ));
            }
            return self.write_into(output, |folder| Destination::Dataset(folder.to_path_buf()));
        };
        let streams = self.request.streams;
        let sequences = export::file_sequences(streams);
        let images: u64 = sequences.iter().map(|frames| frames.count()).sum();
        if !pattern.has_field() && images != 1 {
            return refuse(format!(
                "{}: one file for {images} images: use a pattern such as depth.%04d.exr, or a folder",
                output.display()
            ));
        }
        if sequences.len() != 1 {
            return refuse(format!(
                "{}: a pattern takes one stream, and {} are selected: select one with --probe, --face and --stream, \
                or use a folder",
                output.display(),
                streams.len()
            ));
        }
        let Some(format) = FileFormat::of(output) else {
            return refuse(format!("{}: file names ending in .exr or .png were expected", output.display()));
        };
        let files = |folder: &Path| Destination::Files(pattern.clone().below(folder));
        let coding = FileCoding { format, ..self.coding };
        Export { coding, ..*self }.write_into(parent_of(output), files)
    }

    /// Writes into a folder, which is created once there are files to put into it. `destination` names the files below
    /// a folder.
    pub fn write_into(&self, path: &Path, destination: impl Fn(&Path) -> Destination) -> Result<Decoded> {
        if is_film(path) {
            return refuse(format!(
                "{}: decode writes a folder of images, or a picture stream to - for ffmpeg; lightfold render writes films",
                path.display()
            ));
        }
        let folder = OutputFolder::create(path)?;
        let work = destination(folder.work_path());
        let decoded =
            export::decode_to_files(self.source, self.decoder, self.request, &work, self.coding, self.progress)
                .map_err(|error| folder.present(error))?;
        if decoded.summary.frames > 0 {
            let removed = destination(path).remove_missing(self.decoder, &decoded.missing, self.coding.format)?;
            if removed > 0 {
                output::note(format_args!(
                    "{}: removed {removed} older files of images that could not be decoded",
                    path.display()
                ));
            }
            folder.commit()?;
        }
        Ok(decoded)
    }
}

/// Fails if the dataset in a folder was not written by `decode`: it may be the source of the container.
fn check_replaced(folder: &Path) -> Result<()> {
    match Manifest::read(folder).is_ok_and(|manifest| export::has_decoded(&manifest)) {
        true => Ok(()),
        false => refuse(format!(
            "{}: contains a dataset that lightfold did not decode, whose files would be replaced: specify another \
            folder",
            folder.display()
        )),
    }
}

/// True if the name is that of an image in a format that cannot be written, rather than that of a folder.
fn has_image_extension(path: &Path) -> bool {
    const EXTENSIONS: [&str; 18] = [
        "avif", "bmp", "dds", "dpx", "exr", "gif", "hdr", "heic", "jp2", "jpeg", "jpg", "jxl", "ktx2", "png", "tga",
        "tif", "tiff", "webp",
    ];
    let extension = path.extension().map(|extension| extension.to_string_lossy().to_ascii_lowercase());
    extension.is_some_and(|extension| EXTENSIONS.contains(&extension.as_str()))
}

/// Returns the pattern of an output path. `None` if it names a folder.
fn file_pattern(output: &Path) -> Result<Option<Pattern>> {
    let name = output.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let image = FileFormat::of(output).is_some();
    if !image && !output.is_dir() && has_image_extension(output) {
        return refuse(format!("{}: file names ending in .exr or .png were expected, or a folder", output.display()));
    }
    if !image && !name.contains('%') {
        return Ok(None);
    }
    let pattern = Pattern::parse(&name).map_err(|error| error.in_file(output))?;
    Ok((pattern.has_field() || image).then_some(pattern))
}

#[derive(Serialize)]
struct Document<'a> {
    #[serde(flatten)]
    decoded: DecodeReport<'a>,
    #[serde(flatten)]
    seen: Option<CameraUnitsReport>,
    #[serde(flatten)]
    verification: Option<&'a Verification>,
}

fn speed_text(args: &Args, summary: &DecodeSummary, times: &DecodeTimes, megapixels_per_second: f64) -> String {
    let on = if times.device == "cpu" { String::new() } else { format!(", on {}", times.device) };
    format!(
        "{}, {:.1} Mpixel of which {:.2}% changed, {} read, {} {}, {:.3} s, {megapixels_per_second:.0} Mpixel/s{on}",
        counted(summary.frames, "image"),
        summary.pixels as f64 / 1e6,
        100.0 * summary.cost.updated_pixels as f64 / summary.pixels.max(1) as f64,
        human_bytes(summary.cost.bytes_read),
        human_bytes(summary.bytes_out),
        if args.output.is_none() { "decoded" } else { "written" },
        times.seconds,
    )
}

fn range_text(times: &DecodeTimes) -> String {
    let runs = times.runs_seconds.as_deref();
    let range = runs.and_then(|runs| Some((runs.len(), spread(runs)?)));
    range.map_or_else(String::new, |(count, Spread { low, high })| {
        format!("; median of {count} runs of {low:.4} to {high:.4} s")
    })
}

fn verification_text(verification: Option<&Verification>) -> String {
    match verification {
        None => String::new(),
        Some(Verification { first: Some(first), mismatched_words }) => {
            format!("\n{mismatched_words} words differ from the CPU's, the first in {first}")
        }
        Some(_) => "\nall words equal those of the CPU".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_read_whole_where_that_is_in_proportion() {
        let large = 1 << 29;
        assert_eq!(load_limit(large, large / 2, Budget::UNLIMITED), LOAD_BYTES);
        assert_eq!(load_limit(large, large / 9, Budget::UNLIMITED), 0);
        assert_eq!(load_limit(1 << 20, 1, Budget::UNLIMITED), LOAD_BYTES);
        assert_eq!(load_limit(large, large, Budget::of(400)), 100);
    }
}
