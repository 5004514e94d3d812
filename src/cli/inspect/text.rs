//! The text report of `inspect`.

use std::collections::BTreeMap;
use std::fmt::Write;

use super::args::Report;
use crate::cli::damage;
use crate::cli::output::human_bytes;
use crate::container::header::{VERSION_MAJOR, VERSION_MINOR};
use crate::depth::block::side_of;
use crate::depth::mode_statistics::{ModeStatistics, Share};
use crate::depth::nodes::Function;
use crate::depth::settings::TemporalSettings;
use crate::error::escaped;
use crate::image::StreamKind;
use crate::inspect::{BlockCount, StreamStats, Totals, percent, projection_name};
use crate::report::{Column, Table};
use crate::streams::{CodecHeader, ColorBlocks, ColorFormat, DepthCoding, NodeHeader};

/// More streams than this are summed up for each probe and kind, unless `--streams` is given.
const MAX_STREAM_ROWS: usize = 24;
/// Most settings listed for one kind of stream.
const MAX_SETTINGS: usize = 4;

/// The whole report without `--frames`.
pub fn summary(report: &Report<'_>) -> String {
    let mut out = heading(report);
    let _ = write!(out, "\n{}\n{}", kinds(report), streams(report));
    if let Some(nodes) = nodes(report) {
        let _ = write!(out, "\n{nodes}");
    }
    if let Some(blocks) = blocks(report) {
        let _ = write!(out, "\n{blocks}");
    }
    let settings = settings(report);
    if !settings.is_empty() {
        let _ = write!(out, "\n{settings}");
    }
    out
}

fn heading(report: &Report<'_>) -> String {
    let (reader, all) = (report.decoder.reader(), report.inspection.totals(None));
    let index = reader.index();
    let streams = match report.decoder.streams().len() {
        every if every as u64 == all.streams => counted(all.streams, "stream"),
        every => format!("{} of {every} streams", all.streams),
    };
    let mut out = format!(
        "{}: {} at {} fps, {}, {streams}, {}\n",
        escaped(&index.name),
        projection_name(index.projection),
        index.fps,
        counted(report.inspection.probes().len() as u64, "probe"),
        counted(all.frames, "image"),
    );
    let bytes = report.inspection.bytes(report.decoder);
    let _ = writeln!(
        out,
        "{} of {} raw ({:.2}%), {}, {} saved by sharing, {} head and index",
        human_bytes(bytes),
        human_bytes(all.raw_bytes),
        percent(bytes, all.raw_bytes),
        counted(all.chunks, "chunk"),
        human_bytes(all.shared_bytes_saved),
        human_bytes(reader.overhead_bytes()),
    );
    if report.inspection.unreferenced_bytes > 0 {
        let _ = writeln!(out, "{} outside of chunks", human_bytes(report.inspection.unreferenced_bytes));
    }
    if reader.minor_version() > VERSION_MINOR {
        let _ = writeln!(out, "format {VERSION_MAJOR}.{}, later than this program knows", reader.minor_version());
    }
    out
}

fn counted(count: u64, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}

/// CALF's table 1.
fn kinds(report: &Report<'_>) -> Table {
    let all = report.inspection.totals(None);
    let stored = if all.lzma2_chunks > 0 { "+LZMA2" } else { "Stored" };
    let mut table = Table::new(&[
        Column::Left("Kind"),
        Column::Right("Streams"),
        Column::Right("Images"),
        Column::Right("Raw"),
        Column::Right("Temporal"),
        Column::Right("%"),
        Column::Right(stored),
        Column::Right("%"),
    ]);
    let mut row = |name: &str, totals: Totals| {
        table.row([
            name.to_owned(),
            totals.streams.to_string(),
            totals.frames.to_string(),
            human_bytes(totals.raw_bytes),
            human_bytes(totals.temporal_bytes),
            format!("{:.2}", percent(totals.temporal_bytes, totals.raw_bytes)),
            human_bytes(totals.bytes),
            format!("{:.2}", percent(totals.bytes, totals.raw_bytes)),
        ]);
    };
    let of = |kind| (kind, report.inspection.totals(Some(kind)));
    let present: Vec<_> = StreamKind::ALL.into_iter().map(of).filter(|(_, totals)| totals.streams > 0).collect();
    present.iter().for_each(|(kind, totals)| row(kind.name(), *totals));
    if present.len() > 1 {
        row("all", all);
    }
    table
}

/// A row of the stream table: one stream, or those of one probe and kind.
struct Line {
    probe: usize,
    kind: StreamKind,
    faces: String,
    streams: u64,
    frames: [u32; 2],
    size: [u32; 2],
    sums: Sums,
}

#[derive(Default)]
struct Sums {
    bytes: u64,
    raw_bytes: u64,
    keyframes: u64,
    aabbs: u64,
    updated_pixels: u64,
    pixels: u64,
    units: u64,
    static_units: u64,
    constant_units: u64,
}

impl Line {
    fn new(stats: &StreamStats<'_>) -> Line {
        let info = stats.stream;
        Line {
            probe: info.probe,
            kind: info.kind,
            faces: info.face.name().to_owned(),
            streams: 0,
            frames: [info.frames.first, info.frames.last],
            size: [info.entry.width, info.entry.height],
            sums: Sums::default(),
        }
    }

    fn add(&mut self, stats: &StreamStats<'_>) {
        self.streams += 1;
        if self.streams > 1 {
            self.faces = format!("{} faces", self.streams);
        }
        let (frames, sums) = (stats.stream.frames, &mut self.sums);
        self.frames = [self.frames[0].min(frames.first), self.frames[1].max(frames.last)];
        sums.bytes += stats.storage.bytes;
        sums.raw_bytes = sums.raw_bytes.saturating_add(stats.raw_bytes);
        sums.keyframes += stats.keyframes;
        sums.aabbs += stats.aabbs;
        sums.updated_pixels += stats.updated_pixels;
        sums.pixels = sums.pixels.saturating_add(stats.pixels());
        sums.units += stats.units;
        sums.static_units += stats.static_units;
        sums.constant_units += stats.constant_units;
    }
}

fn streams(report: &Report<'_>) -> Table {
    let mut streams: Vec<_> = report.inspection.streams.iter().collect();
    let summed = streams.len() > MAX_STREAM_ROWS && !report.args.streams;
    if summed {
        streams.sort_by_key(|stats| (stats.stream.probe, stats.stream.kind));
    }
    let mut lines: Vec<Line> = Vec::new();
    for stats in streams {
        let (info, size) = (stats.stream, [stats.stream.entry.width, stats.stream.entry.height]);
        let same = |line: &Line| (line.probe, line.kind, line.size) == (info.probe, info.kind, size);
        match lines.last_mut().filter(|line| summed && same(line)) {
            Some(line) => line.add(stats),
            None => {
                let mut line = Line::new(stats);
                line.add(stats);
                lines.push(line);
            }
        }
    }
    let mut table = Table::new(&[
        Column::Left("Probe"),
        Column::Left("Kind"),
        Column::Left("Face"),
        Column::Right("Frames"),
        Column::Right("Size"),
        Column::Right("Stored"),
        Column::Right("%"),
        Column::Right("Keys"),
        Column::Right("AABBs"),
        Column::Right("Upd. %"),
        Column::Right("Static"),
        Column::Right("Empty"),
        Column::Right("Units"),
    ]);
    for line in lines {
        let sums = &line.sums;
        let boxed = |count: u64| if line.kind == StreamKind::Color { "-".to_owned() } else { count.to_string() };
        table.row([
            report.decoder.reader().index().probes[line.probe].name.clone(),
            line.kind.name().to_owned(),
            line.faces.clone(),
            format!("{}-{}", line.frames[0], line.frames[1]),
            format!("{}x{}", line.size[0], line.size[1]),
            human_bytes(sums.bytes),
            format!("{:.2}", percent(sums.bytes, sums.raw_bytes)),
            sums.keyframes.to_string(),
            boxed(sums.aabbs),
            format!("{:.2}", percent(sums.updated_pixels, sums.pixels)),
            sums.static_units.to_string(),
            boxed(sums.constant_units),
            sums.units.to_string(),
        ]);
    }
    table
}

/// Mode statistics of depth: nodes by level and function, with their part of the updated pixels and of the bytes.
fn nodes(report: &Report<'_>) -> Option<Table> {
    let mut census = ModeStatistics::default();
    report.inspection.streams.iter().for_each(|stats| census.add(&stats.nodes));
    if census.is_empty() {
        return None;
    }
    let sum = |of: fn(Share) -> u64| Function::ALL.into_iter().map(|function| of(census.of(function))).sum::<u64>();
    let (pixels, bytes) = (sum(|share| share.pixels), sum(|share| share.bytes));
    let mut columns = vec![Column::Left("Nodes")];
    columns.extend(Function::ALL.map(|function| Column::Right(function.name())));
    columns.extend([Column::Right("Pixels %"), Column::Right("Bytes %")]);
    let mut table = Table::new(&columns);
    let mut row = |name: String, shares: [Share; 4]| {
        let of = |of: fn(&Share) -> u64| shares.iter().map(of).sum::<u64>();
        let mut cells = vec![name];
        cells.extend(shares.map(|share| share.nodes.to_string()));
        cells.push(format!("{:.2}", percent(of(|share| share.pixels), pixels)));
        cells.push(format!("{:.2}", percent(of(|share| share.bytes), bytes)));
        table.row(cells);
    };
    for level in census.levels() {
        let side = side_of(level);
        row(format!("{side}x{side}"), Function::ALL.map(|function| census.share(level, function)));
    }
    row("all".to_owned(), Function::ALL.map(|function| census.of(function)));
    Some(table)
}

/// Keyframes of colour and block tiles of depth and material that are stored in blocks, by codec.
fn blocks(report: &Report<'_>) -> Option<Table> {
    let mut counts: BTreeMap<&str, BlockCount> = BTreeMap::new();
    for stats in report.inspection.streams.iter().filter(|stats| stats.stream.header.in_blocks()) {
        counts.entry(stats.stream.header.codec_name()).or_default().add(stats.blocks);
    }
    let mut table = Table::new(&[
        Column::Left("Codec"),
        Column::Left("Of"),
        Column::Right("In blocks"),
        Column::Right("Raw"),
        Column::Right("Raw %"),
    ]);
    for (codec, count) in &counts {
        let (of, count) = match codec.starts_with("cells") {
            true => ("keyframes", count.keyframes),
            false => ("block tiles of 16x16", count.pieces),
        };
        let raw = format!("{:.2}", percent(count.raw, count.blocks + count.raw));
        table.row([(*codec).to_owned(), of.to_owned(), count.blocks.to_string(), count.raw.to_string(), raw]);
    }
    (!counts.is_empty()).then_some(table)
}

/// Distinct settings of the streams, each with its widest depth range.
fn settings(report: &Report<'_>) -> String {
    let mut out = String::new();
    for kind in StreamKind::ALL {
        let mut seen: Vec<(String, f32, f32)> = Vec::new();
        for stats in report.inspection.streams.iter().filter(|stats| stats.stream.kind == kind) {
            let line = setting(stats);
            let (near, far) = match &stats.stream.header {
                CodecHeader::Depth(header) => (header.range.near_m(), header.range.far_m()),
                _ => (0.0, 0.0),
            };
            let full = seen.len() > MAX_SETTINGS;
            match seen.iter_mut().find(|(other, ..)| *other == line) {
                Some((_, least, most)) => (*least, *most) = (least.min(near), most.max(far)),
                None if full => {}
                None => seen.push((line, near, far)),
            }
        }
        for (line, near, far) in seen.iter().take(MAX_SETTINGS) {
            let range = if kind == StreamKind::Depth {
                format!(", {} to {} m", metres(*near), metres(*far))
            } else {
                String::new()
            };
            let _ = writeln!(out, "{}: {line}{range}", kind.name());
        }
        if seen.len() > MAX_SETTINGS {
            let _ = writeln!(out, "{}: and other settings, see --json", kind.name());
        }
    }
    out
}

/// Four significant digits.
fn metres(value: f32) -> String {
    let digits = (3.0 - value.abs().log10().floor()).clamp(0.0, 9.0) as usize;
    format!("{value:.digits$}")
}

fn setting(stats: &StreamStats<'_>) -> String {
    let entry = &stats.stream.entry;
    let units = format!("{}x{}", entry.unit_width, entry.unit_height);
    let temporal = |settings: &TemporalSettings| {
        let TemporalSettings { window, epsilon, max_aabbs, keyframe_interval } = settings;
        format!(
            "±{epsilon} codes, window {window}, {max_aabbs} AABBs, keyframe every {keyframe_interval}, tile {units}"
        )
    };
    match &stats.stream.header {
        CodecHeader::Depth(header) => {
            let coding = match header.coding {
                DepthCoding::Boxes(settings) => temporal(&settings),
                DepthCoding::BoxesInBlocks(settings) => format!("{}, BC5", temporal(&settings)),
                DepthCoding::Nodes(nodes) => {
                    let NodeHeader { window, epsilon, keyframe_interval, bound, domain } = nodes;
                    let epsilon = if epsilon > 0 { format!(" and {epsilon} in time") } else { String::new() };
                    format!(
                        "quadtree, ±{bound} codes{epsilon}, {} functions, window {window}, keyframe every \
                         {keyframe_interval}, tile {units}",
                        domain.kind.name()
                    )
                }
                DepthCoding::Tree(nodes) => format!(
                    "quadtree to be packed at up to ±{} codes, {} functions, keyframe every {}, tile {units}",
                    nodes.bound,
                    nodes.domain.kind.name(),
                    nodes.keyframe_interval
                ),
                DepthCoding::Blocks => format!("BC4w blocks without a bound, tile {units}"),
            };
            format!("{coding}, {}", header.kind.name())
        }
        CodecHeader::Material(header) => {
            format!("{}{}", temporal(&header.temporal), if header.in_blocks { ", BC1" } else { "" })
        }
        CodecHeader::Color(header) => {
            let format = match header.format {
                ColorFormat::EightBit(tone) => {
                    format!("8 bits, {}, exposure {} EV", tone.transfer.name(), tone.exposure_ev)
                }
                ColorFormat::Half { white_cd_m2 } => format!("half floats, white at {white_cd_m2} cd/m²"),
            };
            let blocks = match header.blocks {
                None => "",
                Some(ColorBlocks::Bc1) => ", BC1",
                Some(ColorBlocks::Bc7) => ", BC7",
                Some(ColorBlocks::Bc6h) => ", BC6H",
            };
            format!("{format}{blocks}, at least {} dB, cell {units}", header.min_psnr_db)
        }
    }
}

/// The report of `--per-frame`.
pub fn frames(report: &Report<'_>) -> String {
    let mut table = Table::new(&[
        Column::Left("Probe"),
        Column::Left("Kind"),
        Column::Left("Face"),
        Column::Right("Frame"),
        Column::Right("Keys"),
        Column::Right("AABBs"),
        Column::Right("Updated pixels"),
        Column::Right("%"),
        Column::Right("Bytes"),
    ]);
    for row in report.inspection.frame_reports(report.decoder) {
        table.row([
            row.probe.to_owned(),
            row.kind.to_owned(),
            row.face.to_owned(),
            row.frame.to_string(),
            row.keyframe_units.to_string(),
            if row.kind == StreamKind::Color.name() { "-".to_owned() } else { row.aabbs.to_string() },
            row.updated_pixels.to_string(),
            format!("{:.2}", row.updated_percent),
            row.bytes.to_string(),
        ]);
    }
    format!("{}\n{table}", heading(report))
}

/// Result of `--verify`.
pub fn verdict(report: &Report<'_>) -> String {
    let inspection = report.inspection;
    let all = inspection.totals(None);
    if inspection.damaged.is_empty() {
        return format!(
            "\n{} verified ({} of LZMA2), {} outside of chunks\n",
            counted(all.chunks, "chunk"),
            all.lzma2_chunks,
            human_bytes(inspection.unreferenced_bytes)
        );
    }
    let mut out = format!("{} of {} damaged:\n", inspection.damaged.len(), counted(all.chunks, "chunk"));
    out.push_str(&damage::lines(report.decoder, &inspection.damaged));
    let _ = writeln!(out, "{} outside of chunks", human_bytes(inspection.unreferenced_bytes));
    out
}
