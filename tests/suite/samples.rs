//! Small containers written through the library, and their decoded images. All of them are deterministic.

use std::sync::Arc;

use codec::color::cells::builder::CellBuilder;
use codec::color::quality::{EightBit, Pu21, Quality};
use codec::color::temporal::BlockStage;
use codec::color::transform::encode::{PricedTables, TransformEncoder};
use codec::color::transform::{Keyed, Tables};
use codec::color::{CellEncoder, CellFormat, HalfKey, Sample, SearchSettings};
use codec::container::{
    ChunkEntry, ChunkKey, Compression, EncodedChunk, Index, PackedChunk, PayloadKind, ProbeEntry, Reader, Storage,
    StreamEntry, Writer, compression,
};
use codec::decode::{Decoder, Picture};
use codec::depth::block_chunk::encoder::BlockEncoder;
use codec::depth::domain::{Domain, DomainKind};
use codec::depth::mode_decision::Decide;
use codec::depth::node_encoder::{NodeEncoder, NodeSettings};
use codec::depth::nodes::Grid;
use codec::depth::predictive::encoder::PredictiveEncoder;
use codec::depth::predictive::{PredictiveHeader, UnitArea};
use codec::depth::tree_chunk::encoder::TreeEncoder;
use codec::depth::{DepthRange, TemporalEncoder, TemporalSettings, Texel};
use codec::effort::Effort;
use codec::image::DepthKind;
use codec::image::transfer::ToneMap;
use codec::streams::{
    AlphaHeader, CodecHeader, ColorBlocks, ColorCoding, ColorFormat, ColorHeader, DepthCoding, DepthHeader,
    MaterialHeader, NodeHeader,
};
use half::f16;
use lightfold::Result;

// The path is explicit because two test binaries include this file from different folders.
#[path = "samples_of_files.rs"]
mod files;

pub use files::*;

/// Seeded pseudo-random generator, equal on all machines.
#[derive(Debug, Clone)]
pub struct Random(pub u64);

impl Random {
    /// Returns a number below `n`.
    pub fn below(&mut self, n: u32) -> u32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 33) % u64::from(n)) as u32
    }
}

/// Face, size, unit size and frame range of a stream.
#[derive(Debug, Clone, Copy)]
pub struct Shape {
    pub face: u8,
    pub size: [u32; 2],
    pub unit: [u32; 2],
    pub first_frame: u32,
    pub frame_count: u32,
}

/// A stream with its encoded chunks: unit, and chunk with frames counted from the stream's first frame.
#[derive(Debug, Clone)]
pub struct Stream {
    pub entry: StreamEntry,
    pub chunks: Vec<(u32, EncodedChunk)>,
}

pub fn entry(shape: Shape, header: &CodecHeader) -> StreamEntry {
    StreamEntry {
        kind: header.kind() as u8,
        face: shape.face,
        probe: 0,
        codec: header.codec(),
        width: shape.size[0],
        height: shape.size[1],
        first_frame: shape.first_frame,
        frame_count: shape.frame_count,
        unit_width: shape.unit[0],
        unit_height: shape.unit[1],
        codec_header: header.write().into(),
    }
}

pub fn cut<T: Copy>(image: &[T], width: u32, [left, top, w, h]: [u32; 4]) -> Vec<T> {
    (top..top + h).flat_map(|y| (left..left + w).map(move |x| image[(y * width + x) as usize])).collect()
}

fn temporal<T: Texel>(
    entry: StreamEntry,
    images: &[Vec<T>],
    encoder: impl Fn([u32; 2]) -> TemporalEncoder<T>,
) -> Stream {
    assert_eq!(images.len(), entry.frame_count as usize);
    let mut chunks = Vec::new();
    for unit in 0..entry.unit_count() {
        let rect = entry.unit_rect(unit);
        let mut encoder = encoder([rect[2], rect[3]]);
        for image in images {
            chunks.extend(encoder.push(&cut(image, entry.width, rect)).unwrap().map(|chunk| (unit, chunk)));
        }
        chunks.extend(encoder.finish().unwrap().map(|chunk| (unit, chunk)));
    }
    Stream { entry, chunks }
}

fn header_of(range: DepthRange, coding: DepthCoding) -> CodecHeader {
    CodecHeader::Depth(DepthHeader { range, background: f32::INFINITY, kind: DepthKind::Distance, coding })
}

pub fn depth_header(range: [f32; 2], settings: TemporalSettings) -> CodecHeader {
    header_of(DepthRange::new(range[0], range[1]).unwrap(), DepthCoding::Boxes(settings))
}

/// Depth range of all depth streams of this module, except those of [`depth`]: 0.5 m to 8 m.
fn node_range() -> DepthRange {
    DepthRange::new(0.5, 8.0).unwrap()
}

/// Returns the depth domain of quadtree streams.
pub fn node_domain(kind: DomainKind) -> Domain {
    match kind {
        DomainKind::Log => Domain::log(),
        kind => Domain::new(kind, node_range()).unwrap(),
    }
}

/// Returns the header of a quadtree stream.
pub fn node_header(settings: NodeSettings, domain: &Domain) -> NodeHeader {
    let NodeSettings { window, epsilon, keyframe_interval, bound, .. } = settings;
    NodeHeader { window, epsilon, keyframe_interval, bound, domain: domain.parts }
}

pub fn nodes_codec(header: NodeHeader) -> CodecHeader {
    header_of(node_range(), DepthCoding::Nodes(header))
}

pub fn tree_codec(header: NodeHeader) -> CodecHeader {
    header_of(node_range(), DepthCoding::Tree(header))
}

pub fn blocks_codec() -> CodecHeader {
    header_of(node_range(), DepthCoding::Blocks)
}

/// Returns the size of a unit in pixels.
pub fn grid(entry: &StreamEntry, unit: u32) -> Grid {
    let [_, _, width, height] = entry.unit_rect(unit);
    Grid { width, height }
}

/// Encodes each unit of a stream with a separate encoder, which takes an image, or `None` at the end.
fn by_unit<E: FnMut(Option<&[u16]>) -> Option<EncodedChunk>>(
    entry: StreamEntry,
    images: &[Vec<u16>],
    encoder: impl Fn(Grid) -> E,
) -> Stream {
    assert_eq!(images.len(), entry.frame_count as usize);
    let mut chunks = Vec::new();
    for unit in 0..entry.unit_count() {
        let mut push = encoder(grid(&entry, unit));
        for image in images {
            chunks.extend(push(Some(&cut(image, entry.width, entry.unit_rect(unit)))).map(|chunk| (unit, chunk)));
        }
        chunks.extend(push(None).map(|chunk| (unit, chunk)));
    }
    Stream { entry, chunks }
}

/// Encodes depth as packed quadtree nodes.
pub fn nodes(shape: Shape, kind: DomainKind, images: &[Vec<u16>], settings: NodeSettings) -> Stream {
    let domain = node_domain(kind);
    by_unit(entry(shape, &nodes_codec(node_header(settings, &domain))), images, |grid| {
        let mut encoder = NodeEncoder::new(grid, domain.clone(), settings);
        move |image| match image {
            Some(image) => encoder.push(image, None).unwrap(),
            None => encoder.finish().unwrap(),
        }
    })
}

/// Encodes depth in the intermediate quadtree form.
pub fn tree(shape: Shape, kind: DomainKind, images: &[Vec<u16>], settings: NodeSettings) -> Stream {
    let settings = NodeSettings { window: 1, ..settings };
    let domain = node_domain(kind);
    by_unit(entry(shape, &tree_codec(node_header(settings, &domain))), images, |grid| {
        let mut encoder = TreeEncoder::new(grid, domain.clone(), settings);
        move |image| match image {
            Some(image) => encoder.push(image).unwrap(),
            None => encoder.finish().unwrap(),
        }
    })
}

/// Returns the codec header of predictive depth.
pub fn predictive_codec(header: PredictiveHeader) -> CodecHeader {
    header_of(node_range(), DepthCoding::Predictive(header))
}

/// Encodes predictive depth.
pub fn predictive(shape: Shape, images: &[Vec<u16>], header: PredictiveHeader) -> Stream {
    predicted(entry(shape, &predictive_codec(header.clone())), images, &header)
}

/// Encodes alpha.
pub fn alpha(shape: Shape, images: &[Vec<u16>], header: AlphaHeader) -> Stream {
    predicted(entry(shape, &CodecHeader::Alpha(header)), images, &header.predictive())
}

fn predicted(entry: StreamEntry, images: &[Vec<u16>], header: &PredictiveHeader) -> Stream {
    let mut chunks = Vec::new();
    for unit in 0..entry.unit_count() {
        let area = UnitArea { rect: entry.unit_rect(unit), image: [entry.width, entry.height] };
        let mut encoder = PredictiveEncoder::new(header, area, Decide::Mse, Effort::Normal).unwrap();
        let mut push = |codes: &[u16]| encoder.push(&header.levels.numbers(codes).unwrap());
        let closed: Vec<_> = images.iter().map(|image| push(&cut(image, entry.width, area.rect))).collect();
        chunks.extend(closed.into_iter().chain([encoder.finish()]).flatten().map(|chunk| (unit, chunk)));
    }
    Stream { entry, chunks }
}

/// Encodes depth as plain blocks.
pub fn blocks(shape: Shape, images: &[Vec<u16>], keyframe_interval: u32) -> Stream {
    by_unit(entry(shape, &blocks_codec()), images, |grid| {
        let mut encoder = BlockEncoder::new(grid, Effort::Fast, keyframe_interval);
        move |image| match image {
            Some(image) => encoder.push(image),
            None => encoder.finish(),
        }
    })
}

pub fn depth(shape: Shape, range: [f32; 2], images: &[Vec<u16>], settings: TemporalSettings) -> Stream {
    temporal(entry(shape, &depth_header(range, settings)), images, |[width, _]| TemporalEncoder::new(width, settings))
}

/// Returns the codec header of depth in boxes with BC5 blocks.
pub fn bc5_codec(settings: TemporalSettings) -> CodecHeader {
    header_of(node_range(), DepthCoding::BoxesInBlocks(settings))
}

/// Encodes depth in boxes, with pieces in BC5.
pub fn depth_in_blocks(shape: Shape, images: &[Vec<u16>], settings: TemporalSettings) -> Stream {
    let encoder = |size| TemporalEncoder::in_blocks(size, settings, Effort::Fast);
    temporal(entry(shape, &bc5_codec(settings)), images, encoder)
}

pub fn material(shape: Shape, images: &[Vec<[u8; 3]>], settings: TemporalSettings) -> Stream {
    let header = CodecHeader::Material(MaterialHeader { temporal: settings, in_blocks: false });
    temporal(entry(shape, &header), images, |[width, _]| TemporalEncoder::new(width, settings))
}

/// Returns the codec header of material in boxes with BC1 blocks.
pub fn bc1_codec(settings: TemporalSettings) -> CodecHeader {
    CodecHeader::Material(MaterialHeader { temporal: settings, in_blocks: true })
}

/// Encodes material in boxes, with pieces in BC1.
pub fn material_in_blocks(shape: Shape, images: &[Vec<[u8; 3]>], settings: TemporalSettings) -> Stream {
    let encoder = |size| TemporalEncoder::in_blocks(size, settings, Effort::Fast);
    temporal(entry(shape, &bc1_codec(settings)), images, encoder)
}

pub fn color8_header(search: &SearchSettings) -> CodecHeader {
    CodecHeader::Color(ColorHeader {
        format: ColorFormat::EightBit(ToneMap::default()),
        coding: ColorCoding::Cells(None),
        min_psnr_db: search.target.min_psnr_db(),
        min_quality: 0.0,
    })
}

pub fn half_header(search: &SearchSettings) -> CodecHeader {
    CodecHeader::Color(ColorHeader {
        format: ColorFormat::Half { white_cd_m2: 100.0 },
        coding: ColorCoding::Cells(None),
        min_psnr_db: search.target.min_psnr_db(),
        min_quality: 0.0,
    })
}

/// Encodes each cell of a stream with a separate encoder, created for the cell's size.
fn cells<S: Sample, Q: Quality<S>>(
    entry: StreamEntry,
    images: &[Vec<[S; 3]>],
    quality: &Q,
    encoder: impl Fn([u32; 2]) -> CellEncoder<S>,
) -> Stream {
    let mut chunks = Vec::new();
    for unit in 0..entry.unit_count() {
        let rect = entry.unit_rect(unit);
        let mut encoder = encoder([rect[2], rect[3]]);
        for image in images {
            let cell = cut(image, entry.width, rect);
            chunks.extend(encoder.push(cell.as_flattened(), quality).unwrap().map(|chunk| (unit, chunk)));
        }
        chunks.extend(encoder.finish(quality).unwrap().into_iter().map(|chunk| (unit, chunk)));
    }
    Stream { entry, chunks }
}

fn half_keys(images: &[Vec<[f16; 3]>]) -> Vec<Vec<[HalfKey; 3]>> {
    let key = |value: f16| HalfKey::from_bits(value.to_bits());
    images.iter().map(|image| image.iter().map(|pixel| pixel.map(key)).collect()).collect()
}

/// Returns an encoder for cells of a format. With texture blocks, frames have at least `db` dB after block compression.
fn cell_encoder<S: Sample>(
    search: SearchSettings,
    CellFormat { size, blocks }: CellFormat<S>,
    db: f64,
) -> CellEncoder<S> {
    let encoder = CellEncoder::new(search, codec::color::temporal::CLOSE_AT_BYTES);
    match blocks {
        Some(blocks) => encoder.with_blocks(BlockStage { blocks, size, final_psnr_db: db }),
        None => encoder,
    }
}

pub fn color8(shape: Shape, images: &[Vec<[u8; 3]>], search: SearchSettings) -> Stream {
    let entry = entry(shape, &color8_header(&search));
    let format = |[width, height]: [u32; 2]| CellFormat::of_samples(width as usize, height as usize);
    cells(entry, images, &EightBit, |size| cell_encoder(search, format(size), 0.0))
}

/// Encodes 8-bit colour; a chunk is closed at the first keyframe after `close_at_bytes` bytes.
pub fn color8_in_chunks(
    shape: Shape,
    images: &[Vec<[u8; 3]>],
    search: SearchSettings,
    close_at_bytes: usize,
) -> Stream {
    let entry = entry(shape, &color8_header(&search));
    cells(entry, images, &EightBit, |_| CellEncoder::new(search, close_at_bytes))
}

pub fn color_half(shape: Shape, images: &[Vec<[f16; 3]>], search: SearchSettings) -> Stream {
    let entry = entry(shape, &half_header(&search));
    let format = |[width, height]: [u32; 2]| CellFormat::of_samples(width as usize, height as usize);
    let quality = Pu21::new(100.0).unwrap();
    cells(entry, &half_keys(images), &quality, |size| cell_encoder(search, format(size), 0.0))
}

/// Returns the header of colour in the transform codec with the built-in tables.
pub fn transform_header(format: ColorFormat, search: &SearchSettings) -> ColorHeader {
    ColorHeader {
        format,
        coding: ColorCoding::Transform(Tables::default()),
        min_psnr_db: search.target.min_psnr_db(),
        min_quality: search.target.min_quality(),
    }
}

/// Encodes 8-bit colour with the transform codec, in chunks of `chunk_frames` frames.
pub fn color8_transform(shape: Shape, images: &[Vec<[u8; 3]>], search: SearchSettings, chunk_frames: u32) -> Stream {
    let header = transform_header(ColorFormat::EightBit(ToneMap::default()), &search);
    transform(entry(shape, &CodecHeader::Color(header)), images, &EightBit, (search, chunk_frames))
}

/// Encodes half-float colour with the transform codec, in chunks of `chunk_frames` frames.
pub fn color_half_transform(
    shape: Shape,
    images: &[Vec<[f16; 3]>],
    search: SearchSettings,
    chunk_frames: u32,
) -> Stream {
    let header = transform_header(ColorFormat::Half { white_cd_m2: 100.0 }, &search);
    let quality = Pu21::new(100.0).unwrap();
    transform(entry(shape, &CodecHeader::Color(header)), &half_keys(images), &quality, (search, chunk_frames))
}

fn transform<S: Keyed, Q: Quality<S>>(
    entry: StreamEntry,
    images: &[Vec<[S; 3]>],
    quality: &Q,
    (search, chunk_frames): (SearchSettings, u32),
) -> Stream {
    let tables = Arc::new(PricedTables::new(Tables::default()));
    let mut chunks = Vec::new();
    for unit in 0..entry.unit_count() {
        let rect = entry.unit_rect(unit);
        let format = CellFormat::of_samples(rect[2] as usize, rect[3] as usize);
        let mut encoder = TransformEncoder::new(format, search, chunk_frames, Arc::clone(&tables));
        for image in images {
            let cell = cut(image, entry.width, rect);
            chunks.extend(encoder.push(cell.as_flattened(), quality).unwrap().map(|chunk| (unit, chunk)));
        }
        chunks.extend(encoder.finish(quality).unwrap().map(|chunk| (unit, chunk)));
    }
    Stream { entry, chunks }
}

/// Returns the header of colour with keyframes in texture blocks and at least `db` dB.
pub fn color_blocks_header(blocks: ColorBlocks, db: f64) -> ColorHeader {
    let format = match blocks {
        ColorBlocks::Bc6h => ColorFormat::Half { white_cd_m2: 100.0 },
        _ => ColorFormat::EightBit(ToneMap::default()),
    };
    ColorHeader { format, coding: ColorCoding::Cells(Some(blocks)), min_psnr_db: db, min_quality: 0.0 }
}

/// Encodes 8-bit colour with keyframes in texture blocks.
pub fn color8_in_blocks(
    shape: Shape,
    blocks: ColorBlocks,
    images: &[Vec<[u8; 3]>],
    search: SearchSettings,
    db: f64,
) -> Stream {
    let header = color_blocks_header(blocks, db);
    let entry = entry(shape, &CodecHeader::Color(header.clone()));
    cells(entry, images, &EightBit, |size| cell_encoder(search, header.cell_of_bytes(size), db))
}

/// Encodes half-float colour with keyframes in BC6H.
pub fn color_half_in_blocks(shape: Shape, images: &[Vec<[f16; 3]>], search: SearchSettings, db: f64) -> Stream {
    let header = color_blocks_header(ColorBlocks::Bc6h, db);
    let entry = entry(shape, &CodecHeader::Color(header.clone()));
    let quality = Pu21::new(100.0).unwrap();
    cells(entry, &half_keys(images), &quality, |size| cell_encoder(search, header.cell_of_halves(size), db))
}

/// Returns a stream of one unit with cell payloads built by hand.
pub fn cells_by_hand(shape: Shape, header: &CodecHeader, cells: Vec<CellBuilder>) -> Stream {
    let mut first_frame = 0;
    let chunks = cells.into_iter().map(|cell| {
        let frame_count = cell.frame_count();
        let chunk = EncodedChunk { first_frame, frame_count, payload: cell.finish().unwrap() };
        first_frame += frame_count;
        (0, chunk)
    });
    Stream { entry: entry(shape, header), chunks: chunks.collect() }
}

pub fn probe(name: &str, last_frame: u32) -> ProbeEntry {
    ProbeEntry {
        name: name.into(),
        position: [0.5, 1.5, -2.25],
        orientation: [0.0, 0.0, 0.0, 1.0],
        frames: [0, last_frame],
        intrinsics: [0.0; 4],
    }
}

/// Returns a container with some streams of one probe.
pub fn container(projection: u8, probe: ProbeEntry, streams: &[Stream], compression: Compression) -> Vec<u8> {
    let mut writer = Writer::new(Vec::new(), "sample", 24.0, projection).unwrap();
    writer.add_probe(probe).unwrap();
    for stream in streams {
        let index = writer.add_stream(stream.entry.clone());
        for (unit, chunk) in &stream.chunks {
            let first_frame = stream.entry.first_frame + chunk.first_frame;
            let key = ChunkKey { stream: index, unit: *unit, first_frame, frame_count: chunk.frame_count };
            writer
                .push(&PackedChunk::new(key, chunk.payload.clone(), (compression, PayloadKind::Mixed)).unwrap())
                .unwrap();
        }
    }
    writer.finish().unwrap().0
}

/// Returns a container of one static stream of 2x2 depths; `change` may change its index.
pub fn static_depth(change: impl FnOnce(&mut Index)) -> Vec<u8> {
    let shape = Shape { face: 0, size: [2, 2], unit: [2, 2], first_frame: 0, frame_count: 1 };
    let settings = TemporalSettings { window: 1, ..TemporalSettings::default() };
    let file = container(0, probe("00", 0), &[depth(shape, [1.0, 2.0], &[vec![7; 4]], settings)], Compression::None);
    let (mut index, stored) = take_apart(&file);
    change(&mut index);
    assemble(&index, &stored, |_| ())
}

/// Returns the container of [`static_depth`] with `frames` frames that all show its image.
pub fn static_for(frames: u32) -> Vec<u8> {
    static_depth(|index| {
        index.streams[0].frame_count = frames;
        index.chunks[0].key.frame_count = frames;
    })
}

/// Returns a container with `units` units that share one payload: 16 MiB of zeros, compressed to some kilobytes.
pub fn shared_chunk(units: u32) -> Vec<u8> {
    let stored = compression::lzma2(&vec![0; 16 << 20], 6, PayloadKind::Mixed).unwrap();
    let (mut index, _) = take_apart(&static_depth(|_| ()));
    (index.streams[0].width, index.streams[0].unit_width) = (units, 1);
    let chunk = ChunkEntry {
        offset: 16,
        stored_bytes: stored.len() as u32,
        raw_bytes: 16 << 20,
        crc32: crc32fast::hash(&stored),
        storage: Storage::Lzma2,
        ..index.chunks[0]
    };
    let key = |unit| ChunkKey { unit, ..chunk.key };
    index.chunks = (0..units).map(|unit| ChunkEntry { key: key(unit), ..chunk }).collect();
    assemble(&index, &stored, |_| ())
}

/// Returns the bytes of an image as arithmetic.md 1 defines them.
pub fn image_bytes(picture: &Picture) -> Vec<u8> {
    match picture {
        Picture::Depth(plane) => plane.data().iter().flat_map(|code| code.to_le_bytes()).collect(),
        Picture::Color8(plane) | Picture::Material(plane) => plane.data().as_flattened().to_vec(),
        Picture::Alpha(plane) => plane.data().to_vec(),
        Picture::ColorHalf(plane) => {
            plane.data().as_flattened().iter().flat_map(|value| value.to_bits().to_le_bytes()).collect()
        }
    }
}

/// Images of all streams as bytes, by stream and frame.
pub type Images = Vec<Vec<Vec<u8>>>;

/// Decodes all images of all streams, in order.
pub fn decode_all(file: Vec<u8>) -> Result<Images> {
    let decoder = Decoder::new(Reader::from_memory(file)?)?;
    let streams = decoder.streams().iter().map(|stream| {
        let mut face = decoder.face(stream);
        stream.frames.iter().map(|frame| face.decode(frame).map(|picture| image_bytes(&picture))).collect()
    });
    streams.collect()
}

/// Returns depth codes in which a few pixels jump, drift by one or two codes, become background and return.
pub fn moving_codes(size: [u32; 2], frame_count: u32, seed: u64) -> Vec<Vec<u16>> {
    let mut random = Random(seed);
    let pixels = size[0] * size[1];
    let mut image: Vec<u16> = (0..pixels).map(|at| (at % size[0] * 900 + at / size[0] * 77) as u16).collect();
    (0..frame_count)
        .map(|_| {
            for _ in 0..random.below(4) {
                let at = random.below(pixels) as usize;
                image[at] = match random.below(4) {
                    0 => u16::MAX,
                    1 => image[at].wrapping_add(1),
                    2 => image[at].saturating_sub(2),
                    _ => random.below(65_536) as u16,
                };
            }
            image.clone()
        })
        .collect()
}

/// Returns depth codes of a slope, a bowl, a moving edge, patches of noise, and background.
pub fn scene_codes([width, height]: [u32; 2], frame_count: u32) -> Vec<Vec<u16>> {
    let code = |x: u32, y: u32, t: u32| -> u16 {
        let (slope, bowl) = (9000 + 310 * x + 170 * y, 20_000 + 9 * x * x + 7 * y * y + 3 * x * y);
        match (x, y) {
            _ if x > 3 * width / 4 && y < height / 3 => u16::MAX,
            _ if 2 * x + y < 12 + 3 * (t / 2) => 3000,
            _ if (8..16).contains(&x) && (16..24).contains(&y) => (10_000 + (x * 7919 + y * y * 389) % 900) as u16,
            _ if (28..34).contains(&x) && (20..25).contains(&y) => ((x * 7919 + y * 5003 + t / 4 * 77) % 60_000) as u16,
            _ if y < height / 2 => slope as u16,
            _ => (bowl + t) as u16,
        }
    };
    let image = |t| (0..width * height).map(|at| code(at % width, at / width, t)).collect();
    (0..frame_count).map(image).collect()
}

/// Returns materials that are constant over patches, with a few pixels that change.
pub fn patched_materials(size: [u32; 2], frame_count: u32) -> Vec<Vec<[u8; 3]>> {
    let pixel = |at: u32, t: u32| {
        let (x, y) = (at % size[0], at / size[0]);
        match (x / 8 + y / 8) % 3 {
            0 => [0, 0, 0],
            1 => [80 + (x % 8) as u8, 40, 128],
            _ if (x * 7 + y * 3 + t / 2).is_multiple_of(23) => [255, (t * 40) as u8, 3],
            _ => [200, 10, (y * 2) as u8],
        }
    };
    (0..frame_count).map(|t| (0..size[0] * size[1]).map(|at| pixel(at, t)).collect()).collect()
}

/// Returns bytes that drift at different speeds, are constant for a while, and have one scene cut.
pub fn drifting_bytes(size: [u32; 2], frame_count: u32) -> Vec<Vec<[u8; 3]>> {
    (0..frame_count)
        .map(|t| {
            let t = if (10..15).contains(&t) { 10 } else { t };
            let cut = if t > frame_count / 2 { 70 } else { 0 };
            let pixel = |at: u32| [at * 5 + t * 2, at + t + cut, 200 - at % 100].map(|v| (v % 256) as u8);
            (0..size[0] * size[1]).map(pixel).collect()
        })
        .collect()
}
