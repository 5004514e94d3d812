//! Record table at the start of a chunk's payload, which maps frames to records (depth.md 4), and the steps of a decoder over it.
//! Chunks of boxes, of nodes and of trees share it.

use crate::container::fields::Fields;
#[cfg(feature = "encode")]
use crate::container::serialize::PutFields;
#[cfg(feature = "encode")]
use crate::error::Error;
use crate::error::Result;

pub const ROW_BYTES: usize = 8;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Row {
    pub frame: u32,
    pub offset: u32,
}

/// Reads the table of a chunk of `frame_count` frames. Fails unless it has at least one row, its first frame is 0, and frames
/// ascend.
pub fn read(fields: &mut Fields<'_>, frame_count: u32) -> Result<Vec<Row>> {
    let count = fields.u32()?;
    if u64::from(count) * ROW_BYTES as u64 > fields.remaining() as u64 || count > frame_count || count == 0 {
        return Err(fields.error(format!("{count} records for {frame_count} frames do not fit")));
    }
    let rows =
        (0..count).map(|_| Ok(Row { frame: fields.u32()?, offset: fields.u32()? })).collect::<Result<Vec<_>>>()?;
    for (at, row) in rows.iter().enumerate() {
        let ascends = if at == 0 { row.frame == 0 } else { row.frame > rows[at - 1].frame };
        if !ascends || row.frame >= frame_count {
            let frame = row.frame;
            return Err(fields.error(format!("record {at} is for frame {frame}, out of order or out of range")));
        }
    }
    Ok(rows)
}

pub fn check_start(fields: &Fields<'_>, at: usize, row: Row) -> Result<()> {
    if u64::from(row.offset) == fields.offset() {
        return Ok(());
    }
    Err(fields.error(format!("record {at} was announced at offset {}", row.offset)))
}

/// Returns the indices of the records that a decoder applies to step from frame `at` of a chunk (`None`: no frame shown yet) to
/// `target` in steps of at most `window` frames. Frames of records ascend from 0. Going back restarts at the keyframe.
pub fn steps<'a, R>(
    records: &'a [R],
    frame_of: impl Fn(&R) -> u32 + Copy + 'a,
    at: Option<u32>,
    target: u32,
    window: u8,
) -> impl Iterator<Item = usize> + 'a {
    let (start, first) = match at.filter(|&at| at <= target) {
        Some(at) => (at, None),
        None => (0, Some(0)),
    };
    let window = u32::from(window.max(1));
    let mut frame = start;
    let later = std::iter::from_fn(move || {
        while frame < target {
            // Steps to frames without a record do nothing and are skipped at once. Otherwise a payload of a few bytes that
            // declares 2^31 frames would take as many steps.
            let next = records.partition_point(|record| frame_of(record) <= frame);
            let stop = records.get(next).map_or(target, |record| frame_of(record).min(target));
            frame += (stop - frame - 1) / window * window;
            frame += window.min(target - frame);
            if let Ok(found) = records.binary_search_by_key(&frame, frame_of) {
                return Some(found);
            }
        }
        None
    });
    first.into_iter().chain(later)
}

/// Builder of a chunk's payload: the record table, and the records after it.
#[cfg(feature = "encode")]
#[derive(Debug, Default)]
pub struct TableBuilder {
    rows: Vec<Row>,
    data: Vec<u8>,
}

#[cfg(feature = "encode")]
impl TableBuilder {
    /// Starts the record of a frame; returns the buffer to which its bytes are appended.
    pub fn begin(&mut self, frame: u32) -> &mut Vec<u8> {
        self.rows.push(Row { frame, offset: self.data.len() as u32 });
        &mut self.data
    }

    pub fn bytes(&self) -> usize {
        self.start() + self.data.len()
    }

    fn start(&self) -> usize {
        4 + self.rows.len() * ROW_BYTES
    }

    pub fn finish(self) -> Result<Vec<u8>> {
        let start = self.start();
        if u32::try_from(self.bytes()).is_err() {
            return Err(Error::unsupported(
                "a chunk of more than 4 GiB: use a shorter keyframe interval or more tiles",
            ));
        }
        let mut payload = Vec::with_capacity(self.bytes());
        payload.put_u32(self.rows.len() as u32);
        for row in self.rows {
            payload.put_u32(row.frame);
            payload.put_u32(start as u32 + row.offset);
        }
        payload.extend_from_slice(&self.data);
        Ok(payload)
    }
}
