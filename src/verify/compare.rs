//! Comparison of decoded clips with their source.

use crate::case::Measured;
use crate::clip::{Clip, Sequence};
use codec::decode::Picture;
use codec::depth::BACKGROUND_CODE;
use codec::error::{Error, Result};

fn largest_error(clip: Clip, mut see: impl FnMut(&mut Measured, usize, &Picture) -> Result<()>) -> Result<Measured> {
    let mut worst = Measured { place: Some("everywhere alike".to_owned()), ..Measured::count(0) };
    clip.show(|frame, picture| see(&mut worst, frame, picture))?;
    Ok(worst.with_clip(clip))
}

impl Sequence<u16> {
    /// Returns the largest error of the decoded clip in codes. Infinite if background and surface are confused.
    pub(super) fn compare(&self, clip: Clip) -> Result<Measured> {
        let what = clip.what.clone();
        largest_error(clip, |worst, frame, picture| {
            let Picture::Depth(shown) = picture else { return Err(Error::invalid("depth was expected")) };
            for (at, (&shown, &source)) in shown.data().iter().zip(&self.frames[frame]).enumerate() {
                let mixed = (shown == BACKGROUND_CODE) != (source == BACKGROUND_CODE);
                let error = if mixed { f64::INFINITY } else { f64::from(shown.abs_diff(source)) };
                worst.greatest(error, || {
                    let (x, y) = (at % self.size[0] as usize, at / self.size[0] as usize);
                    format!("{what}, frame {frame}, pixel ({x}, {y}): {source} became {shown}")
                });
            }
            Ok(())
        })
    }
}

impl Sequence<[u8; 3]> {
    pub(super) fn compare(&self, clip: Clip) -> Result<Measured> {
        let what = clip.what.clone();
        largest_error(clip, |worst, frame, picture| {
            let Picture::Material(shown) = picture else { return Err(Error::invalid("material was expected")) };
            for (at, (shown, source)) in shown.data().iter().zip(&self.frames[frame]).enumerate() {
                let error = shown.iter().zip(source).map(|(a, b)| a.abs_diff(*b)).max().unwrap_or(0);
                let place = || format!("{what}, frame {frame}, pixel {at}: {source:?} became {shown:?}");
                worst.greatest(f64::from(error), place);
            }
            Ok(())
        })
    }
}
