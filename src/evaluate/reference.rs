//! Reference images of a dataset or a container, with the cameras that took them (CALF 7.2).

use std::path::{Path, PathBuf};

use glam::DVec3;

use crate::decoded_images::{DecodedImages, pose, still_probe};
use codec::container::header::is_container;
use codec::decode::Decoder;
use codec::error::{Error, Result};
use codec::image::{
    ColorPlane, DepthPlane, Face, FrameRange, MaterialPlane, NormalPlane, Primaries, Projection, StreamKind,
};
use codec::math::camera::rotation;
use codec::math::{Camera, Lens};
use codec::streams::StreamInfo;
use footage::account::Account;
use footage::dataset::{Pose, ProbeInfo, Source, SourceOptions};

/// Maximum offset in pixels of a principal point from the image centre at which it is set to the centre.
const CENTRE_TOLERANCE: f64 = 0.01;

#[derive(Debug, Clone, PartialEq)]
pub struct ReferenceImage {
    pub probe: String,
    pub face: Face,
    /// Cameras by frame; a static probe has one, for its first frame.
    cameras: Vec<(u32, Camera)>,
    pub size: [u32; 2],
    pub frames: FrameRange,
    /// Group of files (or stream of a container), and index of the image in it, for colour, depth and material.
    groups: [Option<[usize; 2]>; 3],
}

impl ReferenceImage {
    /// Returns the camera in a frame; the axes of a cube face are mirrored, as its image is. Outside the frames of a moving
    /// probe, returns the camera of the nearest frame.
    pub fn camera(&self, frame: u32) -> Camera {
        let after = self.cameras.partition_point(|(of, _)| *of <= frame);
        self.cameras[after.saturating_sub(1)].1
    }

    /// Iterates over the cameras with their frames: one per frame of a moving probe, one for all frames of a static probe.
    pub fn cameras(&self) -> impl Iterator<Item = (FrameRange, Camera)> {
        let is_still = self.cameras.len() == 1;
        self.cameras.iter().map(move |&(frame, camera)| {
            (if is_still { self.frames } else { FrameRange { first: frame, last: frame } }, camera)
        })
    }
}

#[derive(Debug, Clone, PartialEq)]
pub struct Truth {
    /// Linear RGB in Rec. 709 primaries.
    pub color: ColorPlane,
    /// Reflection weight, refraction weight and index of refraction; `None` without material.
    pub material: Option<MaterialPlane>,
}

/// The faces of one group of files in one frame: group, frame, planes.
type Cached<T> = Option<(usize, u32, Vec<T>)>;

#[derive(Debug)]
enum Images {
    Dataset(Box<Source>),
    Container(Box<DecodedImages>),
}

#[derive(Debug)]
pub struct Reference {
    files: Images,
    /// Images by probe, then by face.
    pub images: Vec<ReferenceImage>,
    /// The files read last; files that hold all faces are read once for all of them.
    color: Cached<ColorPlane>,
    depth: Cached<DepthPlane>,
    material: Cached<MaterialPlane>,
    normal: Cached<NormalPlane>,
}

impl Reference {
    /// Opens a container, or a dataset by its manifest or by the folder that holds `lightfield.json`.
    pub fn open(path: &Path) -> Result<Reference> {
        if is_container(path)? {
            return Reference::of_container(Decoder::open(path)?).map_err(|error| error.in_file(path));
        }
        Reference::new(Source::open(path, &SourceOptions::default())?).map_err(|error| error.in_file(path))
    }

    /// Returns the account of the use of one frame: for a dataset files, channels and probes; for a container no names.
    pub fn account(&self, frame: u32) -> Result<Account> {
        let mut account = match &self.files {
            Images::Dataset(source) => source.account()?,
            _ => Account::default(),
        };
        let frames = self.images.iter().map(|image| image.frames).reduce(FrameRange::hull);
        if let Some(frames) = frames.filter(|frames| frames.count() > 1) {
            account.left_out.push(format!("of frames {frames} all but {frame}: one frame is simplified"));
        }
        let others = self.images.iter().filter(|image| !image.frames.contains(frame)).count();
        if others > 0 {
            account.left_out.push(format!("{others} images: their probes have no frame {frame}"));
        }
        Ok(account)
    }

    /// Returns the image files of a frame; empty for a container, which is a single file.
    pub fn files(&self, frame: u32) -> Vec<PathBuf> {
        let Images::Dataset(source) = &self.files else { return Vec::new() };
        let groups = source.groups().iter().filter(|group| group.frames.contains(frame));
        groups.filter_map(|group| source.file(group, frame).ok()?).collect()
    }

    /// Returns the image files of all frames and kinds; empty for a container.
    pub fn all_files(&self) -> Vec<PathBuf> {
        match &self.files {
            Images::Dataset(source) => source.files().collect(),
            Images::Container(_) => Vec::new(),
        }
    }

    pub fn new(source: Source) -> Result<Reference> {
        let mut images = Vec::new();
        for (at, group) in source.groups().iter().enumerate().filter(|(_, group)| group.kind == StreamKind::Color) {
            let probe = &source.probes()[group.probe];
            for (place, &face) in group.faces.iter().enumerate() {
                let size = [group.width, group.height];
                let of = |kind| group_of(&source, kind, group.probe, face, group.frames);
                images.push(ReferenceImage {
                    probe: probe.name.clone(),
                    face,
                    cameras: cameras(source.projection(), probe, face, (size, group.frames))?,
                    size,
                    frames: group.frames,
                    groups: [Some([at, place]), of(StreamKind::Depth), of(StreamKind::Material)],
                });
            }
        }
        Reference::of(Images::Dataset(Box::new(source)), images)
    }

    /// Creates the reference images of an open container.
    pub fn of_container(decoder: Decoder) -> Result<Reference> {
        let files = DecodedImages::new(decoder);
        let streams = || files.streams().iter().enumerate();
        let mut images = Vec::new();
        for (at, stream) in streams().filter(|(_, stream)| stream.kind == StreamKind::Color) {
            let of = |kind| {
                let same = |other: &StreamInfo| {
                    (other.kind, other.probe, other.face) == (kind, stream.probe, stream.face)
                        && other.size() == stream.size()
                };
                streams().find(|(_, other)| same(other)).map(|(at, _)| [at, 0])
            };
            let probe = &files.probes[stream.probe];
            let projection = if stream.face == Face::View { Projection::Perspective } else { Projection::Cubemap };
            images.push(ReferenceImage {
                probe: probe.name.clone(),
                face: stream.face,
                cameras: cameras(projection, probe, stream.face, (stream.size(), stream.frames))?,
                size: stream.size(),
                frames: stream.frames,
                groups: [Some([at, 0]), of(StreamKind::Depth), of(StreamKind::Material)],
            });
        }
        Reference::of(Images::Container(Box::new(files)), images)
    }

    fn of(files: Images, images: Vec<ReferenceImage>) -> Result<Reference> {
        if images.is_empty() {
            return Err(Error::invalid("the reference has no colour images: capture or encode colour as well"));
        }
        Ok(Reference { files, images, color: None, depth: None, material: None, normal: None })
    }

    /// Returns the maximum error of distances relative to the distance: that of the codec of a container, 0 for a dataset; `None`
    /// if the codec has no bound.
    pub fn relative_depth_error(&self) -> Option<f64> {
        match &self.files {
            Images::Dataset(_) => Some(0.0),
            Images::Container(files) => files.relative_depth_error(),
        }
    }

    /// Returns the distances of an image in a frame, in metres, `+inf` for the background; `None` without depth.
    pub fn distance_m(&mut self, image: usize, frame: u32) -> Result<Option<DepthPlane>> {
        let [_, depth, _] = self.groups(image)?;
        cached(&mut self.depth, (depth, frame), |group| match &self.files {
            Images::Dataset(source) => source.read_depth(&source.groups()[group], frame),
            Images::Container(files) => files.distance_m(group, frame),
        })
    }

    pub fn truth(&mut self, image: usize, frame: u32) -> Result<Truth> {
        let [color, _, material] = self.groups(image)?;
        let color = cached(&mut self.color, (color, frame), |group| match &self.files {
            Images::Dataset(source) => {
                let planes = source.read_color(&source.groups()[group], frame)?;
                Ok(in_rec709(planes, source.primaries()))
            }
            Images::Container(files) => Ok(in_rec709(files.color(group, frame)?, files.primaries())),
        })?;
        let color = color.ok_or_else(|| Error::Usage(format!("image {image} has no colour")))?;
        let material = cached(&mut self.material, (material, frame), |group| match &self.files {
            Images::Dataset(source) => source.read_material(&source.groups()[group], frame),
            Images::Container(files) => files.material(group, frame),
        })?;
        Ok(Truth { color, material })
    }

    /// Returns the normals of an image in a frame; `None` for a dataset without normals, and for a container.
    pub fn normal(&mut self, image: usize, frame: u32) -> Result<Option<NormalPlane>> {
        let [color, ..] = self.groups(image)?;
        cached(&mut self.normal, (color, frame), |group| match &self.files {
            Images::Dataset(source) => Ok(source.read_normal(&source.groups()[group], frame)?.unwrap_or_default()),
            Images::Container(_) => Ok(Vec::new()),
        })
    }

    fn groups(&self, image: usize) -> Result<[Option<[usize; 2]>; 3]> {
        let found = self.images.get(image).map(|image| image.groups);
        found.ok_or_else(|| Error::Usage(format!("there is no image {image} of {}", self.images.len())))
    }
}

fn in_rec709(planes: Vec<ColorPlane>, primaries: Primaries) -> Vec<ColorPlane> {
    match primaries.conversion_to(Primaries::REC709) {
        Some(matrix) => planes.iter().map(|plane| matrix.convert_plane(plane)).collect(),
        None => planes,
    }
}

/// Returns the group of another kind with the same probe, face and frames, and the index of the face in it.
fn group_of(source: &Source, kind: StreamKind, probe: usize, face: Face, frames: FrameRange) -> Option<[usize; 2]> {
    source.groups().iter().enumerate().find_map(|(at, group)| {
        let same = group.kind == kind && group.probe == probe && group.frames == frames;
        let place = group.faces.iter().position(|other| *other == face);
        place.filter(|_| same).map(|place| [at, place])
    })
}

/// Returns the camera of an image of a container in a frame, without mirroring; cube map faces are stored mirrored.
pub fn upright_camera(decoder: &Decoder, stream: &StreamInfo, frame: u32) -> Result<Camera> {
    let probe = still_probe(decoder.probe(stream));
    let moved = decoder.footage().pose(&probe.name, frame).map(pose);
    let (of_frame, size) = (moved.unwrap_or_else(|| probe.pose(frame)), stream.size());
    match stream.face {
        Face::View => camera(Projection::Perspective, (&probe, of_frame), stream.face, size),
        face => camera(Projection::Cubemap, (&probe, of_frame), face, size).map(Camera::mirrored),
    }
}

/// Returns the cameras of an image of a probe by frame; a static probe has one.
fn cameras(
    projection: Projection,
    probe: &ProbeInfo,
    face: Face,
    (size, frames): ([u32; 2], FrameRange),
) -> Result<Vec<(u32, Camera)>> {
    let count = if probe.poses.is_empty() { 1 } else { usize::MAX };
    let poses = frames.iter().take(count).map(|frame| probe.pose(frame));
    poses.map(|pose| Ok((pose.frame, camera(projection, (probe, pose), face, size)?))).collect()
}

fn camera(
    projection: Projection,
    (probe, pose): (&ProbeInfo, Pose),
    face: Face,
    [width, height]: [u32; 2],
) -> Result<Camera> {
    let named = |error: Error| error.context(format!("probe {}", probe.name));
    let turn = rotation(pose.orientation)
        .ok_or_else(|| named(Error::invalid("its orientation is not a quaternion of length 1")))?;
    let (eye, axes) = (DVec3::from_array(pose.position), face.axes().map(|axis| turn * axis));
    if face != Face::View || projection == Projection::Cubemap {
        return Camera::with_axes(eye, axes, Lens::new(90.0)).map_err(named);
    }
    let Some([fx, fy, cx, cy]) = probe.intrinsics else {
        return Err(named(Error::invalid("it has neither \"fov_y_deg\" nor \"intrinsics\", so its camera is unknown")));
    };
    let size @ [width, height] = [width, height].map(f64::from);
    let is_centred = [width / 2.0 - cx, height / 2.0 - cy].iter().all(|beside| beside.abs() <= CENTRE_TOLERANCE);
    let [cx, cy] = if is_centred { [width / 2.0, height / 2.0] } else { [cx, cy] };
    Camera::pinhole(eye, axes, size, [fx, fy, cx, cy]).map_err(named)
}

/// Returns a face of a group in a frame, reading the group unless it was the last one read.
fn cached<T: Clone>(
    held: &mut Cached<T>,
    (place, frame): (Option<[usize; 2]>, u32),
    read: impl Fn(usize) -> Result<Vec<T>>,
) -> Result<Option<T>> {
    let Some([at, place]) = place else { return Ok(None) };
    if !matches!(held, Some((group, of, _)) if (*group, *of) == (at, frame)) {
        *held = Some((at, frame, read(at)?));
    }
    Ok(held.as_ref().and_then(|(_, _, faces)| faces.get(place).cloned()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use codec::image::ImageProjection;
    use codec::monitor::Silent;
    use footage::dataset::cameras::PlacedCamera;
    use footage::encode::{EncodeSettings, encode};
    use scene::{DemoKind, DemoScene, FootagePlan, Pass, Scene};

    const PLAN: FootagePlan = FootagePlan { kind: DemoKind::Courtyard, frames: 2, face_size: 8, probes: 2 };

    #[test]
    fn images_are_seen_by_the_cameras_that_took_them() {
        let folder = tempfile::tempdir().unwrap();
        PLAN.write(folder.path(), &Silent).unwrap();
        let mut reference = Reference::open(folder.path()).unwrap();
        assert_eq!(reference.images.len(), 2 * 6);
        let source = Source::open(folder.path(), &SourceOptions::default()).unwrap();
        for (at, image) in reference.images.to_vec().iter().enumerate() {
            assert_eq!(image.camera(1).eye(), PLAN.positions()[at / 6]);
            for (column, row) in [(0, 0), (7, 0), (3, 6)] {
                let seen = image.camera(0).direction([column, row].map(|at| (f64::from(at) + 0.5) / 8.0));
                let expected = image.face.direction(column, row, 8).normalize();
                assert!((seen - expected).length() < 1e-12, "{seen} {expected}");
            }
            let truth = reference.truth(at, 1).unwrap();
            for group in source.groups().iter().filter(|group| group.probe == at / 6 && group.faces == [image.face]) {
                match group.kind {
                    StreamKind::Color => assert_eq!(source.read_color(group, 1).unwrap()[0], truth.color),
                    _ => {
                        let distance_m = reference.distance_m(at, 1).unwrap();
                        assert_eq!(Some(&source.read_depth(group, 1).unwrap()[0]), distance_m.as_ref());
                    }
                }
            }
            assert_eq!(truth.material, None);
        }
        assert!(reference.truth(12, 0).is_err() && reference.truth(0, 2).is_err());
    }

    /// Writes a dataset of perspective images of one rotated probe.
    fn perspective(folder: &Path) -> footage::dataset::Manifest {
        let mut plan = PLAN.capture().unwrap();
        let half = 0.5f64.sqrt();
        let camera = PlacedCamera { orientation: Some([0.0, half, 0.0, half]), ..PlacedCamera::at([0.0, 1.5, 0.0]) };
        plan.cameras.cameras = vec![PlacedCamera { fov_y_deg: Some(40.0), ..camera }];
        (plan.projection, plan.size) = (Projection::Perspective, [12, 8]);
        plan.passes = vec![Pass::Color];
        plan.write(&Scene::Procedural(DemoScene::new(PLAN.kind)), folder, &Silent).unwrap();
        plan.manifest().unwrap()
    }

    #[test]
    fn perspective_images_have_their_field_of_view() {
        let folder = tempfile::tempdir().unwrap();
        perspective(folder.path());
        let mut reference = Reference::open(folder.path()).unwrap();
        let [image] = &reference.images[..] else { panic!("one image") };
        // A quarter turn to the left about +Y looks along −X.
        let tangent = 20f64.to_radians().tan();
        let corner = DVec3::new(-1.0, -tangent, -1.5 * tangent).normalize();
        assert!(
            (image.camera(0).direction([1.0, 1.0]) - corner).length() < 1e-9,
            "{}",
            image.camera(0).direction([1.0, 1.0])
        );
        assert_eq!(reference.distance_m(0, 0).unwrap(), None);
    }

    #[test]
    fn off_axis_images_are_seen_through_their_principal_point() {
        let folder = tempfile::tempdir().unwrap();
        let manifest = perspective(folder.path());
        let mut json: serde_json::Value = serde_json::from_str(&manifest.to_json().unwrap()).unwrap();
        json["probes"][0]["fov_y_deg"].take();
        json["probes"][0]["intrinsics"] = serde_json::json!([11.0, 12.0, 5.0, 4.5]);
        json["probes"][0]["orientation"].take();
        std::fs::write(folder.path().join("lightfield.json"), json.to_string()).unwrap();
        let reference = Reference::open(folder.path()).unwrap();
        let model = ImageProjection::Pinhole { size: [12, 8], intrinsics: [11.0, 12.0, 5.0, 4.5] };
        let camera = reference.images[0].camera(0);
        for at in [[0.0, 0.0], [12.0, 8.0], [5.0, 4.5], [3.5, 7.5]] {
            let seen = camera.direction([at[0] / 12.0, at[1] / 8.0]);
            assert!((seen - model.unproject(at).normalize()).length() < 1e-12, "{seen}");
        }
    }

    #[test]
    fn images_of_moving_probes_are_seen_from_the_pose_of_their_frame() {
        let folder = tempfile::tempdir().unwrap();
        let manifest = perspective(folder.path());
        let mut json: serde_json::Value = serde_json::from_str(&manifest.to_json().unwrap()).unwrap();
        let half = 0.5f64.sqrt();
        let probe = json["probes"][0].as_object_mut().unwrap();
        probe.remove("position");
        probe.remove("orientation");
        probe.insert(
            "poses".into(),
            serde_json::json!([
                { "frame": 0, "position": [1.0, 2.0, 3.0] },
                { "frame": 1, "position": [4.0, 5.0, 6.0], "orientation": [0.0, half, 0.0, half] },
            ]),
        );
        std::fs::write(folder.path().join("lightfield.json"), json.to_string()).unwrap();
        let encoded = folder.path().join("moving.lfold");
        let source = Source::open(folder.path(), &SourceOptions::default()).unwrap();
        let file = std::fs::File::create(&encoded).unwrap();
        encode(&source, &EncodeSettings::default(), file, &Silent).unwrap();
        for path in [folder.path(), &encoded] {
            let reference = Reference::open(path).unwrap();
            let image = &reference.images[0];
            let eyes = [0, 1, 9].map(|frame| image.camera(frame).eye().to_array());
            assert_eq!(eyes, [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0], [4.0, 5.0, 6.0]]);
            assert!((image.camera(0).axes()[0] - DVec3::NEG_Z).length() < 1e-12);
            assert!((image.camera(1).axes()[0] - DVec3::NEG_X).length() < 1e-12);
            let frames: Vec<_> = image.cameras().map(|(frames, _)| [frames.first, frames.last]).collect();
            assert_eq!(frames, [[0, 0], [1, 1]]);
        }
    }

    #[test]
    fn datasets_that_are_no_reference_are_refused_in_words() {
        let folder = tempfile::tempdir().unwrap();
        let manifest = perspective(folder.path());
        let said = |text: String| {
            std::fs::write(folder.path().join("lightfield.json"), text).unwrap();
            Reference::open(folder.path()).unwrap_err().to_string()
        };
        let with = |change: &dyn Fn(&mut serde_json::Value)| {
            let mut json: serde_json::Value = serde_json::from_str(&manifest.to_json().unwrap()).unwrap();
            change(&mut json["probes"][0]);
            json.to_string()
        };
        let unknown = with(&|probe| {
            probe["fov_y_deg"].take();
            probe["intrinsics"].take();
        });
        assert!(said(unknown).contains("fov_y_deg"));
    }
}
