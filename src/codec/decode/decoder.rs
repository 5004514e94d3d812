//! Opens a container and decodes units and images of its streams.

use std::path::Path;
use std::sync::Arc;

use crate::container::{ByteSource, OpenLimits, ProbeEntry, Reader};
use crate::decode::face::FaceDecoder;
use crate::decode::pixels::Conversion;
use crate::decode::unit::UnitDecoder;
use crate::error::{Error, Result};
use crate::image::{Face, Primaries};
use crate::streams::{self, FootageInfo, StreamInfo, StreamKind};

/// An open container (formats/container.md).
#[derive(Debug)]
pub struct Decoder {
    reader: Reader,
    streams: Vec<StreamInfo>,
    /// One per stream; consecutive streams with equal headers share one, with its tables.
    conversions: Vec<Arc<Conversion>>,
    footage: FootageInfo,
}

impl Decoder {
    /// Opens a file, or standard input for `-`.
    ///
    /// # Errors
    /// [`Error::Io`] if reading fails; [`Error::Invalid`] for a damaged head or index (container.md 3 to 7), or for declared
    /// sizes that exceed the limits for a file of this length; [`Error::Unsupported`] for an unknown codec or version.
    pub fn open(path: impl AsRef<Path>) -> Result<Decoder> {
        Self::new(Reader::open(path)?)
    }

    /// Opens a container in memory.
    ///
    /// # Errors
    /// As for [`Self::open`].
    pub fn from_memory(file: Vec<u8>) -> Result<Decoder> {
        Self::new(Reader::from_memory(file)?)
    }

    /// Opens a container from any source of byte ranges, which error messages call `name`. Reads only head, foot and index.
    ///
    /// # Errors
    /// As for [`Self::open`].
    pub fn from_source(source: impl ByteSource + 'static, name: &str) -> Result<Decoder> {
        Self::new(Reader::from_source(source, name, OpenLimits::default())?)
    }

    #[doc(hidden)]
    pub fn new(reader: Reader) -> Result<Decoder> {
        let named = |error: Error| error.in_file(reader.path());
        let streams = streams::streams(reader.index()).map_err(named)?;
        streams::check_memory(&streams, reader.index(), reader.file_bytes, reader.limits).map_err(named)?;
        let footage = FootageInfo::read(reader.index()).map_err(named)?;
        let mut conversions: Vec<Arc<Conversion>> = Vec::new();
        for stream in &streams {
            let shared = conversions.last().filter(|last| last.header == stream.header).map(Arc::clone);
            conversions.push(shared.unwrap_or_else(|| Arc::new(Conversion::new(stream.header.clone()))));
        }
        Ok(Decoder { reader, streams, conversions, footage })
    }

    /// Returns all streams, in the order of the stream table.
    pub fn streams(&self) -> &[StreamInfo] {
        &self.streams
    }

    /// Returns the primaries and white point of decoded linear RGB (container.md 6.5).
    pub fn primaries(&self) -> Primaries {
        self.footage.primaries
    }

    /// Returns the footage attributes of the container (container.md 6.5).
    #[doc(hidden)]
    pub fn footage(&self) -> &FootageInfo {
        &self.footage
    }

    /// Returns the stream of a kind, probe and face, if there is one.
    pub fn stream(&self, kind: StreamKind, probe: &str, face: Face) -> Option<&StreamInfo> {
        self.streams.iter().find(|s| s.kind == kind && s.face == face && self.probe(s).name == probe)
    }

    #[doc(hidden)]
    pub fn reader(&self) -> &Reader {
        &self.reader
    }

    #[doc(hidden)]
    pub fn load(&mut self, limit_bytes: u64) -> Result<bool> {
        self.reader.load(limit_bytes)
    }

    /// Returns the name of the dataset.
    pub fn name(&self) -> &str {
        &self.reader.index().name
    }

    /// Returns the frame rate in frames per second, above 0.
    pub fn fps(&self) -> f64 {
        self.reader.index().fps
    }

    /// Returns all probes, in the order of the probe table.
    pub fn probes(&self) -> &[ProbeEntry] {
        &self.reader.index().probes
    }

    /// Returns the probe of a stream: name, position in metres, orientation.
    pub fn probe(&self, stream: &StreamInfo) -> &ProbeEntry {
        &self.reader.index().probes[stream.probe]
    }

    /// Returns a probe, given by its index, with its position and orientation in `frame`. Only those of moving probes depend on
    /// the frame.
    pub fn probe_at(&self, probe: usize, frame: u32) -> ProbeEntry {
        let entry = &self.reader.index().probes[probe];
        match self.footage.pose(&entry.name, frame) {
            Some(pose) => ProbeEntry { position: pose.position, orientation: pose.orientation, ..entry.clone() },
            None => entry.clone(),
        }
    }

    /// Returns true if the probe of a stream moves.
    pub fn moves(&self, stream: &StreamInfo) -> bool {
        !self.footage.poses_of(&self.probe(stream).name).is_empty()
    }

    /// Returns a decoder of one unit (tile or cell). Units are numbered row by row from 0.
    ///
    /// # Panics
    /// If `unit` is not below [`StreamInfo::unit_count`].
    pub fn unit<'a>(&'a self, stream: &'a StreamInfo, unit: u32) -> UnitDecoder<'a> {
        self.unit_with_buffer(stream, unit, Vec::new())
    }

    /// As [`Self::unit`], but reuses the chunk buffer that [`UnitDecoder::into_buffer`] of another unit returned.
    #[doc(hidden)]
    pub fn unit_with_buffer<'a>(&'a self, stream: &'a StreamInfo, unit: u32, buffer: Vec<u8>) -> UnitDecoder<'a> {
        UnitDecoder::new((&self.reader, self.conversion(stream)), stream, unit, buffer)
    }

    /// Returns a decoder of whole images of a stream.
    pub fn face<'a>(&'a self, stream: &'a StreamInfo) -> FaceDecoder<'a> {
        FaceDecoder::new((&self.reader, self.conversion(stream)), stream)
    }

    fn conversion(&self, stream: &StreamInfo) -> &Conversion {
        &self.conversions[stream.index as usize]
    }
}
