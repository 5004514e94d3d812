//! Source views from captured images: those of a dataset or a container whose cameras stand on one line and look across it.

use glam::DVec3;

use super::source::{SourceView, in_order};
use codec::error::{Error, Result};
use codec::image::{Face, FrameRange};
use codec::math::Camera;
use evaluate::reference::{Reference, ReferenceImage};

/// Maximum distance of a camera from the line, as a fraction of the line's length.
const BESIDE_LINE: f64 = 1e-4;
/// Tolerance within which the axes and windows of two cameras count as equal.
const ALIKE: f64 = 1e-6;

/// Captured images as source views.
#[derive(Debug)]
pub struct CapturedSources {
    /// Camera in the middle of the line. Its image is not mirrored, unlike stored cube faces.
    pub camera: Camera,
    pub size: [u32; 2],
    /// Distance from the first source to the last, in metres.
    pub length_m: f64,
    /// Planar distance of the plane that does not move between sources; `+inf` for parallel windows.
    pub focus_m: f64,
    pub sources: Vec<SourceView>,
}

impl CapturedSources {
    /// Fails if one of the named probes has no image of `face` in `frame`.
    pub fn check_probes(reference: &Reference, probes: &[String], face: Face, frame: u32) -> Result<()> {
        probes.iter().try_for_each(|probe| find(reference, probe, face, Some(frame)).map(drop))
    }

    /// Returns the frames in which all named probes have an image of `face`. Fails if there are none.
    pub fn frames(reference: &Reference, probes: &[String], face: Face) -> Result<FrameRange> {
        let mut common: Option<FrameRange> = None;
        for probe in probes {
            let image = &reference.images[find(reference, probe, face, None)?];
            let frames = common.map_or(Some(image.frames), |common| common.intersect(image.frames));
            let none = || Error::Usage(format!("the probes {} have no frame in common", probes.join(", ")));
            common = Some(frames.ok_or_else(none)?);
        }
        common.ok_or_else(no_probes)
    }

    /// Reads the images of the named probes, for one face and one frame.
    pub fn read(reference: &mut Reference, probes: &[String], face: Face, frame: u32) -> Result<CapturedSources> {
        let images =
            probes.iter().map(|probe| find(reference, probe, face, Some(frame))).collect::<Result<Vec<_>>>()?;
        let Some(&first) = images.first() else {
            return Err(no_probes());
        };
        let (camera, size) = (seen(reference.images[first].camera(frame)), reference.images[first].size);
        let right = camera.axes()[1];
        let cameras: Vec<Camera> = images.iter().map(|&image| seen(reference.images[image].camera(frame))).collect();
        let along = |camera: &Camera| (camera.eye() - cameras[0].eye()).dot(right);
        let by_place = |a: &&Camera, b: &&Camera| along(a).total_cmp(&along(b));
        let (Some(left), Some(last)) = (cameras.iter().min_by(by_place), cameras.iter().max_by(by_place)) else {
            return Err(Error::invalid("probes without a position"));
        };
        let (least, most) = (along(left), along(last));
        let middle = camera.eye() + 0.5 * (least + most) * right;
        let turned_in = across(left) - across(last);
        // If windows shift relative to their cameras, the plane that does not move is the plane of focus.
        let focus_m = if turned_in > ALIKE { (most - least) / turned_in } else { f64::INFINITY };
        let line = ProbeLine { first: camera, size, middle, length_m: most - least, focus_m };
        for (&image, camera) in images.iter().zip(&cameras) {
            line.check(&reference.images[image], camera)?;
        }
        let mut sources = Vec::new();
        for (&image, camera) in images.iter().zip(&cameras) {
            sources.push(source(reference, (image, frame), (camera.eye() - middle).dot(right))?);
        }
        Ok(CapturedSources {
            camera: line.camera()?,
            size,
            length_m: most - least,
            focus_m,
            sources: in_order(sources),
        })
    }
}

/// Returns the horizontal centre of a camera's window at distance 1, positive to the right.
fn across(camera: &Camera) -> f64 {
    0.5 * camera.window().u.iter().sum::<f64>()
}

/// The line on which the cameras of the probes stand.
struct ProbeLine {
    /// Camera of the first named probe.
    first: Camera,
    size: [u32; 2],
    middle: DVec3,
    length_m: f64,
    focus_m: f64,
}

impl ProbeLine {
    /// Returns the horizontal centre of the window at distance 1 that a camera at `eye` should have.
    fn across_at(&self, eye: DVec3) -> f64 {
        across(&self.first) - (eye - self.first.eye()).dot(self.first.axes()[1]) / self.focus_m
    }

    /// Returns the camera in the middle of the line.
    fn camera(&self) -> Result<Camera> {
        let camera = self.first.moved(self.middle - self.first.eye());
        if self.focus_m == f64::INFINITY {
            return Ok(camera);
        }
        let down = 0.5 * camera.window().v.iter().sum::<f64>();
        camera.off_axis([self.across_at(self.middle), down])
    }

    fn check(&self, image: &ReferenceImage, camera: &Camera) -> Result<()> {
        let refuse = |what: String| Err(Error::Usage(format!("probe {}, {}: {what}", image.probe, image.face.name())));
        let is_near = |a: f64, b: f64| (a - b).abs() < ALIKE;
        let is_alike = camera.axes().iter().zip(self.first.axes()).all(|(a, b)| (*a - b).length() < ALIKE)
            && camera.half().iter().zip(self.first.half()).all(|(a, b)| is_near(*a, b));
        if !is_alike || image.size != self.size {
            return refuse(
                "its image has another size, direction or field of view than that of the first probe".into(),
            );
        }
        let [forward, _, down] = self.first.axes();
        let from_middle = camera.eye() - self.middle;
        let beside = [from_middle.dot(forward), from_middle.dot(down)];
        let most = beside.into_iter().map(f64::abs).fold(0.0, f64::max);
        if most > BESIDE_LINE * self.length_m {
            return refuse(format!(
                "it is {most:.4} m off the line of the first probe's scanlines: choose probes side by side, and the \
                face perpendicular to their line"
            ));
        }
        let ([found, wanted], [high, first_high]) = (
            [across(camera), self.across_at(camera.eye())],
            [camera, &self.first].map(|camera| 0.5 * camera.window().v.iter().sum::<f64>()),
        );
        if !is_near(found, wanted) || !is_near(high, first_high) {
            return refuse(format!(
                "its image is shifted by {found:.6} to the right and {high:.6} down at distance 1, where {wanted:.6} and \
                 {first_high:.6} were expected: cameras must be parallel, or all have one focus"
            ));
        }
        Ok(())
    }
}

fn no_probes() -> Error {
    Error::Usage("no probes for source views were given: set `probe`".into())
}

/// Returns the index of the image of a probe and face, in the given frame or in any frame.
fn find(reference: &Reference, probe: &str, face: Face, frame: Option<u32>) -> Result<usize> {
    let is_it = |image: &ReferenceImage| {
        image.probe == probe && image.face == face && frame.is_none_or(|frame| image.frames.contains(frame))
    };
    reference.images.iter().position(is_it).ok_or_else(|| {
        let mut names: Vec<&str> = reference.images.iter().map(|image| image.probe.as_str()).collect();
        names.dedup();
        Error::Usage(format!(
            "there is no image of probe {probe}, face {}{}; the probes are {}",
            face.name(),
            frame.map_or_else(String::new, |frame| format!(", frame {frame}")),
            names.join(", ")
        ))
    })
}

fn is_mirrored(camera: &Camera) -> bool {
    let [forward, right, down] = camera.axes();
    forward.cross(right).dot(down) < 0.0
}

/// Returns the camera, mirrored back if its image is stored mirrored.
fn seen(camera: Camera) -> Camera {
    if is_mirrored(&camera) { camera.mirrored() } else { camera }
}

/// Reads the image of a probe that is `offset_m` metres to the right of the middle.
fn source(reference: &mut Reference, (image, frame): (usize, u32), offset_m: f64) -> Result<SourceView> {
    let (camera, [width, height]) = (reference.images[image].camera(frame), reference.images[image].size);
    let truth = reference.truth(image, frame)?;
    let distances = reference.distance_m(image, frame)?.ok_or_else(|| {
        let named = &reference.images[image];
        Error::Usage(format!(
            "probe {}, {}: the image has no depth, which interpolation needs",
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
