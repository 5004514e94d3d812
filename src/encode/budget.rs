//! Upper bounds of the memory that encoding takes, and how many frames are read at once.
//!
//! The file depends on none of it, except for [`ColorMemory`], which follows from footage and settings alone: a batch has as
//! many frames as fit, and where the encoders' own state does not fit, the encode is refused before it begins. Nothing adds
//! up over probes or groups, which are encoded one after the other.

use crate::color::SearchSettings;
use crate::color::temporal::CLOSE_AT_BYTES as COLOR_CLOSE_AT_BYTES;
use crate::dataset::SourceGroup;
use crate::decode::memory;
use crate::depth::open_chunk::CLOSE_AT_BYTES;
use crate::encode::source::{FrameSource, GroupRef};
use crate::encode::{DepthCodec, EncodeSettings};
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

#[derive(Debug, Clone, Copy)]
pub(super) struct ScanLimits {
    pub keep_bytes: u64,
    pub frames_at_once: usize,
}

impl Default for ScanLimits {
    fn default() -> Self {
        ScanLimits { keep_bytes: KEEP_BYTES, frames_at_once: usize::MAX }
    }
}

/// Limits of a group's colour cells. They follow from footage and settings alone, because the file depends on them.
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
    /// Encoders with their open chunks.
    state: u64,
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
        };
        // A file is decoded as a whole: its values, and 4 bytes a pixel for one channel while it is unpacked. Then each face
        // as it is read and as it is coded.
        let frame = source.file_pixels() * (read + 4) + pixels * (read + coded);
        let state = match group.kind {
            StreamKind::Color => color_state(group, settings),
            _ => tile_state(group, settings),
        };
        let mut need = GroupNeed { state, frame, keep: KEEP_BYTES };
        if let Some(bytes) = settings.memory.bytes {
            need.keep = need.keep.min(bytes.saturating_sub(state + frame) / 2);
        }
        need
    }

    fn need<'a>(&self, what: &'a str, kind: StreamKind) -> Need<'a> {
        let kept = if kind == StreamKind::Depth { self.keep } else { 0 };
        let instead = match kind {
            StreamKind::Color => "a smaller `lookahead`",
            _ => "a smaller `keyframe_interval`",
        };
        Need { what, fixed: self.state + kept, each: self.frame, instead }
    }
}

/// Refuses groups that would not fit into the settings' memory.
pub(super) fn check(source: &dyn FrameSource, settings: &EncodeSettings, groups: &[GroupRef<'_>]) -> Result<()> {
    if settings.memory.bytes.is_none() {
        return Ok(());
    }
    for GroupRef { group, .. } in groups {
        let probe = &source.probes()[group.probe].name;
        let what = format!("encoding the {} of probe {probe}", group.kind.name());
        settings.memory.at_once(&GroupNeed::new(source, group, settings).need(&what, group.kind), 1)?;
    }
    Ok(())
}

/// Frames of a group that are read and coded together.
pub(super) fn batch_frames(source: &dyn FrameSource, settings: &EncodeSettings, group: &SourceGroup) -> Result<usize> {
    let usual = (BATCH_PIXELS / (group_pixels(group) as usize).max(1)).clamp(1, BATCH_FRAMES);
    settings.memory.at_once(&GroupNeed::new(source, group, settings).need("encoding", group.kind), usual)
}

pub(super) fn scan_limits(
    source: &dyn FrameSource,
    settings: &EncodeSettings,
    groups: &[GroupRef<'_>],
) -> Result<ScanLimits> {
    let mut limits = ScanLimits::default();
    for GroupRef { group, .. } in groups {
        let need = GroupNeed::new(source, group, settings);
        let scanning = Need { what: "scanning", fixed: need.keep, each: need.frame, instead: "" };
        limits.keep_bytes = limits.keep_bytes.min(need.keep);
        limits.frames_at_once = settings.memory.at_once(&scanning, limits.frames_at_once)?;
    }
    Ok(limits)
}

/// Colour cells: pending pictures and open chunks.
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

/// Tiles of depth or material: pictures and open chunks, whose every frame may change every pixel.
fn tile_state(group: &SourceGroup, settings: &EncodeSettings) -> u64 {
    let (pixels, units) = (group_pixels(group), unit_count(group, settings));
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
