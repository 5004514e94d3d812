//! Text report of `inspect`.

use std::collections::BTreeMap;
use std::fmt::Write;

use super::args::Report;
use crate::output::human_bytes;
use crate::report::Table;
use crate::{damage, depth_bound};
use codec::container::header::{VERSION_MAJOR, VERSION_MINOR};
use codec::depth::TemporalSettings;
use codec::depth::block::side_of;
use codec::depth::mode_statistics::{ModeStatistics, Share};
use codec::depth::nodes::Function;
use codec::depth::predictive::PredictiveHeader;
use codec::depth::predictive::modes::BlockCoding;
use codec::error::{counted, escaped};
use codec::image::StreamKind;
use codec::streams::{
    CodecHeader, ColorBlocks, ColorCoding, ColorFormat, DepthCoding, MissingFrame, NodeHeader, StartView,
};
use footage::depth_bound::DepthBound;
use footage::image_files::ColorSpace;
use footage::inspect::{BlockCount, PredictiveCount, StreamStats, Totals, TransformCount, percent, projection_name};

/// Maximum number of streams with a row each. More are summed by probe and kind, unless `--streams` is given.
const MAX_STREAM_ROWS: usize = 24;
/// Maximum number of settings listed for one kind of stream.
const MAX_SETTINGS: usize = 4;

pub fn summary(report: &Report<'_>) -> String {
    let mut out = format!("{}\n{}\n{}", heading(report), kinds(report), streams(report));
    for table in [nodes(report), predicted(report), blocks(report), transforms(report)].into_iter().flatten() {
        let _ = write!(out, "\n{table}");
    }
    let settings = settings(report) + &depth_bounds(report);
    if !settings.is_empty() {
        let _ = write!(out, "\n{settings}");
    }
    out
}

/// Returns the depth error bounds of the probes, one line each.
fn depth_bounds(report: &Report<'_>) -> String {
    let mut bounds: Vec<(&str, DepthBound)> = Vec::new();
    for stats in &report.inspection.streams {
        if let CodecHeader::Depth(header) = &stats.stream.header {
            let known = (report.probe_name(stats.stream), DepthBound::of(header));
            if !bounds.contains(&known) {
                bounds.push(known);
            }
        }
    }
    let most = if report.args.streams { usize::MAX } else { depth_bound::FEW_PROBES };
    depth_bound::lines(&bounds, most).into_iter().map(|line| line + "\n").collect()
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
    out += &footage(report);
    if reader.minor_version > VERSION_MINOR {
        let _ = writeln!(out, "format {VERSION_MAJOR}.{}, newer than this version of lightfold", reader.minor_version);
    }
    out
}

/// Returns lines about unusual primaries, clipped pixels, the view of players and missing frames.
fn footage(report: &Report<'_>) -> String {
    let decoder = report.decoder;
    let footage = decoder.footage();
    let mut out = String::new();
    if !footage.primaries.is_rec709() {
        let _ = match ColorSpace::of_light(footage.primaries) {
            Some(space) => writeln!(out, "colour is light of {}", space.name()),
            None => writeln!(out, "colour is light of the chromaticities {:?}", footage.primaries.to_array()),
        };
    }
    if let Some(count) = footage.clipped_pixels {
        let _ = writeln!(out, "{} were clipped to 8 bits by the encoder", counted(count, "colour pixel"));
    }
    if let Some(StartView { eye, look_at, fov_y_deg }) = footage.view {
        let point = |[x, y, z]: [f64; 3]| format!("{x},{y},{z}");
        let _ = writeln!(out, "players open at {} towards {}, {fov_y_deg} degrees high", point(eye), point(look_at));
    }
    // One line for each stream and replacement of its missing frames.
    let same = |one: &MissingFrame, next: &MissingFrame| {
        (&one.probe, one.kind, one.face, one.held) == (&next.probe, next.kind, next.face, next.held)
    };
    for frames in footage.missing_frames.chunk_by(same) {
        let MissingFrame { probe, kind, face, held, .. } = &frames[0];
        let numbers: Vec<String> = frames.iter().map(|missing| missing.frame.to_string()).collect();
        let held = held.map_or_else(|| "black".to_owned(), |frame| format!("frame {frame}"));
        let (kind, face, frames) = (kind.name(), face.name(), numbers.join(", "));
        let _ = writeln!(out, "missing in {kind} {probe}/{face}: {frames}; {held} is shown instead");
    }
    out
}

/// Table with the columns of CALF table 1.
fn kinds(report: &Report<'_>) -> Table {
    let all = report.inspection.totals(None);
    let stored = match (all.lzma2_chunks > 0, all.zstd_chunks > 0) {
        (true, false) => "+LZMA2",
        (false, true) => "+Zstd",
        _ => "Stored",
    };
    let mut table = Table::new(&format!("Kind|>Streams|>Images|>Raw|>Temporal|>%|>{stored}|>%"));
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

/// Table with a row for each stream or, if there are many, for the streams of one probe and kind.
fn streams(report: &Report<'_>) -> Table {
    let mut streams: Vec<_> = report.inspection.streams.iter().collect();
    let summed = streams.len() > MAX_STREAM_ROWS && !report.args.streams;
    if summed {
        streams.sort_by_key(|stats| (stats.stream.probe, stats.stream.kind));
    }
    let alike = |stats: &StreamStats<'_>| {
        let info = stats.stream;
        (info.probe, info.kind, info.entry.width, info.entry.height)
    };
    let mut table = Table::new("Probe|Kind|Face|>Frames|>Size|>Stored|>%|>Keys|>AABBs|>Upd. %|>Static|>Empty|>Units");
    for row in streams.chunk_by(|a, b| summed && alike(a) == alike(b)) {
        let info = row[0].stream;
        let sum = |of: fn(&StreamStats<'_>) -> u64| row.iter().fold(0, |sum: u64, stats| sum.saturating_add(of(stats)));
        let boxed = |count: u64| if info.kind == StreamKind::Color { "-".to_owned() } else { count.to_string() };
        let frames = row.iter().map(|stats| stats.stream.frames);
        let first = frames.clone().map(|frames| frames.first).min().unwrap_or_default();
        let last = frames.map(|frames| frames.last).max().unwrap_or_default();
        let bytes = sum(|stats| stats.storage.bytes);
        table.row([
            report.probe_name(info).to_owned(),
            info.kind.name().to_owned(),
            if row.len() > 1 { format!("{} faces", row.len()) } else { info.face.name().to_owned() },
            format!("{first}-{last}"),
            format!("{}x{}", info.entry.width, info.entry.height),
            human_bytes(bytes),
            format!("{:.2}", percent(bytes, sum(|stats| stats.raw_bytes))),
            sum(|stats| stats.keyframes).to_string(),
            boxed(sum(|stats| stats.aabbs)),
            format!("{:.2}", percent(sum(|stats| stats.updated_pixels), sum(|stats| stats.pixels()))),
            sum(|stats| stats.static_units).to_string(),
            boxed(sum(|stats| stats.constant_units)),
            sum(|stats| stats.units).to_string(),
        ]);
    }
    table
}

/// Mode statistics of depth: nodes by level and function, with their share of the updated pixels and of the bytes.
fn nodes(report: &Report<'_>) -> Option<Table> {
    let mut census = ModeStatistics::default();
    report.inspection.streams.iter().for_each(|stats| census.add(&stats.nodes));
    if census.is_empty() {
        return None;
    }
    let sum = |of: fn(Share) -> u64| Function::ALL.into_iter().map(|function| of(census.of(function))).sum::<u64>();
    let (pixels, bytes) = (sum(|share| share.pixels), sum(|share| share.bytes));
    let functions = Function::ALL.map(|function| function.name()).join("|>");
    let mut table = Table::new(&format!("Nodes|>{functions}|>Pixels %|>Bytes %"));
    let mut row = |name: String, shares: [Share; 4]| {
        let of = |of: fn(&Share) -> u64| shares.iter().map(of).sum::<u64>();
        let parts = [percent(of(|share| share.pixels), pixels), percent(of(|share| share.bytes), bytes)];
        let nodes = shares.map(|share| share.nodes.to_string()).into_iter();
        table.row(std::iter::once(name).chain(nodes).chain(parts.map(|part| format!("{part:.2}"))));
    };
    for level in census.levels() {
        let side = side_of(level);
        row(format!("{side}x{side}"), Function::ALL.map(|function| census.share(level, function)));
    }
    row("all".to_owned(), Function::ALL.map(|function| census.of(function)));
    Some(table)
}

/// Blocks of predictive coding, with their share of the pixels and of the bytes.
fn predicted(report: &Report<'_>) -> Option<Table> {
    let mut count = PredictiveCount::default();
    report.inspection.streams.iter().for_each(|stats| count.add(&stats.predictive));
    let shares = BlockCoding::ALL.map(|coding| count.share(coding));
    let pixels: u64 = shares.iter().map(|share| share.pixels).sum();
    let bits: f64 = shares.iter().map(|share| share.bits).sum();
    let mut table = Table::new("Coding|>Blocks 8x8|>Pixels %|>Bytes %|>Bits a pixel");
    for (coding, share) in BlockCoding::ALL.into_iter().zip(shares).filter(|(_, share)| share.blocks > 0) {
        table.row([
            coding.name().replace('_', " "),
            share.blocks.to_string(),
            format!("{:.2}", percent(share.pixels, pixels)),
            format!("{:.2}", 100.0 * share.bits / bits.max(1e-9)),
            format!("{:.3}", share.bits / share.pixels as f64),
        ]);
    }
    (pixels > 0).then_some(table)
}

/// Keyframes of colour, and block tiles of depth and material, that are stored in blocks, by codec.
fn blocks(report: &Report<'_>) -> Option<Table> {
    let mut counts: BTreeMap<&str, BlockCount> = BTreeMap::new();
    for stats in report.inspection.streams.iter().filter(|stats| stats.stream.header.in_blocks()) {
        counts.entry(stats.stream.header.codec_name()).or_default().add(stats.blocks);
    }
    let mut table = Table::new("Codec|Of|>In blocks|>Raw|>Raw %");
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

/// Chunks of the transform codec by coding, and their blocks by side in pixels.
fn transforms(report: &Report<'_>) -> Option<Table> {
    let mut counts: BTreeMap<&str, TransformCount> = BTreeMap::new();
    let is_transform = |stats: &&StreamStats<'_>| matches!(&stats.stream.header, CodecHeader::Color(header) if header.tables().is_some());
    for stats in report.inspection.streams.iter().filter(is_transform) {
        counts.entry(stats.stream.header.codec_name()).or_default().add(stats.transform);
    }
    let mut table = Table::new("Codec|>Chunks|>Keyframe chunks|>Blocks 4x4|>8x8|>16x16|>32x32|>Palettes");
    for (codec, count) in &counts {
        let TransformCount { transform_chunks, cells_chunks, blocks, palette_blocks } = count;
        let numbers = [transform_chunks + cells_chunks, *cells_chunks].into_iter().chain(*blocks);
        let numbers = numbers.chain([*palette_blocks]).map(|number| number.to_string());
        table.row(std::iter::once((*codec).to_owned()).chain(numbers));
    }
    (!counts.is_empty()).then_some(table)
}

/// Distinct settings of the streams, each with the union of the depth ranges.
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
            let _ = write!(out, "{}: {line}", kind.name());
            if kind == StreamKind::Depth {
                let _ = write!(out, ", {} to {} m", metres(*near), metres(*far));
            }
            out.push('\n');
        }
        if seen.len() > MAX_SETTINGS {
            let _ = writeln!(out, "{}: and other settings, see --json", kind.name());
        }
    }
    out
}

/// Formats with four significant digits.
fn metres(value: f32) -> String {
    if value.abs() >= 1e7 {
        return format!("{value:.3e}");
    }
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
                DepthCoding::Predictive(PredictiveHeader {
                    bound,
                    epsilon,
                    keyframe_interval,
                    ref tables,
                    ref levels,
                    ..
                }) => {
                    let epsilon = if epsilon > 0 { format!(" and {epsilon} in time") } else { String::new() };
                    let tables = match tables.own().len() as u64 {
                        0 => String::new(),
                        own => format!(", {}", counted(own, "table set")),
                    };
                    let levels = match levels.codes().len() {
                        0 => String::new(),
                        count => format!(", {count} levels"),
                    };
                    format!(
                        "predictive, ±{bound} codes{levels}{epsilon}, keyframe every {keyframe_interval}, tile \
                         {units}{tables}"
                    )
                }
            };
            format!("{coding}, {}", header.kind.name())
        }
        CodecHeader::Material(header) => {
            format!("{}{}", temporal(&header.temporal), if header.in_blocks { ", BC1" } else { "" })
        }
        CodecHeader::Alpha(header) => {
            format!("8 bits, predictive, keyframe every {}, tile {units}", header.keyframe_interval)
        }
        CodecHeader::Color(header) => {
            let format = match header.format {
                ColorFormat::EightBit(tone) => {
                    format!("8 bits, {}, exposure {} EV", tone.transfer.name(), tone.exposure_ev)
                }
                ColorFormat::Half { white_cd_m2 } => format!("half floats, white at {white_cd_m2} cd/m²"),
            };
            let coding = match &header.coding {
                ColorCoding::Cells(None) => String::new(),
                ColorCoding::Cells(Some(ColorBlocks::Bc1)) => ", BC1".to_owned(),
                ColorCoding::Cells(Some(ColorBlocks::Bc7)) => ", BC7".to_owned(),
                ColorCoding::Cells(Some(ColorBlocks::Bc6h)) => ", BC6H".to_owned(),
                ColorCoding::Transform(tables) => match tables.own().len() as u64 {
                    0 => ", transform".to_owned(),
                    own => format!(", transform with {}", counted(own, "table set")),
                },
            };
            let kept = match (header.min_quality, header.min_psnr_db) {
                (0.0, 0.0) => String::new(),
                (0.0, db) => format!(", at least {db} dB"),
                (quality, _) => format!(", quality {quality} at least"),
            };
            format!("{format}{coding}{kept}, cell {units}")
        }
    }
}

pub fn frames(report: &Report<'_>) -> String {
    let mut table = Table::new("Probe|Kind|Face|>Frame|>Keys|>AABBs|>Updated pixels|>%|>Bytes");
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

pub fn verdict(report: &Report<'_>) -> String {
    let inspection = report.inspection;
    let all = inspection.totals(None);
    if inspection.damaged.is_empty() {
        return format!(
            "\n{} verified ({} of LZMA2, {} of Zstandard)\n",
            counted(all.chunks, "chunk"),
            all.lzma2_chunks,
            all.zstd_chunks
        );
    }
    let mut out = format!("{} of {} damaged:\n", inspection.damaged.len(), counted(all.chunks, "chunk"));
    out.push_str(&damage::lines(report.decoder, &inspection.damaged));
    out
}
