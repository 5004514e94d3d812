//! The attributes `shard` and `shard.footage` (container.md 6.4): the piece of an encode that a container holds, the streams
//! of the whole encode, and digests of its footage.

use crate::container::Fields;
use crate::container::index::MAX_FRAME;
use crate::error::Result;
use crate::image::{Face, StreamKind};

/// Name of the attribute with a [`ShardEntry`].
pub const SHARD: &str = "shard";
/// Name of the attribute with [`FootageDigests`].
pub const SHARD_FOOTAGE: &str = "shard.footage";
const SECTION: &str = "container.md 6.4";
/// Minimum bytes of a stream: kind, probe, face, group, first frame and number of frames, each at least one byte.
const MIN_STREAM_BYTES: usize = 6;

#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ShardEntry {
    /// Identifier of the encode, equal in all its pieces.
    pub job: [u8; 16],
    /// Number of the piece, from 1 to `count`.
    pub number: u32,
    pub count: u32,
    /// Streams of the whole encode.
    pub streams: Vec<WholeStream>,
}

/// A stream of the whole encode. The chunks of a group are ordered by time in the file, not by stream.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct WholeStream {
    pub kind: u8,
    pub probe: u16,
    pub face: u8,
    pub group: u32,
    pub first_frame: u32,
    pub frame_count: u32,
}

/// Digests of the content of all frames, 16 bytes for each stream of the whole encode.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct FootageDigests(pub Vec<[u8; 16]>);

impl FootageDigests {
    /// Reads the value of the attribute; `None` if its length does not match the number of streams.
    pub fn read(value: &[u8], streams: usize) -> Option<FootageDigests> {
        let (digests, []) = value.as_chunks() else { return None };
        (digests.len() == streams).then(|| FootageDigests(digests.to_vec()))
    }

    /// Returns the value of the attribute.
    pub fn write(&self) -> Vec<u8> {
        self.0.concat()
    }
}

impl ShardEntry {
    /// Reads the value of the attribute. Offsets in errors are relative to its start.
    pub fn read(value: &[u8]) -> Result<ShardEntry> {
        let mut fields = Fields::new(value, 0, SECTION);
        let mut job = [0; 16];
        job.copy_from_slice(fields.bytes(16)?);
        let (number, count) = (fields.varint_u32()?, fields.varint_u32()?);
        if !(1..=count).contains(&number) {
            return Err(fields.error(format!("piece {number} of {count}")));
        }
        let stream_count = fields.varint_u32()? as usize;
        if stream_count > fields.remaining() / MIN_STREAM_BYTES {
            return Err(fields.error(format!("{stream_count} streams do not fit the attribute")));
        }
        let streams = (0..stream_count).map(|_| WholeStream::read(&mut fields)).collect::<Result<_>>()?;
        fields.finish()?;
        Ok(ShardEntry { job, number, count, streams })
    }
}

impl WholeStream {
    fn read(fields: &mut Fields<'_>) -> Result<WholeStream> {
        let kind = fields.u8()?;
        let probe = fields.varint_u32()?;
        let probe =
            u16::try_from(probe).map_err(|_| fields.error(format!("probe {probe}, a file has at most 65536")))?;
        let (face, group) = (fields.u8()?, fields.varint_u32()?);
        let (first_frame, frame_count) = (fields.varint_u32()?, fields.varint_u32()?);
        if !StreamKind::ALL.iter().any(|known| *known as u8 == kind) || Face::from_index(face).is_none() {
            return Err(fields.error(format!("a stream of kind {kind} and face {face} is unknown")));
        }
        if frame_count == 0 || u64::from(first_frame) + u64::from(frame_count) > u64::from(MAX_FRAME) {
            return Err(fields.error(format!("{frame_count} frames from frame {first_frame} on are impossible")));
        }
        Ok(WholeStream { kind, probe, face, group, first_frame, frame_count })
    }
}

#[cfg(feature = "encode")]
mod write {
    use super::ShardEntry;
    use crate::container::serialize::PutFields;

    impl ShardEntry {
        /// Returns the value of the attribute.
        pub fn write(&self) -> Vec<u8> {
            let mut out = self.job.to_vec();
            out.put_varint(self.number.into());
            out.put_varint(self.count.into());
            out.put_varint(self.streams.len() as u64);
            for stream in &self.streams {
                out.push(stream.kind);
                out.put_varint(stream.probe.into());
                out.push(stream.face);
                for value in [stream.group, stream.first_frame, stream.frame_count] {
                    out.put_varint(value.into());
                }
            }
            out
        }
    }
}

#[cfg(feature = "encode")]
#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shard_comes_back_and_its_every_prefix_is_refused() {
        let stream = |kind, face| WholeStream { kind, probe: 300, face, group: 7, first_frame: 1001, frame_count: 240 };
        let shard =
            ShardEntry { job: *b"0123456789abcdef", number: 3, count: 54, streams: vec![stream(0, 1), stream(1, 6)] };
        let bytes = shard.write();
        assert_eq!(ShardEntry::read(&bytes).unwrap(), shard);
        for length in 0..bytes.len() {
            assert!(ShardEntry::read(&bytes[..length]).is_err(), "{length}");
        }
        assert!(ShardEntry::read(&ShardEntry { number: 0, ..shard.clone() }.write()).is_err());
        assert!(ShardEntry::read(&ShardEntry { number: 55, ..shard.clone() }.write()).is_err());
        for illegal in [
            WholeStream { kind: 4, ..stream(1, 6) },
            stream(1, 7),
            WholeStream { frame_count: 0, ..stream(1, 6) },
            WholeStream { first_frame: MAX_FRAME - 239, ..stream(1, 6) },
        ] {
            let shard = ShardEntry { streams: vec![illegal], ..shard.clone() };
            let message = ShardEntry::read(&shard.write()).unwrap_err().to_string();
            assert!(message.ends_with("(formats/container.md 6.4)"), "{message}");
        }
    }
}
