//! Decoding paths through the frames of a stream.

use crate::case::Measured;
use crate::clip::{Clip, open};
use codec::decode::Picture;
use codec::error::{Error, Result};
use codec::math::random::Random;
use kernels::pictures::mismatched_words;

/// Number of random paths, and of pictures per path.
const RANDOM_PATHS: u32 = 12;
const RANDOM_PICTURES: u32 = 40;

/// Starts at every frame and takes one step of every legal length, then follows random paths. Counts pictures that
/// differ from those of decoding in order.
///
/// A legal path has steps of 1 to W frames. If the decoder state is only its picture, single steps prove all paths;
/// random paths of steps and jumps, each with a new decoder, test whether it is.
pub(super) fn paths(clip: &Clip) -> Result<Measured> {
    let (window, count) = (clip.window(), clip.frame_count);
    let mut shown = Vec::new();
    clip.show(|_, picture| {
        shown.push(picture.clone());
        Ok(())
    })?;
    let decoder = open(std::slice::from_ref(clip))?;
    let stream = decoder.streams().first().ok_or_else(|| Error::invalid("a container without its stream"))?;
    let mut face = decoder.face(stream);
    let (mut looked, mut wrong) = (0u64, Measured::count(0));
    let mut look = |frame: u32, picture: &Picture, way: &dyn Fn() -> String| {
        looked += 1;
        let differs = mismatched_words(picture, &shown[frame as usize]) > 0;
        wrong.count_if(differs, || format!("frame {frame}, {}", way()));
    };
    for start in 0..count {
        // A step of W + 1 frames has to be split by the decoder.
        for step in 1..=window + 1 {
            for frame in [start, start + step].into_iter().filter(|&frame| frame < count) {
                look(frame, &face.decode(frame)?, &|| format!("entered at {start}, step {step}"));
            }
            if start + step >= count {
                break;
            }
        }
    }
    let mut random = Random::new(u64::from(count) << 8 | u64::from(window));
    for path in 0..RANDOM_PATHS {
        let mut face = decoder.face(stream);
        let mut frame = random.below(count);
        for at in 0..RANDOM_PICTURES {
            look(frame, &face.decode(frame)?, &|| format!("picture {at} of random path {path}"));
            let next = frame + 1 + random.below(window + 1);
            frame = if random.one_in(8) || next >= count { random.below(count) } else { next };
        }
    }
    Ok(wrong.with_note(format!("{looked} pictures")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clip::Sequence;
    use codec::depth::TemporalSettings;
    use codec::depth::block_tiles::Layout;

    fn clip() -> Clip {
        let source = Sequence::new([9, 6], 20, |frame, x, y| (100 * frame + x + y) as u16);
        Clip::codes(&source, TemporalSettings { window: 3, ..TemporalSettings::default() }, Layout::Values).unwrap()
    }

    #[test]
    fn paths_enter_at_every_frame() {
        // From each frame except the last four: W + 1 = 4 steps of two pictures each. From the last four: 3, 2, 1 and 0
        // such steps, and the start frame of the step that would pass the end.
        let pairs = 16 * 8 + (6 + 1) + (4 + 1) + (2 + 1) + 1;
        let random = RANDOM_PATHS * RANDOM_PICTURES;
        assert_eq!(paths(&clip()).unwrap().note, Some(format!("{} pictures", pairs + random)));
    }
}
