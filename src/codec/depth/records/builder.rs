//! Writes the payload of a temporally coded chunk (depth.md 4).

use crate::container::serialize::PutFields;
use crate::depth::boxes::PixelBox;
use crate::depth::record_table::TableBuilder;
use crate::depth::records::{BOXES, CONSTANT, WHOLE};
use crate::depth::texel::Texel;

impl TableBuilder {
    pub fn put_values<T: Texel>(&mut self, keyframe: &[T]) {
        self.put_keyframe(keyframe, |data| keyframe.iter().for_each(|value| value.put(data)));
    }

    /// Writes the record of the keyframe: one value if it is constant, otherwise the pixels that `put` appends.
    pub fn put_keyframe<T: Texel>(&mut self, keyframe: &[T], put: impl FnOnce(&mut Vec<u8>)) {
        let constant = keyframe.iter().all(|value| *value == keyframe[0]);
        let data = self.begin(0);
        data.extend_from_slice(&[if constant { CONSTANT } else { WHOLE }, 0, 0, 0]);
        if constant {
            keyframe[0].put(data);
        } else {
            put(data);
        }
    }

    /// Writes a record of boxes with their pixels from `picture`, which has `width` columns.
    pub fn put_boxes_of<T: Texel>(&mut self, frame: u32, boxes: &[PixelBox], picture: &[T], width: usize) {
        self.put_boxes(frame, boxes, |b, data| {
            data.reserve(T::BYTES * b.area() as usize);
            let [x, y, box_width, height] = b.rect();
            for row in picture[y * width..].chunks(width).take(height) {
                row[x..x + box_width].iter().for_each(|value| value.put(data));
            }
        });
    }

    pub fn put_boxes(&mut self, frame: u32, boxes: &[PixelBox], mut put: impl FnMut(PixelBox, &mut Vec<u8>)) {
        let data = self.begin(frame);
        data.extend_from_slice(&[BOXES, 0]);
        data.put_u16(boxes.len() as u16);
        for b in boxes {
            [b.x, b.y, b.width, b.height].iter().for_each(|&value| data.put_u16(value));
        }
        boxes.iter().for_each(|&b| put(b, data));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::depth::block_tiles::Layout;
    use crate::depth::records::TemporalChunk;

    fn sample() -> Vec<u8> {
        let mut builder = TableBuilder::default();
        builder.put_values(&[1u16, 2, 3, 4, 5, 6]);
        let picture = [1u16, 20, 30, 4, 50, 60];
        let b = PixelBox { x: 1, y: 0, width: 2, height: 2 };
        builder.put_boxes_of(3, &[b], &picture, 3);
        assert_eq!(builder.bytes(), 4 + 16 + 4 + 12 + 4 + 8 + 8);
        builder.finish().unwrap()
    }

    #[test]
    fn records_are_applied_at_their_frames() {
        let chunk = TemporalChunk::<u16>::parse(Layout::Values, sample(), [3, 2], 5).unwrap();
        assert_eq!(chunk.records.iter().map(|record| record.bytes).collect::<Vec<_>>(), [24, 28]);
        let mut picture = [0; 6];
        assert_eq!(chunk.advance(&mut picture, None, 2, 1), 6);
        assert_eq!(picture, [1, 2, 3, 4, 5, 6]);
        assert_eq!(chunk.advance(&mut picture, Some(2), 4, 1), 4);
        assert_eq!(picture, [1, 20, 30, 4, 50, 60]);
        assert_eq!(chunk.advance(&mut picture, Some(4), 4, 1), 0);
        assert_eq!(chunk.advance(&mut picture, Some(4), 0, 1), 6);
        assert_eq!(picture, [1, 2, 3, 4, 5, 6]);
    }

    #[test]
    fn one_value_is_stored_once() {
        let mut builder = TableBuilder::default();
        builder.put_values(&[[1u8, 2, 3]; 100]);
        let payload = builder.finish().unwrap();
        assert_eq!(payload.len(), 4 + 8 + 4 + 3);
        let chunk = TemporalChunk::<[u8; 3]>::parse(Layout::Values, payload, [10, 10], 1).unwrap();
        let mut picture = [[0; 3]; 100];
        assert_eq!(chunk.advance(&mut picture, None, 0, 2), 100);
        assert!(picture.iter().all(|value| *value == [1, 2, 3]));
    }

    #[test]
    fn two_billion_frames_without_a_change_cost_nothing() {
        let mut builder = TableBuilder::default();
        builder.put_values(&[7u16; 6]);
        let payload = builder.finish().unwrap();
        let chunk = TemporalChunk::<u16>::parse(Layout::Values, payload, [3, 2], u32::MAX).unwrap();
        let mut picture = [0; 6];
        for window in [1, 2, 255] {
            assert_eq!(chunk.advance(&mut picture, None, u32::MAX - 1, window), 6);
            assert_eq!(chunk.advance(&mut picture, Some(5), u32::MAX - 1, window), 0);
        }
    }

    #[test]
    fn damaged_payloads_are_refused_or_stay_inside_the_picture() {
        let good = sample();
        for length in 0..good.len() {
            assert!(TemporalChunk::<u16>::parse(Layout::Values, good[..length].to_vec(), [3, 2], 5).is_err());
        }
        for at in 0..good.len() {
            for bit in 0..8 {
                let mut damaged = good.clone();
                damaged[at] ^= 1 << bit;
                if let Ok(chunk) = TemporalChunk::<u16>::parse(Layout::Values, damaged, [3, 2], 5) {
                    let mut picture = [0; 6];
                    chunk.advance(&mut picture, None, 4, 1);
                }
            }
        }
        assert!(TemporalChunk::<u16>::parse(Layout::Values, good.clone(), [3, 2], 3).is_err());
        assert!(TemporalChunk::<u16>::parse(Layout::Values, good.clone(), [2, 2], 5).is_err());
        let mut longer = good;
        longer.push(0);
        assert!(TemporalChunk::<u16>::parse(Layout::Values, longer, [3, 2], 5).is_err());
    }
}
