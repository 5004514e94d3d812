//! Probes of a manifest: positions, orientations and lenses (formats/manifest.md 2.5).

use std::f64::consts::FRAC_PI_2;

use glam::DQuat;
use serde::{Deserialize, Serialize};

use codec::image::{Eye, FrameRange};

/// Pose of a moving probe at one frame.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pose {
    /// Number of the frame.
    pub frame: u32,
    /// Centre in metres.
    pub position: [f64; 3],
    /// Unit quaternion x, y, z, w that rotates the probe's axes into the world's; identity if absent.
    #[serde(default = "no_turn")]
    pub orientation: [f64; 4],
}

fn no_turn() -> [f64; 4] {
    [0.0, 0.0, 0.0, 1.0]
}

/// A capture position. A static probe has a position, a moving one a pose for each of its frames.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Probe {
    /// Name: letters, digits, `.`, `_` and `-`.
    pub name: String,
    /// Centre in metres. Optional for a moving probe, where it must equal the position of the first pose.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub position: Option<[f64; 3]>,
    /// First and last frame of this probe, inclusive; those of the dataset if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frames: Option<[u32; 2]>,
    /// Width and height of each image file of this probe, in pixels; those of the dataset if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub size: Option<[u32; 2]>,
    /// Unit quaternion x, y, z, w that rotates the probe's axes into the world's; identity if absent. Static probes only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub orientation: Option<[f64; 4]>,
    /// Poses of a moving probe, in any order, exactly one for each of its frames. Poses at other frames are ignored.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub poses: Vec<Pose>,
    /// The eye whose picture is read, if `stereo` puts two pictures into each image.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub eye: Option<Eye>,
    /// Vertical field of view in degrees, 0..180 exclusive; perspective only. If neither this nor `intrinsics` is given, the
    /// camera is unknown and planar depth is not converted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fov_y_deg: Option<f64>,
    /// fx, fy, cx, cy in pixels of the probe's pictures; perspective only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub intrinsics: Option<[f64; 4]>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub extra: Option<serde_json::Value>,
}

/// Axis of a world that points up.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum UpAxis {
    #[default]
    Y,
    Z,
}

impl Probe {
    /// Turns the pose or poses of a probe from a world whose Z is up into one whose Y is up: Z becomes Y, Y becomes −Z. Pictures
    /// without a stated orientation are upright in both.
    pub fn turn_z_up(&mut self, has_orientation: bool) {
        let turn = DQuat::from_rotation_x(-FRAC_PI_2);
        let position = |[x, y, z]: [f64; 3]| [x, z, -y];
        let orientation = |of: [f64; 4]| (turn * DQuat::from_array(of)).normalize().to_array();
        self.position = self.position.map(position);
        if self.poses.is_empty() && has_orientation {
            self.orientation = Some(orientation(self.orientation.unwrap_or_else(no_turn)));
        }
        for pose in &mut self.poses {
            (pose.position, pose.orientation) = (position(pose.position), orientation(pose.orientation));
        }
    }

    /// Returns the poses of a moving probe within a range of frames, sorted by frame; empty for a static probe.
    pub fn poses_in(&self, frames: FrameRange) -> Vec<Pose> {
        let mut poses: Vec<Pose> = self.poses.iter().copied().filter(|pose| frames.contains(pose.frame)).collect();
        poses.sort_unstable_by_key(|pose| pose.frame);
        poses
    }

    /// Returns the pose at the first frame of a range; for a static probe, its only pose.
    pub fn first_pose(&self, frames: FrameRange) -> Pose {
        let still = Pose {
            frame: frames.first,
            position: self.position.unwrap_or_default(),
            orientation: self.orientation.unwrap_or_else(no_turn),
        };
        self.poses_in(frames).first().copied().unwrap_or(still)
    }

    /// Returns fx, fy, cx, cy for images of `size`, from `intrinsics` or `fov_y_deg`.
    pub fn intrinsics_for(&self, size: [u32; 2]) -> Option<[f64; 4]> {
        self.intrinsics.or_else(|| Some(intrinsics_of(self.fov_y_deg?, size)))
    }
}

/// Returns fx, fy, cx, cy in pixels of an image with a vertical field of view in degrees.
pub fn intrinsics_of(fov_y_deg: f64, size: [u32; 2]) -> [f64; 4] {
    let [width, height] = size.map(f64::from);
    let focal = height / 2.0 / (fov_y_deg.to_radians() / 2.0).tan();
    [focal, focal, width / 2.0, height / 2.0]
}
