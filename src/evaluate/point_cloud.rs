//! Exports the surfaces in a frame of a light field as a point cloud in a PLY file.
//!
//! Input: colour and distances of images, and their cameras. Output: binary little-endian PLY with one vertex per pixel that
//! shows a surface: x, y, z in metres in the world (float), red, green, blue in sRGB (uchar).

use std::io::Write;

use rayon::prelude::*;

use crate::reference::Reference;
use codec::error::{Error, Result};
use codec::image::{CodeSteps, ToneMap};
use codec::monitor::Monitor;

/// Size of a vertex in bytes.
pub const POINT_BYTES: u64 = 3 * 4 + 3;

/// Writes the points of images in a frame; returns their number. `images` are indices into [`Reference::images`], of images with
/// depth. Points are in the order of `images`, then in row order. The monitor advances by one for each image.
pub fn write_ply(
    reference: &mut Reference,
    images: &[usize],
    frame: u32,
    out: &mut dyn Write,
    monitor: &dyn Monitor,
) -> Result<u64> {
    let mut points = Vec::new();
    for &image in images {
        monitor.check()?;
        let about = reference.images.get(image).cloned();
        let about = about.ok_or_else(|| Error::Usage(format!("there is no image {image}")))?;
        let distance_m = reference.distance_m(image, frame)?.ok_or_else(|| {
            let (probe, face) = (&about.probe, about.face.name());
            Error::invalid(format!("probe {probe}, face {face}: there is no depth, which a point cloud needs"))
        })?;
        let color = reference.truth(image, frame)?.color;
        let steps = CodeSteps::new(ToneMap::default());
        let [width, height] = about.size;
        let camera = about.camera(frame);
        let row = |y: u32| {
            let mut bytes = Vec::new();
            for x in 0..width {
                let metres = f64::from(distance_m.get(x, y));
                if !metres.is_finite() {
                    continue;
                }
                let at = [(x, width), (y, height)].map(|(at, of)| (f64::from(at) + 0.5) / f64::from(of));
                let point = (camera.eye() + camera.direction(at) * metres).as_vec3();
                bytes.extend(point.to_array().into_iter().flat_map(f32::to_le_bytes));
                bytes.extend(color.get(x, y).map(|light| steps.code(light.to_f32())));
            }
            bytes
        };
        let rows: Vec<Vec<u8>> = (0..height).into_par_iter().map(row).collect();
        rows.into_iter().for_each(|row| points.extend(row));
        monitor.advance(1);
    }
    let count = points.len() as u64 / POINT_BYTES;
    let head = format!(
        "ply\nformat binary_little_endian 1.0\ncomment frame {frame}, metres, sRGB\nelement vertex {count}\nproperty float x\nproperty float y\n\
         property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n"
    );
    let written = out.write_all(head.as_bytes()).and_then(|()| out.write_all(&points));
    written.map_err(|error| Error::io("", error))?;
    Ok(count)
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use codec::monitor::Silent;
    use scene::{DemoKind, FootagePlan};

    #[test]
    fn points_lie_on_the_rays_of_pixels_at_their_distances() {
        let folder = tempfile::tempdir().unwrap();
        let plan = FootagePlan { kind: DemoKind::Courtyard, frames: 1, face_size: 8, probes: 2 };
        plan.write(folder.path(), &Silent).unwrap();
        let mut reference = Reference::open(folder.path()).unwrap();
        // Face nx of the second probe.
        let image = reference.images.iter().rposition(|image| image.face == codec::image::Face::Nx).unwrap();
        let distance_m = reference.distance_m(image, 0).unwrap().unwrap();
        let mut bytes = Vec::new();
        let count = write_ply(&mut reference, &[image], 0, &mut bytes, &Silent).unwrap();
        let body = bytes.len() - count as usize * POINT_BYTES as usize;
        let head = String::from_utf8(bytes[..body].to_vec()).unwrap();
        assert!(head.ends_with("end_header\n") && head.contains(&format!("element vertex {count}\n")), "{head}");
        let mut vertices = bytes[body..].chunks_exact(POINT_BYTES as usize);
        let about = reference.images[image].clone();
        let color = reference.truth(image, 0).unwrap().color;
        for (x, y) in (0..8).flat_map(|y| (0..8).map(move |x| (x, y))) {
            let metres = f64::from(distance_m.get(x, y));
            if metres.is_infinite() {
                continue;
            }
            let vertex = vertices.next().unwrap();
            let float = |at: usize| f64::from(f32::from_le_bytes(*vertex[at..].first_chunk().unwrap()));
            let expected = about.camera(0).eye() + about.face.direction(x, y, 8).normalize() * metres;
            assert!((DVec3::new(float(0), float(4), float(8)) - expected).length() < 1e-5);
            let steps = CodeSteps::new(ToneMap::default());
            assert_eq!(&vertex[12..], color.get(x, y).map(|light| steps.code(light.to_f32())));
        }
        assert!(vertices.next().is_none() && count > 0);
    }
}
