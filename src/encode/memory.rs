//! What encoding a group of streams takes of memory at the most, and how many of its frames are at work at once.
//!
//! The file depends on none of it: a batch has as many frames as fit, and where the encoders' own state does not fit, the
//! work is refused before it begins.

use crate::dataset::source::{Source, SourceGroup};
use crate::dataset::stream::StreamKind;
use crate::decode::memory;
use crate::depth::block::MAX_TILE;
use crate::depth::temporal::CLOSE_AT_BYTES;
use crate::encode::dataset::{BATCH_FRAMES, BATCH_PIXELS, DepthCodec, EncodeSettings, raw_pixel_bytes};
use crate::encode::scan;
use crate::encode::unit::ColorMemory;
use crate::error::Result;
use crate::memory::Need;
use crate::streams::CodecHeader;

/// Bytes for each pixel of a tile that its encoder works with: what is held (at most 3), its age and whether it changes (2), a
/// leaf for 16 pixels (1), and nodes of 48 bytes with their places, at most 4/3 for 16 pixels: as found, as sent lately, and as
/// children while their parent is tried (3 times 4, and half of it again where they grow).
const TILE_WORK_BYTES: u64 = 24;

/// What one group takes.
#[derive(Debug, Clone, Copy)]
pub(super) struct GroupNeed {
    /// Encoders with their open chunks.
    state: u64,
    /// A frame as it is read and converted.
    frame: u64,
    /// Depth images that a scan may keep.
    keep: u64,
}

impl GroupNeed {
    pub(super) fn new(source: &Source, group: &SourceGroup, settings: &EncodeSettings) -> GroupNeed {
        let pixels = u64::from(group.width) * u64::from(group.height) * group.faces.len() as u64;
        let (read, coded) = match group.kind {
            StreamKind::Depth => (4, 2),
            StreamKind::Color => (6, raw_pixel_bytes(&CodecHeader::Color(settings.color_header()))),
            StreamKind::Material => (12, 3),
        };
        // A file is decoded whole before faces are cut from it: as its values are, and once more as its reader unpacks them,
        // at 4 bytes a pixel and channel at a time. Then each face as it is read and as it is coded.
        let frame = source.file_pixels() * (read + 4) + pixels * (read + coded);
        let state = match group.kind {
            StreamKind::Color => color_state(group, settings),
            _ => tile_state(group, settings),
        };
        let mut need = GroupNeed { state, frame, keep: scan::KEEP_BYTES };
        if let Some(bytes) = settings.memory.bytes() {
            need.keep = need.keep.min(bytes.saturating_sub(state + frame) / 2);
        }
        need
    }

    /// The group's own state and kept images, and each of its frames.
    fn need<'a>(&self, what: &'a str, kind: StreamKind) -> Need<'a> {
        let kept = if kind == StreamKind::Depth { self.keep } else { 0 };
        let instead = match kind {
            StreamKind::Color => "a smaller `keyframe_reach`",
            _ => "a smaller `keyframe_interval`",
        };
        Need { what, fixed: self.state + kept, each: self.frame, instead }
    }
}

/// Refuses a group that would not fit into the settings' memory.
pub(super) fn check(source: &Source, settings: &EncodeSettings, groups: &[(usize, &SourceGroup)]) -> Result<()> {
    if settings.memory.bytes().is_none() {
        return Ok(());
    }
    for (_, group) in groups {
        let probe = &source.probes()[group.probe].name;
        let what = format!("encoding the {} of probe {probe}", group.kind.name());
        settings.memory.at_once(&GroupNeed::new(source, group, settings).need(&what, group.kind), 1)?;
    }
    Ok(())
}

/// Frames of a group that are read and coded together.
pub(super) fn batch_frames(source: &Source, settings: &EncodeSettings, group: &SourceGroup) -> Result<usize> {
    let face_pixels = group.width as usize * group.height as usize * group.faces.len();
    let usual = (BATCH_PIXELS / face_pixels.max(1)).clamp(1, BATCH_FRAMES);
    settings.memory.at_once(&GroupNeed::new(source, group, settings).need("encoding", group.kind), usual)
}

/// What a scan of the groups of a probe may keep and do at once.
pub(super) fn scan_limits(
    source: &Source,
    settings: &EncodeSettings,
    groups: &[(usize, &SourceGroup)],
) -> Result<scan::ScanLimits> {
    let mut limits = scan::ScanLimits::default();
    for (_, group) in groups {
        let need = GroupNeed::new(source, group, settings);
        let scanning = Need { what: "scanning", fixed: need.keep, each: need.frame, instead: "" };
        limits.keep_bytes = limits.keep_bytes.min(need.keep);
        limits.frames_at_once = settings.memory.at_once(&scanning, limits.frames_at_once)?;
    }
    Ok(limits)
}

/// Colour cells: the pictures that the search may reach, and the open chunks.
fn color_state(group: &SourceGroup, settings: &EncodeSettings) -> u64 {
    let header = CodecHeader::Color(settings.color_header());
    let units = units(group, [settings.cell; 2]);
    let memory = ColorMemory::new(group, &header, settings.search, u32::try_from(units).unwrap_or(u32::MAX));
    let picture =
        u64::from(group.width) * u64::from(group.height) * group.faces.len() as u64 * raw_pixel_bytes(&header);
    // Two more for the keyframe as it is stored and as it is shown; a chunk grows past its size by a keyframe.
    let pending = picture * (u64::from(memory.reach()) + 4);
    let open = units * memory.close_at_bytes() as u64 + picture;
    pending + open + compressing(settings, open / units.max(1))
}

/// Tiles of depth or material: what is held of them, and the open chunks, whose every frame may change every pixel.
fn tile_state(group: &SourceGroup, settings: &EncodeSettings) -> u64 {
    let pixels = u64::from(group.width) * u64::from(group.height) * group.faces.len() as u64;
    let boxes = matches!(settings.depth.codec, DepthCodec::Boxes | DepthCodec::BoxesInBlocks);
    let side = |side: u32| match group.kind {
        StreamKind::Depth if !boxes => settings.tiles.side(side, MAX_TILE),
        _ => settings.tiles.side(side, u32::MAX),
    };
    let units = units(group, [side(group.width), side(group.height)]);
    let frames = u64::from(settings.temporal.keyframe_interval).min(group.frames.count());
    // In halves of a byte, with rows and places.
    let pixel_halves = match (group.kind, settings.depth.codec) {
        (StreamKind::Material, _) => 7,
        (_, DepthCodec::Blocks) => 1,
        (_, DepthCodec::Tree) => 8,
        _ => 5,
    };
    let frame = pixels * pixel_halves / 2;
    let open = (frames * frame).min(units * CLOSE_AT_BYTES as u64 + frame);
    pixels * TILE_WORK_BYTES + open + compressing(settings, open / units.max(1))
}

fn units(group: &SourceGroup, [width, height]: [u32; 2]) -> u64 {
    let of = |side: u32, unit: u32| u64::from(side.div_ceil(unit.max(1)));
    of(group.width, width) * of(group.height, height) * group.faces.len() as u64
}

/// What compressing chunks takes, one on each thread.
fn compressing(settings: &EncodeSettings, chunk_bytes: u64) -> u64 {
    let threads = rayon::current_num_threads() as u64;
    settings.lzma2.map_or(0, |_| threads * memory::compressing_bytes(chunk_bytes))
}
