//! Crops of the same place in the source and in the decoded pictures of all points of a coding sweep.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use data_encoding::BASE64;

use super::point::{Measured, Point};
use super::study::Results;
use crate::report::picture::shown::srgb;
use crate::report::plot::number;
use crate::report::plot::palette::{Rgb, grey};
use crate::report::plot::save::escape;
use codec::decode::{Decoder, Picture};
use codec::error::{Error, Result};
use codec::image::plane::Plane;
use codec::image::transfer::{EncodeTable, ToneMap};
use codec::image::{Face, StreamKind};
use codec::streams::{CodecHeader, convert};
use footage::dataset::Source;
use footage::dataset::source::SourceGroup;
use footage::files::write_whole;
use footage::image_files::png;

/// Maximum width and height of a crop in pixels.
const SIDE: u32 = 96;
/// Distance in pixels between the places that are tried.
const STEP: usize = 16;

/// The place with most detail in a picture of the source, and its pixels there.
#[derive(Debug)]
pub struct Crop {
    kind: StreamKind,
    probe: String,
    face: Face,
    frame: u32,
    origin: [u32; 2],
    size: [u32; 2],
    source: Pixels,
}

#[derive(Debug)]
enum Pixels {
    /// sRGB codes.
    Color(Plane<Rgb>),
    /// Metres, with +inf for background.
    Depth(Plane<f32>),
}

impl Pixels {
    fn cut(&self, origin: [u32; 2], size: [u32; 2]) -> Pixels {
        match self {
            Pixels::Color(plane) => Pixels::Color(plane.cut(origin, size)),
            Pixels::Depth(plane) => Pixels::Depth(plane.cut(origin, size)),
        }
    }

    /// Returns values of which differences are visible.
    fn detail(&self) -> Plane<f32> {
        match self {
            Pixels::Color(plane) => plane.map(|pixel| pixel.iter().map(|&code| f32::from(code)).sum()),
            // Background is far, too.
            Pixels::Depth(plane) => plane.map(|metres| metres.clamp(1e-3, 1e3).ln()),
        }
    }
}

impl Crop {
    /// Chooses the place with the largest sum of differences between neighbours, in the middle frame of the first colour or depth
    /// picture of a source. `None` for other kinds of streams and for sources without them.
    ///
    /// # Errors
    /// Fails if the file cannot be read.
    pub fn choose(source: &Source, kind: StreamKind) -> Result<Option<Crop>> {
        let Some(group) = source.groups().iter().find(|group| group.kind == kind) else { return Ok(None) };
        let frame = group.frames.first + (group.frames.last - group.frames.first) / 2;
        let Some(pixels) = read(source, group, frame)? else { return Ok(None) };
        let detail = pixels.detail();
        let size = [detail.width(), detail.height()].map(|side| side.min(SIDE));
        let origin = busiest(&detail, size);
        Ok(Some(Crop {
            kind,
            probe: source.probes()[group.probe].name.clone(),
            face: group.faces[0],
            frame,
            origin,
            size,
            source: pixels.cut(origin, size),
        }))
    }

    /// Writes the crop of the source as PNG into a folder.
    pub fn save_source(&self, folder: &Path) -> Result<()> {
        save(&self.drawn(&self.source), &source_file(folder, self.kind))
    }

    /// Writes the crop of a container of a point as PNG into a folder. Does nothing for points of other kinds of streams.
    ///
    /// # Errors
    /// Fails if the container does not have the picture.
    pub fn save(&self, container: &Path, point: &Point, folder: &Path) -> Result<()> {
        if point.stream != Some(self.kind) {
            return Ok(());
        }
        let decoder = Decoder::open(container)?;
        let is_here = |stream: &&codec::decode::StreamInfo| {
            stream.kind == self.kind && stream.face == self.face && decoder.probe(stream).name == self.probe
        };
        let missing = || Error::invalid(format!("it has no {} of probe {}", self.kind.name(), self.probe));
        let stream = decoder.streams().iter().find(is_here).ok_or_else(|| missing().in_file(container))?;
        let pixels = match (decoder.face(stream).decode(self.frame)?, &stream.header) {
            (Picture::Depth(codes), CodecHeader::Depth(header)) => {
                Pixels::Depth(codes.cut(self.origin, self.size).map(|&code| header.range.metres(code)))
            }
            (picture, header) => {
                let Some(codes) = srgb(header, &picture) else { return Ok(()) };
                Pixels::Color(codes.cut(self.origin, self.size))
            }
        };
        save(&self.drawn(&pixels), &point_file(folder, point))
    }

    /// Returns colour as it is, and depth in grey from the nearest to the farthest surface of the source.
    fn drawn(&self, pixels: &Pixels) -> Plane<Rgb> {
        match (pixels, &self.source) {
            (Pixels::Color(plane), _) => plane.clone(),
            (Pixels::Depth(plane), Pixels::Color(_)) => plane.map(|_| [0; 3]),
            (Pixels::Depth(plane), Pixels::Depth(source)) => {
                let logs =
                    || source.data().iter().filter(|metres| metres.is_finite()).map(|metres| f64::from(*metres).ln());
                let (near, far) = (logs().fold(f64::INFINITY, f64::min), logs().fold(f64::NEG_INFINITY, f64::max));
                let part = |metres: f32| (f64::from(metres).ln() - near) / (far - near).max(1e-9);
                plane.map(|&metres| if metres.is_finite() { grey(part(metres)) } else { [0; 3] })
            }
        }
    }
}

fn read(source: &Source, group: &SourceGroup, frame: u32) -> Result<Option<Pixels>> {
    Ok(match group.kind {
        StreamKind::Color => source
            .read_color(group, frame)?
            .into_iter()
            .next()
            .map(|plane| Pixels::Color(convert::color_codes(&plane, &EncodeTable::new(&ToneMap::default())).0)),
        StreamKind::Depth => source.read_depth(group, frame)?.into_iter().next().map(Pixels::Depth),
        StreamKind::Material | StreamKind::Alpha => None,
    })
}

/// Returns the origin of the window with the largest sum of differences between neighbours; the first of equal ones.
fn busiest(detail: &Plane<f32>, [width, height]: [u32; 2]) -> [u32; 2] {
    let sum = |left: u32, top: u32| -> f32 {
        let rows = top..top + height - 1;
        let row = |y: u32| -> f32 {
            let (this, next) = (detail.row(y), detail.row(y + 1));
            let columns = left as usize..(left + width - 1) as usize;
            columns.map(|x| (this[x] - this[x + 1]).abs() + (this[x] - next[x]).abs()).sum()
        };
        rows.map(row).sum()
    };
    let tops = (0..=detail.height() - height).step_by(STEP);
    let places = tops.flat_map(|top| (0..=detail.width() - width).step_by(STEP).map(move |left| [left, top]));
    let mut best = ([0, 0], f32::NEG_INFINITY);
    for [left, top] in places {
        let found = sum(left, top);
        if found > best.1 {
            best = ([left, top], found);
        }
    }
    best.0
}

fn source_file(folder: &Path, kind: StreamKind) -> PathBuf {
    folder.join(format!("crop-{}-source.png", kind.name()))
}

fn point_file(folder: &Path, point: &Point) -> PathBuf {
    let kind = point.stream.map_or("", StreamKind::name);
    folder.join(format!("crop-{kind}-{:08x}.png", crc32fast::hash(point.words().as_bytes())))
}

fn save(pixels: &Plane<Rgb>, path: &Path) -> Result<()> {
    let mut bytes = Vec::new();
    png::encode_color8(&mut bytes, pixels).map_err(|error| error.in_file(path))?;
    write_whole(path, &bytes)
}

/// Returns the section of the page with all crops in a folder, and their files; empty if there are none.
pub fn section(results: &Results, folder: &Path) -> Result<(String, Vec<PathBuf>)> {
    let (mut out, mut files) = (String::new(), Vec::new());
    for kind in results.streams().into_iter().flatten() {
        let source = source_file(folder, kind);
        if !source.is_file() {
            continue;
        }
        let points: Vec<(&Measured, PathBuf)> = results
            .measured
            .iter()
            .filter(|of| of.point.stream == Some(kind))
            .map(|of| (of, point_file(folder, &of.point)))
            .filter(|(_, path)| path.is_file())
            .collect();
        let _ = write!(out, "<h3>{}</h3>\n<div class=\"crops\">\n", escape(kind.name()));
        let read = |path: &Path| std::fs::read(path).map_err(|error| Error::io(path, error));
        let bytes_of_source = read(&source)?;
        out += &item(&bytes_of_source, "source");
        let mut equal = Vec::new();
        for (of, path) in &points {
            let bytes = read(path)?;
            if bytes == bytes_of_source {
                equal.push(of.point.words());
                continue;
            }
            let container = number::bytes(of.count("bytes_container") as f64);
            out += &item(&bytes, &format!("{}: {container}, {}", of.point.words(), of.quality_words()));
        }
        out += "</div>\n";
        if !equal.is_empty() {
            let _ = writeln!(out, "<p class=\"small\">Equal to the source: {}.</p>", escape(&equal.join("; ")));
        }
        files.push(source);
        files.extend(points.into_iter().map(|(_, path)| path));
    }
    match out.is_empty() {
        true => Ok((out, files)),
        false => Ok((format!("<h2 id=\"pictures\">Pictures</h2>\n{out}"), files)),
    }
}

fn item(png: &[u8], words: &str) -> String {
    let words = escape(words);
    format!("<div><img alt=\"{words}\" src=\"data:image/png;base64,{}\"><p>{words}</p></div>\n", BASE64.encode(png))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_busiest_window_is_found_at_steps() {
        let noise = |x: u32, y: u32| if x >= 64 && y >= 32 && (x + y).is_multiple_of(2) { 1.0 } else { 0.0 };
        let detail = Plane::from_fn(100, 80, noise);
        assert_eq!(busiest(&detail, [32, 32]), [64, 32]);
        assert_eq!(busiest(&Plane::filled(8, 8, 1.0), [8, 8]), [0, 0]);
    }
}
