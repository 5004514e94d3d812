//! The frame that views show: decodes into the texels of a light field (CALF 6.2).
//!
//! Enters: an open container, and the number of a frame. Leaves: the light field in that frame.

use crate::dataset::stream::StreamKind;
use crate::depth::quantise::DepthRange;
use crate::error::{Error, Result};
use crate::image::FrameRange;
use crate::reconstruct::light_field::{ColorCoding, ColorTexels, FaceTexels, InverseDepth, LightField, View};
use crate::reconstruct::selection::Candidate;
use crate::video::codec::{CodecHeader, ColorFormat};
use crate::video::decode::{Decoder, FaceDecoder, Picture, StreamInfo};
use crate::video::unit_filter::UnitFilter;

/// Which probes of a container are shown. Nothing chosen: all.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct ProbeChoice {
    /// Names of those that are shown; empty: all.
    pub only: Vec<String>,
    /// Names of those that are not.
    pub without: Vec<String>,
}

/// A rectangle of a face whose texels changed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Change {
    /// Index of the view in the light field.
    pub view: usize,
    /// Number of the face.
    pub face: usize,
    /// Which of its texels.
    pub kind: StreamKind,
    /// Left, top, width and height in texels.
    pub rect: [u32; 4],
}

/// What it took to show a frame.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct ShowCounts {
    /// Tiles and cells whose pixels changed.
    pub cells_decoded: u64,
    /// Tiles and cells that are wanted and already showed the frame.
    pub cells_unchanged: u64,
    /// Tiles and cells of probes that have the frame and are not wanted.
    pub cells_unseen: u64,
    /// Texels that were written.
    pub texels_updated: u64,
    /// Stored bytes that were read.
    pub bytes_read: u64,
}

impl ShowCounts {
    /// Tiles and cells that were not decoded.
    pub fn cells_skipped(&self) -> u64 {
        self.cells_unchanged + self.cells_unseen
    }

    /// The sum of two.
    #[must_use]
    pub fn plus(self, other: ShowCounts) -> ShowCounts {
        ShowCounts {
            cells_decoded: self.cells_decoded + other.cells_decoded,
            cells_unchanged: self.cells_unchanged + other.cells_unchanged,
            cells_unseen: self.cells_unseen + other.cells_unseen,
            texels_updated: self.texels_updated + other.texels_updated,
            bytes_read: self.bytes_read + other.bytes_read,
        }
    }
}

/// Shows frames of a container.
#[derive(Debug)]
pub struct Player<'a> {
    streams: Vec<Stream<'a>>,
    field: LightField,
    changes: Vec<Change>,
}

/// What a stream is decoded with, and where to.
#[derive(Debug)]
struct Stream<'a> {
    info: &'a StreamInfo,
    decoder: FaceDecoder<'a>,
    /// Index of its view in the light field.
    view: usize,
    /// Of a stream of depth.
    inverse: Option<InverseDepth>,
}

impl<'a> Player<'a> {
    /// A player of all probes that have a face with both colour and depth. Nothing is known until a frame is shown.
    ///
    /// # Errors
    /// When there is no such probe, images of a face differ in size, or colours are coded in more than one way.
    pub fn new(decoder: &'a Decoder, probes: &ProbeChoice) -> Result<Player<'a>> {
        let all = decoder.streams();
        let of = |probe, face, kind| all.iter().find(|s| s.probe == probe && s.face == face && s.kind == kind);
        let (mut views, mut streams, mut coding) = (Vec::<View>::new(), Vec::new(), None);
        for depth in all.iter().filter(|stream| stream.kind == StreamKind::Depth) {
            let name = &decoder.probe(depth).name;
            if probes.without.contains(name) || !(probes.only.is_empty() || probes.only.contains(name)) {
                continue;
            }
            let Some(color) = of(depth.probe, depth.face, StreamKind::Color) else { continue };
            let material = of(depth.probe, depth.face, StreamKind::Material);
            let CodecHeader::Depth(header) = depth.header else { continue };
            let CodecHeader::Color(color_header) = color.header else { continue };
            let coded = match color_header.format {
                ColorFormat::EightBit(tone) => ColorCoding::Codes(tone),
                _ => ColorCoding::Light,
            };
            if *coding.get_or_insert(coded) != coded {
                return Err(Error::unsupported(
                    "colours of one light field are coded in more than one way: encode them alike",
                ));
            }
            let entry = decoder.probe(depth);
            let view = match views.iter().position(|view| view.probe == depth.probe) {
                Some(at) => at,
                None => {
                    let range = views_range(all, depth.probe).unwrap_or(header.range);
                    views.push(View::new(depth.probe, entry, range)?);
                    views.len() - 1
                }
            };
            let size = [depth.entry.width, depth.entry.height];
            for other in [Some(color), material].into_iter().flatten() {
                if [other.entry.width, other.entry.height] != size {
                    return Err(Error::unsupported(format!(
                        "probe {}, face {}: {} has {}x{} pixels and depth {}x{}: rendering takes images of one size",
                        entry.name,
                        depth.face.name(),
                        other.kind.name(),
                        other.entry.width,
                        other.entry.height,
                        size[0],
                        size[1]
                    )));
                }
            }
            let map = View::image_map(entry, depth.face, size);
            let inverse = InverseDepth::new(header.range, header.kind);
            views[view].faces[depth.face as usize] = Some(FaceTexels::unknown(size, map, coded, material.is_some()));
            let mut push = |info, inverse| streams.push(Stream { info, decoder: decoder.face(info), view, inverse });
            push(depth, Some(inverse));
            push(color, None);
            material.into_iter().for_each(|material| push(material, None));
        }
        let coding = coding.ok_or_else(|| {
            Error::Usage("no probe of this container has both colour and depth, which rendering takes".into())
        })?;
        Ok(Player { streams, field: LightField { views, coding }, changes: Vec::new() })
    }

    /// The light field as it was shown last.
    pub fn field(&self) -> &LightField {
        &self.field
    }

    /// Whether probes have a stream of materials.
    pub fn has_material(&self) -> bool {
        self.field.has_material()
    }

    /// All frames that a view has, from the first to the last.
    pub fn frames(&self) -> FrameRange {
        let frames = || self.streams.iter().map(|stream| stream.info.frames);
        let first = frames().map(|frames| frames.first).min().unwrap_or_default();
        FrameRange { first, last: frames().map(|frames| frames.last).max().unwrap_or(first) }
    }

    /// The views that have a frame, as candidates for a selection.
    pub fn candidates(&self, frame: u32) -> Vec<Candidate> {
        let has =
            |view: usize| self.streams.iter().any(|stream| stream.view == view && stream.info.frames.contains(frame));
        let views = self.field.views.iter().enumerate().filter(|(view, _)| has(*view));
        views.map(|(view, known)| Candidate { view, position: known.position }).collect()
    }

    /// The streams of views (indices into [`LightField::views`]) that have a frame.
    pub fn streams_of(&self, frame: u32, views: &[usize]) -> Vec<&'a StreamInfo> {
        let of = |stream: &&Stream<'a>| views.contains(&stream.view) && stream.info.frames.contains(frame);
        self.streams.iter().filter(of).map(|stream| stream.info).collect()
    }

    /// What changed since this was asked last, at first everything.
    pub fn take_changes(&mut self) -> Vec<Change> {
        std::mem::take(&mut self.changes)
    }

    /// Shows a frame of some views (indices into [`LightField::views`]), as far as the filter wants it. What is not shown
    /// becomes [`super::light_field::UNKNOWN`].
    ///
    /// # Errors
    /// When no view has the frame, or it cannot be decoded.
    pub fn show(&mut self, frame: u32, views: &[usize], filter: &dyn UnitFilter) -> Result<ShowCounts> {
        let mut counts = ShowCounts::default();
        for stream in &mut self.streams {
            if !views.contains(&stream.view) || !stream.info.frames.contains(frame) {
                continue;
            }
            let before = stream.decoder.cost();
            let picture = stream.decoder.decode_wanted(frame, filter)?;
            counts.bytes_read += stream.decoder.cost().bytes_read - before.bytes_read;
            counts.texels_updated += stream.decoder.cost().updated_pixels - before.updated_pixels;
            let view = &mut self.field.views[stream.view];
            let face = stream.info.face as usize;
            if let Some(texels) = &mut view.faces[face] {
                put(texels, &picture, stream.inverse.as_ref());
                let rect = [0, 0, texels.size[0], texels.size[1]];
                self.changes.push(Change { view: stream.view, face, kind: stream.info.kind, rect });
            }
        }
        Ok(counts)
    }

    /// Stored bytes of all chunks of the shown probes that hold a frame which was shown.
    pub fn bytes_all(&self) -> u64 {
        0
    }
}

/// Near and far over all faces of a probe.
fn views_range(streams: &[StreamInfo], probe: usize) -> Option<DepthRange> {
    let ranges = streams.iter().filter(|stream| stream.probe == probe).filter_map(|stream| match stream.header {
        CodecHeader::Depth(header) => Some([header.range.near_m(), header.range.far_m()]),
        _ => None,
    });
    let [near, far] = ranges.reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])])?;
    DepthRange::new(near, far).ok()
}

fn put(face: &mut FaceTexels, picture: &Picture, inverse: Option<&InverseDepth>) {
    let width = face.size[0];
    match picture {
        Picture::Depth(plane) => {
            let Some(inverse) = inverse else { return };
            let texels = (0u32..).zip(plane.data()).map(|(at, &code)| inverse.of(code, face, at % width, at / width));
            face.inverse_depth = texels.collect();
        }
        Picture::Color8(plane) => {
            if let ColorTexels::Codes(texels) = &mut face.color {
                texels.iter_mut().zip(plane.data()).for_each(|(texel, &[r, g, b])| *texel = [r, g, b, 0]);
            }
        }
        Picture::ColorHalf(plane) => {
            if let ColorTexels::Light(texels) = &mut face.color {
                texels.iter_mut().zip(plane.data()).for_each(|(texel, &[r, g, b])| *texel = [r, g, b, half::f16::ZERO]);
            }
        }
        Picture::Material(plane) => {
            if let Some(texels) = &mut face.material {
                texels.iter_mut().zip(plane.data()).for_each(|(texel, &[a, b, c])| *texel = [a, b, c, 0]);
            }
        }
    }
}
