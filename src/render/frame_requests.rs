//! Assigns cameras to frames, in render order.

use crate::camera_path::TimedCamera;
use codec::error::{Error, Result};
use codec::image::FrameRange;
use codec::math::Camera;

/// A frame, and the cameras that render it together.
#[derive(Debug, Clone, PartialEq)]
pub struct FrameRequest {
    pub frame: u32,
    /// The cameras, at least one: two for stereo, six for a cube map.
    pub cameras: Vec<Camera>,
}

/// Returns the frame requests of a camera path.
///
/// - A single camera without frames renders all of `frames`.
/// - Cameras with frames render those of their frames that are in `frames`, one camera after the other. If `frames` is given,
///   each of its available frames must have a camera.
/// - Several cameras without frames are poses of one camera: the first renders the first of `frames`, and so on. If `frames` has
///   one frame, all of them render it.
///
/// `frames` defaults to `available` if the cameras have frames, else to the first available frame.
pub fn frame_requests(
    cameras: &[TimedCamera],
    frames: Option<FrameRange>,
    available: FrameRange,
) -> Result<Vec<FrameRequest>> {
    let stated = cameras.iter().filter(|timed| timed.frames.is_some()).count();
    let first = FrameRange { first: available.first, last: available.first };
    let (asked, frames) = (frames, frames.unwrap_or(if stated == 0 { first } else { available }));
    let request = |frame: u32, timed: &TimedCamera| FrameRequest { frame, cameras: vec![timed.camera] };
    let requests: Vec<FrameRequest> = match (cameras, stated) {
        ([], _) => return Err(Error::Usage("a path needs at least one camera".into())),
        ([only], 0) => frames.iter().map(|frame| request(frame, only)).collect(),
        (_, 0) if frames.count() == 1 => cameras.iter().map(|timed| request(frames.first, timed)).collect(),
        (_, 0) if frames.count() == cameras.len() as u64 => {
            frames.iter().zip(cameras).map(|(frame, timed)| request(frame, timed)).collect()
        }
        (_, 0) => {
            return Err(Error::Usage(format!(
                "{} cameras and {} frames: a path has a camera for each frame, or one frame for all cameras",
                cameras.len(),
                frames.count()
            )));
        }
        (_, stated) if stated == cameras.len() => {
            check_covered(cameras, asked, available)?;
            let of = |timed: &TimedCamera| timed.frames.and_then(|own| own.intersect(frames));
            cameras
                .iter()
                .flat_map(|timed| of(timed).into_iter().flat_map(FrameRange::iter).map(|at| request(at, timed)))
                .collect()
        }
        _ => {
            return Err(Error::Usage(
                "some cameras have \"frames\" or a \"frame\" and others do not (`eye` has none): all cameras of a \
                path must have them, or none"
                    .into(),
            ));
        }
    };
    if requests.is_empty() {
        return Err(Error::Usage(format!("no camera is defined for frames {frames}")));
    }
    Ok(requests)
}

/// Fails if a requested and available frame has no camera.
fn check_covered(cameras: &[TimedCamera], asked: Option<FrameRange>, available: FrameRange) -> Result<()> {
    let Some((asked, needed)) = asked.and_then(|asked| Some((asked, asked.intersect(available)?))) else {
        return Ok(());
    };
    let mut own: Vec<FrameRange> = cameras.iter().filter_map(|timed| timed.frames).collect();
    own.sort_unstable_by_key(|range| range.first);
    let mut next = u64::from(needed.first);
    for range in own {
        if u64::from(range.first) <= next {
            next = next.max(u64::from(range.last) + 1);
        }
    }
    if next > u64::from(needed.last) {
        return Ok(());
    }
    Err(Error::Usage(format!(
        "no camera is defined for frame {next} of {asked}: request frames of the path, or extend it"
    )))
}

/// Returns the number of frames that cameras have and `frames` includes, but that are not `available`.
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
    use codec::math::Lens;

    fn range(first: u32, last: u32) -> FrameRange {
        FrameRange { first, last }
    }

    /// Returns cameras at x = 0, 1, 2, ….
    fn cameras(frames: &[Option<FrameRange>]) -> Vec<TimedCamera> {
        let camera = |(at, &frames): (usize, &Option<FrameRange>)| {
            let eye = DVec3::X * at as f64;
            TimedCamera { camera: Camera::look_at(eye, eye + DVec3::Z, DVec3::Y, Lens::new(60.0)).unwrap(), frames }
        };
        frames.iter().enumerate().map(camera).collect()
    }

    /// Returns the frame and the camera number of each request.
    fn of(frames: &[Option<FrameRange>], asked: Option<FrameRange>) -> Vec<(u32, u32)> {
        let requests = frame_requests(&cameras(frames), asked, range(3, 9)).unwrap();
        requests.iter().map(|request| (request.frame, request.cameras[0].eye().x as u32)).collect()
    }

    #[test]
    fn requests_follow_the_cameras() {
        let none = None;
        assert_eq!(of(&[none], None), [(3, 0)]);
        assert_eq!(of(&[none], Some(range(4, 6))), [(4, 0), (5, 0), (6, 0)]);
        // Poses: all in one frame, or one per frame.
        assert_eq!(of(&[none, none], None), [(3, 0), (3, 1)]);
        assert_eq!(of(&[none, none], Some(range(7, 7))), [(7, 0), (7, 1)]);
        assert_eq!(of(&[none, none, none], Some(range(4, 6))), [(4, 0), (5, 1), (6, 2)]);
        // Cameras with their own frames.
        let own = [Some(range(5, 6)), Some(range(6, 6)), Some(range(0, 4))];
        assert_eq!(of(&own, None), [(5, 0), (6, 0), (6, 1), (3, 2), (4, 2)]);
        assert_eq!(of(&own, Some(range(6, 6))), [(6, 0), (6, 1)]);
        let error = frame_requests(&cameras(&own), Some(range(6, 20)), range(3, 9)).unwrap_err().to_string();
        assert!(error.starts_with("no camera is defined for frame 7 of 6-20"), "{error}");
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
        let said = |frames: &[Option<FrameRange>], asked| {
            frame_requests(&cameras(frames), asked, range(3, 9)).unwrap_err().to_string()
        };
        assert!(said(&[], None).contains("at least one"));
        assert!(said(&[None, None], Some(range(3, 5))).contains("2 cameras and 3 frames"));
        assert!(said(&[None, Some(range(3, 3))], None).contains("none"));
        assert!(said(&[Some(range(3, 3))], Some(range(4, 5))).contains("4-5"));
    }
}
