//! Interpolates a moving camera between key poses.

use glam::DQuat;

use codec::error::{Error, Result};
use codec::image::FrameRange;
use codec::math::{Camera, Lens};

pub const MAX_PATH_FRAMES: u32 = 100_000;

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TimedCamera {
    pub camera: Camera,
    /// Frames that the camera renders; `None` for all frames.
    pub frames: Option<FrameRange>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KeyPose {
    pub frame: u32,
    pub camera: Camera,
    pub lens: Lens,
}

/// Returns a camera for each frame from the first pose to the last: position, field of view, aspect ratio and off-axis shift are
/// interpolated linearly, orientation by slerp. Near and far planes are those of the previous pose. Fails if frames do not
/// increase.
pub fn interpolate(poses: &[KeyPose]) -> Result<Vec<TimedCamera>> {
    let timed =
        |frame: u32, camera: Camera| TimedCamera { camera, frames: Some(FrameRange { first: frame, last: frame }) };
    let mut cameras = Vec::new();
    if let [first, .., last] = poses
        && last.frame.saturating_sub(first.frame) >= MAX_PATH_FRAMES
    {
        return Err(Error::invalid(format!("a camera path has at most {MAX_PATH_FRAMES} frames")));
    }
    for pair in poses.windows(2) {
        let [a, b] = [pair[0], pair[1]];
        if b.frame <= a.frame {
            return Err(Error::invalid(format!(
                "the pose of frame {} follows that of frame {}: frames must increase",
                b.frame, a.frame
            )));
        }
        cameras.push(timed(a.frame, a.camera));
        for frame in a.frame + 1..b.frame {
            let part = f64::from(frame - a.frame) / f64::from(b.frame - a.frame);
            cameras.push(timed(frame, between(&a, &b, part)?));
        }
    }
    cameras.extend(poses.last().map(|pose| timed(pose.frame, pose.camera)));
    Ok(cameras)
}

fn between(a: &KeyPose, b: &KeyPose, part: f64) -> Result<Camera> {
    let turn = |pose: &KeyPose| pose.camera.orientation().map_or(DQuat::IDENTITY, DQuat::from_array);
    let mix = |a: f64, b: f64| a + (b - a) * part;
    let lens = Lens {
        fov_y_deg: mix(a.lens.fov_y_deg, b.lens.fov_y_deg),
        aspect: mix(a.lens.aspect, b.lens.aspect),
        ..a.lens
    };
    let orientation = turn(a).slerp(turn(b), part).normalize();
    let middle = [0, 1].map(|axis| mix(a.camera.middle()[axis], b.camera.middle()[axis]));
    Camera::oriented(a.camera.eye().lerp(b.camera.eye(), part), orientation.to_array(), lens)?.off_axis(middle)
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    fn pose(frame: u32, eye: [f64; 3], forward: [f64; 3], fov_y_deg: f64) -> KeyPose {
        let (eye, lens) = (DVec3::from_array(eye), Lens::new(fov_y_deg));
        let camera = Camera::look_at(eye, eye + DVec3::from_array(forward), DVec3::Y, lens).unwrap();
        KeyPose { frame, camera, lens }
    }

    #[test]
    fn orientation_is_interpolated_by_slerp() {
        let poses = [pose(2, [0.0; 3], [1.0, 0.0, 0.0], 40.0), pose(5, [3.0, 0.0, 6.0], [0.0, 0.0, 1.0], 70.0)];
        let cameras = interpolate(&poses).unwrap();
        assert_eq!(cameras.len(), 4);
        for (at, timed) in (0u32..).zip(&cameras) {
            let angle = (f64::from(at) * 30.0).to_radians();
            let forward = DVec3::new(angle.cos(), 0.0, angle.sin());
            assert!((timed.camera.axes()[0] - forward).length() < 1e-12, "{timed:?}");
            assert!((timed.camera.axes()[2] - DVec3::NEG_Y).length() < 1e-12);
            assert!((timed.camera.eye() - DVec3::new(1.0, 0.0, 2.0) * f64::from(at)).length() < 1e-12);
            assert_eq!(timed.frames, Some(FrameRange { first: 2 + at, last: 2 + at }));
        }
        // The field of view is 50 degrees, so the direction at the right edge is 25 degrees off the axis.
        let right = cameras[1].camera.direction([1.0, 0.5]).dot(cameras[1].camera.axes()[1]);
        assert!((right - 25f64.to_radians().sin()).abs() < 1e-12);
        assert_eq!(interpolate(&poses[..1]).unwrap().len(), 1);
        assert!(interpolate(&[poses[1], poses[0]]).is_err());
        assert!(interpolate(&[poses[0], KeyPose { frame: u32::MAX, ..poses[1] }]).is_err());
    }
}
