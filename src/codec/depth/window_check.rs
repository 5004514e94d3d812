//! Checks that any path of steps of at most W frames shows the same pictures (depth.md 4).
//!
//! Input: the records of a chunk. Output: an error at the first frame whose record omits a pixel that changed less than W frames
//! before.

use std::path::PathBuf;

use crate::depth::node_chunk::NodeChunk;
use crate::depth::records::{Body, TemporalChunk};
use crate::depth::texel::Texel;
use crate::error::{Error, Result};

struct Updates<R, A> {
    size: [usize; 2],
    frames: Vec<u32>,
    /// Returns left, top, width and height of the rectangles that a record replaces.
    rectangles: R,
    apply: A,
}

impl<T: Texel> TemporalChunk<T> {
    /// Fails if a frame n of the chunk's `frame_count` frames does not replace a pixel that changed in one of the W - 1 frames
    /// before n. Frames without a record replace nothing.
    ///
    /// Memory: two pictures. Time: one pass over the unit per record.
    pub fn check_window(&self, window: u8, frame_count: u32) -> Result<()> {
        let size @ [width, height] = self.size.map(|side| side as usize);
        let frames = self.records.iter().map(|record| record.frame).collect();
        let rectangles = |at: usize| match self.records[at].body {
            Body::Whole(_) | Body::Constant(_) => vec![[0, 0, width, height]],
            body => self.boxes(body).iter().map(|(b, _)| b.rect()).collect(),
        };
        let apply = |at: usize, picture: &mut [T]| self.apply(picture, self.records[at].body);
        Updates { size, frames, rectangles, apply }.check(window, frame_count)
    }
}

impl NodeChunk {
    pub fn check_window(&self, window: u8, frame_count: u32) -> Result<()> {
        let (grid, rows) = (self.runtime.grid, &self.runtime.frames);
        let size = [grid.width as usize, grid.height as usize];
        let frames = rows.iter().map(|row| row.frame).collect();
        let rectangles = |at: usize| {
            let places = self.runtime.nodes(rows[at]).map(|(place, _)| place);
            places.map(|place| grid.rect_of(place).map(|value| value as usize)).collect()
        };
        let apply = |at: usize, picture: &mut [u16]| self.apply(picture, rows[at]);
        Updates { size, frames, rectangles, apply }.check(window, frame_count)
    }
}

impl<R: Fn(usize) -> Vec<[usize; 4]>, A> Updates<R, A> {
    fn check<T: Texel>(&self, window: u8, frame_count: u32) -> Result<()>
    where
        A: Fn(usize, &mut [T]) -> u64,
    {
        let (window, [width, height]) = (u32::from(window), self.size);
        let mut picture = vec![T::default(); width * height];
        let mut before = picture.clone();
        let mut covered = vec![false; width * height];
        // Frame of the last change of each pixel; 0 if it has not changed since the keyframe.
        let mut changed_at = vec![0; width * height];
        for (at, &frame) in self.frames.iter().enumerate() {
            covered.fill(false);
            for [left, top, columns, rows] in (self.rectangles)(at) {
                covered[top * width..]
                    .chunks_mut(width)
                    .take(rows)
                    .for_each(|row| row[left..left + columns].fill(true));
            }
            before.copy_from_slice(&picture);
            (self.apply)(at, &mut picture);
            if at > 0 {
                for (pixel, changed_at) in changed_at.iter_mut().enumerate() {
                    if !covered[pixel] {
                        check_pixel(pixel, width, window, *changed_at, frame)?;
                    } else if picture[pixel] != before[pixel] {
                        *changed_at = frame;
                    }
                }
            }
            let next = self.frames.get(at + 1).copied().unwrap_or(frame_count);
            if next > frame + 1 {
                // Frames up to the next record replace nothing; the first of them is the strictest to check.
                for (pixel, &changed_at) in changed_at.iter().enumerate() {
                    check_pixel(pixel, width, window, changed_at, frame + 1)?;
                }
            }
        }
        Ok(())
    }
}

fn check_pixel(pixel: usize, width: usize, window: u32, changed_at: u32, frame: u32) -> Result<()> {
    if changed_at == 0 || frame - changed_at >= window {
        return Ok(());
    }
    let (x, y) = (pixel % width, pixel / width);
    let message = format!(
        "pixel ({x}, {y}) of the unit changes in frame {changed_at} of the chunk, and frame {frame} does not repeat it: a \
         decoder that steps over frames, up to the window of {window}, shows another picture"
    );
    Err(Error::Invalid { file: PathBuf::new(), offset: None, section: "depth.md 4", message })
}

#[cfg(feature = "encode")]
#[cfg(test)]
mod tests {
    use super::*;
    use crate::depth::block_tiles::Layout;
    use crate::depth::boxes::PixelBox;
    use crate::depth::record_table::TableBuilder;

    /// Returns a chunk of 3x1 pixels; each record writes `code` to pixel `x` in `frame`.
    fn chunk(records: &[(u32, u16, u16)], frame_count: u32) -> TemporalChunk<u16> {
        let mut builder = TableBuilder::default();
        builder.put_values(&[1u16, 2, 3]);
        for &(frame, x, code) in records {
            builder.put_boxes_of(frame, &[PixelBox { x, y: 0, width: 1, height: 1 }], &[code; 3], 3);
        }
        TemporalChunk::parse(Layout::Values, builder.finish().unwrap(), [3, 1], frame_count).unwrap()
    }

    fn holds(records: &[(u32, u16, u16)], window: u8, frame_count: u32) -> bool {
        chunk(records, frame_count).check_window(window, frame_count).is_ok()
    }

    #[test]
    fn a_change_must_be_repeated_for_the_window() {
        let once = [(1, 0, 9)];
        assert!(holds(&once, 1, 5) && holds(&once, 2, 2));
        assert!(!holds(&once, 2, 3));
        let twice = [(1, 0, 9), (2, 0, 9)];
        assert!(holds(&twice, 2, u32::MAX) && holds(&twice, 3, 3) && !holds(&twice, 3, 4));
        // Another pixel, a gap, and a value that comes back.
        assert!(!holds(&[(1, 0, 9), (2, 1, 9), (3, 1, 9)], 2, 4));
        assert!(!holds(&[(1, 0, 9), (3, 0, 9)], 3, 4));
        assert!(!holds(&[(1, 0, 9), (2, 0, 1)], 2, 4));
        assert!(holds(&[(1, 0, 9), (2, 0, 1), (3, 0, 1)], 2, 4));
        // A value that stays the same is not a change.
        assert!(holds(&[(1, 0, 1)], 255, 300));
        let error = chunk(&once, 3).check_window(2, 3).unwrap_err().to_string();
        assert!(error.contains("pixel (0, 0)") && error.ends_with("(formats/depth.md 4)"), "{error}");
    }
}
