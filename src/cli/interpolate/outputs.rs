//! Output files of interpolated views: a sequence, or quilts.

use std::io::Write;
use std::path::{Path, PathBuf};

use half::f16;

use super::args::Args;
use crate::picture_files::{PictureCoding, PictureFiles, WORD_FIELD, has_word};
use crate::{GlobalArgs, refuse};
use codec::error::{Error, Result};
use codec::image::{Pattern, Primaries, ToneMap};
use epipolar::views::OutputViews;
use footage::export::FileFormat;
use footage::files::DiskFile;
use footage::fingerprint::Fingerprint;
use footage::image_files::quilt::{Quilt, QuiltLayout, quilt_path};
use footage::image_files::{exr, png};
use render::rendered_image::{HoleFill, RenderedImage};

pub(super) struct Outputs {
    files: PictureFiles,
    coding: PictureCoding,
    kind: Kind,
    /// True if files are numbered by frame.
    by_frame: bool,
}

enum Kind {
    Views,
    /// One quilt per frame with `views` views. `tiles` is the quilt of the current frame.
    Quilts {
        layout: QuiltLayout,
        views: usize,
        tiles: Option<Tiles>,
    },
}

/// A quilt in either format, and the number of views it contains so far.
struct Tiles {
    pixels: Pixels,
    count: usize,
}

enum Pixels {
    Png(Quilt<[u8; 4]>),
    Exr(Quilt<[f16; 4]>),
}

impl Outputs {
    /// Opens the outputs: a sequence for a pattern; one view, or all views as a quilt, for a file name. With frames the
    /// field is the frame number, and `%V` the view. Notes state the requirements of a display.
    pub fn open(path: &Path, args: &Args, views: &OutputViews, notes: &mut Vec<String>) -> Result<Outputs> {
        let Some(format) = FileFormat::of(path) else {
            return refuse(format!("{}: file names ending in .png or .exr were expected", path.display()));
        };
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let pattern = Pattern::parse(&name.replace(WORD_FIELD, "")).map_err(|error| error.in_file(path))?;
        let (count, by_word) = (args.range()?.len(), has_word(path));
        let by_frame = by_word || args.frames.frames.is_some();
        let coding = PictureCoding { look: ToneMap::default().into(), holes: HoleFill::Blank };
        if args.frame_count() > 1 && !pattern.has_field() {
            return refuse(format!(
                "{}: one file name for several frames: use a pattern such as q.%04d.png for quilts, or %V/v.%04d.png \
                for views",
                path.display()
            ));
        }
        let is_sequence = by_word || count == 1 && args.quilt.is_none() || pattern.has_field() && !by_frame;
        if is_sequence {
            if args.quilt.is_some() {
                return refuse(format!(
                    "{}: a quilt has all views in one file: leave out the view field, or --quilt",
                    path.display()
                ));
            }
            let files = files(path, format, args)?;
            return Ok(Outputs { files, coding, kind: Kind::Views, by_frame });
        }
        if args.view_range.is_some() {
            return refuse(format!(
                "{}: a quilt needs all views, and --view-range selects some: use a pattern such as views/%04d.png, \
                and join the files with lightfold quilt",
                path.display()
            ));
        }
        let all = count as u32;
        let layout = match args.quilt {
            Some(layout) => layout,
            None if args.rows > 1 => QuiltLayout { columns: args.views, rows: args.rows, size: None },
            None => QuiltLayout::choose(all, views.size)?,
        };
        notes.extend(layout.notes(all, views.size)?);
        let path = quilt_path(path, layout, views.aspect())?;
        let kind = Kind::Quilts { layout, views: count, tiles: None };
        let files = files(&path, format, args)?;
        Ok(Outputs { files, coding, kind, by_frame: true })
    }

    /// Bytes per pixel of a quilt and of the buffers for writing it. 0 for separate views.
    pub fn quilt_pixel_bytes(&self) -> u64 {
        match (&self.kind, self.files.format) {
            (Kind::Views, _) => 0,
            (Kind::Quilts { .. }, FileFormat::Png) => 4,
            // Its channels, and the compressed file.
            (Kind::Quilts { .. }, FileFormat::Exr) => 8 + 13,
        }
    }

    /// Sets the tone mapping from linear RGB to codes.
    pub fn set_tone(&mut self, tone: ToneMap) {
        self.coding.look = tone.into();
    }

    /// Begins, or resumes where an earlier run stopped. `all` is the number of frames and views.
    pub fn begin(&mut self, now: &Fingerprint, all: (u64, u64), how: (bool, &GlobalArgs)) -> Result<()> {
        let files = self.count(all);
        self.files.begin(now, files, how)
    }

    /// Returns the number of files for a number of frames and views.
    fn count(&self, (frames, views): (u64, u64)) -> u64 {
        match self.kind {
            Kind::Views => frames * views,
            Kind::Quilts { .. } => frames,
        }
    }

    pub fn stopped(&mut self, error: Error, all: (u64, u64)) -> Error {
        let files = self.count(all);
        self.files.stopped(error, files)
    }

    /// True if an earlier run wrote the file of a view.
    pub fn has(&self, frame: u32, view: usize) -> Result<bool> {
        let (word, number) = self.file_of(frame, view);
        self.files.has(&word, number)
    }

    /// Returns word and number of the file of a view.
    fn file_of(&self, frame: u32, view: usize) -> (String, u32) {
        match self.kind {
            Kind::Views => (format!("{view:04}"), if self.by_frame { frame } else { view as u32 }),
            Kind::Quilts { .. } => (String::new(), frame),
        }
    }

    pub fn put(&mut self, (frame, view): (u32, usize), picture: &RenderedImage) -> Result<()> {
        let (word, number) = self.file_of(frame, view);
        match &mut self.kind {
            Kind::Views => self.files.write((&word, number), picture, &self.coding).map(|_| ()),
            Kind::Quilts { layout, views, tiles } => {
                let size = [picture.color.width(), picture.color.height()];
                let quilt = match tiles {
                    Some(quilt) => quilt,
                    None => tiles.insert(Tiles::new(*layout, size, self.files.format)?),
                };
                quilt.put(view as u32, picture, &self.coding)?;
                match tiles.take_if(|quilt| quilt.count == *views) {
                    None => Ok(()),
                    Some(quilt) => self.files.write_by(&word, number, &mut |path: &Path| quilt.write(path)).map(|_| ()),
                }
            }
        }
    }

    /// Moves the finished files into place. Returns the path of the quilt, or the pattern of quilts.
    pub fn commit(self, frame: Option<u32>) -> Result<Option<PathBuf>> {
        let quilt = match (&self.kind, frame) {
            (Kind::Quilts { .. }, Some(frame)) => Some(self.files.path("", frame)?),
            (Kind::Quilts { .. }, None) => Some(self.files.pattern()),
            (Kind::Views, _) => None,
        };
        self.files.commit()?;
        Ok(quilt)
    }
}

/// Creates files that a later run can resume, if the options allow it.
fn files(path: &Path, format: FileFormat, args: &Args) -> Result<PictureFiles> {
    if args.is_resumable() {
        PictureFiles::resumable(path, format, &args.part())
    } else {
        PictureFiles::create(path, format)
    }
}

impl Tiles {
    fn new(layout: QuiltLayout, size: [u32; 2], format: FileFormat) -> Result<Tiles> {
        let pixels = match format {
            FileFormat::Png => Pixels::Png(Quilt::new(layout, size, [0, 0, 0, u8::MAX])?),
            FileFormat::Exr => Pixels::Exr(Quilt::new(layout, size, [f16::ZERO, f16::ZERO, f16::ZERO, f16::ONE])?),
        };
        Ok(Tiles { pixels, count: 0 })
    }

    fn put(&mut self, view: u32, picture: &RenderedImage, coding: &PictureCoding) -> Result<()> {
        self.count += 1;
        match &mut self.pixels {
            Pixels::Png(quilt) => quilt.put(view, &coding.look.rgba_codes(picture)),
            Pixels::Exr(quilt) => quilt.put(view, &picture.rgba_light(coding.holes)),
        }
    }

    fn write(&self, path: &Path) -> Result<()> {
        match &self.pixels {
            Pixels::Png(quilt) => png::write_rgba8(path, quilt.picture()),
            Pixels::Exr(quilt) => {
                let bytes = exr::rgba_bytes(quilt.picture(), Primaries::REC709)?;
                DiskFile::create(path)
                    .and_then(|mut file| file.write_all(&bytes))
                    .map_err(|error| Error::io(path, error))
            }
        }
    }
}
