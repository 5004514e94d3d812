//! Converts cameras with frames to poses of moving cameras.

use super::document::FileCamera;
use codec::error::{Error, Result};
use codec::math::Camera;
use render::camera_path::MAX_PATH_FRAMES;

/// A camera at one time.
#[derive(Debug, Clone, Copy)]
pub struct Pose<'a> {
    pub of: &'a FileCamera,
    /// Frame number; `None` for a static camera.
    pub frame: Option<u32>,
}

/// A static or moving camera.
#[derive(Debug)]
pub struct Track {
    /// Unique name of letters, digits and underscores.
    pub name: String,
    /// Poses with increasing frames; a static camera has one pose without a frame.
    pub keys: Vec<(Option<u32>, Camera)>,
}

/// Returns the pose of each camera in each of its frames, in order.
pub fn poses(cameras: &[FileCamera]) -> Result<Vec<Pose<'_>>> {
    let count: u64 = cameras.iter().map(|camera| camera.timed.frames.map_or(1, |frames| frames.count())).sum();
    if count > u64::from(MAX_PATH_FRAMES) {
        return Err(Error::Usage(format!("{count} camera poses, at most {MAX_PATH_FRAMES} are supported")));
    }
    let of = |camera| {
        let frames: &FileCamera = camera;
        match frames.timed.frames {
            None => vec![Pose { of: camera, frame: None }],
            Some(frames) => frames.iter().map(|frame| Pose { of: camera, frame: Some(frame) }).collect(),
        }
    };
    Ok(cameras.iter().flat_map(of).collect())
}

/// Returns the image names of poses, numbered as `render` numbers them: by frame, or in order if poses share a frame or have
/// none.
pub fn picture_names(poses: &[Pose<'_>]) -> Vec<String> {
    let mut frames: Vec<Option<u32>> = poses.iter().map(|pose| pose.frame).collect();
    frames.sort_unstable();
    frames.dedup();
    let by_frame = frames.len() == poses.len();
    let number = |(at, pose): (usize, &Pose<'_>)| pose.frame.filter(|_| by_frame).unwrap_or(at as u32);
    poses.iter().enumerate().map(|pose| format!("images/view.{:04}.png", number(pose))).collect()
}

/// Assigns each pose to the first track that ends before its frame.
pub fn tracks(poses: &[Pose<'_>]) -> Vec<Track> {
    let mut tracks: Vec<Track> = Vec::new();
    for pose in poses {
        let key = (pose.frame, pose.of.timed.camera);
        let is_free =
            |track: &&mut Track| track.keys.last().is_some_and(|(last, _)| last.is_some() && *last < pose.frame);
        match tracks.iter_mut().find(is_free) {
            Some(track) => track.keys.push(key),
            None => {
                let name = unique(&pose.of.name, &tracks);
                tracks.push(Track { name, keys: vec![key] });
            }
        }
    }
    tracks
}

fn unique(name: &str, tracks: &[Track]) -> String {
    let mut plain: String = name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    if plain.is_empty() {
        plain = "camera".to_owned();
    }
    if plain.starts_with(|c: char| c.is_ascii_digit()) {
        plain.insert_str(0, "camera_");
    }
    let is_taken = |name: &str| tracks.iter().any(|track| track.name == name);
    if !is_taken(&plain) {
        return plain;
    }
    (2u32..).map(|number| format!("{plain}_{number}")).find(|name| !is_taken(name)).unwrap_or(plain)
}
