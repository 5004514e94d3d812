//! The index (container.md 4 to 6): the dataset, its probes, its streams, and the chunk table.
//!
//! Input: bytes whose CRC-32 matches. Output: consistent tables, whose numbers a decoder may use as indices.

use std::collections::HashSet;
use std::sync::Arc;

use crate::container::attributes::Attributes;
use crate::container::chunk::{ChunkEntry, ChunkPlace};
use crate::container::fields::Fields;
use crate::error::{Error, Result};

/// Maximum width or height of a stream in pixels.
pub const MAX_SIZE: u32 = 16_384;
/// Exclusive upper bound of frame numbers.
pub const MAX_FRAME: u32 = 1 << 31;

/// A probe: the place where its streams were captured.
#[derive(Debug, Clone, PartialEq)]
pub struct ProbeEntry {
    /// Name, unique in the file.
    pub name: String,
    /// Position in metres.
    pub position: [f64; 3],
    /// Orientation as a unit quaternion x, y, z, w; 0, 0, 0, 1 for no rotation.
    pub orientation: [f64; 4],
    /// First and last frame in which the probe is active.
    pub frames: [u32; 2],
    /// fx, fy, cx, cy of a perspective probe in pixels; zeros for other probes.
    pub intrinsics: [f64; 4],
}

#[derive(Debug, Clone, PartialEq)]
pub struct StreamEntry {
    /// 0: colour; 1: depth; 2: material; 3: alpha.
    pub kind: u8,
    /// 0 to 5: px nx py ny pz nz; 6: the view of a perspective probe.
    pub face: u8,
    pub probe: u16,
    pub codec: [u8; 4],
    pub width: u32,
    pub height: u32,
    pub first_frame: u32,
    /// Number of frames, at least 1.
    pub frame_count: u32,
    /// Width of a unit (tile or cell); units in the last column are cut off at the image's edge.
    pub unit_width: u32,
    pub unit_height: u32,
    /// Codec header; streams of one file with equal headers share it.
    pub codec_header: Arc<Vec<u8>>,
}

impl StreamEntry {
    pub fn grid(&self) -> [u32; 2] {
        [self.width.div_ceil(self.unit_width), self.height.div_ceil(self.unit_height)]
    }

    pub fn unit_count(&self) -> u32 {
        let [columns, rows] = self.grid();
        columns * rows
    }

    /// Left, top, width and height of a unit in pixels.
    pub fn unit_rect(&self, unit: u32) -> [u32; 4] {
        let [columns, _] = self.grid();
        let (x, y) = (unit % columns * self.unit_width, unit / columns * self.unit_height);
        [x, y, self.unit_width.min(self.width - x), self.unit_height.min(self.height - y)]
    }

    pub fn end_frame(&self) -> u32 {
        self.first_frame + self.frame_count
    }
}

#[derive(Debug, Clone, PartialEq, Default)]
pub struct Index {
    pub name: String,
    pub fps: f64,
    /// 0: cube maps; 1: perspective.
    pub projection: u8,
    pub probes: Vec<ProbeEntry>,
    /// Streams; no two have the same kind, probe and face.
    pub streams: Vec<StreamEntry>,
    /// Chunks, sorted by stream, unit and first frame.
    pub chunks: Vec<ChunkEntry>,
    pub attributes: Attributes,
}

impl Index {
    /// Reads projection, frame rate and name of the dataset.
    pub(super) fn read_dataset(fields: &mut Fields<'_>) -> Result<Index> {
        let projection = fields.u8()?;
        fields.zeros(3)?;
        if projection > 1 {
            return Err(fields.error(format!("projection {projection} is unknown")));
        }
        let fps = fields.finite_f64("the frame rate")?;
        if fps <= 0.0 {
            return Err(fields.error(format!("a frame rate of {fps} is not positive")));
        }
        let name = fields.string("the dataset's name")?;
        if name.chars().any(char::is_control) {
            return Err(fields.error("the dataset's name holds control characters"));
        }
        Ok(Index { name, fps, projection, ..Index::default() })
    }

    /// Checks the rules that involve several rows.
    pub(super) fn check(&self) -> Result<()> {
        self.check_unique()?;
        self.check_coverage()
    }

    pub fn unit_chunks(&self, stream: u32, unit: u32) -> &[ChunkEntry] {
        let chunks = self.stream_chunks(stream);
        let start = chunks.partition_point(|chunk| chunk.key.unit < unit);
        let length = chunks[start..].partition_point(|chunk| chunk.key.unit == unit);
        &chunks[start..start + length]
    }

    pub fn place(&self, chunk: &ChunkEntry) -> ChunkPlace {
        let last = self.unit_chunks(chunk.key.stream, chunk.key.unit).last();
        if last.is_some_and(|last| last.key == chunk.key) { ChunkPlace::Last } else { ChunkPlace::Inner }
    }

    pub fn stream_chunks(&self, stream: u32) -> &[ChunkEntry] {
        let start = self.chunks.partition_point(|chunk| chunk.key.stream < stream);
        let length = self.chunks[start..].partition_point(|chunk| chunk.key.stream == stream);
        &self.chunks[start..start + length]
    }

    /// Bytes of the chunks that a stream's decoder holds, one for each unit: the sum of the largest `held` of each unit, at
    /// most 2⁶⁴ − 1.
    pub fn held_payload_bytes(&self, stream: u32, held: impl Fn(&ChunkEntry) -> u64) -> u64 {
        let units = self.stream_chunks(stream).chunk_by(|a, b| a.key.unit == b.key.unit);
        units.map(|chunks| chunks.iter().map(&held).max().unwrap_or(0)).fold(0, u64::saturating_add)
    }

    fn check_unique(&self) -> Result<()> {
        let mut names = HashSet::new();
        if let Some(probe) = self.probes.iter().find(|probe| !names.insert(&probe.name)) {
            return Err(Error::invalid(format!("two probes are named '{}'", probe.name)));
        }
        let mut seen = HashSet::new();
        match self.streams.iter().position(|stream| !seen.insert((stream.kind, stream.probe, stream.face))) {
            None => Ok(()),
            Some(at) => Err(Error::invalid(format!("stream {at} has the kind, probe and face of an earlier one"))),
        }
    }

    /// Checks that the chunks of each unit of each stream cover its frames once, in order, and that there are no other
    /// chunks.
    fn check_coverage(&self) -> Result<()> {
        let broken = |stream: usize, unit: u32, frame: u64| {
            Error::invalid(format!(
                "the chunk table breaks off at stream {stream}, unit {unit}, frame {frame}: each unit's chunks must \
                 cover its frames, in order"
            ))
        };
        let mut chunks = self.chunks.iter().peekable();
        for (at, stream) in self.streams.iter().enumerate() {
            for unit in 0..stream.unit_count() {
                let (mut frame, end) = (u64::from(stream.first_frame), u64::from(stream.end_frame()));
                while frame < end {
                    let chunk = chunks.next().map(|chunk| chunk.key).filter(|key| {
                        (key.stream as usize, key.unit, u64::from(key.first_frame)) == (at, unit, frame)
                            && key.frame_count > 0
                            && frame + u64::from(key.frame_count) <= end
                    });
                    let Some(key) = chunk else { return Err(broken(at, unit, frame)) };
                    frame += u64::from(key.frame_count);
                }
            }
        }
        match chunks.next() {
            None => Ok(()),
            Some(chunk) => Err(broken(chunk.key.stream as usize, chunk.key.unit, u64::from(chunk.key.first_frame))),
        }
    }
}

/// Fails if `count` rows of at least `least` bytes do not fit into the remaining bytes, before memory is reserved for them.
pub(super) fn check_count(fields: &Fields<'_>, what: &str, count: u32, least: usize) -> Result<()> {
    if u64::from(count) * least as u64 > fields.remaining() as u64 {
        return Err(fields.error(format!("{count} {what} do not fit into the rest of the index")));
    }
    Ok(())
}

/// True if a probe's name is valid. Names become parts of file names when a container is decoded.
pub fn is_probe_name(name: &str) -> bool {
    let plain = |c: char| c.is_ascii_alphanumeric() || "._-".contains(c);
    !name.is_empty() && !name.starts_with('.') && name.chars().all(plain)
}

impl ProbeEntry {
    /// Fails if the values of the row that starts at `start` are illegal.
    pub(super) fn check(&self, fields: &Fields<'_>, start: u64) -> Result<()> {
        let ProbeEntry { name, frames, .. } = self;
        if !is_probe_name(name) {
            return Err(fields.error_at(
                start,
                format!("the probe name {name:?} holds more than letters, digits, '.', '_' and '-'"),
            ));
        }
        if frames[0] > frames[1] || frames[1] >= MAX_FRAME {
            return Err(
                fields.error_at(start, format!("probe '{name}' is active from frame {} to {}", frames[0], frames[1]))
            );
        }
        Ok(())
    }
}

impl StreamEntry {
    /// Returns an illegal value of the stream, if any, in a file of `probes` probes.
    pub(super) fn fault(&self, probes: usize) -> Option<String> {
        let StreamEntry { kind, face, probe, width, height, unit_width, unit_height, .. } = *self;
        let (first_frame, frame_count) = (self.first_frame, self.frame_count);
        if kind > 3 || face > 6 {
            return Some(format!("a stream of kind {kind} and face {face} is unknown"));
        }
        if usize::from(probe) >= probes {
            return Some(format!("a stream names probe {probe}, the file has {probes}"));
        }
        if [width, height, unit_width, unit_height].iter().any(|&size| size == 0 || size > MAX_SIZE) {
            return Some(format!(
                "a stream of {width}x{height} in units of {unit_width}x{unit_height}: each must be 1 to {MAX_SIZE}"
            ));
        }
        let impossible = frame_count == 0 || u64::from(first_frame) + u64::from(frame_count) > u64::from(MAX_FRAME);
        impossible.then(|| format!("a stream of {frame_count} frames from frame {first_frame} on is impossible"))
    }
}

#[cfg(feature = "encode")]
#[cfg(test)]
mod tests {
    use super::*;
    use crate::container::chunk::{ChunkKey, Storage};

    fn sample() -> Index {
        let stream = |kind, face| StreamEntry {
            kind,
            face,
            probe: 0,
            codec: *b"TEST",
            width: 5,
            height: 3,
            first_frame: 10,
            frame_count: 7,
            unit_width: 4,
            unit_height: 4,
            codec_header: Arc::new(vec![1, 2, 3]),
        };
        let mut index = Index {
            name: "sample".into(),
            fps: 24.0,
            projection: 0,
            probes: vec![ProbeEntry {
                name: "00".into(),
                position: [1.0, -2.0, 3.5],
                orientation: [0.0, 0.0, 0.0, 1.0],
                frames: [10, 16],
                intrinsics: [0.0; 4],
            }],
            streams: vec![stream(0, 0), stream(1, 0)],
            ..Index::default()
        };
        for stream in 0..2 {
            for unit in 0..2 {
                for (first_frame, frame_count) in [(10, 4), (14, 3)] {
                    index.chunks.push(ChunkEntry {
                        key: ChunkKey { stream, unit, first_frame, frame_count },
                        offset: 16,
                        stored_bytes: 100,
                        raw_bytes: 100,
                        crc32: 5,
                        storage: Storage::Raw,
                    });
                }
            }
        }
        index
    }

    /// End of the chunks of [`sample`], which are stored once.
    const END: u64 = 116;

    #[test]
    fn an_index_round_trips_and_finds_its_chunks() {
        let index = sample();
        let bytes = index.write().unwrap();
        assert_eq!(Index::read(&bytes, END).unwrap(), index);
        assert_eq!(index.unit_chunks(1, 1).iter().map(|c| c.key.first_frame).collect::<Vec<_>>(), [10, 14]);
        assert_eq!(index.unit_chunks(2, 0), []);
        assert_eq!(index.stream_chunks(1).len(), 4);
        assert_eq!(index.streams[0].unit_rect(1), [4, 0, 1, 3]);
    }

    #[test]
    fn tables_that_contradict_themselves_are_refused() {
        type Spoil = fn(&mut Index);
        // The first ones break rules that involve several rows.
        let spoils: [Spoil; 15] = [
            |i| i.chunks[1].key.first_frame = 13,
            |i| i.chunks.truncate(7),
            |i| i.chunks.swap(0, 1),
            |i| i.chunks[7].key.frame_count = 4,
            |i| i.streams[1].kind = 0,
            |i| i.chunks[0].offset = 950,
            |i| i.chunks[0].offset = 3,
            |i| i.chunks[0].raw_bytes = 101,
            |i| i.streams[0].width = 0,
            |i| i.streams[0].unit_width = MAX_SIZE + 1,
            |i| i.streams[0].frame_count = u32::MAX,
            |i| i.streams[0].probe = 1,
            |i| i.probes[0].name = "../x".into(),
            |i| i.fps = f64::NAN,
            |i| i.probes[0].frames = [4, 3],
        ];
        for (at, spoil) in spoils.iter().enumerate() {
            let mut index = sample();
            spoil(&mut index);
            let read = index.write().and_then(|bytes| Index::read(&bytes, END));
            assert!(read.is_err(), "spoil {at}");
            assert!(at >= 5 || index.check().is_err(), "spoil {at}");
        }
    }

    #[test]
    fn counts_that_do_not_fit_are_refused_before_memory_is_asked_for() {
        let bytes = sample().write().unwrap();
        assert_eq!(bytes[..3], [1, 2, 8]);
        for at in 0..3 {
            let mut damaged = bytes.clone();
            damaged.splice(at..=at, [0xff, 0xff, 0xff, 0xff, 0xf]);
            let message = Index::read(&damaged, END).unwrap_err().to_string();
            assert!(message.contains("do not fit into the rest of the index"), "{message}");
        }
        for length in 0..bytes.len() {
            assert!(Index::read(&bytes[..length], END).is_err());
        }
    }
}
