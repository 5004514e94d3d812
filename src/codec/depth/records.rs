//! Payload of a temporally coded chunk: a keyframe and the changes after it (depth.md 4).
//!
//! The pixels of a unit or a box are stored as values or in block tiles ([`Layout`]).

#[cfg(feature = "encode")]
pub mod builder;

use std::marker::PhantomData;

use crate::container::Payload;
use crate::container::fields::Fields;
use crate::depth::block_tiles::Layout;
use crate::depth::boxes::{MAX_BOXES, PixelBox};
use crate::depth::record_table;
use crate::depth::texel::Texel;
use crate::error::Result;

/// Record kind: the pixels of the whole unit follow.
const WHOLE: u8 = 0;
/// Record kind: one value for the whole unit follows.
const CONSTANT: u8 = 1;
/// Record kind: boxes follow, then their pixels.
const BOXES: u8 = 2;
const SECTION: &str = "depth.md 4";

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Body {
    Whole(usize),
    Constant(usize),
    Boxes { first: usize, count: usize },
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Record {
    pub frame: u32,
    pub body: Body,
    /// Bytes of the record in the payload, including its row of the record table.
    pub bytes: u64,
}

#[derive(Debug, Clone)]
pub struct TemporalChunk<T> {
    pub layout: Layout,
    pub payload: Payload,
    /// Records in order of their frames. Frames without a record change nothing.
    pub records: Vec<Record>,
    boxes: Vec<(PixelBox, usize)>,
    pub size: [u32; 2],
    texel: PhantomData<T>,
}

impl<T: Texel> TemporalChunk<T> {
    /// Parses and checks a payload. On success every offset lies inside the payload and every box inside the unit, boxes of a
    /// record do not overlap, frames ascend, and the first record is a keyframe.
    pub fn parse(layout: Layout, payload: impl Into<Payload>, size: [u32; 2], frame_count: u32) -> Result<Self> {
        let payload = payload.into();
        let mut fields = Fields::new(&payload, 0, SECTION);
        let table = record_table::read(&mut fields, frame_count)?;
        let mut chunk = TemporalChunk {
            layout,
            payload: Payload::from(Vec::new()),
            records: Vec::with_capacity(table.len()),
            boxes: Vec::new(),
            size,
            texel: PhantomData,
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
                self.layout.take::<T>(fields, [width as usize, height as usize])?;
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
                    let grid = self.layout.grid();
                    let on_grid = |start: u16, size: u16, limit: u32| {
                        let end = u32::from(start) + u32::from(size);
                        u32::from(start) % grid == 0 && (end % grid == 0 || end == limit)
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
                    self.layout.take::<T>(fields, [usize::from(b.width), usize::from(b.height)])?;
                }
                Ok(Body::Boxes { first, count: usize::from(count) })
            }
            other => Err(fields.error(format!("a record of kind {other}, which is unknown"))),
        }
    }

    pub fn into_spare(self) -> Vec<u8> {
        self.payload.into_spare()
    }

    /// Returns the boxes of a record, with the payload offset of their pixels.
    pub fn boxes(&self, body: Body) -> &[(PixelBox, usize)] {
        match body {
            Body::Boxes { first, count } => &self.boxes[first..first + count],
            _ => &[],
        }
    }

    pub fn updated_pixels(&self, body: Body) -> u64 {
        match body {
            Body::Boxes { .. } => self.boxes(body).iter().map(|(b, _)| u64::from(b.area())).sum(),
            _ => u64::from(self.size[0]) * u64::from(self.size[1]),
        }
    }

    /// Returns the stored rectangles of a record: width and height, and a slice that starts with their bytes. A constant record
    /// has none.
    pub fn rectangles(&self, body: Body) -> impl Iterator<Item = ([usize; 2], &[u8])> {
        let whole = match body {
            Body::Whole(start) => Some((self.size.map(|side| side as usize), start)),
            _ => None,
        };
        let boxes = self.boxes(body).iter();
        let boxes = boxes.map(|&(b, start)| ([usize::from(b.width), usize::from(b.height)], start));
        whole.into_iter().chain(boxes).map(|(size, start)| (size, &self.payload[start..]))
    }

    /// Advances `picture` from frame `at` of this chunk (`None`: no frame shown yet) to `target` in steps of at most `window`
    /// frames; returns the number of pixels written. Going back restarts at the keyframe.
    pub fn advance(&self, picture: &mut [T], at: Option<u32>, target: u32, window: u8) -> u64 {
        record_table::steps(&self.records, |record| record.frame, at, target, window)
            .map(|found| self.apply(picture, self.records[found].body))
            .sum()
    }

    pub fn apply(&self, picture: &mut [T], body: Body) -> u64 {
        let [width, height] = self.size.map(|side| side as usize);
        match body {
            Body::Whole(start) => self.layout.draw(&self.payload[start..], [0, 0, width, height], picture, width),
            Body::Constant(start) => {
                let mut value = [T::default()];
                T::get_row(&mut value, &self.payload[start..start + T::BYTES]);
                picture.fill(value[0]);
            }
            Body::Boxes { .. } => {
                for &(b, start) in self.boxes(body) {
                    self.layout.draw(&self.payload[start..], b.rect(), picture, width);
                }
            }
        }
        self.updated_pixels(body)
    }
}
