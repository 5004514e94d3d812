//! The keys of `inspect --json`, and the columns of `inspect --csv`.

use serde_json::{Map, Value, json};

use super::{Report, percent};
use crate::cli::damage;
use crate::cli::output::json_number;
use crate::container::header::VERSION_MAJOR;
use crate::dataset::stream::{DepthKind, StreamKind};
use crate::depth::block::side_of;
use crate::depth::mode_statistics::Share;
use crate::depth::nodes::Function;
use crate::depth::settings::TemporalSettings;
use crate::image::transfer::Transfer;
use crate::inspect::container::{StreamStats, Totals};
use crate::streams::{CodecHeader, ColorFormat, DepthCoding, DepthHeader};

/// Columns of the CSV with one row for each stream.
pub const COLUMNS: &[&str] = &[
    "kind",
    "probe",
    "face",
    "frames",
    "first_frame",
    "width",
    "height",
    "codec",
    "bytes",
    "raw_bytes",
    "ratio_percent",
    "temporal_bytes",
    "payload_bytes",
    "stored_bytes",
    "chunks",
    "lzma2_chunks",
    "units",
    "unit_width",
    "unit_height",
    "keyframes",
    "keyframes_per_cell.min",
    "keyframes_per_cell.mean",
    "keyframes_per_cell.max",
    "static_cells",
    "static_tiles",
    "constant_units",
    "aabbs",
    "updated_pixels",
    "updated_percent",
    "error_bound_codes",
    "near_m",
    "far_m",
    "background",
    "depth_kind",
    "window",
    "max_aabbs",
    "keyframe_interval",
    "min_psnr_db",
    "transfer",
    "exposure_ev",
    "white_cd_m2",
    "keyframes_blocks",
    "keyframes_raw",
    "pieces.blocks",
    "pieces.raw",
];

/// Everything but the rows of frames.
pub fn head(report: &Report<'_>) -> Map<String, Value> {
    let (reader, inspection) = (report.decoder.reader(), report.inspection);
    let (index, all) = (reader.index(), inspection.totals(None));
    let probes = report.probes();
    let probe_list: Vec<Value> = probes
        .iter()
        .map(|&at| &index.probes[at])
        .map(|probe| json!({ "name": probe.name, "position": probe.position, "frames": probe.frames }))
        .collect();
    let mut head = Map::new();
    let mut put = |key: &str, value: Value| head.insert(key.to_owned(), value);
    put("name", json!(index.name));
    put("fps", json!(index.fps));
    put("projection", json!(projection_name(index.projection)));
    put("format_version", json!(VERSION_MAJOR));
    put("file_bytes", json!(reader.file_bytes()));
    put("bytes", json!(report.bytes()));
    put("raw_bytes", json!(all.raw_bytes));
    put("ratio_percent", json!(percent(report.bytes(), all.raw_bytes)));
    put("frames", json!(all.frames));
    put("probes", json!(probes.len()));
    put("probe_list", json!(probe_list));
    put("chunks", json!(all.chunks));
    put("overhead_bytes", json!(reader.overhead_bytes()));
    put("unreferenced_bytes", json!(inspection.unreferenced_bytes));
    put("shared_bytes_saved", json!(all.shared_bytes_saved));
    put("kinds", kinds(report));
    put("streams", json!(streams(report)));
    if report.args.verify {
        put("verify", verdict(report));
    }
    head
}

/// `cubemap` or `perspective`.
pub fn projection_name(projection: u8) -> &'static str {
    if projection == 0 { "cubemap" } else { "perspective" }
}

fn kinds(report: &Report<'_>) -> Value {
    let mut kinds = Map::new();
    for kind in StreamKind::ALL {
        let totals = report.inspection.totals(Some(kind));
        if totals != Totals::default() {
            kinds.insert(
                kind.name().to_owned(),
                json!({
                    "streams": totals.streams,
                    "frames": totals.frames,
                    "raw_bytes": totals.raw_bytes,
                    "temporal_bytes": totals.temporal_bytes,
                    "temporal_ratio_percent": percent(totals.temporal_bytes, totals.raw_bytes),
                    "bytes": totals.bytes,
                    "ratio_percent": percent(totals.bytes, totals.raw_bytes),
                    "chunks": totals.chunks,
                    "lzma2_chunks": totals.lzma2_chunks,
                    "shared_bytes_saved": totals.shared_bytes_saved,
                }),
            );
        }
    }
    Value::Object(kinds)
}

fn verdict(report: &Report<'_>) -> Value {
    let damaged = damage::json(report.decoder, &report.inspection.damaged);
    let all = report.inspection.totals(None);
    json!({ "chunks": all.chunks, "lzma2_chunks": all.lzma2_chunks, "damaged": damaged })
}

/// One object for each stream.
pub fn streams(report: &Report<'_>) -> Vec<Value> {
    report.inspection.streams.iter().map(|stats| Value::Object(stream(report, stats))).collect()
}

fn stream(report: &Report<'_>, stats: &StreamStats<'_>) -> Map<String, Value> {
    let (info, storage) = (stats.stream, stats.storage);
    let entry = &info.entry;
    let mut object = Map::new();
    let mut put = |key: &str, value: Value| {
        object.insert(key.to_owned(), value);
    };
    put("kind", json!(info.kind.name()));
    put("probe", json!(report.probe_name(info)));
    put("face", json!(info.face.name()));
    put("frames", json!(info.frames.count()));
    put("first_frame", json!(info.frames.first));
    put("width", json!(entry.width));
    put("height", json!(entry.height));
    put("codec", json!(info.header.codec_name()));
    put("bytes", json!(storage.bytes));
    put("raw_bytes", json!(stats.raw_bytes));
    put("ratio_percent", json!(percent(storage.bytes, stats.raw_bytes)));
    put("temporal_bytes", json!(storage.temporal_bytes));
    put("payload_bytes", json!(storage.payload_bytes));
    put("stored_bytes", json!(storage.stored_bytes));
    put("chunks", json!(storage.chunks));
    put("lzma2_chunks", json!(storage.lzma2_chunks));
    put("units", json!(stats.units));
    put("unit_width", json!(entry.unit_width));
    put("unit_height", json!(entry.unit_height));
    put("keyframes", json!(stats.keyframes));
    put("updated_pixels", json!(stats.updated_pixels));
    put("updated_percent", json!(percent(stats.updated_pixels, stats.pixels())));
    let put_temporal = |put: &mut dyn FnMut(&str, Value), temporal: &TemporalSettings| {
        put("static_tiles", json!(stats.static_units));
        put("constant_units", json!(stats.constant_units));
        put("aabbs", json!(stats.aabbs));
        put("error_bound_codes", json!(temporal.epsilon));
        put("window", json!(temporal.window));
        put("max_aabbs", json!(temporal.max_aabbs));
        put("keyframe_interval", json!(temporal.keyframe_interval));
    };
    match &info.header {
        CodecHeader::Depth(header) => {
            match &header.coding {
                DepthCoding::Boxes(temporal) => put_temporal(&mut put, temporal),
                DepthCoding::BoxesInBlocks(temporal) => {
                    put_temporal(&mut put, temporal);
                    put("pieces", pieces(stats));
                }
                coding => coding_of_nodes(header, coding, stats, &mut put),
            }
            put("near_m", json_number(shortest(header.range.near_m())));
            put("far_m", json_number(shortest(header.range.far_m())));
            put("background", json_number(shortest(header.background)));
            put("depth_kind", json!(depth_kind_name(header.kind)));
        }
        CodecHeader::Material(header) => {
            put_temporal(&mut put, &header.temporal);
            if header.in_blocks {
                put("pieces", pieces(stats));
            }
        }
        CodecHeader::Color(header) => {
            let spread = stats.keyframes_per_unit;
            put("keyframes_per_cell", json!({ "min": spread.min, "mean": spread.mean, "max": spread.max }));
            put("static_cells", json!(stats.static_units));
            put("min_psnr_db", json_number(header.min_psnr_db));
            if header.blocks.is_some() {
                put("keyframes_blocks", json!(stats.blocks.keyframes.blocks));
                put("keyframes_raw", json!(stats.blocks.keyframes.raw));
            }
            match header.format {
                ColorFormat::EightBit(tone) => {
                    put("transfer", json!(transfer_name(tone.transfer)));
                    put("exposure_ev", json_number(shortest(tone.exposure_ev)));
                }
                ColorFormat::Half { white_cd_m2 } => put("white_cd_m2", json_number(white_cd_m2)),
            }
        }
    }
    object
}

fn pieces(stats: &StreamStats<'_>) -> Value {
    json!({ "blocks": stats.blocks.pieces.blocks, "raw": stats.blocks.pieces.raw })
}

fn coding_of_nodes(
    header: &DepthHeader,
    coding: &DepthCoding,
    stats: &StreamStats<'_>,
    put: &mut impl FnMut(&str, Value),
) {
    put("static_tiles", json!(stats.static_units));
    put("constant_units", json!(stats.constant_units));
    put("error_bound_codes", json!(header.error_bound()));
    put("window", json!(header.window()));
    if let DepthCoding::Nodes(nodes) | DepthCoding::Tree(nodes) = coding {
        put("epsilon", json!(nodes.epsilon));
        put("max_error_codes", json!(nodes.bound));
        put("domain", json!(nodes.domain.kind.name()));
        put("keyframe_interval", json!(nodes.keyframe_interval));
    }
    let shares = |share: &dyn Fn(Function) -> Share, of: &dyn Fn(Share) -> u64| {
        let entry = |function: Function| (function.name().to_owned(), json!(of(share(function))));
        Value::Object(Function::ALL.into_iter().map(entry).collect())
    };
    let census = &stats.nodes;
    put("nodes", shares(&|function| census.of(function), &|share| share.nodes));
    put("node_pixels", shares(&|function| census.of(function), &|share| share.pixels));
    put("node_bytes", shares(&|function| census.of(function), &|share| share.bytes));
    let level = |level: u8| {
        let nodes = shares(&|function| census.share(level, function), &|share| share.nodes);
        json!({ "level": level, "side": side_of(level), "nodes": nodes })
    };
    put("node_levels", Value::Array(census.levels().map(level).collect()));
}

/// `distance` or `planar`.
pub fn depth_kind_name(kind: DepthKind) -> &'static str {
    match kind {
        DepthKind::Distance => "distance",
        DepthKind::Planar => "planar",
    }
}

/// `srgb` or `linear`.
pub fn transfer_name(transfer: Transfer) -> &'static str {
    match transfer {
        Transfer::Srgb => "srgb",
        Transfer::Linear => "linear",
    }
}

/// The number with the fewest digits that is this one among 32-bit floats.
fn shortest(value: f32) -> f64 {
    value.to_string().parse().unwrap_or(f64::from(value))
}
