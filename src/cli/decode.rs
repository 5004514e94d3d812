//! `lightfold decode IN -o OUT`: image files out of a container, or nothing but the time it takes.

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::ValueEnum;
use serde_json::json;

use crate::cli::options::{CameraArgs, FrameArgs, SelectionArgs, View};
use crate::cli::output::{self, OutputFolder, human_bytes};
use crate::cli::progress::Progress;
use crate::cli::{GlobalArgs, Outcome};
use crate::container::Reader;
use crate::dataset::manifest::MANIFEST_NAME;
use crate::error::{Error, Result};
use crate::image::sequence::Pattern;
use crate::video::decode::Decoder;
use crate::video::export::{self, Chosen, DecodeSummary, Destination, FileFormat};
use crate::video::unit_filter::UnitFilter;

/// Containers up to this size are read into memory before `--null` starts its clock.
const LOAD_BYTES: u64 = 1 << 30;

/// Arguments.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  lightfold decode film.lfold -o frames\n  \
    lightfold decode film.lfold --probe 00 --face px --stream depth -o depth.%04d.exr\n  \
    lightfold decode film.lfold --frames 10-19 --format png -o look\n  \
    lightfold decode film.lfold --null --json\n  \
    lightfold decode film.lfold --eye 0,1.5,0 --look-at 2,1.5,0 --fov 90 --null --stats\n  \
    lightfold decode film.lfold --camera cam.json -o seen\n\n\
    CAM.json holds {\"cameras\": [{\"eye\": [0, 1.5, 0], \"look_at\": [2, 1.5, 0], \"fov_y_deg\": 90}]}. A camera may\n\
    also have \"up\", \"aspect\", \"near_m\", \"far_m\", \"frames\" ([first, last]) and, for \"look_at\" and \"up\",\n\
    \"orientation\" (a quaternion x, y, z, w).")]
pub struct Args {
    /// The container, - for standard input
    #[arg(value_name = "IN.lfold")]
    pub input: PathBuf,
    /// Folder to write a dataset into, or a pattern such as depth.%04d.exr for a single stream
    #[arg(long, short, value_name = "DIR", required_unless_present = "null")]
    pub output: Option<PathBuf>,
    /// Decode everything and write nothing; reports the time of the decoding alone
    #[arg(long, conflicts_with = "output")]
    pub null: bool,
    /// Streams.
    #[command(flatten)]
    pub selection: SelectionArgs,
    /// Frames.
    #[command(flatten)]
    pub frames: FrameArgs,
    /// Kind of files; png holds codes: 8-bit colour, and 16-bit log depth that is for looking at, not for reading back
    #[arg(long, value_enum, default_value_t = FormatArg::Exr)]
    pub format: FormatArg,
    /// Report as JSON
    #[arg(long)]
    pub json: bool,
    /// Cameras.
    #[command(flatten)]
    pub cameras: CameraArgs,
}

/// `--format`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum FormatArg {
    /// OpenEXR
    Exr,
    /// PNG
    Png,
}

/// Decodes.
pub fn run(args: &Args, global: &GlobalArgs) -> Result<Outcome> {
    let mut reader = Reader::open(&args.input)?;
    let start = Instant::now();
    // The time of decoding alone is asked for: the file is read before it counts, where memory allows.
    let in_memory = args.null && reader.load(LOAD_BYTES)?;
    let reading = start.elapsed();
    let decoder = Decoder::new(reader)?;
    let chosen = args.selection.with(args.frames.frames).choose(&decoder)?;
    let view = args.cameras.view(&decoder, &chosen)?;
    let images = chosen.iter().map(|(_, frames)| frames.count()).sum();
    let progress = Progress::start(global, "decoding", images)?;
    let start = Instant::now();
    let summary = match &args.output {
        None => export::decode_to_nothing(&decoder, &chosen, view.filter(), &progress)?,
        Some(output) => write(&decoder, (&chosen, view.filter()), output, args.format, &progress)?,
    };
    let seconds = start.elapsed().as_secs_f64();
    drop(progress);
    let pace = Pace { seconds, reading_seconds: reading.as_secs_f64(), in_memory };
    report(args, (&summary, &view), pace, global)?;
    Ok(Outcome::Fine)
}

fn write(
    decoder: &Decoder,
    (chosen, filter): (&[Chosen<'_>], &dyn UnitFilter),
    output: &Path,
    format: FormatArg,
    progress: &Progress,
) -> Result<DecodeSummary> {
    let format = match format {
        FormatArg::Exr => FileFormat::Exr,
        FormatArg::Png => FileFormat::Png,
    };
    if output == Path::new("-") {
        return Err(Error::Usage("decode writes image files, which standard output cannot hold: name a folder".into()));
    }
    let Some(pattern) = file_pattern(output)? else {
        if output.join(MANIFEST_NAME).exists() {
            output::note(format_args!(
                "{}: holds a dataset already; files of the same names are replaced, others stay",
                output.display()
            ));
        }
        let folder = OutputFolder::create(output)?;
        let destination = Destination::Dataset(folder.work_path().to_path_buf());
        let summary = export::decode_to_files(decoder, chosen, filter, &destination, format, progress)
            .map_err(|error| folder.present(error))?;
        folder.commit()?;
        return Ok(summary);
    };
    let images: u64 = chosen.iter().map(|(_, frames)| frames.count()).sum();
    if !pattern.has_field() && images != 1 {
        return Err(Error::Usage(format!(
            "{}: one file, and {images} images are chosen; name a pattern such as depth.%04d.exr, or a folder",
            output.display()
        )));
    }
    if chosen.len() != 1 {
        return Err(Error::Usage(format!(
            "{}: a pattern names the files of one stream, {} are chosen; use --probe, --face and --stream, or name a folder",
            output.display(),
            chosen.len()
        )));
    }
    let format = match output.extension().and_then(|extension| extension.to_str()) {
        Some("png") => FileFormat::Png,
        Some("exr") => FileFormat::Exr,
        _ => {
            return Err(Error::Usage(format!("{}: file names ending in .exr or .png were expected", output.display())));
        }
    };
    let parent = output.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let folder = OutputFolder::create(parent)?;
    let destination = Destination::Files(pattern.below(folder.work_path()));
    let summary = export::decode_to_files(decoder, chosen, filter, &destination, format, progress)
        .map_err(|error| folder.present(error))?;
    folder.commit()?;
    Ok(summary)
}

/// The pattern that an output path is, or none where it names a folder.
fn file_pattern(output: &Path) -> Result<Option<Pattern>> {
    let name = output.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let image = output.extension().is_some_and(|extension| extension == "exr" || extension == "png");
    if !image && !name.contains('%') {
        return Ok(None);
    }
    let pattern = Pattern::parse(&name).map_err(|error| error.in_file(output))?;
    Ok((pattern.has_field() || image).then_some(pattern))
}

/// How long it took.
struct Pace {
    seconds: f64,
    /// Time for reading the file beforehand, which `seconds` does not include.
    reading_seconds: f64,
    in_memory: bool,
}

fn report(args: &Args, (summary, view): (&DecodeSummary, &View), pace: Pace, global: &GlobalArgs) -> Result<()> {
    let seconds = pace.seconds;
    let speed = summary.pixels as f64 / 1e6 / seconds.max(1e-9);
    let changed = 100.0 * summary.cost.updated_pixels as f64 / summary.pixels.max(1) as f64;
    if args.json {
        let mut report = json!({
            "frames": summary.frames,
            "pixels": summary.pixels,
            "updated_pixels": summary.cost.updated_pixels,
            "seconds": seconds,
            "reading_seconds": pace.reading_seconds,
            "container_in_memory": pace.in_memory,
            "megapixels_per_second": speed,
            "updated_megapixels_per_second": summary.cost.updated_pixels as f64 / 1e6 / seconds.max(1e-9),
            "bytes_read": summary.cost.bytes_read,
            "bytes_out": summary.bytes_out,
            "fetching_thread_seconds": summary.cost.fetching.as_secs_f64(),
            "applying_thread_seconds": summary.cost.applying.as_secs_f64(),
            "device": "cpu",
        });
        view.add_to(&mut report);
        return output::print_json(&report);
    }
    let line = format!(
        "{} images, {:.1} Mpixel of which {changed:.2}% changed, {} read, {} {}, {seconds:.3} s, {speed:.0} Mpixel/s{}",
        summary.frames,
        summary.pixels as f64 / 1e6,
        human_bytes(summary.cost.bytes_read),
        human_bytes(summary.bytes_out),
        if args.null { "decoded" } else { "written" },
        view.line(summary),
    );
    match &args.output {
        None => output::print_text(&format!("{line}\n")),
        Some(output) => {
            if !global.quiet {
                output::note(format_args!("{}: {line}", output.display()));
            }
            Ok(())
        }
    }
}
