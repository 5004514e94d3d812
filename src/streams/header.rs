//! What a stream's codec needs to know once (depth.md 3, color.md 2): typed here, bytes in the container.

use crate::block::SIDE;
use crate::color::blend::HalfKey;
use crate::color::cells::CellFormat;
use crate::color::keyframe_blocks::KeyframeBlocks;
use crate::color::keyframes::SearchSettings;
use crate::color::quality::Pu21;
use crate::container::StreamEntry;
use crate::container::fields::{Fields, PutFields};
use crate::dataset::stream::{DepthKind, StreamKind};
use crate::depth::DomainParts;
use crate::depth::block::MAX_TILE;
use crate::depth::domain::DomainKind;
use crate::depth::quantise::DepthRange;
use crate::depth::temporal::TemporalSettings;
use crate::error::{Error, Result};
use crate::image::transfer::{ToneMap, Transfer};

/// Depth codes in boxes.
pub const DEPTH_AABB: [u8; 4] = *b"DAAB";
/// Depth as packed nodes of a quadtree.
pub const DEPTH_NODES: [u8; 4] = *b"DQPN";
/// Depth in the intermediate form of the quadtree.
pub const DEPTH_TREE: [u8; 4] = *b"DQTR";
/// Depth as plain BC4w blocks.
pub const DEPTH_BLOCKS: [u8; 4] = *b"DB4W";
/// Depth codes in boxes, pieces of them in BC5 blocks.
pub const DEPTH_AABB_BC5: [u8; 4] = *b"DAB5";
/// Material triples in boxes.
pub const MATERIAL_AABB: [u8; 4] = *b"MAAB";
/// Material triples in boxes, pieces of them in BC1 blocks.
pub const MATERIAL_AABB_BC1: [u8; 4] = *b"MAB1";
/// 8-bit colour cells.
pub const COLOR_CELLS_8: [u8; 4] = *b"CCL8";
/// Half-float colour cells.
pub const COLOR_CELLS_HALF: [u8; 4] = *b"CCLH";
/// 8-bit colour cells with keyframes in BC1 blocks.
pub const COLOR_CELLS_BC1: [u8; 4] = *b"CCB1";
/// 8-bit colour cells with keyframes in BC7 blocks.
pub const COLOR_CELLS_BC7: [u8; 4] = *b"CCB7";
/// Half-float colour cells with keyframes in BC6H blocks.
pub const COLOR_CELLS_BC6H: [u8; 4] = *b"CCB6";

/// Header of a depth stream.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DepthHeader {
    /// What codes 0 and 65534 mean.
    pub range: DepthRange,
    /// The value that stood for "nothing there" in the source, and does so again when decoded.
    pub background: f32,
    /// What the metres measure.
    pub kind: DepthKind,
    /// How it was coded.
    pub coding: DepthCoding,
}

/// How depth codes are stored.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum DepthCoding {
    /// Codes as they are, in boxes around what changes; only the window matters to a decoder.
    Boxes(TemporalSettings),
    /// The same with pieces of the boxes in BC5 blocks.
    BoxesInBlocks(TemporalSettings),
    /// Packed nodes of a quadtree.
    Nodes(NodeHeader),
    /// The quadtree itself, with all leaves as they are.
    Tree(NodeHeader),
    /// BC4w blocks, each frame whole.
    Blocks,
}

/// Header of a stream of nodes; only the window and the domain matter to a decoder.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NodeHeader {
    /// W: longest step of a decoder, in frames.
    pub window: u8,
    /// How far, in codes, the source may move away from what is shown on top of the bound.
    pub epsilon: u16,
    /// Most frames of a chunk that the encoder was allowed.
    pub keyframe_interval: u32,
    /// Largest error of a node in codes; of a tree, that of its functions.
    pub bound: u16,
    /// What functions are evaluated in.
    pub domain: DomainParts,
}

/// Header of a material stream.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MaterialHeader {
    /// How it was coded; only the window matters to a decoder.
    pub temporal: TemporalSettings,
    /// Whether pieces of the boxes are in BC1 blocks.
    pub in_blocks: bool,
}

/// The domain that colour is coded and measured in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ColorFormat {
    /// 8 bits a sample behind a transfer function.
    EightBit(ToneMap),
    /// Half floats; the metric takes 1.0 for this many cd/m².
    Half {
        /// Luminance of 1.0, in cd/m².
        white_cd_m2: f64,
    },
}

/// A format of blocks for keyframes of colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ColorBlocks {
    /// 8 bytes for 4x4 pixels of 8 bits.
    Bc1,
    /// 16 bytes for 4x4 pixels of 8 bits.
    Bc7,
    /// 16 bytes for 4x4 pixels of half floats.
    Bc6h,
}

/// Header of a colour stream.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ColorHeader {
    /// The domain.
    pub format: ColorFormat,
    /// What keyframes are stored in: BC1 or BC7 for 8 bits, BC6H for half floats; `None` for samples alone.
    pub blocks: Option<ColorBlocks>,
    /// The PSNR that every frame of every cell reaches.
    pub min_psnr_db: f64,
}

/// Header of a stream.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum CodecHeader {
    /// Depth.
    Depth(DepthHeader),
    /// Colour.
    Color(ColorHeader),
    /// Material.
    Material(MaterialHeader),
}

impl DepthHeader {
    /// The longest step of a decoder, in frames.
    pub fn window(&self) -> u8 {
        match self.coding {
            DepthCoding::Boxes(temporal) | DepthCoding::BoxesInBlocks(temporal) => temporal.window,
            DepthCoding::Nodes(nodes) => nodes.window,
            DepthCoding::Tree(_) | DepthCoding::Blocks => 1,
        }
    }

    /// The promise: how far a decoded surface is from its source at most, in codes; `None` where there is none.
    pub fn error_bound(&self) -> Option<u16> {
        match self.coding {
            DepthCoding::Boxes(temporal) | DepthCoding::BoxesInBlocks(temporal) => Some(temporal.epsilon),
            DepthCoding::Nodes(nodes) => Some(nodes.bound.saturating_add(nodes.epsilon)),
            DepthCoding::Tree(_) => Some(0),
            DepthCoding::Blocks => None,
        }
    }
}

impl ColorHeader {
    /// The header of cells of samples, which speaks of what the search was asked for.
    pub fn new(format: ColorFormat, search: &SearchSettings) -> ColorHeader {
        ColorHeader { format, blocks: None, min_psnr_db: search.min_psnr_db }
    }

    /// How a cell of this width and height is read, of a stream of 8 bits.
    pub fn cell_of_bytes(&self, [width, height]: [u32; 2]) -> CellFormat<u8> {
        let blocks = self.blocks.map(|blocks| match blocks {
            ColorBlocks::Bc1 => KeyframeBlocks::BC1,
            ColorBlocks::Bc7 | ColorBlocks::Bc6h => KeyframeBlocks::BC7,
        });
        CellFormat { size: [width as usize, height as usize], blocks }
    }

    /// How a cell of this width and height is read, of a stream of half floats.
    pub fn cell_of_halves(&self, [width, height]: [u32; 2]) -> CellFormat<HalfKey> {
        CellFormat { size: [width as usize, height as usize], blocks: self.blocks.map(|_| KeyframeBlocks::BC6H) }
    }
}

impl CodecHeader {
    /// The kind of stream.
    pub fn kind(&self) -> StreamKind {
        match self {
            CodecHeader::Depth(_) => StreamKind::Depth,
            CodecHeader::Color(_) => StreamKind::Color,
            CodecHeader::Material(_) => StreamKind::Material,
        }
    }

    /// The four characters of the codec.
    pub fn codec(&self) -> [u8; 4] {
        match self {
            CodecHeader::Depth(header) => match header.coding {
                DepthCoding::Boxes(_) => DEPTH_AABB,
                DepthCoding::BoxesInBlocks(_) => DEPTH_AABB_BC5,
                DepthCoding::Nodes(_) => DEPTH_NODES,
                DepthCoding::Tree(_) => DEPTH_TREE,
                DepthCoding::Blocks => DEPTH_BLOCKS,
            },
            CodecHeader::Material(MaterialHeader { in_blocks: false, .. }) => MATERIAL_AABB,
            CodecHeader::Material(MaterialHeader { in_blocks: true, .. }) => MATERIAL_AABB_BC1,
            CodecHeader::Color(header) => match (header.format, header.blocks) {
                (ColorFormat::EightBit(_), None) => COLOR_CELLS_8,
                (ColorFormat::EightBit(_), Some(ColorBlocks::Bc1)) => COLOR_CELLS_BC1,
                (ColorFormat::EightBit(_), Some(_)) => COLOR_CELLS_BC7,
                (ColorFormat::Half { .. }, None) => COLOR_CELLS_HALF,
                (ColorFormat::Half { .. }, Some(_)) => COLOR_CELLS_BC6H,
            },
        }
    }

    /// The most bytes that a unit takes besides its pixels and payloads: its decoder and what it has parsed, and in reports
    /// what is counted of it. Half a page of fields, and some twenty allocations of a few bytes each.
    pub const HELD_UNIT_BYTES: u64 = 4 << 10;

    /// Bytes that a decoder of whole images holds for each pixel: the picture of its unit, the image, and for colour two
    /// keyframes; half floats are held as keys as well.
    pub fn held_pixel_bytes(&self) -> u64 {
        match self {
            CodecHeader::Depth(_) => 4,
            CodecHeader::Material(_) => 6,
            CodecHeader::Color(ColorHeader { format: ColorFormat::EightBit(_), .. }) => 12,
            CodecHeader::Color(_) => 30,
        }
    }

    /// The most bytes that a decoder holds for a unit's payload of `bytes`: nodes of two bytes become 34 in the runtime form
    /// and as many while they are read; a box of ten, or a record of 14, gets a row of a table; a cell of colour holds the
    /// payload that follows, too, and a row for each keyframe, of which there are at most 65,535. Memory that grows is doubled.
    pub fn held_payload_bytes(&self, bytes: u64) -> u64 {
        match self {
            CodecHeader::Depth(DepthHeader { coding: DepthCoding::Nodes(_) | DepthCoding::Tree(_), .. }) => 64 * bytes,
            CodecHeader::Depth(_) | CodecHeader::Material(_) => 10 * bytes,
            CodecHeader::Color(_) => 4 * bytes + (8 * bytes).min(4 << 20),
        }
    }

    /// The word for the codec in reports.
    pub fn codec_name(&self) -> &'static str {
        match self.codec() {
            COLOR_CELLS_8 => "cells-8bit",
            COLOR_CELLS_HALF => "cells-half",
            COLOR_CELLS_BC1 => "cells-bc1",
            COLOR_CELLS_BC7 => "cells-bc7",
            COLOR_CELLS_BC6H => "cells-bc6h",
            DEPTH_AABB_BC5 => "aabb-bc5",
            MATERIAL_AABB_BC1 => "aabb-bc1",
            DEPTH_NODES => "quadtree",
            DEPTH_TREE => "quadtree-intermediate",
            DEPTH_BLOCKS => "bc4w",
            _ => "aabb",
        }
    }

    /// The header as bytes.
    pub fn write(&self) -> Vec<u8> {
        let mut out = Vec::new();
        match self {
            CodecHeader::Depth(header) => {
                out.put_f32(header.range.near_m());
                out.put_f32(header.range.far_m());
                out.put_f32(header.background);
                out.put_u32(match header.kind {
                    DepthKind::Distance => 0,
                    DepthKind::Planar => 1,
                });
                match header.coding {
                    DepthCoding::Boxes(temporal) | DepthCoding::BoxesInBlocks(temporal) => {
                        write_temporal(&temporal, &mut out);
                    }
                    DepthCoding::Nodes(nodes) | DepthCoding::Tree(nodes) => write_nodes(&nodes, &mut out),
                    DepthCoding::Blocks => {}
                }
            }
            CodecHeader::Material(header) => write_temporal(&header.temporal, &mut out),
            CodecHeader::Color(header) => {
                out.put_f64(header.min_psnr_db);
                match header.format {
                    ColorFormat::EightBit(tone) => {
                        out.put_f32(tone.exposure_ev);
                        out.put_u32(match tone.transfer {
                            Transfer::Srgb => 0,
                            Transfer::Linear => 1,
                        });
                    }
                    ColorFormat::Half { white_cd_m2 } => out.put_f64(white_cd_m2),
                }
            }
        }
        out
    }

    /// Reads the header of a stream of the container.
    pub fn read(stream: &StreamEntry) -> Result<CodecHeader> {
        let section = if stream.kind == StreamKind::Color as u8 { "color.md 2" } else { "depth.md 3" };
        let mut fields = Fields::new(&stream.codec_header, 0, section);
        let header = match (StreamKind::from_index(stream.kind), stream.codec) {
            (
                Some(StreamKind::Depth),
                codec @ (DEPTH_AABB | DEPTH_AABB_BC5 | DEPTH_NODES | DEPTH_TREE | DEPTH_BLOCKS),
            ) => {
                let header = read_depth(&mut fields, codec)?;
                let in_boxes = codec == DEPTH_AABB || codec == DEPTH_AABB_BC5;
                if !in_boxes && stream.unit_width.max(stream.unit_height) > MAX_TILE {
                    return Err(fields.error(format!("tiles of more than {MAX_TILE} pixels")));
                }
                CodecHeader::Depth(header)
            }
            (Some(StreamKind::Material), codec @ (MATERIAL_AABB | MATERIAL_AABB_BC1)) => {
                let in_blocks = codec == MATERIAL_AABB_BC1;
                CodecHeader::Material(MaterialHeader { temporal: read_temporal(&mut fields)?, in_blocks })
            }
            (
                Some(StreamKind::Color),
                codec @ (COLOR_CELLS_8 | COLOR_CELLS_HALF | COLOR_CELLS_BC1 | COLOR_CELLS_BC7 | COLOR_CELLS_BC6H),
            ) => CodecHeader::Color(read_color(&mut fields, codec)?),
            _ => {
                return Err(Error::unsupported(format!(
                    "a stream of kind {} uses codec '{}', which this lightfold does not know",
                    stream.kind,
                    stream.codec.escape_ascii()
                )));
            }
        };
        if header.in_blocks() && [stream.unit_width, stream.unit_height].iter().any(|side| side % SIDE as u32 != 0) {
            return Err(fields.error(format!("units whose sides are no multiples of {SIDE} pixels")));
        }
        fields.finish()?;
        Ok(header)
    }

    /// Whether units are made of blocks of 4x4 pixels, so that their sides are multiples of 4.
    pub fn in_blocks(&self) -> bool {
        match self {
            CodecHeader::Depth(header) => matches!(header.coding, DepthCoding::BoxesInBlocks(_)),
            CodecHeader::Material(header) => header.in_blocks,
            CodecHeader::Color(header) => header.blocks.is_some(),
        }
    }
}

fn read_depth(fields: &mut Fields<'_>, codec: [u8; 4]) -> Result<DepthHeader> {
    let range = DepthRange::new(fields.f32()?, fields.f32()?)?;
    let background = fields.f32()?;
    if background.is_nan() {
        return Err(fields.error("the background value is not a number"));
    }
    let kind = match fields.u32()? {
        0 => DepthKind::Distance,
        1 => DepthKind::Planar,
        other => return Err(fields.error(format!("depth of kind {other} is unknown"))),
    };
    let coding = match codec {
        DEPTH_NODES => DepthCoding::Nodes(read_nodes(fields)?),
        DEPTH_TREE => match read_nodes(fields)? {
            nodes @ NodeHeader { window: 1, .. } => DepthCoding::Tree(nodes),
            NodeHeader { window, .. } => {
                return Err(
                    fields.error(format!("a window of {window} frames, which an intermediate form cannot have"))
                );
            }
        },
        DEPTH_BLOCKS => DepthCoding::Blocks,
        DEPTH_AABB_BC5 => DepthCoding::BoxesInBlocks(read_temporal(fields)?),
        _ => DepthCoding::Boxes(read_temporal(fields)?),
    };
    Ok(DepthHeader { range, background, kind, coding })
}

fn write_nodes(nodes: &NodeHeader, out: &mut Vec<u8>) {
    out.put_u16(u16::from(nodes.window));
    out.put_u16(nodes.epsilon);
    out.put_u32(nodes.keyframe_interval);
    out.put_u16(nodes.bound);
    out.put_u16(nodes.domain.kind as u16);
    out.put_u32(nodes.domain.base);
    out.put_u32(nodes.domain.scale);
}

fn read_nodes(fields: &mut Fields<'_>) -> Result<NodeHeader> {
    fields.enter("depth.md 3");
    let (window, epsilon, keyframe_interval, bound) = (fields.u16()?, fields.u16()?, fields.u32()?, fields.u16()?);
    let window = u8::try_from(window)
        .ok()
        .filter(|&window| window > 0)
        .ok_or_else(|| fields.error(format!("a depth window of {window} frames")))?;
    if keyframe_interval == 0 {
        return Err(fields.error("a keyframe interval of 0 frames"));
    }
    let kind = fields.u16()?;
    let known = u8::try_from(kind).ok().and_then(DomainKind::from_byte);
    let kind = known.ok_or_else(|| fields.error(format!("domain {kind} is unknown")))?;
    let domain = DomainParts { kind, base: fields.u32()?, scale: fields.u32()? };
    domain.domain().map_err(|error| fields.error(error.to_string()))?;
    Ok(NodeHeader { window, epsilon, keyframe_interval, bound, domain })
}

fn read_color(fields: &mut Fields<'_>, codec: [u8; 4]) -> Result<ColorHeader> {
    let min_psnr_db = fields.finite_f64("the quality")?;
    let blocks = match codec {
        COLOR_CELLS_BC1 => Some(ColorBlocks::Bc1),
        COLOR_CELLS_BC7 => Some(ColorBlocks::Bc7),
        COLOR_CELLS_BC6H => Some(ColorBlocks::Bc6h),
        _ => None,
    };
    let format = if codec != COLOR_CELLS_HALF && codec != COLOR_CELLS_BC6H {
        let exposure_ev = fields.f32()?;
        if !(-32.0..=32.0).contains(&exposure_ev) {
            return Err(fields.error(format!("an exposure of {exposure_ev} stops is not within -32 to 32")));
        }
        let transfer = match fields.u32()? {
            0 => Transfer::Srgb,
            1 => Transfer::Linear,
            other => return Err(fields.error(format!("transfer function {other} is unknown"))),
        };
        ColorFormat::EightBit(ToneMap { transfer, exposure_ev })
    } else {
        let white_cd_m2 = fields.finite_f64("the luminance of white")?;
        Pu21::check_white(white_cd_m2)?;
        ColorFormat::Half { white_cd_m2 }
    };
    Ok(ColorHeader { format, blocks, min_psnr_db })
}

fn write_temporal(settings: &TemporalSettings, out: &mut Vec<u8>) {
    out.put_u16(u16::from(settings.window));
    out.put_u16(settings.max_aabbs);
    out.put_u16(settings.epsilon);
    out.put_u16(0);
    out.put_u32(settings.keyframe_interval);
}

fn read_temporal(fields: &mut Fields<'_>) -> Result<TemporalSettings> {
    let (window, max_aabbs, epsilon) = (fields.u16()?, fields.u16()?, fields.u16()?);
    fields.zeros(2)?;
    let keyframe_interval = fields.u32()?;
    let window = u8::try_from(window).map_err(|_| fields.error(format!("a depth window of {window} frames")))?;
    let settings = TemporalSettings { window, epsilon, max_aabbs, keyframe_interval };
    settings.check().map_err(|error| fields.error(error.to_string()))?;
    Ok(settings)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::depth::domain::Domain;

    fn entry(header: &CodecHeader) -> StreamEntry {
        StreamEntry {
            kind: header.kind() as u8,
            face: 0,
            probe: 0,
            codec: header.codec(),
            width: 8,
            height: 8,
            first_frame: 0,
            frame_count: 1,
            unit_width: 8,
            unit_height: 8,
            codec_header: header.write(),
        }
    }

    fn samples() -> Vec<CodecHeader> {
        let temporal = TemporalSettings { window: 3, epsilon: 7, max_aabbs: 9, keyframe_interval: 11 };
        let range = DepthRange::new(0.25, 100.0).unwrap();
        let domain = Domain::new(DomainKind::Inverse, range).unwrap().parts();
        let nodes = NodeHeader { window: 3, epsilon: 1, keyframe_interval: 5, bound: 100, domain };
        let depth = |coding| {
            CodecHeader::Depth(DepthHeader { range, background: f32::INFINITY, kind: DepthKind::Planar, coding })
        };
        let tone = ColorFormat::EightBit(ToneMap { transfer: Transfer::Linear, exposure_ev: -1.5 });
        let half = ColorFormat::Half { white_cd_m2: 80.0 };
        let color = |format, blocks| CodecHeader::Color(ColorHeader { format, blocks, min_psnr_db: 50.0 });
        vec![
            depth(DepthCoding::Boxes(temporal)),
            depth(DepthCoding::BoxesInBlocks(temporal)),
            depth(DepthCoding::Nodes(nodes)),
            depth(DepthCoding::Tree(NodeHeader { window: 1, ..nodes })),
            depth(DepthCoding::Blocks),
            CodecHeader::Material(MaterialHeader { temporal, in_blocks: false }),
            CodecHeader::Material(MaterialHeader { temporal, in_blocks: true }),
            color(tone, None),
            color(tone, Some(ColorBlocks::Bc1)),
            color(tone, Some(ColorBlocks::Bc7)),
            color(half, None),
            color(half, Some(ColorBlocks::Bc6h)),
        ]
    }

    #[test]
    fn units_of_blocks_have_sides_in_whole_blocks() {
        for header in samples() {
            for (width, height) in [(7, 8), (8, 6), (12, 4)] {
                let odd = StreamEntry { unit_width: width, unit_height: height, ..entry(&header) };
                let refused = header.in_blocks() && (width, height) != (12, 4);
                assert_eq!(CodecHeader::read(&odd).is_err(), refused, "{}", header.codec_name());
            }
        }
    }

    #[test]
    fn headers_round_trip() {
        for header in samples() {
            assert_eq!(CodecHeader::read(&entry(&header)).unwrap(), header);
        }
    }

    #[test]
    fn headers_of_another_size_kind_or_codec_are_refused() {
        for header in samples() {
            let good = entry(&header);
            for spoil in 0..4 {
                let mut bad = good.clone();
                match spoil {
                    0 => bad.codec_header.push(0),
                    1 => bad.codec_header.truncate(bad.codec_header.len() - 1),
                    2 => bad.codec = *b"XXXX",
                    _ => bad.kind = (bad.kind + 1) % 3,
                }
                assert!(CodecHeader::read(&bad).is_err());
            }
        }
    }
}
