//! Codec headers of streams (depth.md 3 and 16, color.md 2), and the memory that their decoders need (container.md 2).

use crate::color::blend::HalfKey;
use crate::color::cells::CellFormat;
use crate::color::chunk::ChunkFormat;
use crate::color::keyframe_blocks::KeyframeBlocks;
use crate::color::transform::{Tables, region};
#[cfg(feature = "encode")]
use crate::container::PayloadKind;
use crate::container::{ChunkEntry, StreamEntry};
use crate::depth::block_tiles::Layout;
use crate::depth::boxes::MAX_BOXES;
use crate::depth::predictive::projection::{Projection, Shape};
use crate::depth::predictive::{self, Levels, PredictiveHeader};
use crate::depth::{DepthRange, DomainParts, TemporalSettings};
use crate::image::transfer::ToneMap;
use crate::image::{DepthKind, StreamKind};
use crate::metrics::DEFAULT_WHITE_CD_M2;

// Four-character codes of the codecs (depth.md, color.md).
pub const DEPTH_AABB: [u8; 4] = *b"DAAB";
pub const DEPTH_NODES: [u8; 4] = *b"DQPN";
pub const DEPTH_TREE: [u8; 4] = *b"DQTR";
pub const DEPTH_BLOCKS: [u8; 4] = *b"DB4W";
pub const DEPTH_AABB_BC5: [u8; 4] = *b"DAB5";
pub const DEPTH_PREDICTIVE: [u8; 4] = *b"DPRD";
pub const MATERIAL_AABB: [u8; 4] = *b"MAAB";
pub const MATERIAL_AABB_BC1: [u8; 4] = *b"MAB1";
pub const ALPHA_PREDICTIVE: [u8; 4] = *b"APRD";
pub const COLOR_CELLS_8: [u8; 4] = *b"CCL8";
pub const COLOR_CELLS_HALF: [u8; 4] = *b"CCLH";
pub const COLOR_CELLS_BC1: [u8; 4] = *b"CCB1";
pub const COLOR_CELLS_BC7: [u8; 4] = *b"CCB7";
pub const COLOR_CELLS_BC6H: [u8; 4] = *b"CCB6";
pub const COLOR_TRANSFORM_8: [u8; 4] = *b"CTR8";
pub const COLOR_TRANSFORM_HALF: [u8; 4] = *b"CTRH";

#[derive(Debug, Clone, PartialEq)]
pub struct DepthHeader {
    /// Depths in metres of codes 0 and 65534.
    pub range: DepthRange,
    /// Value that decoders output for the background, never NaN.
    pub background: f32,
    pub kind: DepthKind,
    pub coding: DepthCoding,
}

#[derive(Debug, Clone, PartialEq)]
pub enum DepthCoding {
    /// Raw codes in boxes around changes; a decoder needs only the window.
    Boxes(TemporalSettings),
    /// As `Boxes`, with the block tiles of boxes in BC5 blocks.
    BoxesInBlocks(TemporalSettings),
    Nodes(NodeHeader),
    /// The quadtree itself (depth.md 11), with all leaves as raw codes.
    Tree(NodeHeader),
    Blocks,
    /// Predicted codes with residuals.
    Predictive(PredictiveHeader),
}

/// Coding of nodes; a decoder needs the window and the domain.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NodeHeader {
    pub window: u8,
    /// Update threshold: a change of the source below this number of codes, in addition to the bound, does not update a
    /// pixel.
    pub epsilon: u16,
    pub keyframe_interval: u32,
    /// Maximum error of a node in codes; in a tree, that of its modelling functions.
    pub bound: u16,
    pub domain: DomainParts,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MaterialHeader {
    pub temporal: TemporalSettings,
    pub in_blocks: bool,
}

/// Codes of alpha, predicted without loss (depth.md 16).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AlphaHeader {
    pub keyframe_interval: u32,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ColorFormat {
    EightBit(ToneMap),
    Half {
        /// Luminance of 1.0 in cd/m², for the metric.
        white_cd_m2: f64,
    },
}

impl ColorFormat {
    /// Half floats with the white of a standard display.
    pub const HALF: ColorFormat = ColorFormat::Half { white_cd_m2: DEFAULT_WHITE_CD_M2 };
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ColorBlocks {
    Bc1,
    Bc7,
    Bc6h,
}

#[derive(Debug, Clone, PartialEq)]
pub enum ColorCoding {
    /// Keyframes and weights (color.md 4). Keyframes are in BC1 or BC7 blocks (8 bits) or BC6H blocks (half floats); `None`
    /// for samples.
    Cells(Option<ColorBlocks>),
    /// A transform in space and time, with the entropy tables of the stream.
    Transform(Tables),
}

#[derive(Debug, Clone, PartialEq)]
pub struct ColorHeader {
    pub format: ColorFormat,
    pub coding: ColorCoding,
    /// Minimum PSNR in dB of each frame of each cell; 0 without a PSNR target.
    pub min_psnr_db: f64,
    /// Minimum perceptual quality (color.md 5.2) of each frame of each cell, 0 to 100; 0 without a quality target, as in all
    /// codecs except the transform.
    pub min_quality: f64,
}

#[derive(Debug, Clone, PartialEq)]
pub enum CodecHeader {
    Depth(DepthHeader),
    Color(ColorHeader),
    Material(MaterialHeader),
    Alpha(AlphaHeader),
}

impl DepthHeader {
    pub fn window(&self) -> u8 {
        match self.coding {
            DepthCoding::Boxes(temporal) | DepthCoding::BoxesInBlocks(temporal) => temporal.window,
            DepthCoding::Nodes(nodes) => nodes.window,
            DepthCoding::Tree(_) | DepthCoding::Blocks | DepthCoding::Predictive(_) => 1,
        }
    }

    /// True if the coding requires a cube face.
    pub fn is_of_cube(&self) -> bool {
        matches!(&self.coding, DepthCoding::Predictive(header) if header.projection.shape == Shape::CubeDistance)
    }

    /// Number of codes that may occur; 0 if any code may occur.
    pub fn levels(&self) -> usize {
        if let DepthCoding::Predictive(header) = &self.coding { header.levels.codes().len() } else { 0 }
    }

    /// Maximum error of a decoded surface in codes (depth.md 6); `None` without a bound.
    pub fn error_bound(&self) -> Option<u16> {
        match &self.coding {
            DepthCoding::Boxes(temporal) | DepthCoding::BoxesInBlocks(temporal) => Some(temporal.epsilon),
            DepthCoding::Nodes(nodes) => Some(nodes.bound.saturating_add(nodes.epsilon)),
            DepthCoding::Tree(_) => Some(0),
            DepthCoding::Predictive(header) => Some(header.bound.saturating_add(header.epsilon)),
            DepthCoding::Blocks => None,
        }
    }
}

impl MaterialHeader {
    pub fn layout(&self) -> Layout {
        if self.in_blocks { Layout::BlockTiles } else { Layout::Values }
    }
}

impl AlphaHeader {
    /// Header of a depth stream whose chunks have the same coding.
    pub fn predictive(self) -> PredictiveHeader {
        PredictiveHeader {
            bound: 0,
            epsilon: 0,
            keyframe_interval: self.keyframe_interval,
            projection: Projection::default(),
            tables: predictive::Tables::default(),
            levels: Levels::default(),
        }
    }
}

impl ColorHeader {
    /// Block format of keyframes; `None` if all keyframes are samples.
    pub fn blocks(&self) -> Option<ColorBlocks> {
        if let ColorCoding::Cells(blocks) = self.coding { blocks } else { None }
    }

    /// Entropy tables of the transform codec; `None` for keyframes and weights.
    pub fn tables(&self) -> Option<&Tables> {
        if let ColorCoding::Transform(tables) = &self.coding { Some(tables) } else { None }
    }

    pub fn is_half(&self) -> bool {
        matches!(self.format, ColorFormat::Half { .. })
    }

    pub fn cell_of_bytes(&self, [width, height]: [u32; 2]) -> CellFormat<u8> {
        let blocks = self.blocks().map(|blocks| match blocks {
            ColorBlocks::Bc1 => KeyframeBlocks::BC1,
            ColorBlocks::Bc7 | ColorBlocks::Bc6h => KeyframeBlocks::BC7,
        });
        CellFormat { size: [width as usize, height as usize], blocks }
    }

    pub fn cell_of_halves(&self, [width, height]: [u32; 2]) -> CellFormat<HalfKey> {
        CellFormat { size: [width as usize, height as usize], blocks: self.blocks().map(|_| KeyframeBlocks::BC6H) }
    }

    pub fn chunks_of_bytes(&self, size: [u32; 2]) -> ChunkFormat<u8> {
        ChunkFormat { cell: self.cell_of_bytes(size), tables: self.tables().cloned() }
    }

    pub fn chunks_of_halves(&self, size: [u32; 2]) -> ChunkFormat<HalfKey> {
        ChunkFormat { cell: self.cell_of_halves(size), tables: self.tables().cloned() }
    }
}

/// Maximum bytes that a record needs in addition to its payload: table rows (64), and boxes of 16 bytes, which count three
/// times while their list grows.
const MAX_RECORD_BYTES: u64 = 64 + 3 * 16 * MAX_BOXES as u64;

/// Bytes of a payload of keyframes, of the next payload, and of the rows of keyframes.
fn keyframe_bytes(payload_bytes: u64) -> u64 {
    4 * payload_bytes + (8 * payload_bytes).min(4 << 20)
}

fn unit_size(stream: &StreamEntry, chunk: &ChunkEntry) -> [usize; 2] {
    let [_, _, width, height] = stream.unit_rect(chunk.key.unit);
    [width as usize, height as usize]
}

impl CodecHeader {
    pub fn kind(&self) -> StreamKind {
        match self {
            CodecHeader::Depth(_) => StreamKind::Depth,
            CodecHeader::Color(_) => StreamKind::Color,
            CodecHeader::Material(_) => StreamKind::Material,
            CodecHeader::Alpha(_) => StreamKind::Alpha,
        }
    }

    pub fn codec(&self) -> [u8; 4] {
        match self {
            CodecHeader::Depth(header) => match header.coding {
                DepthCoding::Boxes(_) => DEPTH_AABB,
                DepthCoding::BoxesInBlocks(_) => DEPTH_AABB_BC5,
                DepthCoding::Nodes(_) => DEPTH_NODES,
                DepthCoding::Tree(_) => DEPTH_TREE,
                DepthCoding::Blocks => DEPTH_BLOCKS,
                DepthCoding::Predictive(_) => DEPTH_PREDICTIVE,
            },
            CodecHeader::Material(MaterialHeader { in_blocks: false, .. }) => MATERIAL_AABB,
            CodecHeader::Material(MaterialHeader { in_blocks: true, .. }) => MATERIAL_AABB_BC1,
            CodecHeader::Alpha(_) => ALPHA_PREDICTIVE,
            CodecHeader::Color(header) => match (header.format, &header.coding) {
                (ColorFormat::EightBit(_), ColorCoding::Cells(None)) => COLOR_CELLS_8,
                (ColorFormat::EightBit(_), ColorCoding::Cells(Some(ColorBlocks::Bc1))) => COLOR_CELLS_BC1,
                (ColorFormat::EightBit(_), ColorCoding::Cells(Some(_))) => COLOR_CELLS_BC7,
                (ColorFormat::EightBit(_), ColorCoding::Transform(_)) => COLOR_TRANSFORM_8,
                (ColorFormat::Half { .. }, ColorCoding::Cells(None)) => COLOR_CELLS_HALF,
                (ColorFormat::Half { .. }, ColorCoding::Cells(Some(_))) => COLOR_CELLS_BC6H,
                (ColorFormat::Half { .. }, ColorCoding::Transform(_)) => COLOR_TRANSFORM_HALF,
            },
        }
    }

    /// Upper bound of the bytes of a unit, without pixels and payloads: its decoder, parsed tables and report counters, about
    /// twenty small allocations.
    pub const HELD_UNIT_BYTES: u64 = 4 << 10;

    /// Main content of a payload, which selects parameters of its compression.
    #[cfg(feature = "encode")]
    pub fn payload_kind(&self) -> PayloadKind {
        match self {
            CodecHeader::Depth(DepthHeader { coding: DepthCoding::Nodes(_) | DepthCoding::Tree(_), .. }) => {
                PayloadKind::Unaligned
            }
            CodecHeader::Depth(DepthHeader { coding: DepthCoding::Predictive(_), .. }) | CodecHeader::Alpha(_) => {
                PayloadKind::Bytes
            }
            CodecHeader::Depth(_) | CodecHeader::Material(_) => PayloadKind::Mixed,
            CodecHeader::Color(header) if header.blocks().is_some() => PayloadKind::Blocks,
            CodecHeader::Color(ColorHeader { coding: ColorCoding::Transform(_), .. }) => PayloadKind::Bytes,
            CodecHeader::Color(ColorHeader { format: ColorFormat::EightBit(_), .. }) => PayloadKind::Bytes,
            CodecHeader::Color(_) => PayloadKind::Words,
        }
    }

    /// Bytes per pixel that a decoder of whole images holds: the picture of its unit, the image, and two keyframes for
    /// colour; half floats are also held as keys.
    pub fn held_pixel_bytes(&self) -> u64 {
        match self {
            // Two codes, the prediction state of a pixel (16 bytes, with a margin), and its correction.
            CodecHeader::Depth(DepthHeader { coding: DepthCoding::Predictive(_), .. }) | CodecHeader::Alpha(_) => 32,
            CodecHeader::Depth(_) => 4,
            CodecHeader::Material(_) => 6,
            CodecHeader::Color(ColorHeader { format: ColorFormat::EightBit(_), .. }) => 12,
            CodecHeader::Color(_) => 30,
        }
    }

    /// Upper bound of the bytes that a decoder holds for a chunk of a stream. Nodes of two bytes become 34 bytes in the
    /// runtime form, which exists twice during parsing. A box of ten bytes, or a record of 14, gets a table row. A colour
    /// cell also holds the next payload, and a row for each of at most 65,535 keyframes. Growing buffers count twice.
    pub fn held_chunk_bytes(&self, stream: &StreamEntry, chunk: &ChunkEntry) -> u64 {
        let bytes = u64::from(chunk.raw_bytes);
        match self {
            CodecHeader::Depth(DepthHeader { coding: DepthCoding::Nodes(_) | DepthCoding::Tree(_), .. }) => 64 * bytes,
            CodecHeader::Depth(_) | CodecHeader::Material(_) | CodecHeader::Alpha(_) => 10 * bytes,
            CodecHeader::Color(header) => {
                let (keyframes, size) = (keyframe_bytes(bytes), unit_size(stream, chunk));
                header
                    .tables()
                    .map_or(keyframes, |_| keyframes.max(region::held_bytes(bytes, size, chunk.key.frame_count)))
            }
        }
    }

    /// Upper bound of the bytes of a parsed chunk, for memory budgets; never above [`CodecHeader::held_chunk_bytes`].
    /// Includes the buffer of the previous payload; excludes [`CodecHeader::parsing_bytes`].
    pub fn parsed_chunk_bytes(&self, stream: &StreamEntry, chunk: &ChunkEntry) -> u64 {
        let bytes = u64::from(chunk.raw_bytes);
        let in_boxes = 2 * bytes + u64::from(chunk.key.frame_count) * MAX_RECORD_BYTES;
        let most = match self {
            CodecHeader::Depth(DepthHeader { coding, .. }) => match coding {
                DepthCoding::Predictive(_) | DepthCoding::Blocks => 2 * bytes,
                DepthCoding::Boxes(_) | DepthCoding::BoxesInBlocks(_) => in_boxes,
                DepthCoding::Nodes(_) | DepthCoding::Tree(_) => u64::MAX,
            },
            CodecHeader::Material(_) => in_boxes,
            CodecHeader::Alpha(_) => 2 * bytes,
            CodecHeader::Color(header) if header.tables().is_some() => {
                keyframe_bytes(bytes).max(region::parsed_bytes(bytes, unit_size(stream, chunk), chunk.key.frame_count))
            }
            CodecHeader::Color(_) => u64::MAX,
        };
        most.min(self.held_chunk_bytes(stream, chunk))
    }

    /// Bytes that are needed only while a chunk is parsed.
    pub fn parsing_bytes(&self, stream: &StreamEntry, chunk: &ChunkEntry) -> u64 {
        match self {
            CodecHeader::Color(header) if header.tables().is_some() => {
                region::parsing_bytes(u64::from(chunk.raw_bytes), unit_size(stream, chunk), chunk.key.frame_count)
            }
            _ => 0,
        }
    }

    /// Bytes of an uncompressed pixel as in table 1 of CALF: 32-bit depth, 24-bit colour, three 8-bit materials.
    /// Half-float colour has 48 bits and alpha 8; table 1 has neither.
    pub fn raw_pixel_bytes(&self) -> u64 {
        match self {
            CodecHeader::Depth(_) => 4,
            CodecHeader::Color(ColorHeader { format: ColorFormat::Half { .. }, .. }) => 6,
            CodecHeader::Color(_) | CodecHeader::Material(_) => 3,
            CodecHeader::Alpha(_) => 1,
        }
    }

    pub fn codec_name(&self) -> &'static str {
        match self.codec() {
            COLOR_CELLS_8 => "cells-8bit",
            COLOR_CELLS_HALF => "cells-half",
            COLOR_CELLS_BC1 => "cells-bc1",
            COLOR_CELLS_BC7 => "cells-bc7",
            COLOR_CELLS_BC6H => "cells-bc6h",
            COLOR_TRANSFORM_8 => "transform-8bit",
            COLOR_TRANSFORM_HALF => "transform-half",
            DEPTH_AABB_BC5 => "aabb-bc5",
            MATERIAL_AABB_BC1 => "aabb-bc1",
            DEPTH_NODES => "quadtree",
            DEPTH_TREE => "quadtree-intermediate",
            DEPTH_BLOCKS => "bc4w",
            DEPTH_PREDICTIVE | ALPHA_PREDICTIVE => "predictive",
            _ => "aabb",
        }
    }

    /// True if units consist of blocks of 4x4 pixels, so that their sides are multiples of 4.
    pub fn in_blocks(&self) -> bool {
        match self {
            CodecHeader::Depth(header) => matches!(header.coding, DepthCoding::BoxesInBlocks(_)),
            CodecHeader::Material(header) => header.in_blocks,
            CodecHeader::Color(header) => header.blocks().is_some(),
            CodecHeader::Alpha(_) => false,
        }
    }
}
