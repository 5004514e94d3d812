//! `lightfold quilt VIEWS -o QUILT`: joins rendered views to a quilt for Looking Glass displays.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

use half::f16;
use serde::Serialize;

use crate::options::{MemoryArgs, check_stdout, parse_aspect};
use crate::output::{self, human_bytes};
use crate::progress::Progress;
use crate::{ExitStatus, GlobalArgs, outputs, refuse};
use codec::error::{Error, Result, counted};
use codec::image::plane::Plane;
use codec::image::sequence::{FrameRange, Sequence};
use codec::image::{Primaries, ReadLimits};
use codec::memory::Need;
use codec::monitor::Monitor;
use codec::ordered::try_map_ordered;
use footage::export::FileFormat;
use footage::files::OutputFile;
use footage::image_files::quilt::{Quilt, QuiltLayout, quilt_path};
use footage::image_files::{exr, png};

#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  lightfold render film.lfold --camera row.json -o views/%04d.png --size 420x560\n  \
    lightfold quilt views/%04d.png -o film.png\n  \
    lightfold quilt views --quilt portrait --views 0-47 -o film_qs8x6a0.75.png\n  \
    lightfold quilt light/%04d.exr --quilt 11x6 -o light.exr\n\n\
    The lowest-numbered view is the leftmost one. It is placed at the bottom left; others follow to the right, row by \
    row upwards. Columns, rows and the aspect ratio of a view are appended to the file name: film.png becomes \
    film_qs8x6a0.75.png. Views are not resampled; if a device expects another size, that size is reported."
)]
pub struct Args {
    /// Views: a pattern such as views/%04d.png, or a folder, of PNG files (16 bits are rounded to 8) or EXR files
    #[arg(value_name = "VIEWS")]
    pub input: String,
    /// Output picture, in the format of the views; - writes PNG to standard output
    #[arg(long, short, value_name = "QUILT")]
    pub output: PathBuf,
    /// Columns and rows such as 8x6, or a device: portrait, go, 16, 16-portrait, 16-gen2, 32, 32-portrait, 32-gen2, 65
    /// [default: the device that matches the views, else a nearly square picture]
    #[arg(long, value_name = "DEVICE|CxR")]
    pub quilt: Option<QuiltLayout>,
    /// Only views with these numbers, such as 0-47
    #[arg(long, value_name = "A-B")]
    pub views: Option<FrameRange>,
    /// Aspect ratio of a displayed view for the file name, such as 16/9 [default: that of the device, else width / height in pixels]
    #[arg(long, value_name = "W/H", value_parser = parse_aspect)]
    pub aspect: Option<f64>,
    /// Report as JSON
    #[arg(long)]
    pub json: bool,
    #[command(flatten)]
    pub memory: MemoryArgs,
}

#[derive(Serialize)]
struct Report {
    views: u32,
    columns: u32,
    rows: u32,
    aspect: f64,
    size: [u32; 2],
    view_size: [u32; 2],
    path: String,
    bytes: u64,
    device: Option<&'static str>,
    notes: Vec<String>,
    seconds: f64,
}

pub fn run(args: &Args, global: &GlobalArgs) -> Result<ExitStatus> {
    check_stdout(&args.output, args.json)?;
    let start = Instant::now();
    let views = Views::open(args)?;
    let view_size = views.size()?;
    let layout = match args.quilt {
        Some(layout) => layout,
        None => QuiltLayout::choose(views.count(), view_size)?,
    };
    let notes = layout.notes(views.count(), view_size)?;
    let aspect = args.aspect.unwrap_or_else(|| layout.aspect(view_size));
    let path = match args.output == Path::new("-") {
        true => args.output.clone(),
        false => quilt_path(&args.output, layout, aspect)?,
    };
    outputs::check(&[("-o", path.clone())], &views.paths.iter().map(PathBuf::as_path).collect::<Vec<_>>())?;
    let at_once = views.at_once(layout, view_size, args)?;
    let mut file = OutputFile::create(&path)?;
    let progress = Progress::start(global, "joining views", views.count().into())?;
    let limits = ReadLimits::default();
    let bytes = match views.format {
        FileFormat::Png => {
            let quilt = Quilt::new(layout, view_size, [0, 0, 0, u8::MAX])?;
            let picture = views.join(quilt, at_once, |path| png::read_rgba8(path, &limits), &progress)?;
            let mut bytes = Vec::new();
            png::encode_rgba8(&mut bytes, &picture)?;
            bytes
        }
        FileFormat::Exr => {
            let quilt = Quilt::new(layout, view_size, [f16::ZERO, f16::ZERO, f16::ZERO, f16::ONE])?;
            let primaries = views.paths.first().map_or(Ok(Primaries::REC709), |path| exr::read_primaries(path))?;
            let read = |path: &Path| {
                let plane = exr::read_rgba(path, &limits)?;
                let matrix = exr::read_primaries(path)?.conversion_to(primaries);
                let Some(matrix) = matrix else { return Ok(plane) };
                Ok(plane.map(|&[r, g, b, alpha]| {
                    let [r, g, b] = matrix.convert_half([r, g, b]);
                    [r, g, b, alpha]
                }))
            };
            exr::rgba_bytes(&views.join(quilt, at_once, read, &progress)?, primaries)?
        }
    };
    progress.check()?;
    file.write_all(&bytes).map_err(|error| output::name_output(Error::io(&path, error), &path))?;
    file.commit()?;
    drop(progress);
    notes.iter().for_each(|note| global.note(note));
    let report = Report {
        views: views.count(),
        columns: layout.columns,
        rows: layout.rows,
        aspect,
        size: layout.picture_size(view_size)?,
        view_size,
        path: path.display().to_string(),
        bytes: bytes.len() as u64,
        device: layout.device(),
        notes,
        seconds: start.elapsed().as_secs_f64(),
    };
    global.report(args.json, &report, || report.text())?;
    Ok(ExitStatus::Passed)
}

/// Files of views, from left to right.
struct Views {
    paths: Vec<PathBuf>,
    format: FileFormat,
}

impl Views {
    fn open(args: &Args) -> Result<Views> {
        let sequence = Sequence::find(&args.input, args.views)?;
        let first = sequence.path(sequence.frames.first);
        let is_exr = |path: &Path| path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("exr"));
        let format = match first.as_path() {
            path if png::is_png(path) => FileFormat::Png,
            path if is_exr(path) => FileFormat::Exr,
            path => return refuse(format!("{}: views ending in .png or .exr were expected", path.display())),
        };
        let output = &args.output;
        match (format, FileFormat::of(output), output == Path::new("-")) {
            (FileFormat::Png, _, true) => {}
            (FileFormat::Exr, _, true) => {
                return refuse(
                    "-o -: standard output takes PNG, and the views are EXR files: use a file name ending in .exr",
                );
            }
            (FileFormat::Png, Some(FileFormat::Png), _) | (FileFormat::Exr, Some(FileFormat::Exr), _) => {}
            (FileFormat::Png, ..) => {
                return refuse(format!(
                    "{}: the views are PNG files: use a file name ending in .png",
                    output.display()
                ));
            }
            (FileFormat::Exr, ..) => {
                return refuse(format!(
                    "{}: the views are EXR files: use a file name ending in .exr",
                    output.display()
                ));
            }
        }
        Ok(Views { paths: sequence.frames.iter().map(|view| sequence.path(view)).collect(), format })
    }

    fn count(&self) -> u32 {
        self.paths.len() as u32
    }

    /// Returns width and height of the views, from the files' headers. Fails if they differ.
    fn size(&self) -> Result<[u32; 2]> {
        let read_size = match self.format {
            FileFormat::Png => png::read_size,
            FileFormat::Exr => exr::read_size,
        };
        let limits = ReadLimits::default();
        let sizes =
            try_map_ordered(self.paths.iter().collect(), |path| read_size(path, &limits).map(<[u32; 2]>::from))?;
        let (Some(first), Some(&size)) = (self.paths.first(), sizes.first()) else {
            return refuse("a quilt needs at least one view");
        };
        match self.paths.iter().zip(&sizes).find(|(_, other)| **other != size) {
            None => Ok(size),
            Some((path, other)) => Err(Error::invalid(format!(
                "this view has {}x{} pixels, but {} has {}x{}: all views must have the same size",
                other[0],
                other[1],
                first.display(),
                size[0],
                size[1]
            ))
            .in_file(path)),
        }
    }

    /// Returns the number of views that are read at once.
    fn at_once(&self, layout: QuiltLayout, view_size: [u32; 2], args: &Args) -> Result<usize> {
        let pixels = |size: [u32; 2]| u64::from(size[0]) * u64::from(size[1]);
        let pixel_bytes = match self.format {
            FileFormat::Png => size_of::<[u8; 4]>() as u64,
            FileFormat::Exr => size_of::<[f16; 4]>() as u64,
        };
        let need = Need {
            what: "joining views to a quilt",
            // The picture, a copy that is filtered or split into channels, and the bytes of the file.
            fixed: 3 * pixel_bytes * pixels(layout.picture_size(view_size)?),
            // Samples as stored, of up to twice the size, the decoder's buffer for them, and the view.
            each: 5 * pixel_bytes * pixels(view_size),
            instead: "join fewer `views`",
        };
        args.memory.get().at_once(&need, rayon::current_num_threads())
    }

    fn join<T: Copy + Send>(
        &self,
        mut quilt: Quilt<T>,
        at_once: usize,
        read: impl Fn(&Path) -> Result<Plane<T>> + Sync + Send,
        progress: &Progress,
    ) -> Result<Plane<T>> {
        let mut view = 0;
        for paths in self.paths.chunks(at_once) {
            progress.check()?;
            let views = try_map_ordered(paths.iter().collect(), |path: &PathBuf| read(path))?;
            for (pixels, path) in views.iter().zip(paths) {
                quilt.put(view, pixels).map_err(|error| error.in_file(path))?;
                view += 1;
            }
            progress.advance(views.len() as u64);
        }
        Ok(quilt.finish())
    }
}

impl Report {
    fn text(&self) -> String {
        let [[width, height], [view_width, view_height]] = [self.size, self.view_size];
        let device = self.device.map(|name| format!(" for {name}")).unwrap_or_default();
        format!(
            "{}: {} of {view_width}x{view_height} pixels in {}x{} tiles{device}, {width}x{height} pixels, {}",
            self.path,
            counted(self.views.into(), "view"),
            self.columns,
            self.rows,
            human_bytes(self.bytes)
        )
    }
}
