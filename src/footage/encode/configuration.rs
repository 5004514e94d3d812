//! Configuration of an encode: everything that its bytes depend on, as names and values. An interrupted encode can only be
//! resumed with an equal configuration.

use serde::Serialize;

use crate::dataset::SourceGroup;
use crate::encode::source::FrameSource;
use crate::encode::{
    ColorBlockSettings, ColorCodec, DepthCodec, DepthSettings, EncodeSettings, ErrorBound, MaterialSettings, TileSize,
};
use crate::fingerprint::{Fingerprint, digest};
use codec::color::{SearchSettings, Target};
use codec::depth::TemporalSettings;
use codec::depth::mode_decision::Decide;
use codec::depth::quantise::metres_in_words;
use codec::effort::Effort;
use codec::entropy::{Model, TableSet, Tables};
use codec::error::{Error, Result};
use codec::image::{FrameRange, StreamKind, ToneMap};
use codec::streams::{ColorBlocks, ColorFormat};

pub(super) fn of(source: &dyn FrameSource, settings: &EncodeSettings) -> Fingerprint {
    let mut fields = Fingerprint::of_program(&[codec::SOURCES, crate::SOURCES]);
    fields.extend(of_settings(settings));
    fields.push(("the name of the dataset", source.name().to_owned()));
    fields.push(("the frame rate", source.fps().to_string()));
    fields.push(("the projection", source.projection().name().to_owned()));
    let groups = source.groups().iter().enumerate();
    let groups: Vec<_> = groups.filter(|(_, group)| settings.kinds.contains(&group.kind)).collect();
    fields.extend(words_of_groups(source, groups.iter().map(|(_, group)| *group)));
    fields.push(("the list of probes", digest(format!("{:?}", source.probes()).as_bytes())));
    fields.push(("the list of streams", digest(format!("{groups:?}").as_bytes())));
    fields.extend(source.configuration());
    // Last, because it may differ only if another option selects another encoder.
    fields.push(("the kind of machine", machine(settings)));
    Fingerprint(fields.into_iter().map(|(name, value)| (name.to_owned(), value)).collect())
}

/// Readable summary of probes and streams, for messages; digests cover them completely.
fn words_of_groups<'a>(
    source: &dyn FrameSource,
    groups: impl Iterator<Item = &'a SourceGroup> + Clone,
) -> [(&'static str, String); 3] {
    let first = groups.clone().map(|group| group.frames.first).min().unwrap_or(0);
    let last = groups.clone().map(|group| group.frames.last).max().unwrap_or(0);
    let mut sizes: Vec<String> = groups.map(|group| format!("{}x{}", group.width, group.height)).collect();
    sizes.dedup();
    let names: Vec<&str> = source.probes().iter().map(|probe| probe.name.as_str()).collect();
    [
        ("the range of `frames`", FrameRange { first, last }.to_string()),
        ("the size of the images", sizes.join(", ")),
        ("the choice of probes", names.join(", ")),
    ]
}

pub(super) fn to_bytes<T: Serialize + ?Sized>(part: &T) -> Result<Vec<u8>> {
    serde_json::to_vec(part).map_err(|error| Error::invalid(error.to_string()))
}

/// Settings by name. A new setting must be added here, or left out with a reason.
fn of_settings(settings: &EncodeSettings) -> Vec<(&'static str, String)> {
    let EncodeSettings {
        temporal,
        material,
        depth,
        tiles,
        near_m,
        far_m,
        outside_depth,
        cell,
        color,
        color_codec,
        color_chunk,
        color_tables,
        depth_tables,
        search,
        color_blocks,
        compression,
        kinds,
        // Clipping is refused before anything is written.
        clipping: _,
        // A smaller budget only makes batches smaller; chunk order and bytes stay the same.
        memory: _,
    } = settings;
    let TemporalSettings { window, epsilon, max_aabbs, keyframe_interval } = temporal;
    let MaterialSettings { epsilon: material_error, in_blocks } = material;
    let DepthSettings { codec, error, domain, decide, effort, min_children } = depth;
    let SearchSettings { target, effort: search_effort, lookahead } = search;
    let kinds: Vec<&str> =
        StreamKind::ALL.into_iter().filter(|kind| kinds.contains(kind)).map(StreamKind::name).collect();
    vec![
        ("`stream`", kinds.join(",")),
        ("the compression of chunks", compression.to_string()),
        ("`depth_codec`", name_of_codec(*codec).to_owned()),
        ("`max_error`", words_of_bound(*error)),
        ("`depth_domain`", domain.name().to_owned()),
        ("`optimize`", if *decide == Decide::Size { "size" } else { "quality" }.to_owned()),
        ("`effort`", words_of_efforts(*effort, *search_effort)),
        ("`min_children`", min_children.to_string()),
        ("`depth_window`", window.to_string()),
        ("`update_threshold`", epsilon.to_string()),
        ("`max_aabbs`", max_aabbs.to_string()),
        ("`keyframe_interval`", keyframe_interval.to_string()),
        ("`depth_tile`", words_of_tiles(*tiles)),
        ("`near`", metres(*near_m)),
        ("`far`", metres(*far_m)),
        ("the treatment of depth outside `near` and `far`", outside_depth.name().to_owned()),
        ("`material_error`", material_error.to_string()),
        ("`material_block`", if *in_blocks { "bc1" } else { "none" }.to_owned()),
        ("`color_cell`", cell.to_string()),
        ("`color_codec`", if *color_codec == ColorCodec::Cells { "cells" } else { "transform" }.to_owned()),
        ("`color_chunk`", color_chunk.to_string()),
        ("`color_tables`", digest_of_tables(color_tables.as_slice())),
        ("`depth_tables`", digest_of_tables(depth_tables)),
        ("`quality`, `psnr` or `color_qp`", words_of_target(*target)),
        ("`lookahead`", lookahead.to_string()),
        ("`color_block`", words_of_blocks(*color_blocks)),
        ("the domain of colour", words_of_color(*color)),
    ]
}

fn digest_of_tables<M: Model>(sets: &[TableSet<M>]) -> String {
    if sets.is_empty() {
        return "none".to_owned();
    }
    let mut bytes = Vec::new();
    Tables::with_own(sets.to_vec()).write(&mut bytes);
    digest(&bytes)
}

fn name_of_codec(codec: DepthCodec) -> &'static str {
    match codec {
        DepthCodec::Quadtree => "quadtree",
        DepthCodec::Tree => "the quadtree of a later pack",
        DepthCodec::Boxes => "aabb",
        DepthCodec::BoxesInBlocks => "aabb in bc5 blocks",
        DepthCodec::Blocks => "bc4w",
        DepthCodec::Predictive => "predictive",
    }
}

fn words_of_bound(error: ErrorBound) -> String {
    match error {
        ErrorBound::Codes(codes) => format!("{codes} codes"),
        ErrorBound::Relative(share) => format!("{share} of the distance"),
    }
}

fn words_of_efforts(depth: Effort, color: Effort) -> String {
    match (depth.name(), color.name()) {
        (depth, color) if depth == color => depth.to_owned(),
        (depth, color) => format!("{depth} for depth and {color} for colour"),
    }
}

fn words_of_tiles(tiles: TileSize) -> String {
    match tiles {
        TileSize::Usual => "the default".to_owned(),
        TileSize::PerSide(tiles) => format!("{tiles} per side"),
        TileSize::Pixels(side) => format!("{side} pixels"),
    }
}

fn metres(distance_m: Option<f32>) -> String {
    distance_m.map_or_else(|| "that of the images".to_owned(), |distance| format!("{} m", metres_in_words(distance)))
}

fn words_of_target(target: Target) -> String {
    match target {
        Target::Quality(quality) => format!("quality {quality}"),
        Target::Psnr(db) => format!("{db} dB"),
        Target::Step(step) => format!("step {step}"),
    }
}

fn words_of_blocks(blocks: Option<ColorBlockSettings>) -> String {
    let Some(ColorBlockSettings { blocks, final_psnr_db }) = blocks else { return "none".to_owned() };
    let name = match blocks {
        ColorBlocks::Bc1 => "bc1",
        ColorBlocks::Bc7 => "bc7",
        ColorBlocks::Bc6h => "bc6h",
    };
    format!("{name} at {final_psnr_db} dB")
}

fn words_of_color(format: ColorFormat) -> String {
    match format {
        ColorFormat::EightBit(ToneMap { transfer, exposure_ev }) => {
            format!("8 bits, {}, at {exposure_ev} EV", transfer.name())
        }
        ColorFormat::Half { white_cd_m2 } => format!("half floats with white at {white_cd_m2} cd/m²"),
    }
}

/// Platform properties that rounding depends on: the system's trigonometric functions if images are resampled, and the
/// processor's instruction sets for encoders of texture blocks.
fn machine(settings: &EncodeSettings) -> String {
    let in_blocks = settings.depends_on_processor();
    let system = format!("{} {}", std::env::consts::OS, std::env::consts::ARCH);
    if in_blocks { format!("{system}{}", instruction_sets()) } else { system }
}

#[cfg(target_arch = "x86_64")]
fn instruction_sets() -> String {
    let there = [
        (is_x86_feature_detected!("sse4.1"), " sse4.1"),
        (is_x86_feature_detected!("avx"), " avx"),
        (is_x86_feature_detected!("avx2"), " avx2"),
        (is_x86_feature_detected!("fma"), " fma"),
        (is_x86_feature_detected!("avx512f"), " avx512f"),
        (is_x86_feature_detected!("avx512bw"), " avx512bw"),
    ];
    there.into_iter().filter_map(|(is_there, name)| is_there.then_some(name)).collect()
}

#[cfg(not(target_arch = "x86_64"))]
fn instruction_sets() -> String {
    String::new()
}

/// Error for an encode that cannot be resumed because of a difference in configuration.
pub(super) fn other(difference: &str) -> Error {
    Error::Usage(format!(
        "cannot resume the unfinished encode: {difference}: use its settings, or leave out `resume` to start over"
    ))
}
