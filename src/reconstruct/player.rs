//! The frame that views show: decodes into the texels of a light field (CALF 6.2).
//!
//! Enters: an open container, and the number of a frame. Leaves: the light field in that frame.

use crate::dataset::stream::StreamKind;
use crate::depth::quantise::DepthRange;
use crate::error::{Error, Result};
use crate::reconstruct::light_field::{ColorCoding, ColorTexels, FaceTexels, InverseDepth, LightField, View};
use crate::video::codec::{CodecHeader, ColorFormat};
use crate::video::decode::{Decoder, FaceDecoder, Picture, StreamInfo};
use crate::video::unit_filter::UnitFilter;

/// Shows frames of a container.
#[derive(Debug)]
pub struct Player<'a> {
    streams: Vec<Stream<'a>>,
    field: LightField,
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
    pub fn new(decoder: &'a Decoder) -> Result<Player<'a>> {
        let all = decoder.streams();
        let of = |probe, face, kind| all.iter().find(|s| s.probe == probe && s.face == face && s.kind == kind);
        let (mut views, mut streams, mut coding) = (Vec::<View>::new(), Vec::new(), None);
        for depth in all.iter().filter(|stream| stream.kind == StreamKind::Depth) {
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
        Ok(Player { streams, field: LightField { views, coding } })
    }

    /// The light field as it was shown last.
    pub fn field(&self) -> &LightField {
        &self.field
    }

    /// Shows a frame.
    ///
    /// # Errors
    /// When a stream does not have the frame, or cannot be decoded.
    pub fn show(&mut self, frame: u32, filter: &dyn UnitFilter) -> Result<()> {
        for stream in &mut self.streams {
            let picture = stream.decoder.decode_wanted(frame, filter)?;
            let view = &mut self.field.views[stream.view];
            if let Some(face) = &mut view.faces[stream.info.face as usize] {
                put(face, &picture, stream.inverse.as_ref());
            }
        }
        Ok(())
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
            face.depth_changed(0..width, 0..face.size[1]);
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
