//! Probe views of a dataset, without encoding.

use codec::container::ProbeEntry;
use codec::error::{Error, Result};
use codec::image::{Primaries, StreamKind};
use footage::dataset::{Pose, Source, SourceGroup};
use render::views::from_images::{FaceImages, from_images};
use render::views::{ColorCoding, LightField};

/// Reads the views of all probes of a dataset in a frame, in linear Rec. 709: their faces with both colour and depth. Fails if no
/// probe has such a face.
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
            let mut alphas = match groups(StreamKind::Alpha).find(same_faces) {
                Some(group) => source.read_alpha(group, frame)?.into_iter(),
                None => Vec::new().into_iter(),
            };
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
                let (alpha, material) = (alphas.next(), materials.next());
                images.push(FaceImages { face, color, alpha, depth, kind, material });
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
