//! Streams of one codec. Sizes, codec header and payloads are the input; the container around them is valid.

use codec::container::{
    ChunkKey, Compression, OpenLimits, PackedChunk, PayloadKind, ProbeEntry, Reader, StreamEntry, Writer,
};
use codec::decode::Decoder;

use super::{Judged, container, refused};
use crate::ALLOCATED;

/// Maximum width and height of images and units.
const MAX_SIDE: u16 = 192;
/// Maximum number of payloads, and of chunks per unit.
const MAX_PAYLOADS: usize = 8;

/// Parts of a stream.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Case {
    /// Width and height of the images, then of the units, each less one.
    pub sizes: [u16; 4],
    /// Frames per chunk, less one.
    pub frames: u8,
    /// Chunks per unit, less one, modulo `MAX_PAYLOADS`.
    pub chunks: u8,
    pub header: Vec<u8>,
    /// Payloads; chunks use them cyclically.
    pub payloads: Vec<Vec<u8>>,
}

/// Reader of the front of a slice; reads zeros after its end.
pub(super) struct Front<'a>(pub(super) &'a [u8]);

impl<'a> Front<'a> {
    pub(super) fn bytes(&mut self, count: usize) -> &'a [u8] {
        let (front, rest) = self.0.split_at(count.min(self.0.len()));
        self.0 = rest;
        front
    }

    pub(super) fn u8(&mut self) -> u8 {
        self.bytes(1).first().copied().unwrap_or(0)
    }

    pub(super) fn u16(&mut self) -> u16 {
        u16::from_le_bytes([self.u8(), self.u8()])
    }
}

impl Case {
    /// Parses a case; any bytes are valid.
    pub fn read(bytes: &[u8]) -> Case {
        let mut front = Front(bytes);
        let mut case = Case { sizes: std::array::from_fn(|_| front.u16() % MAX_SIDE), ..Case::default() };
        case.frames = front.u8();
        case.chunks = front.u8();
        let count = usize::from(front.u8());
        case.header = front.bytes(count).to_vec();
        while !front.0.is_empty() && case.payloads.len() < MAX_PAYLOADS {
            let count = usize::from(front.u16());
            case.payloads.push(front.bytes(count).to_vec());
        }
        case
    }

    /// Returns the bytes of a case, of which [`Case::read`] keeps what is within the limits.
    pub fn write(&self) -> Vec<u8> {
        let mut out: Vec<u8> = self.sizes.iter().flat_map(|size| size.to_le_bytes()).collect();
        out.extend_from_slice(&[self.frames, self.chunks, self.header.len() as u8]);
        out.extend_from_slice(&self.header);
        for payload in self.payloads.iter().take(MAX_PAYLOADS) {
            out.extend_from_slice(&(payload.len() as u16).to_le_bytes());
            out.extend_from_slice(payload);
        }
        out
    }

    /// Returns a container with the stream.
    pub fn container(&self, codec: [u8; 4]) -> lightfold::Result<Vec<u8>> {
        let [width, height, unit_width, unit_height] = self.sizes.map(|size| u32::from(size) + 1);
        let frames = u32::from(self.frames) + 1;
        let chunks = u32::from(self.chunks) % MAX_PAYLOADS as u32 + 1;
        let kind = match codec[0] {
            b'C' => 0,
            b'D' => 1,
            _ => 2,
        };
        let entry = StreamEntry {
            kind,
            face: 0,
            probe: 0,
            codec,
            width,
            height,
            first_frame: 3,
            frame_count: frames * chunks,
            unit_width,
            unit_height,
            codec_header: self.header.clone().into(),
        };
        let mut writer = Writer::new(Vec::new(), "case", 24.0, 0)?;
        writer.add_probe(ProbeEntry {
            name: "00".into(),
            position: [0.0; 3],
            orientation: [0.0, 0.0, 0.0, 1.0],
            frames: [3, 3],
            intrinsics: [0.0; 4],
        })?;
        let stream = writer.add_stream(entry.clone());
        let mut next = self.payloads.iter().cycle();
        for unit in 0..entry.unit_count() {
            for chunk in 0..chunks {
                let key = ChunkKey { stream, unit, first_frame: 3 + chunk * frames, frame_count: frames };
                let payload = next.next().cloned().unwrap_or_default();
                writer.push(&PackedChunk::new(key, payload, (Compression::None, PayloadKind::Mixed))?)?;
            }
        }
        Ok(writer.finish()?.0)
    }
}

/// Decodes an input as a stream of a codec.
pub fn run(codec: [u8; 4], bytes: &[u8]) -> Judged {
    match Case::read(bytes).container(codec) {
        Ok(file) => {
            // The bound is for decoders, so memory used by the writer is excluded.
            ALLOCATED.reset_peak_usage();
            container::run_within(&file, OpenLimits::DEFAULT)
        }
        Err(error) => refused(&error),
    }
}

/// Returns the bytes that the decoder states for the stream, and those used in addition.
pub fn bound(codec: [u8; 4], bytes: &[u8]) -> u64 {
    let Ok(file) = Case::read(bytes).container(codec) else { return container::beside(4 << 20) };
    let file_bytes = file.len() as u64;
    let flattened = if codec == *b"DQTR" { container::FLATTENING } else { 0 };
    let stream = match Reader::from_memory(file).and_then(Decoder::new) {
        Ok(decoder) => decoder.streams()[0].memory_bytes(decoder.reader().index()),
        Err(_) => 0,
    };
    // Stricter than container.md 2, which allows 64 bytes per byte of the file: a unit decoder corresponds to 40 bytes of the
    // index.
    stream + (2 << 20) + 32 * file_bytes + flattened
}
