//! Writes the index, as [`index_read`](crate::container::index_read) reads it.

use std::collections::HashMap;
use std::sync::Arc;

use crate::container::attributes::{Attributes, is_name};
use crate::container::chunk::{ChunkEntry, ChunkKey, Storage};
use crate::container::header::HEAD_BYTES;
use crate::container::index::{Index, ProbeEntry, StreamEntry};
use crate::container::index_read::{ChunkOrder, StreamRow, before_first, chunk_flags, probe_flags, stream_flags};
use crate::container::serialize::PutFields;
use crate::error::{Error, Result};

fn count(what: &str, n: usize) -> Result<u32> {
    u32::try_from(n).map_err(|_| Error::unsupported(format!("a container of {n} {what}: at most 2^32 - 1 fit")))
}

impl Index {
    /// Writes the index (container.md 4 to 6). Chunks are in the order in which they were written, not sorted.
    pub fn write(&self) -> Result<Vec<u8>> {
        if let Some(fault) = self.streams.iter().find_map(|stream| stream.fault(self.probes.len())) {
            return Err(Error::invalid(fault));
        }
        let mut out = Vec::new();
        for (what, n) in [("probes", self.probes.len()), ("streams", self.streams.len()), ("chunks", self.chunks.len())]
        {
            out.put_varint(count(what, n)?.into());
        }
        let streams = self.stream_rows();
        let by_time = self.chunk_rows(&streams, ChunkOrder::ByTime)?;
        let by_unit = self.chunk_rows(&streams, ChunkOrder::ByUnit)?;
        let (order, chunks) =
            if by_unit.len() < by_time.len() { (ChunkOrder::ByUnit, by_unit) } else { (ChunkOrder::ByTime, by_time) };
        out.push(order as u8);
        self.write_dataset(&mut out)?;
        let (mut probe, mut stream) = before_first();
        for next in &self.probes {
            write_probe(&mut out, &probe, next)?;
            probe.clone_from(next);
        }
        let mut headers = HashMap::new();
        for (at, next) in streams.into_iter().enumerate() {
            write_stream(&mut out, &stream, &next, headers.get(&next.entry.codec_header).map(|earlier| at - earlier))?;
            headers.insert(Arc::clone(&next.entry.codec_header), at);
            stream = next;
        }
        out.extend_from_slice(&chunks);
        self.attributes.write(&mut out)?;
        Ok(out)
    }

    /// Writes projection, frame rate and name of the dataset.
    fn write_dataset(&self, out: &mut Vec<u8>) -> Result<()> {
        out.push(self.projection);
        out.extend_from_slice(&[0; 3]);
        out.put_f64(self.fps);
        out.put_string("the dataset's name", &self.name)
    }

    /// Returns stream rows with the length of the stream's chunks, if all except the last of each unit have the same length.
    fn stream_rows(&self) -> Vec<StreamRow> {
        let mut longest = vec![0; self.streams.len()];
        for ChunkKey { stream, frame_count, .. } in self.chunks.iter().map(|chunk| chunk.key) {
            if let Some(longest) = longest.get_mut(stream as usize) {
                *longest = frame_count.max(*longest);
            }
        }
        for chunk in &self.chunks {
            let ChunkKey { stream, first_frame, frame_count, .. } = chunk.key;
            let Some(entry) = self.streams.get(stream as usize) else { continue };
            let longest = &mut longest[stream as usize];
            let left = u64::from(entry.first_frame) + u64::from(entry.frame_count);
            if frame_count < *longest && u64::from(first_frame) + u64::from(frame_count) < left {
                *longest = 0;
            }
        }
        let rows = self.streams.iter().zip(longest);
        rows.map(|(entry, chunk_frames)| StreamRow { entry: entry.clone(), chunk_frames }).collect()
    }

    fn chunk_rows(&self, streams: &[StreamRow], order: ChunkOrder) -> Result<Vec<u8>> {
        let mut out = Vec::new();
        let units: u64 = streams.iter().map(|stream| u64::from(stream.entry.unit_count())).sum();
        if units > self.chunks.len() as u64 {
            return Err(Error::invalid(format!("{} chunks for {units} units: one is missing", self.chunks.len())));
        }
        let mut first_unit = Vec::with_capacity(streams.len());
        let mut next_frame = Vec::new();
        for StreamRow { entry, .. } in streams {
            first_unit.push(next_frame.len());
            next_frame.resize(next_frame.len() + entry.unit_count() as usize, entry.first_frame);
        }
        let units = next_frame.len();
        let mut stored = HashMap::new();
        let (mut predicted, mut position) = (0, HEAD_BYTES as u64);
        for (at, chunk) in self.chunks.iter().enumerate() {
            let ChunkEntry { key, offset, stored_bytes, raw_bytes, crc32, storage } = *chunk;
            let stream = streams.get(key.stream as usize).filter(|stream| key.unit < stream.entry.unit_count());
            let unit = stream.map(|_| first_unit[key.stream as usize] + key.unit as usize);
            let (Some(stream), Some(unit)) = (stream, unit) else { return Err(out_of_order(key)) };
            let end = u64::from(stream.entry.first_frame) + u64::from(stream.entry.frame_count);
            let last = u64::from(key.first_frame) + u64::from(key.frame_count);
            if next_frame[unit] != key.first_frame || last > end {
                return Err(out_of_order(key));
            }
            next_frame[unit] += key.frame_count;
            let place = (offset, stored_bytes, raw_bytes, crc32, storage);
            let shared = stored.insert(place, at).map(|earlier| at - earlier - 1);
            let (low, value) = match shared {
                Some(back) => (chunk_flags::SHARED, back as u64),
                None => (storage as u64, stored_bytes.into()),
            };
            let step = (unit + units - predicted) % units;
            out.put_varint(value << chunk_flags::BITS | low | if step > 0 { chunk_flags::STEP } else { 0 });
            if step > 0 {
                out.put_varint(step as u64);
            }
            if stream.chunk_frames == 0 {
                out.put_varint(key.frame_count.into());
            }
            if shared.is_none() {
                if offset != position {
                    return Err(Error::invalid(format!("a chunk at byte {offset}, where {position} was expected")));
                }
                position += u64::from(stored_bytes);
                if storage != Storage::Raw {
                    out.put_varint(raw_bytes.into());
                }
                out.put_u32(crc32);
            }
            predicted = if order == ChunkOrder::ByUnit && last < end { unit } else { (unit + 1) % units };
        }
        Ok(out)
    }
}

fn out_of_order(key: ChunkKey) -> Error {
    let ChunkKey { stream, unit, first_frame, frame_count } = key;
    Error::invalid(format!(
        "a chunk of {frame_count} frames from frame {first_frame} on is not the next of stream {stream}, unit {unit}"
    ))
}

fn write_probe(out: &mut Vec<u8>, before: &ProbeEntry, probe: &ProbeEntry) -> Result<()> {
    // Compared by their bits: 0 and −0 differ.
    let same = |a: &[f64; 4], b: &[f64; 4]| a.map(f64::to_bits) == b.map(f64::to_bits);
    let flags = [
        (probe_flags::ORIENTATION, !same(&before.orientation, &probe.orientation)),
        (probe_flags::FRAMES, before.frames != probe.frames),
        (probe_flags::INTRINSICS, !same(&before.intrinsics, &probe.intrinsics)),
    ];
    let flags = flags_of(&flags);
    out.push(flags);
    out.put_string("a probe's name", &probe.name)?;
    probe.position.iter().for_each(|&value| out.put_f64(value));
    if flags & probe_flags::ORIENTATION != 0 {
        probe.orientation.iter().for_each(|&value| out.put_f64(value));
    }
    if flags & probe_flags::FRAMES != 0 {
        put_varints(out, &probe.frames);
    }
    if flags & probe_flags::INTRINSICS != 0 {
        probe.intrinsics.iter().for_each(|&value| out.put_f64(value));
    }
    Ok(())
}

/// Writes the row after `before`. `back` is the distance to the last row with the same codec header, if any.
fn write_stream(out: &mut Vec<u8>, before: &StreamRow, row: &StreamRow, back: Option<usize>) -> Result<()> {
    let (old, new) = (&before.entry, &row.entry);
    let flags = [
        (stream_flags::KIND, (old.kind, old.codec) != (new.kind, new.codec)),
        (stream_flags::PROBE, old.probe != new.probe),
        (stream_flags::FACE, old.face.wrapping_add(1) != new.face),
        (stream_flags::SIZE, (old.width, old.height) != (new.width, new.height)),
        (stream_flags::FRAMES, (old.first_frame, old.frame_count) != (new.first_frame, new.frame_count)),
        (stream_flags::UNIT, (old.unit_width, old.unit_height) != (new.unit_width, new.unit_height)),
        (stream_flags::HEADER, old.codec_header != new.codec_header),
        (stream_flags::CHUNK_FRAMES, before.chunk_frames != row.chunk_frames),
    ];
    let flags = flags_of(&flags);
    let has = |flag: u8| flags & flag != 0;
    let StreamEntry {
        kind, face, probe, codec, width, height, first_frame, frame_count, unit_width, unit_height, ..
    } = *new;
    out.push(flags);
    if has(stream_flags::KIND) {
        out.push(kind);
        out.extend_from_slice(&codec);
    }
    if has(stream_flags::PROBE) {
        out.put_varint(probe.into());
    }
    if has(stream_flags::FACE) {
        out.push(face);
    }
    if has(stream_flags::SIZE) {
        put_varints(out, &[width, height]);
    }
    if has(stream_flags::FRAMES) {
        put_varints(out, &[first_frame, frame_count]);
    }
    if has(stream_flags::UNIT) {
        put_varints(out, &[unit_width, unit_height]);
    }
    if has(stream_flags::HEADER) {
        out.put_varint(back.unwrap_or(0) as u64);
        if back.is_none() {
            out.put_varint(count("codec header bytes", new.codec_header.len())?.into());
            out.extend_from_slice(&new.codec_header);
        }
    }
    if has(stream_flags::CHUNK_FRAMES) {
        put_varints(out, &[row.chunk_frames]);
    }
    Ok(())
}

impl Attributes {
    pub(super) fn write(&self, out: &mut Vec<u8>) -> Result<()> {
        match self.iter().find(|(name, _)| !is_name(name)) {
            Some((name, _)) => Err(Error::invalid(format!("{name:?} is not an attribute name"))),
            None => self.write_rows(out),
        }
    }

    pub(super) fn write_rows(&self, out: &mut Vec<u8>) -> Result<()> {
        for (name, value) in self.iter() {
            out.put_string("an attribute's name", name)?;
            out.put_varint(count("bytes of an attribute", value.len())?.into());
            out.extend_from_slice(value);
        }
        Ok(())
    }
}

fn flags_of(fields: &[(u8, bool)]) -> u8 {
    fields.iter().filter(|(_, present)| *present).fold(0, |flags, (flag, _)| flags | flag)
}

fn put_varints(out: &mut Vec<u8>, values: &[u32]) {
    values.iter().for_each(|&value| out.put_varint(value.into()));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_takes_six_bytes_and_a_stream_one() {
        let codec_header = Arc::new(vec![7; 3000]);
        let stream = |face| StreamEntry {
            kind: 0,
            face,
            probe: 0,
            codec: *b"TEST",
            width: 512,
            height: 512,
            first_frame: 0,
            frame_count: 30,
            unit_width: 64,
            unit_height: 64,
            codec_header: Arc::new(codec_header.to_vec()),
        };
        let (mut probe, _) = before_first();
        probe.name = "00".into();
        let mut index =
            Index { fps: 24.0, probes: vec![probe], streams: (0..6).map(stream).collect(), ..Index::default() };
        let mut offset = 16;
        // Chunks of 12 frames, ordered by time; the last chunk of each unit has six.
        for (first_frame, frame_count) in [(0, 12), (12, 12), (24, 6)] {
            for (stream, unit) in (0..6).flat_map(|stream| (0..64).map(move |unit| (stream, unit))) {
                let bytes = 600 + unit * 3;
                let key = ChunkKey { stream, unit, first_frame, frame_count };
                let (stored_bytes, raw_bytes, crc32, storage) = (bytes, bytes, unit ^ stream, Storage::Raw);
                index.chunks.push(ChunkEntry { key, offset, stored_bytes, raw_bytes, crc32, storage });
                offset += u64::from(bytes);
            }
        }
        let bytes = index.write().unwrap();
        let rows = 6 * index.chunks.len();
        assert!((rows + 3000..rows + 3100).contains(&bytes.len()), "{} bytes", bytes.len());
        let read = Index::read(&bytes, offset).unwrap();
        assert!(read.streams.iter().all(|stream| Arc::ptr_eq(&stream.codec_header, &read.streams[0].codec_header)));
        index.chunks.sort_by_key(|chunk| chunk.key);
        assert_eq!(read, index);
    }

    #[test]
    fn chunks_that_rows_cannot_express_are_refused() {
        type Spoil = fn(&mut Index);
        let spoils: [(Spoil, &str); 5] = [
            (|index| index.chunks.swap(0, 1), "is not the next of stream 0, unit 0"),
            (|index| index.chunks[1].key.frame_count = 3, "is not the next of stream 0, unit 0"),
            (|index| index.chunks[0].offset = 17, "a chunk at byte 17, where 16 was expected"),
            (|index| index.chunks.clear(), "0 chunks for 1 units"),
            (|index| index.streams[0].unit_width = 0, "each must be 1 to 16384"),
        ];
        for (spoil, expected) in spoils {
            let (mut probe, stream) = before_first();
            probe.name = "00".into();
            let entry = StreamEntry {
                face: 0,
                width: 1,
                height: 1,
                unit_width: 1,
                unit_height: 1,
                frame_count: 4,
                ..stream.entry
            };
            let mut index = Index { fps: 1.0, probes: vec![probe], streams: vec![entry], ..Index::default() };
            for (first_frame, offset) in [(0, 16), (2, 20)] {
                let key = ChunkKey { stream: 0, unit: 0, first_frame, frame_count: 2 };
                let (stored_bytes, raw_bytes, storage) = (4, 4, Storage::Raw);
                index.chunks.push(ChunkEntry { key, offset, stored_bytes, raw_bytes, crc32: first_frame, storage });
            }
            spoil(&mut index);
            let message = index.write().unwrap_err().to_string();
            assert!(message.contains(expected), "{message}");
        }
    }
}
