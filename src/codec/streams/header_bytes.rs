//! Reads and writes codec headers (depth.md 3 and 16, color.md 2).

use crate::block::SIDE;
use crate::color::quality::{MAX_QUALITY, Pu21};
use crate::container::StreamEntry;
use crate::container::fields::Fields;
use crate::container::serialize::PutFields;
use crate::depth::block::MAX_TILE;
use crate::depth::domain::DomainKind;
use crate::depth::predictive::projection::{Projection, Shape};
use crate::depth::predictive::{Levels, PredictiveHeader};
use crate::depth::quantise::FAR_CODE;
use crate::depth::{DepthRange, DomainParts, TemporalSettings};
use crate::entropy::Tables;
use crate::error::{Error, Result};
use crate::image::transfer::{ToneMap, Transfer};
use crate::image::{DepthKind, StreamKind};
use crate::streams::header::{
    ALPHA_PREDICTIVE, AlphaHeader, COLOR_CELLS_8, COLOR_CELLS_BC1, COLOR_CELLS_BC6H, COLOR_CELLS_BC7, COLOR_CELLS_HALF,
    COLOR_TRANSFORM_8, COLOR_TRANSFORM_HALF, CodecHeader, ColorBlocks, ColorCoding, ColorFormat, ColorHeader,
    DEPTH_AABB, DEPTH_AABB_BC5, DEPTH_BLOCKS, DEPTH_NODES, DEPTH_PREDICTIVE, DEPTH_TREE, DepthCoding, DepthHeader,
    MATERIAL_AABB, MATERIAL_AABB_BC1, MaterialHeader, NodeHeader,
};

/// Number of planes of the transform codec: red, green and blue.
const PLANES: u8 = 3;

impl CodecHeader {
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
                match &header.coding {
                    DepthCoding::Boxes(temporal) | DepthCoding::BoxesInBlocks(temporal) => {
                        write_temporal(temporal, &mut out);
                    }
                    DepthCoding::Nodes(nodes) | DepthCoding::Tree(nodes) => write_nodes(nodes, &mut out),
                    DepthCoding::Blocks => {}
                    DepthCoding::Predictive(predictive) => write_predictive(predictive, &mut out),
                }
            }
            CodecHeader::Material(header) => write_temporal(&header.temporal, &mut out),
            CodecHeader::Alpha(header) => out.put_u32(header.keyframe_interval),
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
                if let ColorCoding::Transform(tables) = &header.coding {
                    out.put_f64(header.min_quality);
                    out.extend_from_slice(&[PLANES, 0, 0, 0]);
                    out.push(tables.own_count());
                    tables.write(&mut out);
                }
            }
        }
        out
    }

    pub fn read(stream: &StreamEntry) -> Result<CodecHeader> {
        let section = match StreamKind::from_index(stream.kind) {
            Some(StreamKind::Color) => "color.md 2",
            Some(StreamKind::Alpha) => "depth.md 16",
            _ => "depth.md 3",
        };
        let mut fields = Fields::new(&stream.codec_header, 0, section);
        let header = match (StreamKind::from_index(stream.kind), stream.codec) {
            (
                Some(StreamKind::Depth),
                codec @ (DEPTH_AABB | DEPTH_AABB_BC5 | DEPTH_NODES | DEPTH_TREE | DEPTH_BLOCKS | DEPTH_PREDICTIVE),
            ) => {
                let header = read_depth(&mut fields, codec)?;
                let in_boxes = codec == DEPTH_AABB || codec == DEPTH_AABB_BC5;
                if !in_boxes {
                    check_tile(stream, &fields)?;
                }
                if header.is_of_cube() && stream.width != stream.height {
                    return Err(fields.error("a cube face that is not square"));
                }
                CodecHeader::Depth(header)
            }
            (Some(StreamKind::Material), codec @ (MATERIAL_AABB | MATERIAL_AABB_BC1)) => {
                let in_blocks = codec == MATERIAL_AABB_BC1;
                CodecHeader::Material(MaterialHeader { temporal: read_temporal(&mut fields)?, in_blocks })
            }
            (Some(StreamKind::Alpha), ALPHA_PREDICTIVE) => {
                check_tile(stream, &fields)?;
                CodecHeader::Alpha(AlphaHeader { keyframe_interval: read_keyframe_interval(&mut fields)? })
            }
            (
                Some(StreamKind::Color),
                codec @ (COLOR_CELLS_8 | COLOR_CELLS_HALF | COLOR_CELLS_BC1 | COLOR_CELLS_BC7 | COLOR_CELLS_BC6H
                | COLOR_TRANSFORM_8 | COLOR_TRANSFORM_HALF),
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
            return Err(fields.error(format!("units whose sides are not multiples of {SIDE} pixels")));
        }
        fields.finish()?;
        Ok(header)
    }
}

fn check_tile(stream: &StreamEntry, fields: &Fields<'_>) -> Result<()> {
    match stream.unit_width.max(stream.unit_height) > MAX_TILE {
        true => Err(fields.error(format!("tiles of more than {MAX_TILE} pixels"))),
        false => Ok(()),
    }
}

fn read_keyframe_interval(fields: &mut Fields<'_>) -> Result<u32> {
    match fields.u32()? {
        0 => Err(fields.error("a keyframe interval of 0 frames")),
        frames => Ok(frames),
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
        DEPTH_PREDICTIVE => DepthCoding::Predictive(read_predictive(fields)?),
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
    let (window, epsilon) = (fields.u16()?, fields.u16()?);
    let (keyframe_interval, bound) = (read_keyframe_interval(fields)?, fields.u16()?);
    let window = u8::try_from(window)
        .ok()
        .filter(|&window| window > 0)
        .ok_or_else(|| fields.error(format!("a depth window of {window} frames")))?;
    let kind = fields.u16()?;
    let known = u8::try_from(kind).ok().and_then(DomainKind::from_byte);
    let kind = known.ok_or_else(|| fields.error(format!("domain {kind} is unknown")))?;
    let domain = DomainParts { kind, base: fields.u32()?, scale: fields.u32()? };
    domain.domain().map_err(|error| fields.error(error.to_string()))?;
    Ok(NodeHeader { window, epsilon, keyframe_interval, bound, domain })
}

fn write_predictive(header: &PredictiveHeader, out: &mut Vec<u8>) {
    out.put_u16(header.bound);
    out.put_u16(header.epsilon);
    out.put_u32(header.keyframe_interval);
    out.put_u16(header.projection.shape as u16);
    out.extend([u8::from(!header.levels.is_empty()), header.tables.own_count()]);
    out.put_u32(header.projection.octave);
    header.tables.write(out);
    if !header.levels.is_empty() {
        out.put_u16(header.levels.codes().len() as u16);
        header.levels.codes().iter().for_each(|&code| out.put_u16(code));
    }
}

fn read_predictive(fields: &mut Fields<'_>) -> Result<PredictiveHeader> {
    let (bound, epsilon, keyframe_interval) = (fields.u16()?, fields.u16()?, read_keyframe_interval(fields)?);
    if bound > FAR_CODE {
        return Err(fields.error(format!("a bound of {bound} codes, at most {FAR_CODE} are legal")));
    }
    let (shape, has_levels, own_sets, octave) = (fields.u16()?, fields.u8()?, fields.u8()?, fields.u32()?);
    let known = u8::try_from(shape).ok().and_then(Shape::from_byte);
    let shape = known.ok_or_else(|| fields.error(format!("projection {shape} is unknown")))?;
    let projection = Projection { shape, octave };
    if !projection.is_legal() {
        return Err(fields.error(format!("projection {} with {octave} codes for a factor of two", shape as u8)));
    }
    let tables = Tables::read(fields, own_sets)?;
    let levels = match has_levels {
        0 => Levels::default(),
        1 if bound == 0 && epsilon == 0 && shape == Shape::None => {
            let codes = (0..fields.u16()?).map(|_| fields.u16()).collect::<Result<Vec<_>>>()?;
            Levels::new(codes).map_err(|error| fields.error(error.to_string()))?
        }
        1 => return Err(fields.error("levels in a stream with a bound, a threshold or a projection")),
        other => return Err(fields.error(format!("levels of kind {other} are unknown"))),
    };
    Ok(PredictiveHeader { bound, epsilon, keyframe_interval, projection, tables, levels })
}

fn read_color(fields: &mut Fields<'_>, codec: [u8; 4]) -> Result<ColorHeader> {
    let min_psnr_db = fields.finite_f64("the PSNR")?;
    let is_half = matches!(codec, COLOR_CELLS_HALF | COLOR_CELLS_BC6H | COLOR_TRANSFORM_HALF);
    let format = if !is_half {
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
    let mut min_quality = 0.0;
    let coding = match codec {
        COLOR_CELLS_BC1 => ColorCoding::Cells(Some(ColorBlocks::Bc1)),
        COLOR_CELLS_BC7 => ColorCoding::Cells(Some(ColorBlocks::Bc7)),
        COLOR_CELLS_BC6H => ColorCoding::Cells(Some(ColorBlocks::Bc6h)),
        COLOR_TRANSFORM_8 | COLOR_TRANSFORM_HALF => {
            min_quality = fields.finite_f64("the quality")?;
            if !(0.0..=MAX_QUALITY).contains(&min_quality) {
                return Err(fields.error(format!("a quality of {min_quality} is not within 0 to {MAX_QUALITY}")));
            }
            let planes = fields.u8()?;
            if planes != PLANES {
                return Err(fields.error(format!("{planes} planes of colour, {PLANES} were expected")));
            }
            fields.zeros(3)?;
            let own_sets = fields.u8()?;
            ColorCoding::Transform(Tables::read(fields, own_sets)?)
        }
        _ => ColorCoding::Cells(None),
    };
    Ok(ColorHeader { format, coding, min_psnr_db, min_quality })
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
    use std::sync::Arc;

    use super::*;
    use crate::container::Index;
    use crate::depth::domain::Domain;
    use crate::streams::info::streams;

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
            codec_header: header.write().into(),
        }
    }

    fn samples() -> Vec<CodecHeader> {
        let temporal = TemporalSettings { window: 3, epsilon: 7, max_aabbs: 9, keyframe_interval: 11 };
        let range = DepthRange::new(0.25, 100.0).unwrap();
        let domain = Domain::new(DomainKind::Inverse, range).unwrap().parts;
        let nodes = NodeHeader { window: 3, epsilon: 1, keyframe_interval: 5, bound: 100, domain };
        let depth = |coding| {
            CodecHeader::Depth(DepthHeader { range, background: f32::INFINITY, kind: DepthKind::Planar, coding })
        };
        let tone = ColorFormat::EightBit(ToneMap { transfer: Transfer::Linear, exposure_ev: -1.5 });
        let half = ColorFormat::Half { white_cd_m2: 80.0 };
        let color = |format, blocks| {
            CodecHeader::Color(ColorHeader {
                format,
                coding: ColorCoding::Cells(blocks),
                min_psnr_db: 50.0,
                min_quality: 0.0,
            })
        };
        let transform = |format, tables| {
            CodecHeader::Color(ColorHeader {
                format,
                coding: ColorCoding::Transform(tables),
                min_psnr_db: 0.0,
                min_quality: 77.5,
            })
        };
        let predictive = |tables| PredictiveHeader {
            bound: 100,
            epsilon: 3,
            keyframe_interval: 64,
            projection: Projection { shape: Shape::Planar, octave: 9731 },
            tables,
            levels: Levels::default(),
        };
        let levels = PredictiveHeader {
            bound: 0,
            epsilon: 0,
            projection: Projection::default(),
            levels: Levels::new(vec![3, 700, 65_534]).unwrap(),
            ..predictive(Tables::default())
        };
        let predictive = |tables| depth(DepthCoding::Predictive(predictive(tables)));
        vec![
            depth(DepthCoding::Boxes(temporal)),
            depth(DepthCoding::BoxesInBlocks(temporal)),
            depth(DepthCoding::Nodes(nodes)),
            depth(DepthCoding::Tree(NodeHeader { window: 1, ..nodes })),
            depth(DepthCoding::Blocks),
            predictive(Tables::default()),
            predictive(Tables::with_own(Tables::default().sets()[1..4].to_vec())),
            depth(DepthCoding::Predictive(levels)),
            CodecHeader::Material(MaterialHeader { temporal, in_blocks: false }),
            CodecHeader::Material(MaterialHeader { temporal, in_blocks: true }),
            color(tone, None),
            color(tone, Some(ColorBlocks::Bc1)),
            color(tone, Some(ColorBlocks::Bc7)),
            color(half, None),
            color(half, Some(ColorBlocks::Bc6h)),
            transform(tone, Tables::default()),
            transform(half, Tables::with_own(Tables::default().sets()[1..3].to_vec())),
        ]
    }

    #[test]
    fn units_of_blocks_have_sides_in_whole_blocks() {
        for header in samples() {
            for (width, height) in [(7, 8), (8, 6), (12, 4)] {
                let odd = StreamEntry { unit_width: width, unit_height: height, ..entry(&header) };
                let refused = header.in_blocks() && (width, height) != (12, 4);
                assert_eq!(CodecHeader::read(&odd).is_err(), refused, "{}", header.codec_name());
                // Also after a stream with an equal header.
                let index = Index { streams: vec![entry(&header), odd], ..Index::default() };
                assert_eq!(streams(&index).is_err(), refused, "{}", header.codec_name());
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
    fn other_planes_than_red_green_and_blue_are_refused() {
        let transforms = samples().into_iter().filter(|header| header.codec_name().starts_with("transform"));
        for header in transforms {
            for (at, value) in [(23, 0xc0), (24, 4), (24, 1), (25, 1), (27, 1), (28, 9)] {
                let mut bad = entry(&header);
                Arc::make_mut(&mut bad.codec_header)[at] = value;
                assert!(CodecHeader::read(&bad).is_err(), "{} {at} {value}", header.codec_name());
            }
        }
    }

    #[test]
    fn headers_of_another_size_kind_or_codec_are_refused() {
        for header in samples() {
            let good = entry(&header);
            for spoil in 0..4 {
                let mut bad = good.clone();
                match spoil {
                    0 => Arc::make_mut(&mut bad.codec_header).push(0),
                    1 => Arc::make_mut(&mut bad.codec_header).truncate(good.codec_header.len() - 1),
                    2 => bad.codec = *b"XXXX",
                    _ => bad.kind = (bad.kind + 1) % 3,
                }
                assert!(CodecHeader::read(&bad).is_err());
            }
        }
    }
}
