//! Source views of captured images: those of a dataset or a container whose cameras stand on one line and look across it.

use glam::DVec3;

use super::source::{SourceView, in_order};
use crate::error::{Error, Result};
use crate::evaluate::reference::{Reference, ReferenceImage};
use crate::image::Face;
use crate::math::Camera;

/// Metres by which a camera may stand beside the line, as a part of its length.
const BESIDE_LINE: f64 = 1e-4;
/// Difference of axes and windows of cameras that count as alike.
const ALIKE: f64 = 1e-6;

/// Images as source views.
#[derive(Debug)]
pub struct CapturedSources {
    /// In the middle of the line, as people see: cube faces are stored mirrored.
    pub camera: Camera,
    pub size: [u32; 2],
    /// Metres from the first source to the last.
    pub length_m: f64,
    pub sources: Vec<SourceView>,
}

impl CapturedSources {
    /// Refuses probes, by name, without an image of a face in a frame.
    pub fn check_probes(reference: &Reference, probes: &[String], face: Face, frame: u32) -> Result<()> {
        probes.iter().try_for_each(|probe| find(reference, probe, face, frame).map(drop))
    }

    /// The images of some probes, by name, and one face, in a frame.
    pub fn read(reference: &mut Reference, probes: &[String], face: Face, frame: u32) -> Result<CapturedSources> {
        let images = probes.iter().map(|probe| find(reference, probe, face, frame)).collect::<Result<Vec<_>>>()?;
        let Some(&first) = images.first() else {
            return Err(Error::Usage("name the probes whose images are the source views".into()));
        };
        let (camera, size) = (seen(reference.images[first].camera), reference.images[first].size);
        let right = camera.axes()[1];
        let eyes: Vec<DVec3> = images.iter().map(|&image| reference.images[image].camera.eye()).collect();
        let along = |eye: &DVec3| (*eye - eyes[0]).dot(right);
        let (least, most) =
            eyes.iter().map(along).fold((0f64, 0f64), |(least, most), at| (least.min(at), most.max(at)));
        let middle = eyes[0] + 0.5 * (least + most) * right;
        for (&image, eye) in images.iter().zip(&eyes) {
            check(&reference.images[image], (&camera, size), *eye - middle, most - least)?;
        }
        let mut sources = Vec::new();
        for (&image, eye) in images.iter().zip(&eyes) {
            sources.push(source(reference, (image, frame), (*eye - middle).dot(right))?);
        }
        Ok(CapturedSources {
            camera: camera.moved(middle - eyes[0]),
            size,
            length_m: most - least,
            sources: in_order(sources),
        })
    }
}

fn find(reference: &Reference, probe: &str, face: Face, frame: u32) -> Result<usize> {
    let is_it = |image: &ReferenceImage| image.probe == probe && image.face == face && image.frames.contains(frame);
    reference.images.iter().position(is_it).ok_or_else(|| {
        let mut names: Vec<&str> = reference.images.iter().map(|image| image.probe.as_str()).collect();
        names.dedup();
        Error::Usage(format!(
            "there is no image of probe {probe}, face {}, frame {frame}; the probes are {}",
            face.name(),
            names.join(", ")
        ))
    })
}

fn is_mirrored(camera: &Camera) -> bool {
    let [forward, right, down] = camera.axes();
    forward.cross(right).dot(down) < 0.0
}

/// The camera whose picture is not mirrored.
fn seen(camera: Camera) -> Camera {
    if is_mirrored(&camera) { camera.mirrored() } else { camera }
}

fn check(image: &ReferenceImage, (camera, size): (&Camera, [u32; 2]), from_middle: DVec3, length_m: f64) -> Result<()> {
    let refuse = |what: String| Err(Error::Usage(format!("probe {}, {}: {what}", image.probe, image.face.name())));
    let other = seen(image.camera);
    let is_alike = other.axes().iter().zip(camera.axes()).all(|(a, b)| (*a - b).length() < ALIKE)
        && other.half().iter().zip(camera.half()).all(|(a, b)| (a - b).abs() < ALIKE)
        && other.window() == camera.window();
    if !is_alike || image.size != size {
        return refuse("its image has another size, direction or field of view than that of the first probe".into());
    }
    let [forward, _, down] = camera.axes();
    let beside = [from_middle.dot(forward), from_middle.dot(down)];
    let most = beside.into_iter().map(f64::abs).fold(0.0, f64::max);
    match most <= BESIDE_LINE * length_m {
        true => Ok(()),
        false => refuse(format!(
            "it stands {most:.4} m off the line of the first probe's scanlines: choose probes side by side, and the face that looks \
             across their line"
        )),
    }
}

/// The image of a probe that stands so many metres to the right of the middle.
fn source(reference: &mut Reference, (image, frame): (usize, u32), offset_m: f64) -> Result<SourceView> {
    let (camera, [width, height]) = (reference.images[image].camera, reference.images[image].size);
    let truth = reference.truth(image, frame)?;
    let distances = reference.distance_m(image, frame)?.ok_or_else(|| {
        let named = &reference.images[image];
        Error::Usage(format!(
            "probe {}, {}: there is no depth: interpolation needs colour and depth of each image",
            named.probe,
            named.face.name()
        ))
    })?;
    let mirrored = is_mirrored(&camera);
    let forward = camera.axes()[0];
    Ok(SourceView::of_image(offset_m, [width, height], |column, row| {
        let stored = if mirrored { width - 1 - column } else { column };
        let at = [(f64::from(stored) + 0.5) / f64::from(width), (f64::from(row) + 0.5) / f64::from(height)];
        let planar = f64::from(distances.get(stored, row)) * camera.direction(at).dot(forward);
        Some((planar as f32, truth.color.get(stored, row)))
    }))
}
