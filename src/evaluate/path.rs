//! A path of cameras: which cameras look at which frame, in which order.

use crate::error::{Error, Result};
use crate::evaluate::camera_file::TimedCamera;
use crate::image::FrameRange;
use crate::math::Camera;

/// What is shown at once: a frame, as one or more cameras see it.
#[derive(Debug, Clone, PartialEq)]
pub struct Shot {
    /// The frame.
    pub frame: u32,
    /// The cameras, at least one: two of them for two eyes, six for a cube map.
    pub cameras: Vec<Camera>,
}

/// The shots of a path.
///
/// - One camera that states no frames shows all of `frames`.
/// - Cameras that state frames show them, each of its own, one camera after the other; of these those in `frames`.
/// - More cameras that state no frames are poses of one camera, frame by frame: the first camera shows the first of `frames`,
///   and so on. There are as many shots as cameras; a range of one frame stands still in time.
///
/// Where no frames were asked for, they are all that the light field has (`available`) for cameras that state theirs, and its
/// first for the others.
///
/// # Errors
/// When some cameras state frames and others do not, when there are neither as many frames as cameras nor one, and when
/// nothing is left to show.
pub fn shots(cameras: &[TimedCamera], frames: Option<FrameRange>, available: FrameRange) -> Result<Vec<Shot>> {
    let stated = cameras.iter().filter(|timed| timed.frames.is_some()).count();
    let first = FrameRange { first: available.first, last: available.first };
    let frames = frames.unwrap_or(if stated == 0 { first } else { available });
    let shot = |frame: u32, timed: &TimedCamera| Shot { frame, cameras: vec![timed.camera] };
    let shots: Vec<Shot> = match (cameras, stated) {
        ([], _) => return Err(Error::Usage("a path needs at least one camera".into())),
        ([only], 0) => frames.iter().map(|frame| shot(frame, only)).collect(),
        (_, 0) if frames.count() == 1 => cameras.iter().map(|timed| shot(frames.first, timed)).collect(),
        (_, 0) if frames.count() == cameras.len() as u64 => {
            frames.iter().zip(cameras).map(|(frame, timed)| shot(frame, timed)).collect()
        }
        (_, 0) => {
            return Err(Error::Usage(format!(
                "{} cameras and {} frames: a path has a camera for each frame, or one frame for all cameras",
                cameras.len(),
                frames.count()
            )));
        }
        (_, stated) if stated == cameras.len() => {
            let of = |timed: &TimedCamera| timed.frames.and_then(|own| own.intersect(frames));
            cameras
                .iter()
                .flat_map(|timed| of(timed).into_iter().flat_map(FrameRange::iter).map(|at| shot(at, timed)))
                .collect()
        }
        _ => {
            return Err(Error::Usage(
                "some cameras state \"frames\" or a \"frame\" and others do not (`eye` states none): let all of a path state theirs, \
                 or none"
                    .into(),
            ));
        }
    };
    if shots.is_empty() {
        return Err(Error::Usage(format!("no camera looks in the frames {frames}")));
    }
    Ok(shots)
}

/// How many of the frames that cameras state, and that are asked for, are not among those that there are (`available`):
/// a path passes over them.
pub fn missing_frames(cameras: &[TimedCamera], frames: Option<FrameRange>, available: FrameRange) -> u64 {
    let missing = |own: FrameRange| {
        let asked = frames.map_or(Some(own), |frames| own.intersect(frames));
        asked.map_or(0, |asked| asked.count() - asked.intersect(available).map_or(0, FrameRange::count))
    };
    cameras.iter().filter_map(|timed| timed.frames).map(missing).sum()
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::math::Lens;

    fn range(first: u32, last: u32) -> FrameRange {
        FrameRange { first, last }
    }

    /// Cameras that stand at x = 0, 1, 2, ….
    fn cameras(frames: &[Option<FrameRange>]) -> Vec<TimedCamera> {
        let camera = |(at, &frames): (usize, &Option<FrameRange>)| {
            let eye = DVec3::X * at as f64;
            TimedCamera { camera: Camera::look_at(eye, eye + DVec3::Z, DVec3::Y, Lens::new(60.0)).unwrap(), frames }
        };
        frames.iter().enumerate().map(camera).collect()
    }

    /// Frame and camera of each shot.
    fn of(frames: &[Option<FrameRange>], asked: Option<FrameRange>) -> Vec<(u32, u32)> {
        let shots = shots(&cameras(frames), asked, range(3, 9)).unwrap();
        shots.iter().map(|shot| (shot.frame, shot.cameras[0].eye().x as u32)).collect()
    }

    #[test]
    fn shots_follow_the_cameras() {
        let none = None;
        assert_eq!(of(&[none], None), [(3, 0)]);
        assert_eq!(of(&[none], Some(range(4, 6))), [(4, 0), (5, 0), (6, 0)]);
        // Poses: frozen in time, or one a frame.
        assert_eq!(of(&[none, none], None), [(3, 0), (3, 1)]);
        assert_eq!(of(&[none, none], Some(range(7, 7))), [(7, 0), (7, 1)]);
        assert_eq!(of(&[none, none, none], Some(range(4, 6))), [(4, 0), (5, 1), (6, 2)]);
        // Cameras with frames of their own.
        let own = [Some(range(5, 6)), Some(range(6, 6)), Some(range(0, 4))];
        assert_eq!(of(&own, None), [(5, 0), (6, 0), (6, 1), (3, 2), (4, 2)]);
        assert_eq!(of(&own, Some(range(6, 20))), [(6, 0), (6, 1)]);
    }

    #[test]
    fn frames_that_do_not_exist_are_counted() {
        let missing = |frames: &[Option<FrameRange>], asked| missing_frames(&cameras(frames), asked, range(3, 9));
        assert_eq!(missing(&[None], Some(range(0, 20))), 0);
        assert_eq!(missing(&[Some(range(0, 11)), Some(range(9, 9)), Some(range(20, 20))], None), 3 + 2 + 1);
        assert_eq!(missing(&[Some(range(0, 11))], Some(range(9, 10))), 1);
        assert_eq!(missing(&[Some(range(0, 11))], Some(range(30, 40))), 0);
    }

    #[test]
    fn paths_that_are_not_clear_are_refused() {
        let said =
            |frames: &[Option<FrameRange>], asked| shots(&cameras(frames), asked, range(3, 9)).unwrap_err().to_string();
        assert!(said(&[], None).contains("at least one"));
        assert!(said(&[None, None], Some(range(3, 5))).contains("2 cameras and 3 frames"));
        assert!(said(&[None, Some(range(3, 3))], None).contains("none"));
        assert!(said(&[Some(range(3, 3))], Some(range(4, 5))).contains("4-5"));
    }
}
