//! Probe views from images in metres and light: of a dataset, or captured. Nothing is encoded.

use half::f16;

use crate::container::ProbeEntry;
use crate::dataset::{Pose, Source, SourceGroup};
use crate::depth::DepthRange;
use crate::error::{Error, Result};
use crate::image::{ColorPlane, DepthKind, DepthPlane, Face, MaterialPlane, Primaries, StreamKind, TexelMap};
use crate::streams::convert::material_codes;
use crate::views::{BACKGROUND, ColorCoding, ColorTexels, FaceTexels, LightField, View};

/// The images of a face; all have the same size.
#[derive(Debug, Clone)]
pub struct FaceImages {
    pub face: Face,
    /// Linear light.
    pub color: ColorPlane,
    /// Metres; +inf for background.
    pub depth: DepthPlane,
    pub kind: DepthKind,
    /// Weights of reflection and refraction, and index of refraction.
    pub material: Option<MaterialPlane>,
}

impl FaceImages {
    fn texels(&self, entry: &ProbeEntry, coding: ColorCoding) -> Result<FaceTexels> {
        let size = [self.color.width(), self.color.height()];
        let mut texels = FaceTexels::unknown(size, TexelMap::of_face(self.face, size, entry.intrinsics), coding);
        for (at, &metres) in (0u32..).zip(self.depth.data()) {
            let inverse = match self.kind {
                DepthKind::Planar => 1.0 / metres,
                DepthKind::Distance => 1.0 / metres * texels.map.ray_length_factor(at % size[0], at / size[0]),
            };
            texels.inverse_depth[at as usize] = BACKGROUND.max(inverse);
        }
        let color = self.color.data().iter();
        texels.color = match coding {
            ColorCoding::Codes(tone) => {
                let code = |value: f16| tone.code(value.to_f32());
                ColorTexels::Codes(color.map(|&[r, g, b]| [code(r), code(g), code(b), 0]).collect())
            }
            ColorCoding::Light => ColorTexels::Light(color.map(|&[r, g, b]| [r, g, b, f16::ZERO]).collect()),
        };
        if let Some(material) = &self.material {
            let codes = material_codes(material)?;
            texels.material = Some(codes.data().iter().map(|&[a, b, c]| [a, b, c, 0]).collect());
            texels.update_specular();
        }
        Ok(texels)
    }
}

/// The view of a probe; near and far are those of its images.
pub fn from_images(probe: usize, entry: &ProbeEntry, images: &[FaceImages], coding: ColorCoding) -> Result<View> {
    let finite = images.iter().flat_map(|image| image.depth.data()).filter(|metres| metres.is_finite());
    let (near, far) = finite.fold((f32::INFINITY, 0f32), |(near, far), &m| (near.min(m), far.max(m)));
    let range = if near < far { DepthRange::new(near, far)? } else { DepthRange::empty() };
    let mut view = View::new(probe, entry, range)?;
    for image in images {
        view.faces[image.face as usize] = Some(image.texels(entry, coding)?);
    }
    Ok(view)
}

/// The views of all probes of a dataset in a frame, in light of Rec. 709: their faces with both colour and depth.
pub fn from_dataset(source: &Source, frame: u32, coding: ColorCoding) -> Result<LightField> {
    let kind = source.depth_stored;
    let mut views = Vec::new();
    for (probe, info) in source.probes().iter().enumerate() {
        let groups = |kind: StreamKind| {
            let of_probe = move |group: &&SourceGroup| group.probe == probe && group.kind == kind;
            source.groups().iter().filter(of_probe).filter(|group| group.frames.contains(frame))
        };
        let mut images = Vec::new();
        for depths in groups(StreamKind::Depth) {
            let same_faces = |group: &&SourceGroup| group.faces == depths.faces;
            let Some(colors) = groups(StreamKind::Color).find(same_faces) else { continue };
            let mut materials = match groups(StreamKind::Material).find(same_faces) {
                Some(group) => source.read_material(group, frame)?.into_iter(),
                None => Vec::new().into_iter(),
            };
            let matrix = source.primaries().conversion_to(Primaries::REC709);
            let planes = source.read_depth(depths, frame)?.into_iter().zip(source.read_color(colors, frame)?);
            for (&face, (depth, color)) in depths.faces.iter().zip(planes) {
                let color = match matrix {
                    Some(matrix) => matrix.convert_plane(&color),
                    None => color,
                };
                images.push(FaceImages { face, color, depth, kind, material: materials.next() });
            }
        }
        if !images.is_empty() {
            let Pose { position, orientation, .. } = info.pose(frame);
            let entry = ProbeEntry {
                name: info.name.clone(),
                position,
                orientation,
                frames: [info.frames.first, info.frames.last],
                intrinsics: info.intrinsics.unwrap_or_default(),
            };
            views.push(from_images(probe, &entry, &images, coding)?);
        }
    }
    match views.is_empty() {
        true => Err(Error::Usage(format!("{}: no probe has colour and depth of frame {frame}", source.name()))),
        false => Ok(LightField { views, coding }),
    }
}
