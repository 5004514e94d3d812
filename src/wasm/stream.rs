//! Streams of the page, and their chunks: codec headers as JSON, payloads of stored bytes.

use std::sync::Arc;

use codec::container::{ChunkPlace, Payload, StreamEntry, lzma2, zstd};
use codec::depth::TemporalSettings;
use codec::depth::domain::DomainKind;
use codec::depth::predictive::UnitArea;
use codec::error::{Error, Result};
use codec::image::transfer::Transfer;
use codec::streams::{
    CodecHeader, ColorBlocks, ColorCoding, ColorFormat, ColorHeader, DepthCoding, DepthHeader, DepthKind, NodeHeader,
};

/// Compression method of stored bytes (container.md 6), and the bytes of what they mean.
#[derive(Clone, Copy)]
pub struct Storage {
    pub method: u32,
    pub raw_bytes: u32,
}

impl Storage {
    /// Returns the payload of stored bytes, whose CRC-32 was checked.
    pub fn payload(self, stored: Vec<u8>) -> Result<Payload> {
        match self.method {
            0 => Ok(stored.into()),
            1 => Ok(lzma2::decompress(&stored, self.raw_bytes)?.into()),
            2 => Ok(zstd::decompress(&stored, self.raw_bytes)?.into()),
            other => Err(Error::unsupported(format!("a chunk is stored by method {other}, which is unknown"))),
        }
    }
}

/// Position of a chunk in its stream.
#[derive(Clone, Copy)]
pub struct ChunkArea {
    pub unit: u32,
    pub frames: u32,
    pub place: ChunkPlace,
}

/// A stream whose codec header is legal.
pub struct Stream {
    entry: StreamEntry,
    pub header: CodecHeader,
}

impl Stream {
    /// Reads a codec header, behind the four characters of the codec. `kind` and `face` are those of the stream table, `sizes`
    /// the sides of the image and of units.
    pub fn read(bytes: &[u8], [kind, face]: [u32; 2], sizes: [u32; 4]) -> Result<Stream> {
        let Some((&codec, header)) = bytes.split_first_chunk() else {
            return Err(Error::invalid("a stream without a codec"));
        };
        let [width, height, unit_width, unit_height] = sizes;
        let entry = StreamEntry {
            kind: kind as u8,
            face: face as u8,
            probe: 0,
            codec,
            width,
            height,
            first_frame: 0,
            frame_count: 1,
            unit_width,
            unit_height,
            codec_header: Arc::new(header.to_vec()),
        };
        let header = CodecHeader::read(&entry)?;
        Ok(Stream { entry, header })
    }

    /// Returns the area of a unit, which decoders need.
    pub fn unit_area(&self, unit: u32) -> UnitArea {
        UnitArea { rect: self.entry.unit_rect(unit), image: [self.entry.width, self.entry.height] }
    }

    /// Returns the header as JSON: `CodecHeader` of viewer/src/format/types.ts.
    pub fn json(&self) -> String {
        match &self.header {
            CodecHeader::Depth(header) => depth_json(header),
            CodecHeader::Material(header) => {
                let TemporalSettings { window, .. } = header.temporal;
                format!(r#"{{"kind":"material","window":{window},"inBlocks":{}}}"#, header.in_blocks)
            }
            CodecHeader::Alpha(_) => r#"{"kind":"alpha"}"#.into(),
            CodecHeader::Color(header) => color_json(header),
        }
    }
}

fn depth_json(header: &DepthHeader) -> String {
    let boxes = |TemporalSettings { window, .. }: TemporalSettings, in_blocks: bool| {
        format!(r#""name":"boxes","window":{window},"inBlocks":{in_blocks}"#)
    };
    let coding = match &header.coding {
        DepthCoding::Boxes(temporal) => boxes(*temporal, false),
        DepthCoding::BoxesInBlocks(temporal) => boxes(*temporal, true),
        DepthCoding::Nodes(NodeHeader { window, domain, .. })
        | DepthCoding::Tree(NodeHeader { window, domain, .. }) => {
            let kind = match domain.kind {
                DomainKind::Log => 0,
                DomainKind::Linear => 1,
                DomainKind::Inverse => 2,
            };
            let domain = format!(r#"{{"kind":{kind},"base":{},"scale":{}}}"#, domain.base, domain.scale);
            format!(r#""name":"nodes","window":{window},"domain":{domain}"#)
        }
        DepthCoding::Blocks => r#""name":"blocks""#.into(),
        DepthCoding::Predictive(_) => r#""name":"predictive""#.into(),
    };
    let [near, far] = [header.range.near_m(), header.range.far_m()].map(f64::from);
    let is_distance = header.kind == DepthKind::Distance;
    format!(
        r#"{{"kind":"depth","range":{{"nearM":{near},"farM":{far}}},"isDistance":{is_distance},"coding":{{{coding}}}}}"#
    )
}

fn color_json(header: &ColorHeader) -> String {
    let (is_half, transfer, exposure_ev) = match header.format {
        ColorFormat::EightBit(tone) if tone.transfer == Transfer::Srgb => (false, "srgb", tone.exposure_ev),
        ColorFormat::EightBit(tone) => (false, "linear", tone.exposure_ev),
        ColorFormat::Half { .. } => (true, "linear", 0.0),
    };
    let blocks = |name: &str| format!(r#""name":"cells","blocks":"{name}""#);
    let coding = match &header.coding {
        ColorCoding::Cells(None) => r#""name":"cells""#.into(),
        ColorCoding::Cells(Some(ColorBlocks::Bc1)) => blocks("bc1"),
        ColorCoding::Cells(Some(ColorBlocks::Bc7)) => blocks("bc7"),
        ColorCoding::Cells(Some(ColorBlocks::Bc6h)) => blocks("bc6h"),
        ColorCoding::Transform(_) => r#""name":"transform""#.into(),
    };
    let exposure_ev = f64::from(exposure_ev);
    format!(
        r#"{{"kind":"color","isHalf":{is_half},"transfer":"{transfer}","exposureEv":{exposure_ev},"coding":{{{coding}}}}}"#
    )
}
