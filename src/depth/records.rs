//! The payload of a temporally coded chunk: a keyframe and what changes after it (depth.md 4).
//!
//! The pixels of a unit or a box are stored as values ([`Values`]) or in pieces ([`crate::depth::pieces`]).
//! Decoder first: [`TemporalChunk`]. The encoder's side, [`ChunkBuilder`], is below it.

use std::marker::PhantomData;

use crate::container::Payload;
use crate::container::fields::{Fields, PutFields};
use crate::depth::boxes::{MAX_BOXES, PixelBox};
use crate::depth::record_table::{self, TableBuilder};
use crate::depth::texel::Texel;
use crate::error::Result;

/// The whole unit follows, row-major.
const WHOLE: u8 = 0;
/// One value follows, which the whole unit has.
const CONSTANT: u8 = 1;
/// Boxes follow, then their pixels.
const BOXES: u8 = 2;
const SECTION: &str = "depth.md 4";

/// How the pixels of a rectangle, which is a unit or a box, are stored.
pub trait Layout<T: Texel>: std::fmt::Debug + Clone + Copy + Send + Sync + 'static {
    /// Boxes start at multiples of this, in pixels, and end at multiples of it or at the unit's edge.
    const GRID: u32;

    /// Takes the bytes of a rectangle of this width and height, and checks them.
    fn take(fields: &mut Fields<'_>, size: [usize; 2]) -> Result<()>;

    /// Writes the pixels of a rectangle (left, top, width, height) into a picture of `stride` columns; `bytes` start
    /// with what [`Self::take`] took.
    fn draw(bytes: &[u8], rect: [usize; 4], picture: &mut [T], stride: usize);
}

/// Values as they are, row by row.
#[derive(Debug, Clone, Copy)]
pub struct Values;

impl<T: Texel> Layout<T> for Values {
    const GRID: u32 = 1;

    fn take(fields: &mut Fields<'_>, [width, height]: [usize; 2]) -> Result<()> {
        let bytes = width.saturating_mul(height).saturating_mul(T::BYTES);
        fields.bytes(bytes).map(drop)
    }

    fn draw(bytes: &[u8], [left, top, width, height]: [usize; 4], picture: &mut [T], stride: usize) {
        if width == stride {
            let pixels = top * stride..(top + height) * stride;
            return T::get_row(&mut picture[pixels], &bytes[..width * height * T::BYTES]);
        }
        let rows = picture[top * stride..].chunks_mut(stride).take(height);
        for (row, bytes) in rows.zip(bytes.chunks(width * T::BYTES)) {
            T::get_row(&mut row[left..left + width], bytes);
        }
    }
}

/// What one record does to the picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Body {
    /// Every pixel, at this offset of the payload.
    Whole(usize),
    /// Every pixel, the same value, at this offset.
    Constant(usize),
    /// These of the chunk's boxes.
    Boxes {
        /// Index of the first in [`TemporalChunk::boxes`].
        first: usize,
        /// Their number.
        count: usize,
    },
}

/// A record: the frame, counted from the chunk's first, and what it changes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Record {
    /// Frames since the keyframe.
    pub frame: u32,
    /// What changes.
    pub body: Body,
    /// Payload bytes that it takes, its row in the record table included.
    pub bytes: u64,
}

/// A payload that has been checked, ready to be applied.
#[derive(Debug, Clone)]
pub struct TemporalChunk<T, L = Values> {
    payload: Payload,
    records: Vec<Record>,
    boxes: Vec<(PixelBox, usize)>,
    size: [u32; 2],
    layout: PhantomData<(T, L)>,
}

impl<T: Texel, L: Layout<T>> TemporalChunk<T, L> {
    /// Checks a payload for a unit of `size` (width, height) pixels and `frame_count` frames.
    ///
    /// Afterwards every offset lies inside the payload and every box inside the unit, no two boxes of a record
    /// overlap, frames ascend, and the first record is a keyframe.
    pub fn parse(payload: impl Into<Payload>, size: [u32; 2], frame_count: u32) -> Result<Self> {
        let payload = payload.into();
        let mut fields = Fields::new(&payload, 0, SECTION);
        let table = record_table::read(&mut fields, frame_count)?;
        let mut chunk = TemporalChunk {
            payload: Payload::from(Vec::new()),
            records: Vec::with_capacity(table.len()),
            boxes: Vec::new(),
            size,
            layout: PhantomData,
        };
        for (at, &row) in table.iter().enumerate() {
            record_table::check_start(&fields, at, row)?;
            let body = chunk.parse_body(&mut fields)?;
            if at == 0 && matches!(body, Body::Boxes { .. }) {
                return Err(fields.error("a chunk's first record must be a whole picture"));
            }
            let bytes = record_table::ROW_BYTES as u64 + fields.offset() - u64::from(row.offset);
            chunk.records.push(Record { frame: row.frame, body, bytes });
        }
        fields.finish()?;
        chunk.payload = payload;
        Ok(chunk)
    }

    fn parse_body(&mut self, fields: &mut Fields<'_>) -> Result<Body> {
        let [width, height] = self.size;
        let kind = fields.u8()?;
        fields.zeros(1)?;
        let count = fields.u16()?;
        if kind != BOXES && count != 0 {
            return Err(fields.error("a whole picture announces boxes"));
        }
        match kind {
            WHOLE => {
                let start = fields.position();
                L::take(fields, [width as usize, height as usize])?;
                Ok(Body::Whole(start))
            }
            CONSTANT => {
                let start = fields.position();
                fields.bytes(T::BYTES)?;
                Ok(Body::Constant(start))
            }
            BOXES if count == 0 || count > MAX_BOXES => Err(fields.error(format!("a record of {count} boxes"))),
            BOXES => {
                let first = self.boxes.len();
                for _ in 0..count {
                    let [x, y, w, h] = [fields.u16()?, fields.u16()?, fields.u16()?, fields.u16()?];
                    let inside =
                        |start: u16, size: u16, limit: u32| size > 0 && u32::from(start) + u32::from(size) <= limit;
                    if !inside(x, w, width) || !inside(y, h, height) {
                        return Err(fields.error(format!("a box of {w}x{h} at {x},{y} is not inside {width}x{height}")));
                    }
                    let on_grid = |start: u16, size: u16, limit: u32| {
                        let end = u32::from(start) + u32::from(size);
                        u32::from(start) % L::GRID == 0 && (end % L::GRID == 0 || end == limit)
                    };
                    if !on_grid(x, w, width) || !on_grid(y, h, height) {
                        return Err(fields.error(format!("a box of {w}x{h} at {x},{y} cuts blocks of 4x4 pixels")));
                    }
                    let new = PixelBox { x, y, width: w, height: h };
                    if self.boxes[first..].iter().any(|(other, _)| other.overlaps(new)) {
                        return Err(fields.error("two boxes of a record overlap"));
                    }
                    self.boxes.push((new, 0));
                }
                for at in first..self.boxes.len() {
                    let (b, start) = &mut self.boxes[at];
                    *start = fields.position();
                    L::take(fields, [usize::from(b.width), usize::from(b.height)])?;
                }
                Ok(Body::Boxes { first, count: usize::from(count) })
            }
            other => Err(fields.error(format!("a record of kind {other}, which is unknown"))),
        }
    }

    /// Width and height of the unit in pixels.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// The payload that was checked.
    pub fn payload(&self) -> &[u8] {
        &self.payload
    }

    /// The payload's memory, for the next chunk.
    pub fn into_spare(self) -> Vec<u8> {
        self.payload.into_spare()
    }

    /// All records in order of their frames; frames without one change nothing.
    pub fn records(&self) -> &[Record] {
        &self.records
    }

    /// The boxes of a record, with the payload offset of their pixels.
    pub fn boxes(&self, body: Body) -> &[(PixelBox, usize)] {
        match body {
            Body::Boxes { first, count } => &self.boxes[first..first + count],
            _ => &[],
        }
    }

    /// Pixels that a record writes.
    pub fn updated_pixels(&self, body: Body) -> u64 {
        match body {
            Body::Boxes { .. } => self.boxes(body).iter().map(|(b, _)| u64::from(b.area())).sum(),
            _ => u64::from(self.size[0]) * u64::from(self.size[1]),
        }
    }

    /// The stored rectangles of a record: width and height, and their bytes, which other bytes may follow. None for one
    /// value that the whole unit has.
    pub fn rectangles(&self, body: Body) -> impl Iterator<Item = ([usize; 2], &[u8])> {
        let whole = match body {
            Body::Whole(start) => Some((self.size.map(|side| side as usize), start)),
            _ => None,
        };
        let boxes = self.boxes(body).iter();
        let boxes = boxes.map(|&(b, start)| ([usize::from(b.width), usize::from(b.height)], start));
        whole.into_iter().chain(boxes).map(|(size, start)| (size, &self.payload[start..]))
    }

    /// Brings `picture`, which shows frame `at` of this chunk (`None`: nothing yet), to frame `target` in steps of at
    /// most `window` frames; answers how many pixels were written.
    ///
    /// Both frames count from the chunk's first. Going back starts over at the keyframe.
    pub fn advance(&self, picture: &mut [T], at: Option<u32>, target: u32, window: u8) -> u64 {
        record_table::steps(&self.records, |record| record.frame, at, target, window)
            .map(|found| self.apply(picture, self.records[found].body))
            .sum()
    }

    /// Writes what one record holds into `picture`; answers how many pixels that were.
    pub fn apply(&self, picture: &mut [T], body: Body) -> u64 {
        let [width, height] = self.size.map(|side| side as usize);
        match body {
            Body::Whole(start) => L::draw(&self.payload[start..], [0, 0, width, height], picture, width),
            Body::Constant(start) => {
                let mut value = [T::default()];
                T::get_row(&mut value, &self.payload[start..start + T::BYTES]);
                picture.fill(value[0]);
            }
            Body::Boxes { .. } => {
                for &(b, start) in self.boxes(body) {
                    let rect = [b.x, b.y, b.width, b.height].map(usize::from);
                    L::draw(&self.payload[start..], rect, picture, width);
                }
            }
        }
        self.updated_pixels(body)
    }
}

/// Builds a payload record by record.
#[derive(Debug)]
pub struct ChunkBuilder<T> {
    records: TableBuilder,
    texel: PhantomData<T>,
}

impl<T: Texel> ChunkBuilder<T> {
    /// Starts with the keyframe.
    pub fn new(keyframe: &[T]) -> Self {
        Self::starting_with(keyframe, |data| keyframe.iter().for_each(|value| value.put(data)))
    }

    /// Starts with the keyframe, which `put` writes unless it has one value.
    pub fn starting_with(keyframe: &[T], put: impl FnOnce(&mut Vec<u8>)) -> Self {
        let mut builder = ChunkBuilder { records: TableBuilder::default(), texel: PhantomData };
        let constant = keyframe.iter().all(|value| *value == keyframe[0]);
        let data = builder.begin(0, if constant { CONSTANT } else { WHOLE }, 0);
        if constant {
            keyframe[0].put(data);
        } else {
            put(data);
        }
        builder
    }

    fn begin(&mut self, frame: u32, kind: u8, count: u16) -> &mut Vec<u8> {
        let data = self.records.begin(frame);
        data.extend_from_slice(&[kind, 0]);
        data.put_u16(count);
        data
    }

    /// Adds the boxes that a frame updates, with their pixels from `picture` of `width` columns.
    pub fn push_boxes(&mut self, frame: u32, boxes: &[PixelBox], picture: &[T], width: usize) {
        self.put_boxes(frame, boxes, |b, data| {
            data.reserve(T::BYTES * b.area() as usize);
            for y in usize::from(b.y)..usize::from(b.y) + usize::from(b.height) {
                let start = y * width + usize::from(b.x);
                picture[start..start + usize::from(b.width)].iter().for_each(|value| value.put(data));
            }
        });
    }

    /// Adds the boxes that a frame updates; `put` writes the pixels of each.
    pub fn put_boxes(&mut self, frame: u32, boxes: &[PixelBox], mut put: impl FnMut(PixelBox, &mut Vec<u8>)) {
        let data = self.begin(frame, BOXES, boxes.len() as u16);
        for b in boxes {
            [b.x, b.y, b.width, b.height].iter().for_each(|&value| data.put_u16(value));
        }
        boxes.iter().for_each(|&b| put(b, data));
    }

    /// Bytes gathered so far.
    pub fn bytes(&self) -> usize {
        self.records.bytes()
    }

    /// The payload.
    pub fn finish(self) -> Result<Vec<u8>> {
        self.records.finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample() -> Vec<u8> {
        let mut builder = ChunkBuilder::<u16>::new(&[1, 2, 3, 4, 5, 6]);
        let picture = [1, 20, 30, 4, 50, 60];
        let b = PixelBox { x: 1, y: 0, width: 2, height: 2 };
        builder.push_boxes(3, &[b], &picture, 3);
        assert_eq!(builder.bytes(), 4 + 16 + 4 + 12 + 4 + 8 + 8);
        builder.finish().unwrap()
    }

    #[test]
    fn records_are_applied_at_their_frames() {
        let chunk = TemporalChunk::<u16>::parse(sample(), [3, 2], 5).unwrap();
        assert_eq!(chunk.records().iter().map(|record| record.bytes).collect::<Vec<_>>(), [24, 28]);
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
        let payload = ChunkBuilder::<[u8; 3]>::new(&[[1, 2, 3]; 100]).finish().unwrap();
        assert_eq!(payload.len(), 4 + 8 + 4 + 3);
        let chunk = TemporalChunk::<[u8; 3]>::parse(payload, [10, 10], 1).unwrap();
        let mut picture = [[0; 3]; 100];
        assert_eq!(chunk.advance(&mut picture, None, 0, 2), 100);
        assert!(picture.iter().all(|value| *value == [1, 2, 3]));
    }

    #[test]
    fn two_billion_frames_without_a_change_cost_nothing() {
        let payload = ChunkBuilder::<u16>::new(&[7; 6]).finish().unwrap();
        let chunk = TemporalChunk::<u16>::parse(payload, [3, 2], u32::MAX).unwrap();
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
            assert!(TemporalChunk::<u16>::parse(good[..length].to_vec(), [3, 2], 5).is_err());
        }
        for at in 0..good.len() {
            for bit in 0..8 {
                let mut damaged = good.clone();
                damaged[at] ^= 1 << bit;
                if let Ok(chunk) = TemporalChunk::<u16>::parse(damaged, [3, 2], 5) {
                    let mut picture = [0; 6];
                    chunk.advance(&mut picture, None, 4, 1);
                }
            }
        }
        assert!(TemporalChunk::<u16>::parse(good.clone(), [3, 2], 3).is_err());
        assert!(TemporalChunk::<u16>::parse(good.clone(), [2, 2], 5).is_err());
        let mut longer = good;
        longer.push(0);
        assert!(TemporalChunk::<u16>::parse(longer, [3, 2], 5).is_err());
    }
}
