//! Writes rendered images to files, a folder or standard output, and draws the contact sheet.

use std::collections::BTreeSet;
use std::io::Stdout;
use std::path::{Path, PathBuf};

use glam::DVec3;

use super::args::Args;
use super::options::{CUBE_COLUMNS, ProjectionArgs};
use crate::film::{FILM_ENDINGS, Film, FilmFormat, is_film};
use crate::look::Look;
use crate::picture_files::{PictureCoding, PictureFiles, WORD_FIELD, has_word};
use crate::refuse;
use crate::report::picture::contact_sheet::ContactSheet;
use codec::error::{Error, Result};
use codec::image::plane::Plane;
use codec::image::sequence::Pattern;
use codec::math::Camera;
use codec::monitor::Monitor;
use footage::export::FileFormat;
use footage::files::OutputFile;
use footage::image_files::picture_stream::{CodePicture, PictureStream};
use footage::image_files::png;
use render::frame_requests::FrameRequest;
use render::rendered_image::{Aov, RenderedImage};

const EYES: [&str; 2] = ["left", "right"];

#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PictureName {
    /// Number in patterns: the frame, or the index of the camera if several cameras share a frame.
    pub number: u32,
    /// Content, for files in a folder and for the contact sheet: `view`, or probe and face of a reference.
    pub subject: String,
}

impl PictureName {
    pub fn png(&self) -> String {
        format!("{}.{:04}.png", self.subject, self.number)
    }
}

/// Images of one frame that are rendered at once.
pub struct Job {
    pub request: FrameRequest,
    /// Name of each picture. Both eyes, and all faces of a cube map, share a name.
    pub names: Vec<PictureName>,
    pub size: [u32; 2],
    /// Indices of reference images, in the order of the cameras.
    pub references: Vec<usize>,
}

impl Job {
    /// Returns a caption with the content of a picture, its frame, and the eye position in metres.
    fn caption(&self, name: &PictureName) -> String {
        let parts = self.request.cameras.len() / self.names.len().max(1);
        let at = self.names.iter().position(|other| other == name).unwrap_or(0) * parts;
        let cameras = &self.request.cameras[at..at + parts];
        let [x, y, z] = (cameras.iter().map(Camera::eye).sum::<DVec3>() / parts.max(1) as f64).to_array();
        let frame = self.request.frame;
        let number = if name.number == frame { String::new() } else { format!(" {}", name.number) };
        format!("{}{number}, frame {frame}, eye {x:.2},{y:.2},{z:.2}", name.subject)
    }
}

enum Destination {
    Nowhere,
    StandardOutput(PictureStream<Stdout>),
    Film(Box<Film>),
    /// Files whose word is the eye.
    Files(PictureFiles),
    /// Files whose word is the content of the picture.
    Folder(PictureFiles),
}

pub struct Pictures {
    destination: Destination,
    projection: ProjectionArgs,
    coding: PictureCoding,
    sheet: Option<(PathBuf, ContactSheet)>,
    bytes: u64,
}

impl Pictures {
    /// Opens the destination. `fps` is the frame rate of streams.
    pub fn open(args: &Args, jobs: &[Job], (fps, look): (f64, Look), threads: Option<u16>) -> Result<Pictures> {
        let stream = args.stream.open(args.output.as_deref(), args.json, fps)?;
        let numbers: Vec<u32> = jobs.iter().flat_map(|job| &job.names).map(|name| name.number).collect();
        let destination = match (&args.output, stream) {
            (None, _) => Destination::Nowhere,
            (_, Some(stream)) => {
                one_size(jobs, Path::new("-"))?;
                Destination::StandardOutput(stream)
            }
            (Some(path), None) if is_film(path) => {
                let format = FilmFormat {
                    size: args.projection.joined_size(one_size(jobs, path)?),
                    fps,
                    transfer: look.transfer(),
                    threads,
                };
                Destination::Film(Box::new(Film::create(path, format)?))
            }
            (Some(path), None) => Self::files(path, &numbers, args)?,
        };
        if let Some(sheet) = &args.contact_sheet
            && sheet != Path::new("-")
            && FileFormat::of(sheet) != Some(FileFormat::Png)
        {
            return refuse(format!("{}: a contact sheet needs a file name ending in .png", sheet.display()));
        }
        let sheet = args.contact_sheet.clone().map(|path| (path, ContactSheet::default()));
        Ok(Pictures {
            destination,
            projection: args.projection.clone(),
            coding: PictureCoding { look, holes: args.march.holes },
            sheet,
            bytes: 0,
        })
    }

    fn files(path: &Path, numbers: &[u32], args: &Args) -> Result<Destination> {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let has_eyes = has_word(path);
        let Some(format) = FileFormat::of(path) else {
            let file =
                name.contains('%') || path.extension().is_some_and(|ending| !ending.is_empty() && !path.is_dir());
            if file || has_eyes {
                return refuse(format!(
                    "{}: file names ending in .png or .exr were expected, a film ({FILM_ENDINGS}), or a folder",
                    path.display()
                ));
            }
            return Ok(Destination::Folder(PictureFiles::in_folder(path)?));
        };
        let pattern = Pattern::parse(&name.replace(WORD_FIELD, "")).map_err(|error| error.in_file(path))?;
        let count = numbers.len();
        if !pattern.has_field() && args.shard.is_some() {
            return refuse(format!(
                "{}: --shard cannot write to a single file: use a pattern such as view.%04d.png, or a folder",
                path.display(),
            ));
        }
        if !pattern.has_field() && count != 1 {
            return refuse(format!(
                "{}: one file for {count} pictures: use a pattern such as view.%04d.png, or a folder",
                path.display(),
            ));
        }
        let numbers = numbers.iter().collect::<BTreeSet<_>>().len();
        if numbers != count {
            return refuse(format!(
                "{}: {count} pictures have only {numbers} different frame numbers: use a folder, whose file names \
                include probe and face",
                path.display(),
            ));
        }
        if has_eyes && args.projection.stereo.is_none() {
            return refuse(format!(
                "{}: {WORD_FIELD} needs --stereo: add --stereo, or leave out {WORD_FIELD}",
                path.display()
            ));
        }
        Ok(Destination::Files(PictureFiles::create(path, format)?))
    }

    /// Returns the files of a picture, and its words: one, or one for each eye.
    fn words<'a>(&'a self, name: &'a PictureName) -> (Option<&'a PictureFiles>, Vec<&'a str>) {
        match &self.destination {
            Destination::Nowhere | Destination::StandardOutput(_) | Destination::Film(_) => (None, Vec::new()),
            Destination::Folder(files) => (Some(files), vec![&name.subject]),
            Destination::Files(files) => (Some(files), if files.has_word() { EYES.to_vec() } else { vec![""] }),
        }
    }

    /// Returns the paths, from the current directory, of the files to which a picture is written.
    pub fn files_of(&self, name: &PictureName) -> Result<Vec<PathBuf>> {
        let (files, words) = self.words(name);
        files.map_or(Ok(Vec::new()), |files| words.iter().map(|word| files.path(word, name.number)).collect())
    }

    /// Writes a picture composed of images, which are sorted by eye and then by face. Both eyes are joined unless the
    /// pattern has a field for the eye.
    pub fn put(&mut self, name: &PictureName, job: &Job, images: &[RenderedImage]) -> Result<()> {
        let eyes: Vec<RenderedImage> = images
            .chunks(self.projection.faces() as usize)
            .map(|faces| tiled(faces, CUBE_COLUMNS))
            .collect::<Result<_>>()?;
        let joined = tiled(&eyes, self.projection.eyes_in_row())?;
        if let Some((_, sheet)) = &mut self.sheet {
            sheet.add(job.caption(name), &self.coding.look.rgba_codes(&joined));
        }
        match &mut self.destination {
            Destination::StandardOutput(stream) => {
                stream.put(&CodePicture::Rgba8(self.coding.look.rgba_codes(&joined)))?;
                self.bytes = stream.bytes;
                return Ok(());
            }
            Destination::Film(film) => return film.put(&CodePicture::Rgba8(self.coding.look.rgba_codes(&joined))),
            Destination::Nowhere | Destination::Files(_) | Destination::Folder(_) => {}
        }
        let (Some(files), words) = self.words(name) else { return Ok(()) };
        let pictures = if words.len() > 1 { &eyes[..] } else { std::slice::from_ref(&joined) };
        let mut bytes = 0;
        for (word, picture) in words.iter().zip(pictures) {
            bytes += files.write((word, name.number), picture, &self.coding)?;
        }
        self.bytes += bytes;
        Ok(())
    }

    /// Moves all files into place. Returns the number of bytes written, without the contact sheet.
    pub fn commit(self, monitor: &dyn Monitor) -> Result<u64> {
        let bytes = match self.destination {
            Destination::Nowhere | Destination::StandardOutput(_) => self.bytes,
            Destination::Film(film) => film.commit(monitor)?,
            Destination::Files(files) | Destination::Folder(files) => {
                files.commit()?;
                self.bytes
            }
        };
        if let Some((path, sheet)) = self.sheet.filter(|(_, sheet)| !sheet.is_empty()) {
            let mut file = OutputFile::create(&path)?;
            png::encode_color8(&mut file, &sheet.draw()?).map_err(|error| error.in_file(&path))?;
            file.commit()?;
        }
        Ok(bytes)
    }
}

/// Returns the size of all pictures. Fails if a stream cannot hold them because they have several.
fn one_size(jobs: &[Job], path: &Path) -> Result<[u32; 2]> {
    let first = jobs.first().map_or([0, 0], |job| job.size);
    match jobs.iter().find(|job| job.size != first) {
        None => Ok(first),
        Some(job) => {
            let [[a, b], [c, d]] = [first, job.size];
            refuse(format!(
                "-o {}: all pictures of a stream must have one size, and these have {a}x{b} and {c}x{d} pixels: write \
                them into a folder",
                path.display()
            ))
        }
    }
}

/// Tiles images of equal size row by row.
fn tiled(images: &[RenderedImage], in_row: u32) -> Result<RenderedImage> {
    let [first, rest @ ..] = images else { return Err(Error::invalid("a picture of no eye")) };
    if rest.is_empty() {
        return Ok(first.clone());
    }
    let (width, height) = (first.color.width(), first.color.height());
    let in_row = in_row.min(images.len() as u32);
    let all = [width * in_row, height * (images.len() as u32).div_ceil(in_row)];
    let of = |x: u32, y: u32| (&images[(y / height * in_row + x / width) as usize], x % width, y % height);
    fn plane<T: Copy>([width, height]: [u32; 2], value: impl Fn(u32, u32) -> T) -> Plane<T> {
        Plane::from_fn(width, height, value)
    }
    let aov = |number: usize| Aov {
        channel: first.aovs[number].channel,
        plane: plane(all, |x, y| {
            let (image, x, y) = of(x, y);
            image.aovs[number].plane.get(x, y)
        }),
    };
    Ok(RenderedImage {
        color: plane(all, |x, y| {
            let (image, x, y) = of(x, y);
            image.color.get(x, y)
        }),
        alpha: plane(all, |x, y| {
            let (image, x, y) = of(x, y);
            image.alpha.get(x, y)
        }),
        primaries: first.primaries,
        aovs: (0..first.aovs.len()).map(aov).collect(),
    })
}

pub fn pixels(size: [u32; 2]) -> u64 {
    size.into_iter().map(u64::from).product()
}
