//! JSON report of an inspected container.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::depth_bound::DepthBound;
use crate::export::DamagedChunkReport;
use crate::inspect::chunk_counts::{PredictedShare, TransformCount};
use crate::inspect::statistics::{FrameRow, Inspection, Spread, StorageStats, StreamStats, Totals};
use crate::json::Number;
use codec::color::transform::Tables;
use codec::color::transform::blocks::MIN_SIDE;
use codec::container::header::VERSION_MAJOR;
use codec::decode::{Decoder, StreamInfo};
use codec::depth::TemporalSettings;
use codec::depth::block::side_of;
use codec::depth::mode_statistics::{ModeStatistics, Share};
use codec::depth::nodes::Function;
use codec::depth::predictive::PredictiveHeader;
use codec::depth::predictive::modes::BlockCoding;
use codec::image::{DepthKind, StreamKind, Transfer};
use codec::streams::{
    CodecHeader, ColorFormat, ColorHeader, DepthCoding, DepthHeader, MaterialHeader, MissingFrame, StartView,
};

#[derive(Debug, Serialize)]
pub struct ContainerReport<'a> {
    name: &'a str,
    fps: f64,
    projection: &'static str,
    format_version: u16,
    file_bytes: u64,
    bytes: u64,
    raw_bytes: u64,
    ratio_percent: f64,
    frames: u64,
    probes: usize,
    probe_list: Vec<ProbeReport<'a>>,
    chunks: u64,
    overhead_bytes: u64,
    shared_bytes_saved: u64,
    kinds: BTreeMap<&'static str, KindReport>,
    /// Red, green, blue and white, x and y of each.
    chromaticities: [f32; 8],
    #[serde(skip_serializing_if = "Option::is_none")]
    clipped_pixels: Option<u64>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    missing_frames: Vec<MissingReport<'a>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    view: Option<StartView>,
    streams: Vec<StreamReport<'a>>,
}

/// A frame whose file was missing.
#[derive(Debug, Serialize)]
struct MissingReport<'a> {
    kind: &'static str,
    probe: &'a str,
    face: &'static str,
    frame: u32,
    /// The frame shown in its place; `None` for black.
    held: Option<u32>,
}

#[derive(Debug, Serialize)]
struct ProbeReport<'a> {
    name: &'a str,
    position: [f64; 3],
    frames: [u32; 2],
}

#[derive(Debug, Serialize)]
struct KindReport {
    #[serde(flatten)]
    totals: Totals,
    temporal_ratio_percent: f64,
    ratio_percent: f64,
}

#[derive(Debug, Serialize)]
pub struct ChunksReport<'a> {
    chunks: u64,
    lzma2_chunks: u64,
    zstd_chunks: u64,
    damaged: Vec<DamagedChunkReport<'a>>,
}

#[derive(Debug, Serialize)]
pub struct FrameReport<'a> {
    pub kind: &'static str,
    pub probe: &'a str,
    pub face: &'static str,
    pub frame: u32,
    pub keyframe_units: u64,
    pub aabbs: u64,
    pub updated_pixels: u64,
    pub updated_percent: f64,
    pub bytes: u64,
}

#[derive(Debug, Serialize)]
pub struct StreamReport<'a> {
    kind: &'static str,
    probe: &'a str,
    face: &'static str,
    frames: u64,
    first_frame: u32,
    width: u32,
    height: u32,
    codec: &'static str,
    raw_bytes: u64,
    ratio_percent: f64,
    #[serde(flatten)]
    storage: StorageStats,
    units: u64,
    unit_width: u32,
    unit_height: u32,
    keyframes: u64,
    updated_pixels: u64,
    updated_percent: f64,
    #[serde(flatten)]
    coding: CodingReport,
    #[serde(flatten)]
    depth: Option<DepthReport>,
}

#[derive(Debug, Serialize)]
#[serde(untagged)]
enum CodingReport {
    Boxes(BoxesReport),
    Nodes(NodesReport),
    Predictive(PredictiveReport),
    Color(ColorReport),
}

#[derive(Debug, Serialize)]
struct BoxesReport {
    static_tiles: u64,
    constant_units: u64,
    aabbs: u64,
    error_bound_codes: u16,
    window: u8,
    max_aabbs: u16,
    keyframe_interval: u32,
    #[serde(skip_serializing_if = "Option::is_none")]
    pieces: Option<PiecesReport>,
}

#[derive(Debug, Serialize)]
struct PiecesReport {
    blocks: u64,
    raw: u64,
}

#[derive(Debug, Serialize)]
struct DepthReport {
    near_m: Number,
    far_m: Number,
    background: Number,
    depth_kind: DepthKind,
    /// Maximum error in percent of the distance; `None` without a bound.
    max_error_percent: Option<f64>,
    /// Maximum error in metres at some distances; `None` outside near and far.
    max_error_m: BTreeMap<String, Option<f64>>,
}

/// Report of modelling functions. Keys of the maps are their names.
#[derive(Debug, Serialize)]
struct NodesReport {
    static_tiles: u64,
    constant_units: u64,
    error_bound_codes: Option<u16>,
    window: u8,
    #[serde(flatten)]
    settings: Option<NodeSettingsReport>,
    nodes: BTreeMap<&'static str, u64>,
    node_pixels: BTreeMap<&'static str, u64>,
    node_bytes: BTreeMap<&'static str, u64>,
    node_levels: Vec<LevelReport>,
}

/// Report of predictive blocks. Keys of the maps are the names of [`BlockCoding`].
#[derive(Debug, Serialize)]
struct PredictiveReport {
    static_tiles: u64,
    constant_units: u64,
    error_bound_codes: u16,
    window: u8,
    epsilon: u16,
    max_error_codes: u16,
    keyframe_interval: u32,
    own_table_sets: usize,
    /// Number of codes that may occur; 0 if any code may occur.
    levels: usize,
    predicted_blocks: BTreeMap<&'static str, u64>,
    predicted_pixels: BTreeMap<&'static str, u64>,
    /// Bytes of the symbols, rounded down.
    predicted_bytes: BTreeMap<&'static str, u64>,
}

#[derive(Debug, Serialize)]
struct NodeSettingsReport {
    epsilon: u16,
    max_error_codes: u16,
    domain: &'static str,
    keyframe_interval: u32,
}

#[derive(Debug, Serialize)]
struct LevelReport {
    level: u8,
    side: usize,
    nodes: BTreeMap<&'static str, u64>,
}

#[derive(Debug, Serialize)]
struct ColorReport {
    keyframes_per_cell: Spread,
    static_cells: u64,
    min_psnr_db: Number,
    min_quality: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    keyframes_blocks: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    keyframes_raw: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    transfer: Option<Transfer>,
    #[serde(skip_serializing_if = "Option::is_none")]
    exposure_ev: Option<Number>,
    #[serde(skip_serializing_if = "Option::is_none")]
    white_cd_m2: Option<Number>,
    #[serde(flatten)]
    transform: Option<TransformReport>,
}

/// Counts of chunks and blocks of the transform codec.
#[derive(Debug, Serialize)]
struct TransformReport {
    transform_chunks: u64,
    cells_chunks: u64,
    /// Number of transform blocks by side in pixels.
    transform_blocks: BTreeMap<usize, u64>,
    palette_blocks: u64,
    own_table_sets: usize,
}

impl<'a> Inspection<'a> {
    /// Returns the report that `lightfold inspect --json` prints.
    pub fn report(&self, decoder: &'a Decoder) -> ContainerReport<'a> {
        let (reader, index, all) = (decoder.reader(), decoder.reader().index(), self.totals(None));
        let probes = self.probes();
        let bytes = self.bytes(decoder);
        let probe = |&at: &usize| &index.probes[at];
        ContainerReport {
            name: &index.name,
            fps: index.fps,
            projection: projection_name(index.projection),
            format_version: VERSION_MAJOR,
            file_bytes: reader.file_bytes,
            bytes,
            raw_bytes: all.raw_bytes,
            ratio_percent: percent(bytes, all.raw_bytes),
            frames: all.frames,
            probes: probes.len(),
            probe_list: probes
                .iter()
                .map(probe)
                .map(|probe| ProbeReport { name: &probe.name, position: probe.position, frames: probe.frames })
                .collect(),
            chunks: all.chunks,
            overhead_bytes: reader.overhead_bytes(),
            shared_bytes_saved: all.shared_bytes_saved,
            kinds: self.kinds(),
            chromaticities: decoder.primaries().to_array(),
            clipped_pixels: decoder.footage().clipped_pixels,
            missing_frames: missing_frames(decoder),
            view: decoder.footage().view,
            streams: self.stream_reports(decoder),
        }
    }

    fn kinds(&self) -> BTreeMap<&'static str, KindReport> {
        let totals = StreamKind::ALL.into_iter().map(|kind| (kind.name(), self.totals(Some(kind))));
        let report = |(kind, totals): (&'static str, Totals)| {
            let temporal_ratio_percent = percent(totals.temporal_bytes, totals.raw_bytes);
            let ratio_percent = percent(totals.bytes, totals.raw_bytes);
            (kind, KindReport { totals, temporal_ratio_percent, ratio_percent })
        };
        totals.filter(|(_, totals)| *totals != Totals::default()).map(report).collect()
    }

    pub fn stream_reports(&self, decoder: &'a Decoder) -> Vec<StreamReport<'a>> {
        self.streams.iter().map(|stats| StreamReport::new(decoder, stats)).collect()
    }

    pub fn frame_reports(&self, decoder: &'a Decoder) -> Vec<FrameReport<'a>> {
        self.rows.iter().map(|row| FrameReport::new(decoder, row)).collect()
    }

    pub fn chunks_report(&'a self, decoder: &'a Decoder) -> ChunksReport<'a> {
        let all = self.totals(None);
        let damaged = self.damaged.iter().map(|chunk| DamagedChunkReport::new(chunk, decoder)).collect();
        let Totals { chunks, lzma2_chunks, zstd_chunks, .. } = all;
        ChunksReport { chunks, lzma2_chunks, zstd_chunks, damaged }
    }

    /// Returns true if only some of the streams were inspected.
    fn is_partial(&self, decoder: &Decoder) -> bool {
        self.streams.len() < decoder.streams().len()
    }

    /// Returns the bytes of the file; if only some streams were inspected, the bytes of their chunks.
    pub fn bytes(&self, decoder: &Decoder) -> u64 {
        if self.is_partial(decoder) { self.totals(None).bytes } else { decoder.reader().file_bytes }
    }

    pub fn probes(&self) -> Vec<usize> {
        let mut probes: Vec<usize> = self.streams.iter().map(|stats| stats.stream.probe).collect();
        probes.sort_unstable();
        probes.dedup();
        probes
    }
}

impl<'a> FrameReport<'a> {
    fn new(decoder: &'a Decoder, row: &FrameRow<'a>) -> FrameReport<'a> {
        let (stream, cost) = (row.stream, row.cost);
        let pixels = u64::from(stream.entry.width) * u64::from(stream.entry.height);
        FrameReport {
            kind: stream.kind.name(),
            probe: &decoder.probe(stream).name,
            face: stream.face.name(),
            frame: row.frame,
            keyframe_units: cost.keyframe_units,
            aabbs: cost.aabbs,
            updated_pixels: cost.updated_pixels,
            updated_percent: percent(cost.updated_pixels, pixels),
            bytes: cost.bytes,
        }
    }
}

impl<'a> StreamReport<'a> {
    fn new(decoder: &'a Decoder, stats: &StreamStats<'a>) -> StreamReport<'a> {
        let info: &'a StreamInfo = stats.stream;
        let entry = &info.entry;
        StreamReport {
            kind: info.kind.name(),
            probe: &decoder.probe(info).name,
            face: info.face.name(),
            frames: info.frames.count(),
            first_frame: info.frames.first,
            width: entry.width,
            height: entry.height,
            codec: info.header.codec_name(),
            raw_bytes: stats.raw_bytes,
            ratio_percent: percent(stats.storage.bytes, stats.raw_bytes),
            storage: stats.storage,
            units: stats.units,
            unit_width: entry.unit_width,
            unit_height: entry.unit_height,
            keyframes: stats.keyframes,
            updated_pixels: stats.updated_pixels,
            updated_percent: percent(stats.updated_pixels, stats.pixels()),
            coding: match &info.header {
                CodecHeader::Depth(header) => match &header.coding {
                    DepthCoding::Boxes(temporal) => CodingReport::Boxes(BoxesReport::new(stats, temporal, false)),
                    DepthCoding::BoxesInBlocks(temporal) => {
                        CodingReport::Boxes(BoxesReport::new(stats, temporal, true))
                    }
                    DepthCoding::Predictive(header) => CodingReport::Predictive(PredictiveReport::new(stats, header)),
                    _ => CodingReport::Nodes(NodesReport::new(stats, header)),
                },
                CodecHeader::Material(MaterialHeader { temporal, in_blocks }) => {
                    CodingReport::Boxes(BoxesReport::new(stats, temporal, *in_blocks))
                }
                CodecHeader::Alpha(header) => {
                    CodingReport::Predictive(PredictiveReport::new(stats, &header.predictive()))
                }
                CodecHeader::Color(header) => CodingReport::Color(ColorReport::new(stats, header)),
            },
            depth: match &info.header {
                CodecHeader::Depth(header) => Some(DepthReport {
                    near_m: Number::shortest(header.range.near_m()),
                    far_m: Number::shortest(header.range.far_m()),
                    background: Number::shortest(header.background),
                    depth_kind: header.kind,
                    max_error_percent: DepthBound::of(header).percent(),
                    max_error_m: DepthBound::of(header).metres(),
                }),
                _ => None,
            },
        }
    }
}

impl BoxesReport {
    fn new(stats: &StreamStats<'_>, temporal: &TemporalSettings, in_blocks: bool) -> BoxesReport {
        BoxesReport {
            static_tiles: stats.static_units,
            constant_units: stats.constant_units,
            aabbs: stats.aabbs,
            error_bound_codes: temporal.epsilon,
            window: temporal.window,
            max_aabbs: temporal.max_aabbs,
            keyframe_interval: temporal.keyframe_interval,
            pieces: in_blocks
                .then_some(PiecesReport { blocks: stats.blocks.pieces.blocks, raw: stats.blocks.pieces.raw }),
        }
    }
}

impl NodesReport {
    fn new(stats: &StreamStats<'_>, header: &DepthHeader) -> NodesReport {
        let modes = &stats.nodes;
        let of = |value: fn(Share) -> u64| by_function(|function| value(modes.of(function)));
        NodesReport {
            static_tiles: stats.static_units,
            constant_units: stats.constant_units,
            error_bound_codes: header.error_bound(),
            window: header.window(),
            settings: match header.coding {
                DepthCoding::Nodes(nodes) | DepthCoding::Tree(nodes) => Some(NodeSettingsReport {
                    epsilon: nodes.epsilon,
                    max_error_codes: nodes.bound,
                    domain: nodes.domain.kind.name(),
                    keyframe_interval: nodes.keyframe_interval,
                }),
                _ => None,
            },
            nodes: of(|share| share.nodes),
            node_pixels: of(|share| share.pixels),
            node_bytes: of(|share| share.bytes),
            node_levels: modes.levels().map(|level| LevelReport::new(modes, level)).collect(),
        }
    }
}

impl PredictiveReport {
    fn new(stats: &StreamStats<'_>, header: &PredictiveHeader) -> PredictiveReport {
        let of = |value: fn(PredictedShare) -> u64| {
            BlockCoding::ALL.into_iter().map(|coding| (coding.name(), value(stats.predictive.share(coding)))).collect()
        };
        PredictiveReport {
            static_tiles: stats.static_units,
            constant_units: stats.constant_units,
            error_bound_codes: header.bound.saturating_add(header.epsilon),
            // Each frame is coded relative to the previous one.
            window: 1,
            epsilon: header.epsilon,
            max_error_codes: header.bound,
            keyframe_interval: header.keyframe_interval,
            own_table_sets: header.tables.own().len(),
            levels: header.levels.codes().len(),
            predicted_blocks: of(|share| share.blocks),
            predicted_pixels: of(|share| share.pixels),
            predicted_bytes: of(|share| (share.bits / 8.0) as u64),
        }
    }
}

impl LevelReport {
    fn new(modes: &ModeStatistics, level: u8) -> LevelReport {
        let nodes = by_function(|function| modes.share(level, function).nodes);
        LevelReport { level, side: side_of(level), nodes }
    }
}

impl ColorReport {
    fn new(stats: &StreamStats<'_>, header: &ColorHeader) -> ColorReport {
        let keyframes = header.blocks().is_some().then_some(stats.blocks.keyframes);
        let (tone, white_cd_m2) = match header.format {
            ColorFormat::EightBit(tone) => (Some(tone), None),
            ColorFormat::Half { white_cd_m2 } => (None, Some(Number(white_cd_m2))),
        };
        ColorReport {
            keyframes_per_cell: stats.keyframes_per_unit,
            static_cells: stats.static_units,
            min_psnr_db: Number(header.min_psnr_db),
            min_quality: header.min_quality,
            keyframes_blocks: keyframes.map(|count| count.blocks),
            keyframes_raw: keyframes.map(|count| count.raw),
            transfer: tone.map(|tone| tone.transfer),
            exposure_ev: tone.map(|tone| Number::shortest(tone.exposure_ev)),
            white_cd_m2,
            transform: header.tables().map(|tables| TransformReport::new(&stats.transform, tables)),
        }
    }
}

impl TransformReport {
    fn new(count: &TransformCount, tables: &Tables) -> TransformReport {
        TransformReport {
            transform_chunks: count.transform_chunks,
            cells_chunks: count.cells_chunks,
            transform_blocks: (0..).map(|level| MIN_SIDE << level).zip(count.blocks).collect(),
            palette_blocks: count.palette_blocks,
            own_table_sets: tables.own().len(),
        }
    }
}

fn by_function(value: impl Fn(Function) -> u64) -> BTreeMap<&'static str, u64> {
    Function::ALL.into_iter().map(|function| (function.name(), value(function))).collect()
}

pub fn percent(part: u64, whole: u64) -> f64 {
    100.0 * part as f64 / whole.max(1) as f64
}

/// Returns `cubemap` or `perspective`.
pub fn projection_name(projection: u8) -> &'static str {
    if projection == 0 { "cubemap" } else { "perspective" }
}

fn missing_frames(decoder: &Decoder) -> Vec<MissingReport<'_>> {
    fn of(missing: &MissingFrame) -> MissingReport<'_> {
        let MissingFrame { probe, kind, face, frame, held } = missing;
        MissingReport { kind: kind.name(), probe, face: face.name(), frame: *frame, held: *held }
    }
    decoder.footage().missing_frames.iter().map(of).collect()
}
