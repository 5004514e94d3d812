//! Writes rendered images to files, a folder or standard output, and draws the contact sheet.

use std::collections::BTreeSet;
use std::io::Write;
use std::path::{Path, PathBuf};

use glam::DVec3;

use super::args::Args;
use crate::cli::picture_files::{PictureCoding, PictureFiles, WORD_FIELD, has_word};
use crate::cli::refuse;
use crate::decode::FileFormat;
use crate::error::{Error, Result};
use crate::evaluate::frame_requests::FrameRequest;
use crate::evaluate::rendered_image::{Aov, HoleFill, RenderedImage};
use crate::files::OutputFile;
use crate::image::plane::Plane;
use crate::image::png;
use crate::image::sequence::Pattern;
use crate::image::transfer::ToneMap;
use crate::math::Camera;
use crate::report::picture::contact_sheet::ContactSheet;

const EYES: [&str; 2] = ["left", "right"];

#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PictureName {
    /// Its number in patterns: the frame, or the place of its camera where several look in one frame.
    pub number: u32,
    /// What it shows, for files in a folder and for the contact sheet: `view`, or probe and face of a reference.
    pub subject: String,
}

impl PictureName {
    pub fn png(&self) -> String {
        format!("{}.{:04}.png", self.subject, self.number)
    }
}

/// Images to render at once, for one frame.
pub struct Job {
    pub request: FrameRequest,
    /// Name of each image; stereo pairs have one.
    pub names: Vec<PictureName>,
    pub size: [u32; 2],
    /// Indices of reference images, in the order of the cameras.
    pub references: Vec<usize>,
}

impl Job {
    /// What a picture shows, in which frame and from where in metres.
    fn caption(&self, name: &PictureName) -> String {
        let eyes = self.request.cameras.len() / self.names.len().max(1);
        let at = self.names.iter().position(|other| other == name).unwrap_or(0) * eyes;
        let cameras = &self.request.cameras[at..at + eyes];
        let [x, y, z] = (cameras.iter().map(Camera::eye).sum::<DVec3>() / eyes.max(1) as f64).to_array();
        let frame = self.request.frame;
        let number = if name.number == frame { String::new() } else { format!(" {}", name.number) };
        format!("{}{number}, frame {frame}, eye {x:.2},{y:.2},{z:.2}", name.subject)
    }
}

enum Destination {
    Nowhere,
    StandardOutput,
    /// The word in their names is the eye.
    Files(PictureFiles),
    /// The word is what pictures show.
    Folder(PictureFiles),
}

pub struct Pictures {
    destination: Destination,
    tone: ToneMap,
    holes: HoleFill,
    sheet: Option<(PathBuf, ContactSheet)>,
    pub bytes: u64,
}

impl Pictures {
    pub fn open(args: &Args, jobs: &[Job], tone: ToneMap) -> Result<Pictures> {
        let numbers: Vec<u32> = jobs.iter().flat_map(|job| &job.names).map(|name| name.number).collect();
        let destination = match &args.output {
            None => Destination::Nowhere,
            Some(path) if path == Path::new("-") => match numbers.len() {
                1 => Destination::StandardOutput,
                count => {
                    return refuse(format!(
                        "-o -: standard output takes one picture, and {count} are rendered; name a pattern such as \
                         view.%04d.png"
                    ));
                }
            },
            Some(path) => Self::files(path, &numbers, args.stereo.is_some())?,
        };
        if let Some(sheet) = &args.contact_sheet
            && sheet != Path::new("-")
            && FileFormat::of(sheet) != Some(FileFormat::Png)
        {
            return refuse(format!("{}: a contact sheet is a file ending in .png", sheet.display()));
        }
        let sheet = args.contact_sheet.clone().map(|path| (path, ContactSheet::default()));
        Ok(Pictures { destination, tone, holes: args.march.holes, sheet, bytes: 0 })
    }

    fn files(path: &Path, numbers: &[u32], is_stereo: bool) -> Result<Destination> {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let has_eyes = has_word(path);
        let Some(format) = FileFormat::of(path) else {
            let file =
                name.contains('%') || path.extension().is_some_and(|ending| !ending.is_empty() && !path.is_dir());
            if file || has_eyes {
                return refuse(format!(
                    "{}: file names ending in .png or .exr were expected, or a folder",
                    path.display()
                ));
            }
            return Ok(Destination::Folder(PictureFiles::in_folder(path)?));
        };
        let pattern = Pattern::parse(&name.replace(WORD_FIELD, "")).map_err(|error| error.in_file(path))?;
        let count = numbers.len();
        if !pattern.has_field() && count != 1 {
            return refuse(format!(
                "{}: one file, and {count} pictures are asked for; name a pattern such as view.%04d.png, or a folder",
                path.display(),
            ));
        }
        let numbers = numbers.iter().collect::<BTreeSet<_>>().len();
        if numbers != count {
            return refuse(format!(
                "{}: {count} pictures are asked for, and their frames tell {numbers} of them apart; name a folder, where \
                 file names tell probes and faces apart",
                path.display(),
            ));
        }
        if has_eyes && !is_stereo {
            return refuse(format!(
                "{}: {WORD_FIELD} stands for the eye, and there is one; add --stereo, or leave it out",
                path.display()
            ));
        }
        Ok(Destination::Files(PictureFiles::create(path, format)?))
    }

    /// The files of a picture, by their words: one, or one for each eye.
    fn words<'a>(&'a self, name: &'a PictureName) -> (Option<&'a PictureFiles>, Vec<&'a str>) {
        match &self.destination {
            Destination::Nowhere | Destination::StandardOutput => (None, Vec::new()),
            Destination::Folder(files) => (Some(files), vec![&name.subject]),
            Destination::Files(files) => (Some(files), if files.has_word() { EYES.to_vec() } else { vec![""] }),
        }
    }

    /// The files that a picture is written to, as paths from here.
    pub fn files_of(&self, name: &PictureName) -> Result<Vec<PathBuf>> {
        let (files, words) = self.words(name);
        files.map_or(Ok(Vec::new()), |files| words.iter().map(|word| files.path(word, name.number)).collect())
    }

    /// Writes one image, or those of both eyes: side by side unless the pattern has a field for the eye.
    pub fn put(&mut self, name: &PictureName, job: &Job, eyes: &[RenderedImage]) -> Result<()> {
        let joined = beside(eyes)?;
        if let Some((_, sheet)) = &mut self.sheet {
            sheet.add(job.caption(name), &joined.rgba_codes(self.tone));
        }
        if matches!(self.destination, Destination::StandardOutput) {
            return self.print(&joined);
        }
        let (Some(files), words) = self.words(name) else { return Ok(()) };
        let pictures = if words.len() > 1 { eyes } else { std::slice::from_ref(&joined) };
        let coding = PictureCoding { tone: self.tone, holes: self.holes };
        let mut bytes = 0;
        for (word, picture) in words.iter().zip(pictures) {
            bytes += files.write((word, name.number), picture, coding)?;
        }
        self.bytes += bytes;
        Ok(())
    }

    fn print(&mut self, picture: &RenderedImage) -> Result<()> {
        let mut bytes = Vec::new();
        png::encode_rgba8(&mut bytes, &picture.rgba_codes(self.tone))?;
        self.bytes += bytes.len() as u64;
        let mut out = std::io::stdout().lock();
        out.write_all(&bytes).and_then(|()| out.flush()).map_err(|error| Error::io("-", error))
    }

    pub fn commit(self) -> Result<()> {
        match self.destination {
            Destination::Nowhere | Destination::StandardOutput => {}
            Destination::Files(files) | Destination::Folder(files) => files.commit()?,
        }
        let Some((path, sheet)) = self.sheet.filter(|(_, sheet)| !sheet.is_empty()) else { return Ok(()) };
        let mut file = OutputFile::create(&path)?;
        png::encode_color8(&mut file, &sheet.draw()?).map_err(|error| error.in_file(&path))?;
        file.commit()
    }
}

fn beside(eyes: &[RenderedImage]) -> Result<RenderedImage> {
    let [first, rest @ ..] = eyes else { return Err(Error::invalid("a picture of no eye")) };
    if rest.is_empty() {
        return Ok(first.clone());
    }
    let (width, height) = (first.color.width(), first.color.height());
    let at = |x: u32| (&eyes[(x / width) as usize], x % width);
    let all = width * eyes.len() as u32;
    let aov = |number: usize| Aov {
        channel: first.aovs[number].channel,
        plane: Plane::from_fn(all, height, |x, y| at(x).0.aovs[number].plane.get(at(x).1, y)),
    };
    Ok(RenderedImage {
        color: Plane::from_fn(all, height, |x, y| at(x).0.color.get(at(x).1, y)),
        alpha: Plane::from_fn(all, height, |x, y| at(x).0.alpha.get(at(x).1, y)),
        primaries: first.primaries,
        aovs: (0..first.aovs.len()).map(aov).collect(),
    })
}

pub fn pixels(size: [u32; 2]) -> u64 {
    size.into_iter().map(u64::from).product()
}
