//! Reads the index (container.md 4 to 6), whose rows omit the fields that follow from earlier rows.
//!
//! The order of the chunk table determines streams, units, frames and the position of the stored bytes, so the row of a chunk
//! of a few hundred bytes takes six bytes.

use std::sync::Arc;

use crate::container::attributes::Attributes;
use crate::container::chunk::{ChunkEntry, ChunkKey, Storage};
use crate::container::fields::Fields;
use crate::container::header::HEAD_BYTES;
use crate::container::index::{Index, ProbeEntry, StreamEntry, check_count};
use crate::error::Result;

/// Minimum bytes of a probe row: flags, length of the name, position.
const PROBE_MIN_BYTES: usize = 1 + 2 + 3 * 8;

/// Fields that a row of the probe table has; the others are equal to those of the row before.
pub mod probe_flags {
    pub const ORIENTATION: u8 = 1;
    pub const FRAMES: u8 = 2;
    pub const INTRINSICS: u8 = 4;
    pub const RESERVED: u8 = !7;
}

/// Fields that a row of the stream table has; the others follow from the row before.
pub mod stream_flags {
    pub const KIND: u8 = 1;
    pub const PROBE: u8 = 2;
    pub const FACE: u8 = 4;
    pub const SIZE: u8 = 8;
    pub const FRAMES: u8 = 16;
    pub const UNIT: u8 = 32;
    pub const HEADER: u8 = 64;
    pub const CHUNK_FRAMES: u8 = 128;
}

/// Low bits of the first number in a row of the chunk table.
pub mod chunk_flags {
    pub const STORAGE: u64 = 3;
    /// Instead of a storage: the row has the stored bytes of an earlier row.
    pub const SHARED: u64 = 3;
    pub const STEP: u64 = 4;
    pub const BITS: u32 = 3;
}

/// Unit of the next row of the chunk table, unless the row has a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum ChunkOrder {
    /// The next unit, because encoders close the chunks of one time together.
    ByTime = 0,
    /// Unit of the chunk before, until its frames are complete.
    ByUnit = 1,
}

/// A row of the stream table, and the length of the stream's chunks for the chunk table.
#[derive(Debug, Clone, PartialEq)]
pub struct StreamRow {
    pub entry: StreamEntry,
    /// Frames of each chunk except the last of a unit; 0 if each row of the chunk table states them.
    pub chunk_frames: u32,
}

/// Rows from which the first probe and the first stream take the fields that they omit.
pub fn before_first() -> (ProbeEntry, StreamRow) {
    let (position, orientation, intrinsics) = ([0.0; 3], [0.0, 0.0, 0.0, 1.0], [0.0; 4]);
    let probe = ProbeEntry { name: String::new(), position, orientation, frames: [0; 2], intrinsics };
    let entry = StreamEntry {
        kind: 0,
        face: u8::MAX,
        probe: 0,
        codec: [0; 4],
        width: 0,
        height: 0,
        first_frame: 0,
        frame_count: 0,
        unit_width: 0,
        unit_height: 0,
        codec_header: Arc::default(),
    };
    (probe, StreamRow { entry, chunk_frames: 0 })
}

impl Index {
    /// Reads an index that starts at `offset` of its file, where the chunks end.
    pub fn read(bytes: &[u8], offset: u64) -> Result<Index> {
        let mut index = read_as_written(bytes, offset)?;
        index.chunks.sort_unstable_by_key(|chunk| chunk.key);
        index.check()?;
        Ok(index)
    }
}

/// As [`Index::read`], with the chunks in the order of their rows, which is the order of their stored bytes.
pub fn read_as_written(bytes: &[u8], offset: u64) -> Result<Index> {
    let mut fields = Fields::new(bytes, offset, "container.md 4");
    let [probe_count, stream_count, chunk_count] = varints(&mut fields)?;
    let order = match fields.u8()? {
        0 => ChunkOrder::ByTime,
        1 => ChunkOrder::ByUnit,
        other => return Err(fields.error(format!("order {other} of the chunk table is unknown"))),
    };
    let mut index = Index::read_dataset(&mut fields)?;
    let (mut probe, stream) = before_first();
    check_count(&fields, "probes", probe_count, PROBE_MIN_BYTES)?;
    for _ in 0..probe_count {
        probe = read_probe(&mut fields, probe)?;
        index.probes.push(probe.clone());
    }
    fields.enter("container.md 5");
    // A stream takes at least one byte in this table and one for each of its units.
    check_count(&fields, "streams", stream_count, 2)?;
    let mut streams: Vec<StreamRow> = Vec::with_capacity(stream_count as usize);
    for _ in 0..stream_count {
        let start = fields.offset();
        let row = read_stream(&mut fields, &streams, streams.last().unwrap_or(&stream))?;
        if let Some(fault) = row.entry.fault(index.probes.len()) {
            return Err(fields.error_at(start, fault));
        }
        streams.push(row);
    }
    fields.enter("container.md 6");
    check_count(&fields, "chunks", chunk_count, 1)?;
    index.chunks = ChunkTable::new(&fields, &streams, chunk_count)?.read(&mut fields, order, offset)?;
    index.attributes = Attributes::read(&mut fields)?;
    index.streams = streams.into_iter().map(|row| row.entry).collect();
    Ok(index)
}

fn varints<const N: usize>(fields: &mut Fields<'_>) -> Result<[u32; N]> {
    let mut values = [0; N];
    for value in &mut values {
        *value = fields.varint_u32()?;
    }
    Ok(values)
}

fn read_probe(fields: &mut Fields<'_>, before: ProbeEntry) -> Result<ProbeEntry> {
    let start = fields.offset();
    let flags = fields.u8()?;
    if flags & probe_flags::RESERVED != 0 {
        return Err(fields.error_at(start, format!("flags {flags} of a probe, of which some are unknown")));
    }
    let (name, position) = (fields.string("a probe's name")?, fields.finite_f64s("a probe's position")?);
    let mut probe = ProbeEntry { name, position, ..before };
    if flags & probe_flags::ORIENTATION != 0 {
        probe.orientation = fields.finite_f64s("a probe's orientation")?;
    }
    if flags & probe_flags::FRAMES != 0 {
        probe.frames = varints(fields)?;
    }
    if flags & probe_flags::INTRINSICS != 0 {
        probe.intrinsics = fields.finite_f64s("a probe's intrinsics")?;
    }
    probe.check(fields, start)?;
    Ok(probe)
}

/// Reads the row after `rows`; `before` is the last of these.
fn read_stream(fields: &mut Fields<'_>, rows: &[StreamRow], before: &StreamRow) -> Result<StreamRow> {
    let start = fields.offset();
    let flags = fields.u8()?;
    let has = |flag: u8| flags & flag != 0;
    let StreamRow { mut entry, mut chunk_frames } = before.clone();
    if has(stream_flags::KIND) {
        entry.kind = fields.u8()?;
        entry.codec.copy_from_slice(fields.bytes(4)?);
    }
    if has(stream_flags::PROBE) {
        let [probe] = varints(fields)?;
        let unknown = || fields.error_at(start, format!("a stream names probe {probe}, a file has at most 65536"));
        entry.probe = u16::try_from(probe).map_err(|_| unknown())?;
    }
    entry.face = if has(stream_flags::FACE) { fields.u8()? } else { entry.face.wrapping_add(1) };
    if has(stream_flags::SIZE) {
        [entry.width, entry.height] = varints(fields)?;
    }
    if has(stream_flags::FRAMES) {
        [entry.first_frame, entry.frame_count] = varints(fields)?;
    }
    if has(stream_flags::UNIT) {
        [entry.unit_width, entry.unit_height] = varints(fields)?;
    }
    if has(stream_flags::HEADER) {
        let [back] = varints(fields)?;
        entry.codec_header = match rows.len().checked_sub(back as usize) {
            Some(_) if back == 0 => {
                let [length] = varints(fields)?;
                Arc::new(fields.bytes(length as usize)?.to_vec())
            }
            Some(at) => Arc::clone(&rows[at].entry.codec_header),
            None => return Err(fields.error_at(start, format!("a codec header of {back} rows before the first"))),
        };
    }
    if has(stream_flags::CHUNK_FRAMES) {
        [chunk_frames] = varints(fields)?;
    }
    Ok(StreamRow { entry, chunk_frames })
}

/// Reader of the chunk table. Units are numbered across all streams.
struct ChunkTable<'a> {
    streams: &'a [StreamRow],
    /// Number of the first unit of each stream.
    first_unit: Vec<u32>,
    /// First frame of each unit that no row has covered yet.
    next_frame: Vec<u32>,
    chunks: Vec<ChunkEntry>,
    count: u32,
}

impl<'a> ChunkTable<'a> {
    fn new(fields: &Fields<'_>, streams: &'a [StreamRow], count: u32) -> Result<ChunkTable<'a>> {
        let mut units = 0u64;
        let mut first_unit = Vec::with_capacity(streams.len());
        for stream in streams {
            first_unit.push(units as u32);
            units += u64::from(stream.entry.unit_count());
            if units > u64::from(count) {
                return Err(
                    fields.error(format!("the streams have more units than the {count} rows of the chunk table"))
                );
            }
        }
        if units == 0 && count > 0 {
            return Err(fields.error(format!("{count} chunks and no stream")));
        }
        let mut next_frame = Vec::with_capacity(units as usize);
        for stream in streams {
            next_frame.resize(next_frame.len() + stream.entry.unit_count() as usize, stream.entry.first_frame);
        }
        Ok(ChunkTable { streams, first_unit, next_frame, chunks: Vec::with_capacity(count as usize), count })
    }

    /// Reads the rows, in file order.
    fn read(mut self, fields: &mut Fields<'_>, order: ChunkOrder, end: u64) -> Result<Vec<ChunkEntry>> {
        let units = self.next_frame.len() as u64;
        let (mut predicted, mut offset) = (0u64, HEAD_BYTES as u64);
        for _ in 0..self.count {
            let start = fields.offset();
            let head = fields.varint()?;
            let step = if head & chunk_flags::STEP == 0 {
                0
            } else {
                let step = u64::from(fields.varint_u32()?);
                if step == 0 || step >= units {
                    return Err(fields.error_at(start, format!("a step of {step} units, where there are {units}")));
                }
                step
            };
            let unit = (predicted + step) % units;
            let (key, complete) = self.key(fields, start, unit as usize)?;
            let entry = self.place(fields, start, (head, key), offset)?;
            entry.check(fields, start, end)?;
            if head & chunk_flags::STORAGE != chunk_flags::SHARED {
                offset += u64::from(entry.stored_bytes);
            }
            self.chunks.push(entry);
            predicted = if order == ChunkOrder::ByUnit && !complete { unit } else { (unit + 1) % units };
        }
        if offset != end {
            return Err(fields.error(format!("the chunks end at byte {offset}, and the index starts at {end}")));
        }
        Ok(self.chunks)
    }

    /// Returns the key of the next row of a unit, and true if the row completes the unit.
    fn key(&mut self, fields: &mut Fields<'_>, start: u64, at: usize) -> Result<(ChunkKey, bool)> {
        let stream = self.first_unit.partition_point(|&first| first as usize <= at) - 1;
        let (row, unit) = (&self.streams[stream], at as u32 - self.first_unit[stream]);
        let first_frame = self.next_frame[at];
        let left = row.entry.end_frame() - first_frame;
        let frame_count = match row.chunk_frames {
            0 => fields.varint_u32()?,
            frames => frames.min(left),
        };
        if frame_count == 0 || frame_count > left {
            return Err(fields.error_at(
                start,
                format!("a chunk of {frame_count} frames of stream {stream}, unit {unit}, of which {left} are left"),
            ));
        }
        self.next_frame[at] += frame_count;
        Ok((ChunkKey { stream: stream as u32, unit, first_frame, frame_count }, frame_count == left))
    }

    /// Reads the rest of a row: its bytes are stored at `offset`, or they are those of an earlier row.
    fn place(
        &self,
        fields: &mut Fields<'_>,
        start: u64,
        (head, key): (u64, ChunkKey),
        offset: u64,
    ) -> Result<ChunkEntry> {
        // 35 bits without the three flags: 32 bits.
        let value = (head >> chunk_flags::BITS) as u32;
        let Some(storage) = Storage::of(head & chunk_flags::STORAGE) else {
            let earlier = self.chunks.len().checked_sub(value as usize + 1).map(|at| self.chunks[at]);
            let none = || fields.error_at(start, format!("the bytes of a chunk {value} rows before the first"));
            return Ok(ChunkEntry { key, ..earlier.ok_or_else(none)? });
        };
        let raw_bytes = if storage == Storage::Raw { value } else { fields.varint_u32()? };
        Ok(ChunkEntry { key, offset, stored_bytes: value, raw_bytes, crc32: fields.u32()?, storage })
    }
}
