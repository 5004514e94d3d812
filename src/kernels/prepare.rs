//! Converts chunks to the form that the device reads: the bytes of the stream, and tables of offsets into them.
//!
//! Takes a payload; returns rows whose offsets are relative to the chunk's first byte, word or row. `gpu::resident`
//! adds the chunk's position.

use crate::layout::{
    BOX_BLOCKS, BOX_CONSTANT, BOX_VALUES, BoxRow, KEYFRAME_BLOCKS, KEYFRAME_SAMPLES, PASS_ITERATIONS, Record,
    STEP_ITERATIONS,
};
use crate::pictures::{code_stride, pack_halves};
use crate::transform_tables::SET_WORDS;
use codec::block;
use codec::color::cells::Blend;
use codec::color::transform::blocks::{Shape, regions};
use codec::color::transform::payload::{Header, Layout};
use codec::color::transform::region::{ChannelLevels, Content, Leaf, Region};
use codec::color::transform::steps::Steps;
use codec::color::transform::{Keyed, Tables, TransformChunk};
use codec::color::{CellChunk, ChunkFormat, ColorChunk, Sample};
use codec::container::{ChunkEntry, ChunkPlace, Payload};
use codec::decode::StreamInfo;
use codec::depth::predictive::{PredictiveChunk, UnitArea};
use codec::depth::records::Body;
use codec::depth::runtime::Runtime;
use codec::depth::{TemporalChunk, Texel};
use codec::entropy::rans;
use codec::error::{Error, Result};
use codec::streams::{CodecHeader, ColorFormat, DepthChunk, DepthCoding, DepthHeader, PictureChunk};

/// Maximum bytes of the codes of a predictive chunk, whose payload may be far smaller.
const MAX_UNPACKED: u64 = 128 << 20;

/// Returns an upper bound of the bytes that a chunk takes while it is prepared, without the overhead that every chunk has.
pub fn prepared_bytes(stream: &StreamInfo, entry: &ChunkEntry) -> u64 {
    match &stream.header {
        CodecHeader::Depth(DepthHeader { coding: DepthCoding::Predictive(_), .. }) | CodecHeader::Alpha(_) => {
            let [_, _, width, height] = stream.entry.unit_rect(entry.key.unit);
            (2 * u64::from(width) * u64::from(height)).saturating_mul(entry.key.frame_count.into()).min(MAX_UNPACKED)
        }
        _ => entry.raw_bytes.into(),
    }
}

/// Data of a resident chunk that the host keeps.
#[derive(Debug, Clone, Default)]
pub struct Timeline {
    /// Frames that have a record, with the number of pixels it writes. Empty for colour.
    pub records: Vec<(u32, u64)>,
    /// Colour only: the frames of keyframes; for the transform codec, the frames that have a record.
    pub keyframes: Vec<u32>,
    /// Weights of the first frames; later frames have weight 0.
    pub weights: Vec<u8>,
    /// Transform codec only: for each set of frames, the number of pixels that are equal in all its frames.
    pub pixels_of_frames: Vec<(u128, u64)>,
}

impl Timeline {
    /// Returns the blend that shows a frame of a colour chunk, and whether it needs the cell's next chunk.
    pub fn blend(&self, frame: u32) -> (Blend, bool) {
        let keyframe = self.keyframes.partition_point(|&first| first <= frame).saturating_sub(1);
        let weight = self.weights.get(frame as usize).copied().unwrap_or(0);
        (Blend { keyframe, weight }, weight > 0 && keyframe + 1 == self.keyframes.len())
    }

    /// Returns how many of a colour cell's `pixels` differ between a frame and the shown frame; all if no frame of this chunk
    /// is shown.
    pub fn changed_pixels(&self, frame: u32, shown: Option<u32>, pixels: u64) -> u64 {
        let Some(shown) = shown else { return pixels };
        if self.pixels_of_frames.is_empty() {
            return if self.blend(shown).0 == self.blend(frame).0 { 0 } else { pixels };
        }
        let changed = self.pixels_of_frames.iter().filter(|(frames, _)| frames >> frame & 1 > frames >> shown & 1);
        changed.map(|(_, pixels)| pixels).sum()
    }
}

/// Selects the kernel of a family that decodes a chunk.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum KernelOf {
    #[default]
    Codec,
    /// The kernel for keyframe chunks, for codecs that have both chunk types.
    Keyframes,
}

#[derive(Debug, Clone)]
pub struct Prepared {
    pub kernel: KernelOf,
    /// Bytes of the stream, as words.
    pub stream: Vec<u32>,
    pub records: Vec<Record>,
    pub boxes: Vec<BoxRow>,
    /// Byte offset of the weights, and their number.
    pub weights: [u32; 2],
    /// Upper bound of the passes of the kernel's reader; 0 without a reader.
    pub passes: u32,
    pub timeline: Timeline,
}

impl Prepared {
    /// True if its records are nodes, which are addressed by words; all others are addressed by bytes.
    pub fn is_nodes(&self) -> bool {
        self.boxes.is_empty() && self.timeline.keyframes.is_empty()
    }
}

/// Checks a payload of `frames` frames, at `place` in its unit, and converts it for the device.
pub fn prepare(
    header: &CodecHeader,
    payload: Payload,
    area: UnitArea,
    frames: u32,
    place: ChunkPlace,
) -> Result<Prepared> {
    let size = area.size();
    Ok(match header {
        CodecHeader::Depth(header) => match DepthChunk::parse(header, payload, area, frames)? {
            DepthChunk::Boxes(chunk) => of_boxes(&chunk, size),
            DepthChunk::Nodes(chunk) => of_nodes(&chunk.runtime),
            DepthChunk::Tree(chunk) => of_nodes(&chunk.leaves.runtime),
            DepthChunk::Blocks(chunk) => of_nodes(&chunk.runtime()),
            DepthChunk::Predictive(chunk) => of_predictive(&chunk, MAX_UNPACKED)?,
        },
        CodecHeader::Material(header) => {
            of_boxes(&TemporalChunk::<[u8; 3]>::parse(header.layout(), payload, size, frames)?, size)
        }
        CodecHeader::Alpha(header) => {
            of_predictive(&PredictiveChunk::parse(payload, header.predictive(), area, frames)?, MAX_UNPACKED)?
        }
        CodecHeader::Color(header) => match header.format {
            ColorFormat::EightBit(_) => of_color(&header.chunks_of_bytes(size), payload, frames, place)?,
            ColorFormat::Half { .. } => of_color(&header.chunks_of_halves(size), payload, frames, place)?,
        },
    })
}

fn of_color<S: Keyed>(format: &ChunkFormat<S>, payload: Payload, frames: u32, place: ChunkPlace) -> Result<Prepared> {
    let Some(tables) = &format.tables else {
        return Ok(of_cells(&CellChunk::parse_at(payload, format.cell, frames, place)?));
    };
    let bytes = payload.to_vec();
    Ok(match format.parse(payload, frames, place)? {
        ColorChunk::Cells(chunk) => Prepared { kernel: KernelOf::Keyframes, ..of_cells(&chunk) },
        ColorChunk::Transform(chunk) => of_transform::<S>(&chunk, &bytes, frames, tables)?,
    })
}

/// Packs bytes into little-endian words; pads the last word with zeros.
pub fn words_from(bytes: &[u8]) -> Vec<u32> {
    let word = |chunk: &[u8]| chunk.iter().rev().fold(0, |word, &byte| word << 8 | u32::from(byte));
    bytes.chunks(4).map(word).collect()
}

pub fn of_nodes(runtime: &Runtime) -> Prepared {
    let records = runtime.frames.iter().map(|&frame| {
        let parts = runtime.nodes(frame).map(|(place, _)| 1u32 << (2 * place.level)).sum();
        Record { frame: frame.frame, at: frame.offset as u32 / 4, work: parts, ..Record::default() }
    });
    let pixels = runtime.frames.iter().map(|frame| (frame.frame, frame.updated_pixels));
    Prepared {
        kernel: KernelOf::Codec,
        records: records.collect(),
        stream: words_from(&runtime.buffer),
        boxes: Vec::new(),
        weights: [0; 2],
        passes: 0,
        timeline: Timeline { records: pixels.collect(), ..Timeline::default() },
    }
}

pub fn of_boxes<T: Texel>(chunk: &TemporalChunk<T>, [width, height]: [u32; 2]) -> Prepared {
    let mut boxes = Vec::new();
    let mut records = Vec::new();
    for record in &chunk.records {
        let (first, mut work) = (boxes.len(), 0);
        let mut push = |row: BoxRow| {
            // The kernel writes this many words of each row.
            let columns = if T::BYTES == 2 { code_stride(row.x + row.width) - row.x / 2 } else { row.width };
            work += columns * row.height;
            boxes.push(BoxRow { end: work, ..row });
        };
        let mut parts = |[left, top, width, height]: [u32; 4], at: usize| {
            let size = [width as usize, height as usize];
            for part in chunk.layout.parts::<T>(&chunk.payload[at..], size) {
                let [x, y, width, height] = part.rect.map(|side| side as u32);
                let coding = if part.in_blocks { BOX_BLOCKS } else { BOX_VALUES };
                let at = (at + part.start) as u32;
                push(BoxRow { x: left + x, y: top + y, width, height, coding, at, end: 0 });
            }
        };
        match record.body {
            Body::Whole(at) => parts([0, 0, width, height], at),
            Body::Constant(at) => {
                push(BoxRow { width, height, at: at as u32, coding: BOX_CONSTANT, ..BoxRow::default() });
            }
            Body::Boxes { .. } => {
                for &(b, at) in chunk.boxes(record.body) {
                    parts([b.x, b.y, b.width, b.height].map(u32::from), at);
                }
            }
        }
        let count = (boxes.len() - first) as u32;
        records.push(Record { frame: record.frame, first: first as u32, count, work, ..Record::default() });
    }
    let pixels = chunk.records.iter().map(|record| (record.frame, chunk.updated_pixels(record.body)));
    let timeline = Timeline { records: pixels.collect(), ..Timeline::default() };
    let stream = words_from(&chunk.payload);
    Prepared { kernel: KernelOf::Codec, stream, records, boxes, weights: [0; 2], passes: 0, timeline }
}

/// Decodes a predictive chunk on the host, to boxes of the codes that each frame changes: every symbol depends on the previous
/// ones, and a unit is a single substream. The codes may take at most `max_bytes` bytes.
fn of_predictive(chunk: &PredictiveChunk, max_bytes: u64) -> Result<Prepared> {
    let (mut codes, mut boxes, mut records, mut pixels) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    chunk.for_each_frame(|frame| {
        let (first, mut work) = (boxes.len(), 0);
        for [x, y, width, height] in frame.written() {
            work += (code_stride(x + width) - x / 2) * height;
            let at = 2 * codes.len() as u32;
            boxes.push(BoxRow { x, y, width, height, coding: BOX_VALUES, at, end: work });
            let rows = frame.picture.chunks(frame.size[0] as usize).skip(y as usize).take(height as usize);
            rows.for_each(|row| codes.extend_from_slice(&row[x as usize..][..width as usize]));
        }
        if 2 * codes.len() as u64 > max_bytes {
            let most = max_bytes >> 20;
            return Err(Error::unsupported(format!(
                "the codes of a chunk need more than {most} MiB on a device: use the CPU, or encode with smaller \
                tiles or fewer frames between keyframes"
            )));
        }
        let count = (boxes.len() - first) as u32;
        if count > 0 {
            records.push(Record { frame: frame.frame, first: first as u32, count, work, ..Record::default() });
            pixels.push((frame.frame, frame.updated_pixels));
        }
        Ok(())
    })?;
    let timeline = Timeline { records: pixels, ..Timeline::default() };
    let stream = codes.chunks(2).map(|pair| pair.iter().rev().fold(0, |word, &code| word << 16 | u32::from(code)));
    let stream = stream.collect();
    Ok(Prepared { kernel: KernelOf::Codec, stream, records, boxes, weights: [0; 2], passes: 0, timeline })
}

pub fn of_cells<S: Sample>(chunk: &CellChunk<S>) -> Prepared {
    let format = &chunk.format;
    let [columns, rows] = block::grid(format.size[0], format.size[1]);
    // Kernels for block-compressed keyframes process one block per invocation.
    let work = if format.blocks.is_some() { columns * rows } else { format.pixels() } as u32;
    let records = chunk.keyframes.iter().enumerate().map(|(at, &frame)| {
        let start = chunk.keyframe_at(at) as u32;
        let coding = if chunk.in_blocks(at) { KEYFRAME_BLOCKS } else { KEYFRAME_SAMPLES };
        Record { frame, at: start, coding, work, ..Record::default() }
    });
    let (weights_at, weights) = chunk.weights();
    Prepared {
        kernel: KernelOf::Codec,
        records: records.collect(),
        stream: words_from(&chunk.payload),
        boxes: Vec::new(),
        weights: [weights_at as u32, weights.len() as u32],
        passes: 0,
        timeline: Timeline { keyframes: chunk.keyframes.to_vec(), weights: weights.to_vec(), ..Timeline::default() },
    }
}

/// Converts a chunk of the transform codec, which was parsed from `payload`: its header, then the substream of each region in
/// whole words. Each frame that differs from the previous one has a record, which covers all regions.
pub fn of_transform<S: Keyed>(
    chunk: &TransformChunk,
    payload: &[u8],
    frames: u32,
    tables: &Tables,
) -> Result<Prepared> {
    let size = chunk.size();
    let Layout { header, deltas, substreams } = Layout::parse::<S>(payload, size, tables)?;
    let mut stream = header_words(&header, frames);
    let mut boxes = Vec::new();
    for ((rect, substream), delta) in regions(size).zip(substreams).zip(deltas) {
        let [x, y, width, height] = rect.map(|side| side as u32);
        let end = boxes.len() as u32 + 1;
        boxes.push(BoxRow { x, y, width, height, at: 4 * stream.len() as u32, end, ..BoxRow::default() });
        let steps = Steps::new(header.steps, header.offset_set, delta, S::DOMAIN.steps);
        stream.extend(steps.indices().map(|index| index as u32));
        let bytes = &payload[substream];
        match words_from(bytes).as_slice() {
            words if bytes.len() >= 4 => stream.extend(words),
            short => stream.push(rans::LOW + short.first().unwrap_or(&0)),
        }
    }
    let (count, work) = (boxes.len() as u32, boxes.len() as u32);
    let record = Record { count, work, ..Record::default() };
    let pixels_of_frames = chunk.pixels_of_frames().into_iter().collect();
    let all = Timeline { pixels_of_frames, ..Timeline::default() };
    let differs = |&frame: &u32| all.changed_pixels(frame, frame.checked_sub(1), 1) > 0;
    let keyframes: Vec<u32> = (0..frames).filter(differs).collect();
    let records = keyframes.iter().map(|&frame| Record { frame, ..record }).collect();
    let timeline = Timeline { keyframes, ..all };
    let passes = chunk.regions().iter().map(passes_of).max().unwrap_or(1);
    Ok(Prepared { kernel: KernelOf::Codec, stream, records, boxes, weights: [0; 2], passes, timeline })
}

/// Returns an upper bound of the passes in which a region is read, from the iterations that
/// `shaders/color/transform/region.wgsl` counts. The maximum is about 470: a region has 98,304 pixels in 96 frames, and a pixel
/// takes at most 24 iterations (leaves of 4x4 pixels in one frame, with 16 colours).
fn passes_of(region: &Region) -> u32 {
    let iterations = |leaf: &Leaf| {
        let Shape { frames, .. } = leaf.block().shape;
        let pixels = leaf.block().shape.pixels() as u32;
        // There is at most one split node per leaf.
        2 * STEP_ITERATIONS
            + match &leaf.content {
                Content::Palette(palette) => {
                    let colors = 17 * palette.colors.len() as u32;
                    colors + (frames as u32 + 1) * (STEP_ITERATIONS + 2 * pixels)
                }
                Content::Transform { channels, .. } => {
                    let of_channel = |levels: &ChannelLevels| {
                        // The scan visits positions diagonal by diagonal.
                        let [columns, rows] = levels.extent().map(|side| side as u32);
                        let diagonals = columns + rows - 1;
                        let positions = (diagonals * (diagonals + 1) / 2).min(pixels);
                        let planes = levels.of(region).last().map_or(0, |level| u32::from(level.plane) + 1);
                        STEP_ITERATIONS + 3 * pixels / 16 + planes * (STEP_ITERATIONS + positions)
                    };
                    channels.iter().map(of_channel).sum()
                }
            }
    };
    1 + region.leaves().map(iterations).sum::<u32>() / PASS_ITERATIONS
}

/// Returns the words of a chunk before its regions, in the layout of `shaders/color/transform/chunk.wgsl`.
fn header_words(header: &Header, frames: u32) -> Vec<u32> {
    let Header { set, slopes, offset_set, colors, .. } = header;
    let slopes = [slopes.green, slopes.orange].map(|slope| i32::from(slope) as u32);
    let mut words = vec![(set * SET_WORDS) as u32, slopes[0], slopes[1], colors.len() as u32, frames];
    words.push(*offset_set as u32);
    words.extend(colors.iter().flat_map(|color| pack_halves(color.map(|key| key as u16))));
    words
}

#[cfg(test)]
mod tests {
    use super::*;
    use codec::color::cells::CellFormat;
    use codec::color::cells::builder::CellBuilder;
    use codec::depth::block_tiles::Layout;
    use codec::depth::boxes::PixelBox;
    use codec::depth::mode_decision::Decide;
    use codec::depth::predictive::encoder::PredictiveEncoder;
    use codec::depth::predictive::projection::Projection;
    use codec::depth::predictive::{Levels, PredictiveHeader, Tables};
    use codec::depth::record_table::TableBuilder;
    use codec::effort::Effort;

    #[test]
    fn boxes_count_the_words_that_they_touch() {
        let mut builder = TableBuilder::default();
        builder.put_values(&[1u16, 2, 3, 4, 5, 6, 7, 8, 9, 10]);
        let boxes = [PixelBox { x: 1, y: 0, width: 2, height: 2 }, PixelBox { x: 4, y: 1, width: 1, height: 1 }];
        builder.put_boxes_of(3, &boxes, &[0u16; 10], 5);
        let chunk = TemporalChunk::<u16>::parse(Layout::Values, builder.finish().unwrap(), [5, 2], 4).unwrap();
        let prepared = of_boxes(&chunk, [5, 2]);
        assert_eq!(
            prepared.records.iter().map(|row| (row.frame, row.first, row.count, row.work)).collect::<Vec<_>>(),
            [(0, 0, 1, 6), (3, 1, 2, 5)]
        );
        assert_eq!(prepared.boxes.iter().map(|row| row.end).collect::<Vec<_>>(), [6, 4, 5]);
        assert_eq!(prepared.timeline.records, [(0, 10), (3, 5)]);
        assert!(!prepared.is_nodes());
    }

    #[test]
    fn blends_are_those_of_the_chunk() {
        let mut builder = CellBuilder::default();
        builder.push_keyframe::<u8>(&[1, 2, 3]);
        builder.push_weight(9, 2);
        builder.push_keyframe::<u8>(&[4, 5, 6]);
        builder.push_weight(200, 1);
        let chunk = CellChunk::parse(builder.finish().unwrap(), CellFormat::<u8>::of_samples(1, 1), 7).unwrap();
        let prepared = of_cells(&chunk);
        for frame in 0..7 {
            let blend = chunk.blend(frame);
            let closed = blend.weight > 0 && chunk.is_last(blend.keyframe);
            assert_eq!(prepared.timeline.blend(frame), (blend, closed), "frame {frame}");
        }
        assert_eq!(prepared.weights[1], 5);
    }

    #[test]
    fn a_predictive_chunk_whose_codes_take_too_much_is_refused() {
        let header = PredictiveHeader {
            bound: 0,
            epsilon: 0,
            keyframe_interval: 64,
            projection: Projection::default(),
            tables: Tables::default(),
            levels: Levels::default(),
        };
        // 1 MiB of codes per frame; every frame changes all pixels.
        let area = UnitArea::whole([1024, 512]);
        let mut encoder = PredictiveEncoder::new(&header, area, Decide::Size, Effort::Fast).unwrap();
        for frame in 0..3 {
            assert!(encoder.push(&vec![1000 * frame; 1024 * 512]).is_none());
        }
        let chunk = encoder.finish().unwrap();
        let chunk = PredictiveChunk::parse(chunk.payload, header, area, 3).unwrap();
        let prepared = of_predictive(&chunk, 3 << 20).unwrap();
        assert_eq!(prepared.stream.len(), 3 << 18);
        let said = of_predictive(&chunk, 2 << 20).unwrap_err().to_string();
        assert!(
            said.contains("codes of a chunk need more than 2 MiB on a device: use the CPU, or encode with"),
            "{said}"
        );
    }

    #[test]
    fn bytes_become_words() {
        assert_eq!(words_from(&[1, 2, 3, 4, 5]), [0x0403_0201, 5]);
    }
}
