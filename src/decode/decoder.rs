//! An open container, from which units and images of streams are decoded.

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
///
/// ```
/// # fn main() -> lightfold::Result<()> {
/// # use lightfold::{Encoder, Face, ProbePose};
/// # let mut encoder = Encoder::new("film", 24.0);
/// # let probe = encoder.add_probe("00", ProbePose::default())?;
/// # let depth = encoder.add_depth(probe, Face::View, [8, 4])?;
/// # encoder.push_depth(depth, &[1.5; 32])?;
/// # let (file, _) = encoder.finish(Vec::new())?;
/// use lightfold::{Decoder, PixelsMut, StreamKind};
///
/// let container = Decoder::from_memory(file)?; // or Decoder::open("film.lfold")
/// let stream = container.stream(StreamKind::Depth, "00", Face::View).unwrap();
/// let [width, height] = stream.size();
/// let mut metres = vec![0.0; width as usize * height as usize];
/// container.face(stream).decode_into(stream.frames.first, PixelsMut::DepthMetres(&mut metres))?;
/// assert_eq!(metres, [1.5; 32]);
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct Decoder {
    reader: Reader,
    streams: Vec<StreamInfo>,
    /// Of each stream; neighbours with the same header share one, and its tables.
    conversions: Vec<Arc<Conversion>>,
    footage: FootageInfo,
}

impl Decoder {
    /// Opens a file, `-` for standard input.
    ///
    /// # Errors
    /// [`Error::Io`]; [`Error::Invalid`] for a damaged head or index (container.md 3 to 7) or sizes that the file does not
    /// justify; [`Error::Unsupported`] for an unknown codec or version.
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

    /// Opens a container in any source of byte ranges; errors call it `name`. Only head, foot and index are read.
    ///
    /// ```
    /// # fn main() -> lightfold::Result<()> {
    /// # let mut encoder = lightfold::Encoder::new("film", 24.0);
    /// # let probe = encoder.add_probe("00", Default::default())?;
    /// # let depth = encoder.add_depth(probe, lightfold::Face::View, [8, 4])?;
    /// # encoder.push_depth(depth, &[1.5; 32])?;
    /// # let (object, _) = encoder.finish(Vec::new())?;
    /// use std::io::{Error, ErrorKind, Result};
    ///
    /// use lightfold::{ByteSource, Decoder};
    ///
    /// /// An object of a store that answers requests for ranges.
    /// #[derive(Debug)]
    /// struct Object(Vec<u8>);
    ///
    /// impl ByteSource for Object {
    ///     fn byte_count(&self) -> Result<u64> {
    ///         Ok(self.0.len() as u64)
    ///     }
    ///
    ///     fn read_at(&self, offset: u64, bytes: &mut [u8]) -> Result<()> {
    ///         let range = offset as usize..offset as usize + bytes.len();
    ///         bytes.copy_from_slice(self.0.get(range).ok_or(Error::from(ErrorKind::UnexpectedEof))?);
    ///         Ok(())
    ///     }
    /// }
    ///
    /// let container = Decoder::from_source(Object(object), "store/film.lfold")?;
    /// assert_eq!(container.streams().len(), 1);
    /// # Ok(())
    /// # }
    /// ```
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

    /// All streams, in the order of the stream table.
    pub fn streams(&self) -> &[StreamInfo] {
        &self.streams
    }

    /// Primaries and white of decoded colour, which is linear light of them (container.md 6.6).
    pub fn primaries(&self) -> Primaries {
        self.footage.primaries
    }

    /// How the footage was made.
    #[doc(hidden)]
    pub fn footage(&self) -> &FootageInfo {
        &self.footage
    }

    /// The stream of a kind, probe and face.
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

    /// Name of the dataset.
    pub fn name(&self) -> &str {
        &self.reader.index().name
    }

    /// Frames per second, above 0.
    pub fn fps(&self) -> f64 {
        self.reader.index().fps
    }

    /// All probes, in the order of the probe table.
    pub fn probes(&self) -> &[ProbeEntry] {
        &self.reader.index().probes
    }

    /// The probe of a stream: name, position in metres, orientation.
    pub fn probe(&self, stream: &StreamInfo) -> &ProbeEntry {
        &self.reader.index().probes[stream.probe]
    }

    /// The probe of a stream as it stands in a frame: position and orientation of probes that move are those of the frame.
    pub(crate) fn probe_at(&self, probe: usize, frame: u32) -> ProbeEntry {
        let entry = &self.reader.index().probes[probe];
        match self.footage.pose(&entry.name, frame) {
            Some(pose) => ProbeEntry { position: pose.position, orientation: pose.orientation, ..entry.clone() },
            None => entry.clone(),
        }
    }

    /// Whether the probe of a stream moves.
    pub(crate) fn moves(&self, stream: &StreamInfo) -> bool {
        !self.footage.poses_of(&self.probe(stream).name).is_empty()
    }

    /// A decoder of one unit (tile or cell), numbered row by row from 0.
    ///
    /// # Panics
    /// If `unit` is not below [`StreamInfo::unit_count`].
    pub fn unit<'a>(&'a self, stream: &'a StreamInfo, unit: u32) -> UnitDecoder<'a> {
        self.unit_with_buffer(stream, unit, Vec::new())
    }

    /// As [`Self::unit`], with the chunk memory of another unit's [`UnitDecoder::into_buffer`].
    #[doc(hidden)]
    pub fn unit_with_buffer<'a>(&'a self, stream: &'a StreamInfo, unit: u32, buffer: Vec<u8>) -> UnitDecoder<'a> {
        UnitDecoder::new((&self.reader, self.conversion(stream)), stream, unit, buffer)
    }

    /// A decoder of whole images of a stream.
    pub fn face<'a>(&'a self, stream: &'a StreamInfo) -> FaceDecoder<'a> {
        FaceDecoder::new((&self.reader, self.conversion(stream)), stream)
    }

    fn conversion(&self, stream: &StreamInfo) -> &Conversion {
        &self.conversions[stream.index as usize]
    }
}
