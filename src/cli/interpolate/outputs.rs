//! Files of interpolated views: a sequence, or a quilt.

use std::io::Write;
use std::path::{Path, PathBuf};

use half::f16;

use super::args::Args;
use crate::cli::refuse;
use crate::decode::FileFormat;
use crate::epipolar::views::OutputViews;
use crate::error::{Error, Result};
use crate::evaluate::RenderedImage;
use crate::evaluate::rendered_image::HoleFill;
use crate::files::{OutputFile, OutputFolder};
use crate::image::quilt::{Quilt, QuiltLayout, quilt_path};
use crate::image::{Pattern, ToneMap, exr, png};

pub(super) enum Outputs {
    Sequence { pattern: Pattern, format: FileFormat, folder: OutputFolder },
    Quilt { tiles: Tiles, path: PathBuf, file: OutputFile },
}

/// A quilt of either format.
pub(super) enum Tiles {
    Png(Quilt<[u8; 4]>),
    Exr(Quilt<[f16; 4]>),
}

impl Outputs {
    /// A pattern takes a sequence, and a file one view, or all of them as a quilt. Notes say what a display expects.
    pub fn open(path: &Path, args: &Args, views: &OutputViews, notes: &mut Vec<String>) -> Result<Outputs> {
        let Some(format) = FileFormat::of(path) else {
            return refuse(format!("{}: file names ending in .png or .exr were expected", path.display()));
        };
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let pattern = Pattern::parse(&name).map_err(|error| error.in_file(path))?;
        let count = args.range()?.len();
        if pattern.has_field() || count == 1 && args.quilt.is_none() {
            if args.quilt.is_some() {
                return refuse(format!("{}: a quilt is one file; leave out the field, or --quilt", path.display()));
            }
            let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
            return Ok(Outputs::Sequence { pattern, format, folder: OutputFolder::create(folder)? });
        }
        if args.view_range.is_some() {
            return refuse(format!(
                "{}: a quilt has all views, and --view-range selects some; name a pattern such as views/%04d.png, and join \
                 the files with lightfold quilt",
                path.display()
            ));
        }
        let layout = match args.quilt {
            Some(layout) => layout,
            None => QuiltLayout::choose(views.count(), views.size)?,
        };
        notes.extend(layout.notes(views.count(), views.size)?);
        let path = quilt_path(path, layout, f64::from(views.size[0]) / f64::from(views.size[1]))?;
        let tiles = match format {
            FileFormat::Png => Tiles::Png(Quilt::new(layout, views.size, [0, 0, 0, u8::MAX])?),
            FileFormat::Exr => Tiles::Exr(Quilt::new(layout, views.size, [f16::ZERO, f16::ZERO, f16::ZERO, f16::ONE])?),
        };
        let file = OutputFile::create(&path)?;
        Ok(Outputs::Quilt { tiles, path, file })
    }

    pub fn put(&mut self, view: usize, picture: &RenderedImage) -> Result<()> {
        let (codes, light) = (|| picture.rgba_codes(ToneMap::default()), || picture.rgba_light(HoleFill::Blank));
        match self {
            Outputs::Sequence { pattern, format, folder } => {
                let path = folder.work_path().join(pattern.path(view as u32));
                let written = match format {
                    FileFormat::Png => png::write_rgba8(&path, &codes()),
                    FileFormat::Exr => exr::write_rgba(&path, &light()),
                };
                written.map_err(|error: Error| folder.present(error))
            }
            Outputs::Quilt { tiles: Tiles::Png(quilt), .. } => quilt.put(view as u32, &codes()),
            Outputs::Quilt { tiles: Tiles::Exr(quilt), .. } => quilt.put(view as u32, &light()),
        }
    }

    /// Whole, or not at all. Answers the file of a quilt.
    pub fn commit(self) -> Result<Option<PathBuf>> {
        match self {
            Outputs::Sequence { folder, .. } => folder.commit().map(|()| None),
            Outputs::Quilt { tiles, path, mut file } => {
                let bytes = match tiles {
                    Tiles::Png(quilt) => {
                        let mut bytes = Vec::new();
                        png::encode_rgba8(&mut bytes, &quilt.finish())?;
                        bytes
                    }
                    Tiles::Exr(quilt) => exr::rgba_bytes(&quilt.finish())?,
                };
                file.write_all(&bytes).map_err(|error| Error::io(&path, error))?;
                file.commit()?;
                Ok(Some(path))
            }
        }
    }
}
