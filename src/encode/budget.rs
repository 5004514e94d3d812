//! Upper bounds of the memory that encoding takes, and how many frames are read at once.
//!
//! The file depends on none of it, except for [`ColorMemory`], which follows from footage and settings alone: a batch has as
//! many frames as fit, and where the encoders' own state does not fit, the encode is refused before it begins. Nothing adds
//! up over probes or groups, which are encoded one after the other.

use crate::color::SearchSettings;
use crate::color::temporal::CLOSE_AT_BYTES as COLOR_CLOSE_AT_BYTES;
use crate::color::transform::blocks::padded_pixels;
use crate::dataset::SourceGroup;
use crate::decode::memory;
use crate::depth::open_chunk::CLOSE_AT_BYTES;
use crate::depth::predictive::encoder::CLOSE_AT_BYTES_A_PIXEL;
use crate::encode::source::{FrameSource, GroupRef};
use crate::encode::{ColorCodec, DepthCodec, EncodeSettings};
use crate::error::Result;
use crate::image::StreamKind;
use crate::memory::Need;
use crate::streams::CodecHeader;

const BATCH_FRAMES: usize = 16;
const BATCH_PIXELS: usize = 64 << 20;
/// Most bytes of depth images that a scan keeps, so that they are read once.
const KEEP_BYTES: u64 = 512 << 20;
/// Most bytes of pictures that the cells of a group hold while they wait for the next keyframe.
const PENDING_BYTES: u64 = 768 << 20;
/// Most bytes of keyframes in the open chunks of a group.
const OPEN_BYTES: usize = 384 << 20;

/// Bytes that the encoder of a tile works with, for each pixel: what decoders hold (at most 3), its age and whether it changes
/// (2), a leaf for 16 pixels (1), and nodes of 48 bytes with their places, at most 4/3 for 16 pixels: as found, as sent lately,
/// and as children while their parent is tried (3 times 4, and half of it again where they grow).
const TILE_WORK_BYTES: u64 = 24;

/// Bytes that the search of the transform codec takes for each pixel of a chunk of a cell: coefficients of four block sizes in three
/// channels (48), keys and samples (24), levels of two partitions and of those that are tried (48), and at most 100 for nodes and places of
/// blocks of 4x4 pixels in them.
const SEARCH_BYTES: u64 = 220;

#[derive(Debug, Clone, Copy)]
pub(super) struct ScanLimits {
    pub keep_bytes: u64,
    pub frames_at_once: usize,
    /// Whether the distances that occur are of use.
    pub finds_levels: bool,
}

impl Default for ScanLimits {
    fn default() -> Self {
        ScanLimits { keep_bytes: KEEP_BYTES, frames_at_once: usize::MAX, finds_levels: false }
    }
}

#[derive(Clone, Copy)]
/// Limits of a group's cells of keyframes and weights. They follow from footage and settings alone, because the file depends on them.
pub(super) struct ColorMemory {
    /// With a shorter lookahead where more pictures would be pending.
    pub search: SearchSettings,
    pub close_at_bytes: usize,
}

impl ColorMemory {
    pub fn new(group: &SourceGroup, header: &CodecHeader, search: SearchSettings, unit_count: u32) -> ColorMemory {
        let picture = group_pixels(group) * header.raw_pixel_bytes();
        let lookahead = (PENDING_BYTES / picture.max(1)).clamp(1, u64::from(search.lookahead)) as u32;
        let close_at_bytes = COLOR_CLOSE_AT_BYTES.min(OPEN_BYTES / unit_count.max(1) as usize);
        ColorMemory { search: SearchSettings { lookahead, ..search }, close_at_bytes }
    }
}

/// Bytes of one group.
#[derive(Debug, Clone, Copy)]
struct GroupNeed {
    /// Encoders with their open chunks, and the searches of all units at work.
    state: u64,
    /// Units that are coded at the same time.
    units_at_once: usize,
    /// A frame as it is read and converted.
    frame: u64,
    /// Depth images that a scan may keep.
    keep: u64,
}

impl GroupNeed {
    fn new(source: &dyn FrameSource, group: &SourceGroup, settings: &EncodeSettings) -> GroupNeed {
        let pixels = group_pixels(group);
        let (read, coded) = match group.kind {
            StreamKind::Depth => (4, 2),
            StreamKind::Color => (6, CodecHeader::Color(settings.color_header()).raw_pixel_bytes()),
            StreamKind::Material => (12, 3),
            StreamKind::Alpha => (4, 2),
        };
        // Its values as 4 codes of 16 bits and as floats, and colour that is multiplied by it.
        let alpha = if is_multiplied(source, group) { 18 } else { 0 };
        // A file is decoded as a whole: its values, and 4 bytes a pixel for one channel while it is unpacked. Then each face
        // as it is read and as it is coded.
        let frame = source.file_pixels() * (read + 4 + alpha) + pixels * (read + coded);
        let (held, search) = match (group.kind, settings.color_codec) {
            (StreamKind::Color, ColorCodec::Transform) => transform_state(group, settings),
            (StreamKind::Color, ColorCodec::Cells) => (color_state(group, settings), 0),
            _ => (tile_state(group, settings), 0),
        };
        let searches = Need { what: "", fixed: held + frame, each: search, instead: "" };
        // One at least, which is refused later where it does not fit.
        let units_at_once = settings.memory.at_once(&searches, rayon::current_num_threads()).unwrap_or(1);
        let state = held + search * units_at_once as u64;
        let mut need = GroupNeed { state, units_at_once, frame, keep: KEEP_BYTES };
        if let Some(bytes) = settings.memory.bytes {
            need.keep = need.keep.min(bytes.saturating_sub(state + frame) / 2);
        }
        need
    }

    fn need<'a>(&self, what: &'a str, kind: StreamKind, settings: &EncodeSettings) -> Need<'a> {
        let kept = if kind == StreamKind::Depth { self.keep } else { 0 };
        let instead = match (kind, settings.color_codec) {
            (StreamKind::Color, ColorCodec::Transform) if settings.color_chunk > 1 => "a smaller `color_chunk`",
            (StreamKind::Color, ColorCodec::Cells) if settings.search.lookahead > 1 => "a smaller `lookahead`",
            (StreamKind::Depth | StreamKind::Material | StreamKind::Alpha, _)
                if settings.temporal.keyframe_interval > 1 =>
            {
                "a smaller `keyframe_interval`"
            }
            _ => "",
        };
        Need { what, fixed: self.state + kept, each: self.frame, instead }
    }
}

/// Whether alpha is read with a frame of colour.
fn is_multiplied(source: &dyn FrameSource, group: &SourceGroup) -> bool {
    let files = group.frames.iter().map(|frame| source.files(group, frame).unwrap_or_default());
    files.map(|files| files.len()).find(|count| *count > 0).is_some_and(|count| count > 1)
}

/// Refuses groups that would not fit into the settings' memory.
pub(super) fn check(source: &dyn FrameSource, settings: &EncodeSettings, groups: &[GroupRef<'_>]) -> Result<()> {
    if settings.memory.bytes.is_none() {
        return Ok(());
    }
    for GroupRef { group, .. } in groups {
        let probe = &source.probes()[group.probe].name;
        let what = format!("encoding the {} of probe {probe}", group.kind.name());
        settings.memory.at_once(&GroupNeed::new(source, group, settings).need(&what, group.kind, settings), 1)?;
    }
    Ok(())
}

/// How much of a group is worked on at the same time.
#[derive(Debug, Clone, Copy)]
pub(super) struct Batches {
    /// Frames that are read and coded together.
    pub frames: usize,
    pub units_at_once: usize,
}

pub(super) fn batches(source: &dyn FrameSource, settings: &EncodeSettings, group: &SourceGroup) -> Result<Batches> {
    let usual = (BATCH_PIXELS / (group_pixels(group) as usize).max(1)).clamp(1, BATCH_FRAMES);
    let need = GroupNeed::new(source, group, settings);
    let frames = settings.memory.at_once(&need.need("encoding", group.kind, settings), usual)?;
    Ok(Batches { frames, units_at_once: need.units_at_once })
}

pub(super) fn scan_limits(
    source: &dyn FrameSource,
    settings: &EncodeSettings,
    groups: &[GroupRef<'_>],
) -> Result<ScanLimits> {
    let mut limits = ScanLimits { finds_levels: settings.finds_levels(), ..ScanLimits::default() };
    for GroupRef { group, .. } in groups {
        let need = GroupNeed::new(source, group, settings);
        let scanning = Need { what: "scanning", fixed: need.keep, each: need.frame, instead: "" };
        limits.keep_bytes = limits.keep_bytes.min(need.keep);
        limits.frames_at_once = settings.memory.at_once(&scanning, limits.frames_at_once)?;
    }
    Ok(limits)
}

/// Cells of keyframes and weights: pending pictures and open chunks.
fn color_state(group: &SourceGroup, settings: &EncodeSettings) -> u64 {
    let header = CodecHeader::Color(settings.color_header());
    let units = unit_count(group, settings);
    let memory = ColorMemory::new(group, &header, settings.search, u32::try_from(units).unwrap_or(u32::MAX));
    let picture = group_pixels(group) * header.raw_pixel_bytes();
    // Two more for the keyframe as it is stored and as it is shown; a chunk grows past its size by a keyframe.
    let pending = picture * (u64::from(memory.search.lookahead) + 4);
    let open = units * memory.close_at_bytes as u64 + picture;
    pending + open + compressing(settings, open / units.max(1))
}

/// Cells of the transform codec: the frames of a chunk, and what the search of one cell takes.
fn transform_state(group: &SourceGroup, settings: &EncodeSettings) -> (u64, u64) {
    let header = CodecHeader::Color(settings.color_header());
    let frames = u64::from(settings.color_chunk).min(group.frames.count());
    let cell = settings.unit_size(group.kind, [group.width, group.height]);
    let size = [cell[0].min(group.width) as usize, cell[1].min(group.height) as usize];
    let held = frames * group_pixels(group) * header.raw_pixel_bytes();
    let chunk = frames * size[0] as u64 * size[1] as u64 * header.raw_pixel_bytes();
    (held + compressing(settings, chunk), frames * padded_pixels(size) * SEARCH_BYTES)
}

/// Tiles of depth, material or alpha: pictures and open chunks, whose every frame may change every pixel.
fn tile_state(group: &SourceGroup, settings: &EncodeSettings) -> u64 {
    let (pixels, units) = (group_pixels(group), unit_count(group, settings));
    let frames = u64::from(settings.temporal.keyframe_interval).min(group.frames.count());
    // In halves of a byte, with rows and places.
    let codec = match group.kind {
        StreamKind::Alpha => DepthCodec::Predictive,
        _ => settings.depth.codec,
    };
    let pixel_halves = match (group.kind, codec) {
        (StreamKind::Material, _) => 7,
        (_, DepthCodec::Blocks) => 1,
        (_, DepthCodec::Tree) => 8,
        // A symbol and what follows it are held as four words.
        (_, DepthCodec::Predictive) => 32,
        _ => 5,
    };
    let frame = pixels * pixel_halves / 2;
    let most = match (group.kind, codec) {
        (StreamKind::Depth | StreamKind::Alpha, DepthCodec::Predictive) => pixels * CLOSE_AT_BYTES_A_PIXEL as u64,
        _ => units * CLOSE_AT_BYTES as u64,
    };
    let open = (frames * frame).min(most + frame);
    pixels * TILE_WORK_BYTES + open + compressing(settings, open / units.max(1))
}

fn group_pixels(group: &SourceGroup) -> u64 {
    u64::from(group.width) * u64::from(group.height) * group.faces.len() as u64
}

fn unit_count(group: &SourceGroup, settings: &EncodeSettings) -> u64 {
    let [width, height] = settings.unit_size(group.kind, [group.width, group.height]);
    let of = |side: u32, unit: u32| u64::from(side.div_ceil(unit.max(1)));
    of(group.width, width) * of(group.height, height) * group.faces.len() as u64
}

/// Compressing one chunk on each thread.
fn compressing(settings: &EncodeSettings, chunk_bytes: u64) -> u64 {
    let threads = rayon::current_num_threads() as u64;
    threads * memory::compressing_bytes(settings.compression, chunk_bytes)
}
