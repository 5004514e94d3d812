//! Digests of the content of footage. Shards of one encode must agree on them, in addition to settings and layout.
//!
//! A digest covers bytes, never names or times, so that a copy in another folder or on another machine has the same digest. Each
//! shard of an encode stores the digests of all frames of the encode, including those that only other shards read. They come from
//! a shared scan, or from reading all files. A shard checks the digest of each frame again when it reads the frame.

use std::collections::{BTreeMap, HashMap};
use std::io::Read;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Deserializer, Serialize, Serializer, de};

use crate::dataset::SourceGroup;
use crate::encode::EncodeSettings;
use crate::encode::source::{FrameSource, name_frame, selected_groups};
use crate::fingerprint::digest_bytes;
use codec::error::{Error, Result};
use codec::image::{Face, Plane, StreamKind};
use codec::monitor::Monitor;
use codec::ordered::try_map_ordered;

/// Size of the read buffer in bytes.
const BLOCK_BYTES: usize = 256 << 10;

/// Number of bytes of a frame's files, and their CRC-32.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FrameDigest {
    bytes: u64,
    crc32: u32,
}

impl FrameDigest {
    fn of_file(path: &Path) -> Result<FrameDigest> {
        let failed = |error| Error::io(path, error);
        let mut file = crate::files::open_regular(path)?;
        let (mut hasher, mut bytes) = (crc32fast::Hasher::new(), 0);
        let mut block = vec![0; BLOCK_BYTES];
        loop {
            match file.read(&mut block) {
                Ok(0) => return Ok(FrameDigest { bytes, crc32: hasher.finalize() }),
                Ok(count) => {
                    hasher.update(&block[..count]);
                    bytes += count as u64;
                }
                Err(error) if error.kind() == std::io::ErrorKind::Interrupted => {}
                Err(error) => return Err(failed(error)),
            }
        }
    }

    /// Combines the digests of several files into one.
    fn of_files(files: &[FrameDigest]) -> FrameDigest {
        match files {
            [only] => *only,
            _ => {
                let mut hasher = crc32fast::Hasher::new();
                files.iter().for_each(|file| hasher.update(&file.to_bytes()));
                FrameDigest { bytes: files.iter().map(|file| file.bytes).sum(), crc32: hasher.finalize() }
            }
        }
    }

    /// Computes the digest of values in memory.
    fn of_values<const N: usize>(values: impl Iterator<Item = [u8; N]>) -> FrameDigest {
        let (mut hasher, mut bytes, mut block) = (crc32fast::Hasher::new(), 0, Vec::with_capacity(BLOCK_BYTES));
        for value in values {
            block.extend_from_slice(&value);
            bytes += N as u64;
            if block.len() + N > BLOCK_BYTES {
                hasher.update(&block);
                block.clear();
            }
        }
        hasher.update(&block);
        FrameDigest { bytes, crc32: hasher.finalize() }
    }

    fn to_bytes(self) -> [u8; 12] {
        let mut bytes = [0; 12];
        bytes[..8].copy_from_slice(&self.bytes.to_le_bytes());
        bytes[8..].copy_from_slice(&self.crc32.to_le_bytes());
        bytes
    }
}

/// Text form `BYTES-CRC32`: the number of bytes in decimal, the CRC-32 in eight hexadecimal digits.
impl Serialize for FrameDigest {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(&format_args!("{}-{:08x}", self.bytes, self.crc32))
    }
}

impl<'de> Deserialize<'de> for FrameDigest {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<FrameDigest, D::Error> {
        let text = String::deserialize(deserializer)?;
        let parts = text.split_once('-');
        let digest = parts.and_then(|(bytes, crc32)| {
            Some(FrameDigest { bytes: bytes.parse().ok()?, crc32: u32::from_str_radix(crc32, 16).ok()? })
        });
        digest.ok_or_else(|| de::Error::custom(format!("\"{text}\" is not a digest such as \"1024-0f3a5c7e\"")))
    }
}

/// Key of a group: its kind, probe and first face.
type Place = (StreamKind, usize, Face);

fn place(group: &SourceGroup) -> Place {
    (group.kind, group.probe, group.faces.first().copied().unwrap_or(Face::View))
}

/// Digests of all frames of some groups.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Footage {
    groups: BTreeMap<Place, GroupDigests>,
    /// The time since which files must not have changed, as words for errors.
    since: &'static str,
}

#[derive(Debug, Clone, PartialEq)]
struct GroupDigests {
    first_frame: u32,
    frames: Vec<FrameDigest>,
}

impl Footage {
    /// Reads all files of the selected groups. The monitor advances by one per image.
    ///
    /// # Errors
    /// Fails if a file cannot be read; the error names the file.
    pub fn read(source: &dyn FrameSource, settings: &EncodeSettings, monitor: &dyn Monitor) -> Result<Footage> {
        let mut footage = Footage::empty("this encode began");
        let mut known = KnownFiles::default();
        for group in selected_groups(source, settings) {
            let digests = known.read(source, group, monitor)?;
            footage.insert(group, digests);
        }
        Ok(footage)
    }

    pub(super) fn empty(since: &'static str) -> Footage {
        Footage { groups: BTreeMap::new(), since }
    }

    pub(super) fn insert(&mut self, group: &SourceGroup, frames: Vec<FrameDigest>) {
        self.groups.insert(place(group), GroupDigests { first_frame: group.frames.first, frames });
    }

    /// Returns the digest of all frames of a group; `None` if it is unknown.
    pub(super) fn of_group(&self, group: &SourceGroup) -> Option<[u8; 16]> {
        let digests = &self.groups.get(&place(group))?.frames;
        Some(digest_bytes(&digests.iter().flat_map(|frame| frame.to_bytes()).collect::<Vec<u8>>()))
    }

    /// Fails if the content of a frame's files has changed. Frames without files are not checked.
    pub(super) fn check(&self, source: &dyn FrameSource, group: &SourceGroup, frame: u32) -> Result<()> {
        let Some(GroupDigests { first_frame, frames }) = self.groups.get(&place(group)) else { return Ok(()) };
        let Some(known) = frame.checked_sub(*first_frame).and_then(|at| frames.get(at as usize)) else { return Ok(()) };
        let files = source.files(group, frame)?;
        let (Some(file), true) = (files.first(), source.digest(group, frame)?.is_none()) else { return Ok(()) };
        let digests = files.iter().map(|file| FrameDigest::of_file(file)).collect::<Result<Vec<_>>>()?;
        if FrameDigest::of_files(&digests) == *known {
            return Ok(());
        }
        let message = format!(
            "its content has changed since {} ({}): scan again, and encode all shards again",
            self.since,
            name_frame(source, group, frame)
        );
        Err(Error::invalid(message).in_file(file))
    }
}

/// Cache of file digests, so that files shared by several kinds of streams are read once.
#[derive(Default)]
pub(super) struct KnownFiles(HashMap<PathBuf, FrameDigest>);

impl KnownFiles {
    /// Returns the digests of all frames of a group. The monitor advances by one per image.
    pub fn read(
        &mut self,
        source: &dyn FrameSource,
        group: &SourceGroup,
        monitor: &dyn Monitor,
    ) -> Result<Vec<FrameDigest>> {
        let known = &self.0;
        let found = try_map_ordered(group.frames.iter().collect(), |frame| {
            monitor.check()?;
            let (digest, files) = digest_of_frame(source, group, frame, known)?;
            monitor.advance(group.faces.len() as u64);
            Ok((digest, files))
        })?;
        let (digests, files): (Vec<_>, Vec<_>) = found.into_iter().unzip();
        self.0.extend(files.into_iter().flatten());
        Ok(digests)
    }
}

/// Returns the digest of a frame and those of its files.
fn digest_of_frame(
    source: &dyn FrameSource,
    group: &SourceGroup,
    frame: u32,
    known: &HashMap<PathBuf, FrameDigest>,
) -> Result<(FrameDigest, Vec<(PathBuf, FrameDigest)>)> {
    if let Some(digest) = source.digest(group, frame)? {
        return Ok((FrameDigest::of_values(std::iter::once(digest)), Vec::new()));
    }
    let files = source.files(group, frame)?;
    if files.is_empty() {
        return Ok((digest_of_pixels(source, group, frame)?, Vec::new()));
    }
    let digest = |file: PathBuf| {
        let digest = known.get(&file).copied().map_or_else(|| FrameDigest::of_file(&file), Ok)?;
        Ok((file, digest))
    };
    let files = files.into_iter().map(digest).collect::<Result<Vec<_>>>()?;
    let digests: Vec<FrameDigest> = files.iter().map(|(_, digest)| *digest).collect();
    Ok((FrameDigest::of_files(&digests), files))
}

fn digest_of_pixels(source: &dyn FrameSource, group: &SourceGroup, frame: u32) -> Result<FrameDigest> {
    let one = |planes: Vec<Plane<f32>>| {
        FrameDigest::of_values(planes.iter().flat_map(|plane| plane.data()).map(|value| value.to_le_bytes()))
    };
    Ok(match group.kind {
        StreamKind::Depth => one(source.read_depth(group, frame)?),
        StreamKind::Alpha => one(source.read_alpha(group, frame)?),
        StreamKind::Color => {
            let planes = source.read_color(group, frame)?;
            let values = planes.iter().flat_map(|plane| plane.data().as_flattened());
            FrameDigest::of_values(values.map(|value| value.to_le_bytes()))
        }
        StreamKind::Material => {
            let planes = source.read_material(group, frame)?;
            let values = planes.iter().flat_map(|plane| plane.data().as_flattened());
            FrameDigest::of_values(values.map(|value| value.to_le_bytes()))
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_digest_comes_back_from_a_scan() {
        for digest in [FrameDigest { bytes: 0, crc32: 0 }, FrameDigest { bytes: u64::MAX, crc32: 0xf00f }] {
            let text = serde_json::to_string(&digest).unwrap();
            assert_eq!(serde_json::from_str::<FrameDigest>(&text).unwrap(), digest, "{text}");
        }
        for text in ["\"\"", "\"12\"", "\"x-00\"", "\"1-123456789\"", "7"] {
            assert!(serde_json::from_str::<FrameDigest>(text).is_err(), "{text}");
        }
    }

    #[test]
    fn files_and_values_of_the_same_bytes_have_one_digest() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        let bytes: Vec<u8> = (0..3 * BLOCK_BYTES + 5).map(|at| (at % 251) as u8).collect();
        std::fs::write(&path, &bytes).unwrap();
        let digest = FrameDigest::of_file(&path).unwrap();
        assert_eq!(FrameDigest::of_values(bytes.iter().map(|byte| [*byte])), digest);
        assert_eq!(digest.bytes, bytes.len() as u64);
        let other = FrameDigest::of_values(bytes.iter().map(|byte| [byte ^ 1]));
        assert_ne!(FrameDigest::of_files(&[digest, other]), FrameDigest::of_files(&[other, digest]));
    }
}
