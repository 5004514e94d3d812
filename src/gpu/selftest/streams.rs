//! Random valid streams of every codec, decoded on a device and on the CPU in any order of frames.
//!
//! Most payloads are random rather than encoded, so they contain what the format allows but no footage needs. Some payloads of
//! the intermediate form, and all predictive depth, come from encoders.

use crate::decode::UnitFrame;
use crate::family::Family;
use crate::selftest::boxes::{BoxTexel, put_random, random_boxes_in, random_picture};
use crate::selftest::cells::{CellSample, push_random_keyframe};
use crate::selftest::nodes::random_nodes;
use crate::selftest::predictive;
use crate::selftest::transform::{any_payload, random_tables};
use crate::verify::Verification;
use crate::{Gpu, GpuDecoder};
use codec::color::cells::builder::CellBuilder;
use codec::color::transform::payload::CELLS;
use codec::color::transform::{Keyed, Tables};
use codec::color::{CellFormat, ChunkFormat};
use codec::container::{
    ChunkKey, Compression, EncodedChunk, PackedChunk, PayloadKind, ProbeEntry, Reader, StreamEntry, Writer,
};
use codec::decode::{Decoder, FaceDecoder, StreamInfo};
use codec::depth::block_chunk::picture_bytes;
use codec::depth::block_tiles::Layout;
use codec::depth::domain::{Domain, DomainKind};
use codec::depth::node_encoder::NodeSettings;
use codec::depth::nodes::Grid;
use codec::depth::record_table::TableBuilder;
use codec::depth::tree_chunk::encoder::TreeEncoder;
use codec::depth::{DepthRange, DomainParts, TemporalSettings, storage};
use codec::error::Result;
use codec::image::{DepthKind, ToneMap, Transfer};
use codec::math::random::Random;
use codec::monitor::Monitor;
use codec::streams::{
    AlphaHeader, CodecHeader, ColorBlocks, ColorCoding, ColorFormat, ColorHeader, DepthCoding, DepthHeader,
    MaterialHeader, NodeHeader,
};
use kernels::Kernel;
use kernels::prepare::prepared_bytes;

/// Number of faces of a probe; each has a stream of depth, colour, material and alpha.
const FACES: u8 = 6;
/// Frames requested from each stream.
const VISITS: u32 = 6;
/// Kernels of all families, in the order of comparison.
static DECODING: [&Kernel; 12] = [
    &kernels::NODES,
    &kernels::BOXES_CODES,
    &kernels::BOXES_BC5,
    &kernels::BOXES_MATERIAL,
    &kernels::BOXES_BC1,
    &kernels::CELLS_8BIT,
    &kernels::CELLS_BC1,
    &kernels::CELLS_BC7,
    &kernels::CELLS_HALF,
    &kernels::CELLS_BC6H,
    &kernels::TRANSFORM_8BIT,
    &kernels::TRANSFORM_HALF,
];

#[derive(Debug, Clone, Default, PartialEq, serde::Serialize)]
pub struct StreamsReport {
    pub streams: u64,
    pub images: u64,
    #[serde(flatten)]
    pub verification: Verification,
}

/// Decodes at least `count` random streams on a device and on the CPU. The monitor advances by one per stream.
pub fn test_streams(gpu: &Gpu, count: u64, seed: u64, monitor: &dyn Monitor) -> Result<StreamsReport> {
    let mut report = StreamsReport::default();
    let mut random = Random::new(seed);
    while report.streams < count {
        let container = random_container(&mut random)?;
        let decoder = Decoder::new(Reader::from_memory(container)?)?;
        for kernel in DECODING {
            monitor.check()?;
            let of = decoder.streams().iter().filter(|stream| Family::of(&stream.header).kernel == kernel);
            let streams: Vec<&StreamInfo> = of.collect();
            if !streams.is_empty() {
                compare(gpu, &decoder, &streams, &mut random, &mut report)?;
                monitor.advance(streams.len() as u64);
            }
        }
    }
    Ok(report)
}

fn compare(
    gpu: &Gpu,
    decoder: &Decoder,
    streams: &[&StreamInfo],
    random: &mut Random,
    report: &mut StreamsReport,
) -> Result<()> {
    let mut on_gpu = GpuDecoder::new(gpu, decoder, streams)?;
    if random.one_in(8) {
        // Large enough for any of these chunks and its successor, too small for all of them.
        let chunks = decoder.reader().index().chunks.iter();
        let of = chunks.filter_map(|chunk| {
            let stream = streams.iter().find(|stream| stream.index == chunk.key.stream)?;
            Some(prepared_bytes(stream, chunk) as usize)
        });
        on_gpu.limit_resident(of.fold(1 << 15, usize::max))?;
    }
    if random.one_in(8) {
        on_gpu.limit_work(random.pick(&[1, 20, 1000]).unwrap_or(1));
    }
    let mut on_cpu: Vec<FaceDecoder<'_>> = streams.iter().map(|stream| decoder.face(stream)).collect();
    let mut frames: Vec<u32> = streams.iter().map(|stream| stream.frames.first).collect();
    for _ in 0..VISITS {
        for (frame, stream) in frames.iter_mut().zip(streams) {
            let last = stream.frames.last;
            *frame = match random.below(4) {
                0 => stream.frames.first + random.below((last - stream.frames.first).min(60) + 1),
                1 => *frame,
                _ => (*frame + 1 + random.below(4)).min(last),
            };
        }
        let now: Vec<usize> = (0..streams.len()).filter(|_| !random.one_in(5)).collect();
        let units_of = |stream: usize| (0..streams[stream].entry.unit_count()).map(move |unit| (stream, unit));
        let units = now.iter().flat_map(|&stream| units_of(stream));
        let wanted = units.map(|(stream, unit)| UnitFrame { stream, unit, frame: frames[stream] });
        on_gpu.decode_units(&wanted.collect::<Vec<_>>())?;
        let pictures = on_gpu.read()?;
        for at in now {
            let on_cpu = on_cpu[at].decode(frames[at])?;
            report.images += 1;
            report.verification.compare(&pictures[at], &on_cpu, || {
                let header = &streams[at].header;
                let number = report.streams;
                format!("frame {} of a {} stream, about number {number}", frames[at], header.codec_name())
            });
        }
    }
    report.streams += streams.len() as u64;
    Ok(())
}

fn random_container(random: &mut Random) -> Result<Vec<u8>> {
    let mut writer = Writer::new(Vec::new(), "random", 24.0, 0)?;
    let probe = ProbeEntry {
        name: "00".into(),
        position: [0.0; 3],
        orientation: [0.0, 0.0, 0.0, 1.0],
        frames: [0, 1 << 20],
        intrinsics: [0.0; 4],
    };
    writer.add_probe(probe)?;
    let mut chunks = Vec::new();
    for face in 0..FACES {
        let alpha = CodecHeader::Alpha(AlphaHeader { keyframe_interval: 8 });
        for header in [depth_header(random)?, color_header(random), material_header(random), alpha] {
            add_stream(&mut writer, face, &header, &mut chunks, random)?;
        }
    }
    for (key, payload) in chunks {
        writer.push(&PackedChunk::new(key, payload, (Compression::None, PayloadKind::Mixed))?)?;
    }
    Ok(writer.finish()?.0)
}

fn depth_header(random: &mut Random) -> Result<CodecHeader> {
    let nodes = |random: &mut Random, window: u8| {
        let domain = match random.below(4) {
            0 => DomainParts { kind: DomainKind::Linear, base: random.below(24 << 24), scale: random.word().max(1) },
            1 => DomainParts { kind: DomainKind::Inverse, base: random.below(24 << 24), scale: random.word().max(1) },
            2 => DomainParts { kind: DomainKind::Inverse, base: 402_652_814, scale: 4_194_176 },
            _ => DomainParts { kind: DomainKind::Log, base: 0, scale: 0 },
        };
        NodeHeader { window, epsilon: 0, keyframe_interval: 64, bound: 100, domain }
    };
    let temporal = random_temporal(random);
    let coding = match random.below(15) {
        0..4 => DepthCoding::Nodes(nodes(random, temporal.window)),
        4 => DepthCoding::Tree(nodes(random, 1)),
        5 | 6 => DepthCoding::Blocks,
        7 | 8 => DepthCoding::BoxesInBlocks(temporal),
        9..12 => DepthCoding::Predictive(predictive::random_header(random)?),
        _ => DepthCoding::Boxes(temporal),
    };
    let (range, kind) = (DepthRange::new(0.5, 8.0)?, DepthKind::Distance);
    Ok(CodecHeader::Depth(DepthHeader { range, background: f32::INFINITY, kind, coding }))
}

fn color_header(random: &mut Random) -> CodecHeader {
    let bytes = ColorFormat::EightBit(ToneMap { transfer: Transfer::Srgb, exposure_ev: 0.0 });
    let half = ColorFormat::Half { white_cd_m2: 100.0 };
    let all = [
        (bytes, None),
        (bytes, Some(ColorBlocks::Bc1)),
        (bytes, Some(ColorBlocks::Bc7)),
        (half, None),
        (half, Some(ColorBlocks::Bc6h)),
    ];
    let (format, blocks) = random.pick(&all).unwrap_or(all[0]);
    let coding = match random.below(3) {
        0 if random.one_in(2) => ColorCoding::Transform(random_tables(random)),
        0 => ColorCoding::Transform(Tables::default()),
        _ => ColorCoding::Cells(blocks),
    };
    CodecHeader::Color(ColorHeader { format, coding, min_psnr_db: 50.0, min_quality: 0.0 })
}

fn material_header(random: &mut Random) -> CodecHeader {
    CodecHeader::Material(MaterialHeader { temporal: random_temporal(random), in_blocks: random.one_in(2) })
}

fn random_temporal(random: &mut Random) -> TemporalSettings {
    let window = random.pick(&[1, 2, 3, 5, 255]).unwrap_or(1);
    TemporalSettings { window, epsilon: 0, max_aabbs: 256, keyframe_interval: 64 }
}

/// Adds a random stream, and its encoded chunks.
fn add_stream(
    writer: &mut Writer<Vec<u8>>,
    face: u8,
    header: &CodecHeader,
    chunks: &mut Vec<(ChunkKey, Vec<u8>)>,
    random: &mut Random,
) -> Result<()> {
    let side = |random: &mut Random| if random.one_in(4) { 1 + random.below(90) } else { 1 + random.below(24) };
    let (width, height) = (side(random), side(random));
    // A few to a few dozen units.
    let part = |size: u32, random: &mut Random| size.div_ceil(6).max(1 + random.below(size + 4));
    let grid = if header.in_blocks() { 4 } else { 1 };
    let (unit_width, unit_height) = (part(width, random), part(height, random));
    let (unit_width, unit_height) = (unit_width.next_multiple_of(grid), unit_height.next_multiple_of(grid));
    // Some codecs take bytes for every frame.
    let is_short = Family::of(header).kernel == &kernels::NODES || is_predictive(header) || tables_of(header).is_some();
    let long = random.one_in(20) && !is_short;
    let frame_count = 1 + random.below(if long { 100_000 } else { 40 });
    let entry = StreamEntry {
        kind: header.kind() as u8,
        face,
        probe: 0,
        codec: header.codec(),
        width,
        height,
        first_frame: random.below(3),
        frame_count,
        unit_width,
        unit_height,
        codec_header: header.write().into(),
    };
    let stream = writer.add_stream(entry.clone());
    for unit in 0..entry.unit_count() {
        let [_, _, width, height] = entry.unit_rect(unit);
        for EncodedChunk { first_frame, frame_count, payload } in
            unit_chunks(header, [width, height], frame_count, random)?
        {
            let first_frame = entry.first_frame + first_frame;
            chunks.push((ChunkKey { stream, unit, first_frame, frame_count }, payload));
        }
    }
    Ok(())
}

fn unit_chunks(
    header: &CodecHeader,
    size: [u32; 2],
    frame_count: u32,
    random: &mut Random,
) -> Result<Vec<EncodedChunk>> {
    let grid = Grid { width: size[0], height: size[1] };
    let mut chunks = Vec::new();
    let mut first_frame = 0;
    while first_frame < frame_count {
        let left = frame_count - first_frame;
        let mut count = if random.one_in(3) { left } else { 1 + random.below(left) };
        let last = count == left;
        let payload = match header {
            CodecHeader::Depth(DepthHeader { coding: DepthCoding::Nodes(_), .. }) => nodes(grid, count, random)?,
            CodecHeader::Depth(DepthHeader { coding: DepthCoding::Tree(header), .. }) => {
                let domain = header.domain.domain()?;
                // An encoder writes it frame by frame.
                count = count.min(8);
                tree(grid, domain, count, random)?
            }
            CodecHeader::Depth(DepthHeader { coding: DepthCoding::Blocks, .. }) => {
                count = count.min(12);
                blocks(grid, count, random)
            }
            CodecHeader::Depth(DepthHeader { coding: DepthCoding::Boxes(_), .. }) => {
                records::<u16>(Layout::Values, size, count, random)?
            }
            CodecHeader::Depth(DepthHeader { coding: DepthCoding::Predictive(header), .. }) => {
                // An encoder writes it frame by frame and may close the chunk early.
                let Some(chunk) = predictive::random_chunk(header, size, count.min(8), random)? else { break };
                count = chunk.frame_count;
                chunk.payload
            }
            CodecHeader::Depth(_) => records::<u16>(Layout::BlockTiles, size, count, random)?,
            CodecHeader::Alpha(header) => {
                let Some(chunk) = predictive::random_chunk(&header.predictive(), size, count.min(8), random)? else {
                    break;
                };
                count = chunk.frame_count;
                chunk.payload
            }
            CodecHeader::Material(header) => records::<[u8; 3]>(header.layout(), size, count, random)?,
            CodecHeader::Color(header @ ColorHeader { format: ColorFormat::EightBit(_), .. }) => {
                color(&header.chunks_of_bytes(size), count, last, random)?
            }
            CodecHeader::Color(header) => color(&header.chunks_of_halves(size), count, last, random)?,
        };
        chunks.push(EncodedChunk { first_frame, frame_count: count, payload });
        first_frame += count;
    }
    Ok(chunks)
}

/// Returns frames that have a record: the first, and some of the following.
fn record_frames(count: u32, random: &mut Random) -> Vec<u32> {
    let mut frames = vec![0];
    let mut frame = 0;
    while frames.len() < 24 {
        let gap = if random.one_in(4) { 30 } else { 3 };
        frame += 1 + random.below(gap);
        if frame >= count {
            break;
        }
        frames.push(frame);
    }
    frames
}

fn nodes(grid: Grid, count: u32, random: &mut Random) -> Result<Vec<u8>> {
    let mut builder = TableBuilder::default();
    for frame in record_frames(count, random) {
        storage::write_record(grid, &random_nodes(grid, frame > 0, random), builder.begin(frame));
    }
    builder.finish()
}

fn tree(grid: Grid, domain: Domain, count: u32, random: &mut Random) -> Result<Vec<u8>> {
    let settings = NodeSettings { keyframe_interval: u32::MAX, ..NodeSettings::default() };
    let mut encoder = TreeEncoder::new(grid, domain, settings);
    let mut picture = random_picture::<u16>(grid.pixel_count() as usize, random);
    for _ in 0..count {
        let changed = random.below(picture.len() as u32) as usize;
        picture[changed] = random.word() as u16;
        encoder.push(&picture)?;
    }
    Ok(encoder.finish()?.map(|chunk| chunk.payload).unwrap_or_default())
}

fn blocks(grid: Grid, count: u32, random: &mut Random) -> Vec<u8> {
    let mut payload = vec![0; picture_bytes(grid) * count as usize];
    random.fill(&mut payload);
    // The last word of a block must not equal the marker.
    payload.iter_mut().skip(31).step_by(32).for_each(|byte| *byte &= 0x7f);
    payload
}

/// Returns records of all kinds, including those that the encoder never writes.
fn records<T: BoxTexel>(layout: Layout, size: [u32; 2], count: u32, random: &mut Random) -> Result<Vec<u8>> {
    let mut table = TableBuilder::default();
    for frame in record_frames(count, random) {
        let kind = if frame == 0 || random.one_in(5) { random.below(2) } else { 2 };
        let boxes = if kind == 2 { random_boxes_in(layout, size, random) } else { Vec::new() };
        let data = table.begin(frame);
        data.extend_from_slice(&[kind as u8, 0]);
        data.extend_from_slice(&(boxes.len() as u16).to_le_bytes());
        for b in &boxes {
            [b.x, b.y, b.width, b.height].iter().for_each(|value| data.extend_from_slice(&value.to_le_bytes()));
        }
        match kind {
            0 => put_random::<T>(layout, size, random, data),
            1 => T::random(random).put(data),
            _ => boxes.iter().for_each(|b| put_random::<T>(layout, [b.width, b.height].map(u32::from), random, data)),
        }
    }
    table.finish()
}

fn is_predictive(header: &CodecHeader) -> bool {
    matches!(header, CodecHeader::Depth(DepthHeader { coding: DepthCoding::Predictive(_), .. }) | CodecHeader::Alpha(_))
}

fn tables_of(header: &CodecHeader) -> Option<&Tables> {
    if let CodecHeader::Color(header) = header { header.tables() } else { None }
}

fn color<S: CellSample + Keyed>(
    format: &ChunkFormat<S>,
    count: u32,
    last: bool,
    random: &mut Random,
) -> Result<Vec<u8>> {
    let Some(tables) = &format.tables else { return cells(&format.cell, count, last, random) };
    if random.one_in(4) {
        return Ok([vec![CELLS], cells(&format.cell, count, true, random)?].concat());
    }
    any_payload::<S>(format.cell.size, count, tables, random)
}

/// Returns keyframes with weights between them. Weights after the last keyframe blend into the next chunk, so the last chunk
/// has none.
fn cells<S: CellSample>(format: &CellFormat<S>, count: u32, last: bool, random: &mut Random) -> Result<Vec<u8>> {
    let mut builder = CellBuilder::default();
    loop {
        push_random_keyframe(format, &mut builder, random);
        let left = count - builder.frame_count();
        let weights = random.below(6);
        // Another keyframe follows these weights.
        let more = weights < left && builder.keyframe_count() < 6;
        if more || !last {
            (0..weights.min(left)).for_each(|_| builder.push_weight(random.word() as u8, 1));
        }
        if !more {
            return builder.finish();
        }
    }
}
